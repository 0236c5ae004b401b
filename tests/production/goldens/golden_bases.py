"""Small scenes with their goldens, and candidates that differ from them in one respect."""

from __future__ import annotations

import shutil
import wave
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.production.goldens.cue_facts import Cues
from pipeline.production.goldens.golden_candidate import Candidate
from pipeline.production.goldens.golden_card import Framing, read_card
from pipeline.production.goldens.golden_case import Case, GoldenFolder, GoldenRenderer
from pipeline.production.goldens.golden_content import Content, read_content
from pipeline.production.goldens.golden_record import record
from pipeline.production.run.progress import Reporter
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene, read_scene
from render.renderer import Renderer

RATE = 48_000
"""Of the sound [samples/s]."""

FRAME = RATE // 24
"""Samples of a frame."""

SCENE = """\
pronk: 1
fps: 24
frames: 12
seed: 3
terrain: {kind: flat, size: [8, 8], cells: [8, 8], material: ground}
cast:
  - name: bug
    figure: beetle
    scale: 0.6
    walk: {gait: tripod, cycle: 0.275, speed: 0.6}
  - name: ball
    body: {shape: sphere, radius: 0.06, density: 900, bounciness: 0.5}
    at: [0.55, 0.3, 0.45]
    material: rubber
materials:
  ground: {preset: dry soil}
  rubber: {preset: red rubber, roughness: 0.4}
camera: {at: [0.9, 0.5, 0.9], look_at: [0.1, 0.12, 0]}
light: LIGHT
film: {size: [640, 360], depth: 3}
sound: {room: dry}
golden: {frames: [8], size: [96, 54], samples: 64}
"""

LIGHTS = (
    "{studio: {fill: 0.3, rim: 0.5}}",
    "{sun: {hour: 16.5, day: 172, latitude_deg: 48}}",
)

Sound = NDArray[np.float64]
Picture = NDArray[np.uint8]


def text_of(light: str) -> str:
    """Return the scene with a light."""
    return SCENE.replace("LIGHT", light)


@dataclass(frozen=True)
class Base:
    """A scene with its take and its golden."""

    case: Case
    text: str
    take: Take
    renderer: GoldenRenderer

    @property
    def scene(self) -> Scene:
        """The scene as it was recorded."""
        return self.case.scene

    @cached_property
    def golden(self) -> Content:
        """Its golden as it stands in its folder."""
        return read_content(self.case.golden, read_card(self.case.golden.card))

    def written(self, old: str, new: str) -> Scene:
        """Return the scene with other words."""
        assert old in self.text, old
        return read_scene(self.text.replace(old, new))

    def changed(self, old: str, new: str) -> Candidate:
        """Return the candidate of the scene with other words; its motion must be the same."""
        return Candidate(self.written(old, new), self.take)

    def simulated(self, old: str, new: str) -> Candidate:
        """Return the candidate of the scene with other words, simulated again."""
        return Candidate(self.written(old, new))

    def moved(self, **changes: Any) -> Candidate:
        """Return the candidate of a take with other members."""
        return Candidate(self.scene, replace(self.take, **changes))

    def altered(self, **changes: Any) -> Altered:
        """Return a candidate whose results are altered; see `Altered`."""
        return Altered(self, **changes)


class Altered(Candidate):
    """Results of a scene that something altered on the way.

    Args:
        base: the scene.
        sound: alters the samples (N, 2) that are written.
        track: alters those that the film gets.
        picture: alters the golden's own pictures, so that none is rendered.
        cues: alters the cues.
        order: frames of the film in the order in which they are shown.
        shown: offset of the frames that the golden's pictures show.
        take: of the scene; None for that of the golden.
    """

    def __init__(
        self,
        base: Base,
        *,
        sound: Callable[[Sound], Sound] | None = None,
        track: Callable[[Sound], Sound] | None = None,
        picture: Callable[[Picture], Picture] | None = None,
        cues: Callable[[Cues], Cues] | None = None,
        order: Sequence[int] = (),
        shown: int = 0,
        take: Take | None = None,
    ) -> None:
        super().__init__(base.scene, take or base.take)
        self._base = base
        self._alter = {"sound": sound, "track": track, "picture": picture, "cues": cues}
        self._order = order
        self._shown = shown

    def write_sound(self, path: Path) -> None:
        """Write the sound, altered."""
        super().write_sound(path)
        if self._alter["sound"] is not None:
            rewrite(path, self._alter["sound"])

    def write_film(self, path: Path, sound: Path) -> None:
        """Write the film with an altered track."""
        if self._alter["track"] is not None:
            track = sound.with_name("track.wav")
            shutil.copy(sound, track)
            rewrite(track, self._alter["track"])
            sound = track
        super().write_film(path, sound)

    def frames(
        self, framing: Framing, renderer: Renderer, seed: int = 0
    ) -> Iterator[tuple[int, Picture]]:
        """Yield the golden's pictures, altered, or other frames."""
        alter = self._alter["picture"]
        if alter is not None:
            yield from ((n, alter(p)) for n, p in self._base.golden.frames.items())
            return
        numbers = tuple(n + self._shown for n in framing.numbers)
        others = super().frames(framing.model_copy(update={"numbers": numbers}), renderer, seed)
        yield from zip(framing.numbers, (picture for _, picture in others), strict=True)

    @cached_property
    def cues(self) -> Cues:
        """The cues, altered."""
        cues: Cues = Candidate.cues.func(self)  # type: ignore[attr-defined]
        alter = self._alter["cues"]
        return cues if alter is None else alter(cues)

    def frame_order(self) -> Sequence[int]:
        """Return the frames in another order."""
        return self._order or super().frame_order()


def rewrite(path: Path, alter: Callable[[Sound], Sound]) -> None:
    """Alter the samples (N, 2) of a WAV file of 24 bits."""
    with wave.open(str(path)) as file:
        params, data = file.getparams(), file.readframes(file.getnframes())
    words = np.zeros((len(data) // 3, 4), np.uint8)
    words[:, 1:] = np.frombuffer(data, np.uint8).reshape(-1, 3)
    sound = np.clip(alter(words.view("<i4").reshape(-1, 2) / 2.0**31), -1.0, 1.0)
    whole = np.ascontiguousarray(np.rint(sound * (2**23 - 1)).astype("<i4"))
    with wave.open(str(path), "wb") as file:
        file.setparams(params)
        file.writeframes(whole.view(np.uint8).reshape(-1, 4)[:, :3].tobytes())


def record_base(name: str, text: str, folder: Path, renderer: GoldenRenderer) -> Base:
    """Record the golden of a scene."""
    scene = read_scene(text)
    case = Case(name, scene, GoldenFolder(folder / name), folder / "out", "bug")
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("CI", raising=False)
        record(case, renderer, Reporter(), seeds=4)
    (folder / "out" / "golden").mkdir(parents=True, exist_ok=True)
    return Base(case, text, simulate(scene), renderer)


class Bases:
    """The two scenes, each recorded when first needed."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._renderer = GoldenRenderer("llvm")
        self._made: dict[int, Base] = {}

    def __getitem__(self, number: int) -> Base:
        if number not in self._made:
            text = text_of(LIGHTS[number])
            self._made[number] = record_base(f"bug{number}", text, self._folder, self._renderer)
        return self._made[number]
