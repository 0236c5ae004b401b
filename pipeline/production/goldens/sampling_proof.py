"""Proof: what a scene gives now, to be compared with its golden or to become one."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from audio.errors import AudioError
from audio.grid import grid_of
from audio.midi import midi_bytes
from audio.modal import write_wav
from audio.note_list import note_list
from audio.score import Score
from pipeline.errors import FilmingError, ScoringError
from pipeline.production.goldens.cue_files import Cues, cues_of
from pipeline.production.goldens.film_facts import FilmFacts, facts_of_film
from pipeline.production.goldens.frame_slates import slate
from pipeline.production.goldens.golden_card import Framing
from pipeline.production.reports.stills import spread
from pipeline.production.run.interrupts import held_back
from pipeline.production.shots.shot_builder import Shooting
from pipeline.production.sound.score_builder import build_score
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from render.errors import RenderError
from render.film_encoder import CODECS, Picture, write_film
from render.renderer import Renderer
from render.shot import Shot

WIDTH = 256
"""Of a golden's frames unless the scene says otherwise [pixels]."""

_SEEDS_APART = 104_729
"""Between the seeds of pictures that differ in noise alone."""


def framing_of(scene: Scene) -> Framing:
    """Return which frames the scene wants to have compared."""
    width, height = scene.film.resolved().size
    # Both sides even, and no side shorter than a tile.
    size = scene.golden.size or (WIDTH, max(2 * round(WIDTH * height / width / 2), 16))
    numbers = scene.golden.frames or spread(scene.n_frames, 3)
    return Framing(numbers=tuple(sorted(set(numbers))), size=size, samples=scene.golden.samples)


def filmed_for(scene: Scene, framing: Framing) -> Scene:
    """Return the scene with the film of its golden's frames: as they are before the denoiser."""
    words = {
        "size": framing.size,
        "samples": framing.samples,
        "soft_light": "full",
        "denoise": "off",
        "format": "png",
    }
    return scene.model_copy(update={"film": scene.film.model_copy(update=words)})


class Proof:
    """What a scene gives now; each thing is made when it is first asked for.

    Args:
        scene: as its author wrote it.
        take: its take, if there is one already.
    """

    def __init__(self, scene: Scene, take: Take | None = None) -> None:
        self.scene = scene
        self._take = take

    @cached_property
    def take(self) -> Take:
        """How everything moves."""
        return self._take or simulate(self.scene)

    @cached_property
    def score(self) -> Score:
        """What is heard."""
        return build_score(self.scene, self.take, self._shooting.poses)[0]

    @cached_property
    def _shooting(self) -> Shooting:
        return Shooting(self.scene, self.take)

    @cached_property
    def cues(self) -> Cues:
        """The camera's way and the notes of the score."""
        with _told():
            notes = note_list(midi_bytes(self.score))
            ticks = str(grid_of(self.score.rate).tick(2) - grid_of(self.score.rate).tick(1))
        return cues_of(self._shooting.poses, ticks, notes, self.take.parts)

    @cached_property
    def film(self) -> FilmFacts:
        """What its film is, with slates for pictures: no frame is rendered for it."""
        codec = CODECS[self.scene.film.resolved().suffix]
        with _told(), tempfile.TemporaryDirectory(prefix="pronk-") as folder:
            wav = Path(folder, "sound.wav")
            self.write_sound(wav)
            path = Path(folder, f"film{self.scene.film.resolved().suffix}")
            write_film(path, self._slates(codec.bits), self.scene.rate, wav)
            return facts_of_film(path)

    def write_sound(self, path: Path) -> None:
        """Write the sound of the film."""
        write_wav(self.score, path)

    def order(self) -> Sequence[int]:
        """Return the frames of the film in the order in which they are shown."""
        return range(1, self.scene.n_frames + 1)

    def _slates(self, bits: int) -> Iterator[Picture]:
        for number in self.order():
            picture = slate(number)
            # 255 stays white: each value is repeated in the lower byte.
            yield picture.astype(np.uint16) * 257 if bits == 16 else picture

    def frames(
        self, framing: Framing, renderer: Renderer, seed: int = 0
    ) -> Iterator[tuple[int, NDArray[np.uint8]]]:
        """Render the frames of a golden, without a denoiser, and yield each as it is done.

        Args:
            framing: which, and how.
            renderer: that makes them.
            seed: 0 for the golden's own noise, another number for another noise.

        Raises:
            FilmingError: a frame cannot be rendered.
        """
        for number, shot in self.shots(framing):
            with _told(), held_back():
                other = replace(shot, seed=shot.seed + _SEEDS_APART * seed)
                yield number, renderer.render(other).srgb8

    def shots(self, framing: Framing) -> Iterator[tuple[int, Shot]]:
        """Yield the frames of a golden as the renderer is given them."""
        shooting = Shooting(filmed_for(self.scene, framing), self.take)
        for number in framing.numbers:
            yield number, shooting.shot(number)


@contextmanager
def _told() -> Iterator[None]:
    """Turn what the lower floors raise into our own errors."""
    try:
        yield
    except RenderError as error:
        raise FilmingError(str(error)) from error
    except AudioError as error:
        raise ScoringError(str(error)) from error
