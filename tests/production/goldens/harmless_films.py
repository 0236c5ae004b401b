"""Changes that keep a film: other words, noise, machines and versions."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from pipeline.production.goldens.cue_facts import Cues
from pipeline.production.goldens.golden_candidate import Candidate
from pipeline.production.goldens.verdict import Layer
from pipeline.spec import read_scene
from render.denoiser import Denoiser
from tests.production.goldens.golden_bases import Base, Picture, Sound

Make = Callable[[Base], Candidate]
CHEAP: tuple[Layer, ...] = ("motion", "film")
ALL: tuple[Layer, ...] = ("motion", "frames", "film")


@dataclass(frozen=True)
class Harmless:
    """A change that no layer may find.

    Attributes:
        name: of the change.
        make: returns the results after it.
        layers: that it could concern.
        base: number of the scene.
        environment: of the renderer; empty for that of the golden.
    """

    name: str
    make: Make
    layers: tuple[Layer, ...] = CHEAP
    base: int = 0
    environment: str = ""


# --- other words ------------------------------------------------------------------


def words(name: str, old: str, new: str, layers: tuple[Layer, ...] = CHEAP) -> Harmless:
    """Return other words for the same film, simulated again."""
    return Harmless(f"words: {name}", lambda base: base.simulated(old, new), layers)


def whole(name: str, alter: Callable[[str], str]) -> Harmless:
    """Return another form of the whole file."""
    return Harmless(f"words: {name}", lambda base: Candidate(read_scene(alter(base.text))))


STUDIO, FILM = "{studio: {fill: 0.3, rim: 0.5}}", "{size: [640, 360], depth: 3}"
CAMERA = "{at: [0.9, 0.5, 0.9], look_at: [0.1, 0.12, 0]}"

WORDS = (
    whole("a comment", lambda text: f"# The same film.\n{text}"),
    whole("CRLF", lambda text: text.replace("\n", "\r\n")),
    whole("blocks in another order", lambda t: "\n".join([*t.splitlines()[1:], "pronk: 1", ""])),
    whole("a title", lambda text: f"{text}title: Another title\n"),
    words("the rate as a fraction", "fps: 24", 'fps: "24/1"'),
    words("a duration for frames", "frames: 12", "duration: 0.5"),
    words("whole numbers with a point", "size: [8, 8]", "size: [8.0, 8.0]"),
    words("a start that is the default", "scale: 0.6", "scale: 0.6\n    at: [0, 0]"),
    words("the steps that are the default", "seed: 3", "seed: 3\nsteps: 4"),
    words("the rows that are the default", "seed: 3", "seed: 3\nrows_per_frame: 4"),
    words(
        "a light with its defaults", STUDIO, "{studio: {elevation_deg: 42, fill: 0.3, rim: 0.5}}"
    ),
    words("a light by its preset", STUDIO, "studio"),
    words("film with its preset", FILM, "{preset: preview, size: [640, 360], depth: 3}"),
    words("film with its defaults", FILM, "{size: [640, 360], depth: 3, samples: 2, exposure: 0}"),
    words(
        "film without motion blur, written out",
        FILM,
        "{size: [640, 360], depth: 3, shutter_deg: 0}",
    ),
    words("camera as a list", CAMERA, f"[{CAMERA}]"),
    words("camera with its lens", "0.12, 0]}", "0.12, 0], fov_deg: 35}"),
    words("a material's own roughness", "{preset: dry soil}", "{preset: dry soil, metallic: 0}"),
    words("an unused material", "materials:\n", "materials:\n  other: {preset: snow}\n"),
    words(
        "an unused voice", "{room: dry}", "{room: dry, voices: [{when: {cause: hug}, mute: true}]}"
    ),
    words("a voice with its defaults", "{room: dry}", "{room: dry, voices: [{gain_db: 0}]}"),
    words("the room in full", "{room: dry}", "{room: {preset: dry}}"),
    words("the master in full", "{room: dry}", "{room: dry, master: {lufs: -16}}"),
    words("the scale in full", "{room: dry}", "{room: dry, scale: C minor pentatonic}"),
    words("a box out of sight, as a place", "seed: 3", "seed: 3\nplaces: {home: [1, 1]}"),
    words("a body's default", "bounciness: 0.5", "bounciness: 0.5, collide: terrain"),
)

# --- sound ------------------------------------------------------------------------


def heard(name: str, alter: Callable[[Sound], Sound]) -> Harmless:
    """Return a sound that nobody can tell from the golden's."""
    return Harmless(f"sound: {name}", lambda base: base.altered(sound=alter), ("film",))


ENCODE = """
import ctypes, sys
from pathlib import Path
import av
text, film, sound, flags = sys.argv[1:]
(library,) = Path(av.__file__).parents[1].glob("av.libs/libavutil*")
ctypes.CDLL(str(library)).av_force_cpu_flags(int(flags))
from pipeline.production.goldens.golden_candidate import Candidate
from pipeline.spec import read_scene
Candidate(read_scene(text)).write_film(Path(film), Path(sound))
"""


class EncodedElsewhere(Candidate):
    """A film that another class of processor encodes, with other noise.

    Its units are those of FFmpeg's `av_force_cpu_flags`.
    """

    def __init__(self, base: Base, flags: int) -> None:
        super().__init__(base.scene, base.take)
        self._text, self._flags = base.text, flags

    def write_film(self, path: Path, sound: Path) -> None:
        """Write the film in a process of its own, as the encoder asks for the units once."""
        if not list(Path(av.__file__).parents[1].glob("av.libs/libavutil*")):
            pytest.skip("the encoder's library is not the one of the wheel")
        arguments = [self._text, str(path), str(sound), str(self._flags)]
        subprocess.run([sys.executable, "-c", ENCODE, *arguments], check=True)


def encoded(name: str, flags: int, base: int = 0) -> Harmless:
    """Return a film that another class of processor encodes."""
    made = f"encoder: {name}"
    return Harmless(made, lambda b: EncodedElsewhere(b, flags), ("film",), base)


def dither(level: float, seed: int = 1) -> Callable[[Sound], Sound]:
    """Return the addition of noise [dBFS]."""
    return lambda x: x + 10 ** (level / 20) * np.random.default_rng(seed).normal(size=x.shape)


SOUND = (
    heard("other last bits", lambda x: np.round(x * 2**22) / 2**22),
    heard("rounded to 20 bits", lambda x: np.round(x * 2**19) / 2**19),
    heard("rounded to 16 bits", lambda x: np.round(x * 2**15) / 2**15),
    heard("dither at -120 dB", dither(-120)),
    heard("dither at -100 dB", dither(-100)),
    heard("noise at -85 dB", dither(-85)),
    heard("0.01 dB louder", lambda x: x * 1.00115),
    heard("0.1 dB softer", lambda x: x * 0.98855),
    heard("an offset of -90 dB", lambda x: x + 3e-5),
    heard("left 0.1 dB louder", lambda x: x * [1.0116, 1.0]),
    heard("crosstalk at -60 dB", lambda x: x + 0.001 * x[:, ::-1]),
    encoded("no vector units", 0),
    encoded("MMX and SSE2", 0x1B),
    encoded("no vector units, in the sun", 0, 1),
    Harmless("film: the track dithered", lambda b: b.altered(track=dither(-80)), ("film",)),
    Harmless(
        "film: the track rounded to 16 bits",
        lambda b: b.altered(track=lambda x: np.round(x * 2**15) / 2**15),
        ("film",),
    ),
)

# --- camera and notes -------------------------------------------------------------


def cued(name: str, alter: Callable[[Cues], Cues], elsewhere: bool = False) -> Harmless:
    """Return other cues; elsewhere, of a take with other bits."""

    def make(base: Base) -> Candidate:
        other = replace(base.take, positions=base.take.positions + 1e-12)
        return base.altered(cues=alter, take=other if elsewhere else base.take)

    return Harmless(f"cues: {name}", make, ("motion",))


def poses(amount: float) -> Callable[[Cues], Cues]:
    """Return poses of the camera with noise."""

    def alter(cues: Cues) -> Cues:
        draw = np.random.default_rng(9)
        camera = {
            frame: tuple(x + amount * u for x, u in zip(pose, draw.uniform(-1, 1, 12), strict=True))
            for frame, pose in cues.camera.items()
        }
        return replace(cues, camera=camera)

    return alter


def notes(**changes: Callable[[int], int]) -> Callable[[Cues], Cues]:
    """Return a change of all notes."""
    return lambda cues: replace(
        cues,
        notes=tuple(
            replace(n, **{name: change(getattr(n, name)) for name, change in changes.items()})
            for n in cues.notes
        ),
    )


CUES = (
    cued("camera off by a nanometre", poses(1e-9)),
    cued("camera off by a hundredth of a millimetre", poses(1e-5)),
    cued("elsewhere, notes on other channels", notes(channel=lambda c: (c + 1) % 9), True),
    cued("elsewhere, velocities one less", notes(velocity=lambda v: v - 1), True),
    cued("elsewhere, the same notes", lambda cues: cues, True),
    cued("written and read again", lambda cues: cues),
)

# --- pictures ---------------------------------------------------------------------


class Reseeded(Candidate):
    """Frames with other noise."""

    def __init__(self, base: Base, seed: int) -> None:
        super().__init__(base.scene, base.take)
        self._seed = seed

    def frames(self, framing: Any, renderer: Any, seed: int = 0) -> Iterator[tuple[int, Picture]]:
        """Yield the frames of another seed."""
        yield from super().frames(framing, renderer, self._seed)


class Undenoised(Candidate):
    """Frames where the denoiser is another version, which nothing may ask."""

    def frames(self, framing: Any, renderer: Any, seed: int = 0) -> Iterator[tuple[int, Picture]]:
        """Yield the frames while the denoiser fails."""

        def refuse(*_: object) -> None:
            raise AssertionError("golden frames are not denoised")

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Denoiser, "__init__", refuse)
            yield from super().frames(framing, renderer, seed)


def seeded(seed: int, base: int = 0, environment: str = "") -> Harmless:
    """Return pictures with other noise."""
    where = f", {environment}" if environment else ""
    name = f"noise: seed {seed}{where}, scene {base}"
    return Harmless(name, lambda b: Reseeded(b, seed), ("frames",), base, environment)


def seen(name: str, alter: Callable[[Picture], Picture], environment: str = "") -> Harmless:
    """Return pictures that nobody can tell from the golden's."""
    made = f"picture: {name}"
    return Harmless(made, lambda b: b.altered(picture=alter), ("frames",), 0, environment)


def levels_off(share: float, by: int = 1) -> Callable[[Picture], Picture]:
    """Return pictures in which a share of the values is a level off."""

    def alter(p: Picture) -> Picture:
        draw = np.random.default_rng(5)
        off = (draw.random(p.shape) < share) * draw.choice([-by, by], p.shape)
        return np.clip(p.astype(int) + off, 0, 255).astype(np.uint8)

    return alter


def one_pixel(p: Picture) -> Picture:
    """Return a picture with one pixel three levels off."""
    out = p.copy()
    out[20, 30] = np.clip(out[20, 30].astype(int) + 3, 0, 255)
    return out


PICTURES = (
    *(seeded(100 + k) for k in range(4)),
    *(seeded(200 + k, 1) for k in range(3)),
    *(seeded(300 + k, 0, "another processor") for k in range(3)),
    *(seeded(400 + k, 1, "another processor") for k in range(2)),
    seen("the same, elsewhere", lambda p: p.copy(), "another processor"),
    seen("a fifth of the values a level off", levels_off(0.22)),
    seen("a fifth of the values a level off, elsewhere", levels_off(0.22), "another processor"),
    seen("all values a level off", levels_off(1.0)),
    seen("one pixel three levels off", one_pixel),
    seen("one pixel three levels off, elsewhere", one_pixel, "another processor"),
    Harmless("denoiser: another version", lambda b: Undenoised(b.scene, b.take), ("frames",)),
    Harmless("nothing", lambda b: Candidate(b.scene, b.take), ALL),
    Harmless("nothing, in the sun", lambda b: Candidate(b.scene, b.take), ALL, 1),
    Harmless("simulated again", lambda b: Candidate(b.scene)),
)
