"""Renderer: shots in, frames out, and where the time went."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from render.backend import Backend
from render.config import FullFilm
from render.device_memory import told_memory
from render.exposure import Exposure
from render.frame import Frame
from render.shot import Shot

if TYPE_CHECKING:
    from render.mitsuba_scene import Stage


@dataclass
class Split:
    """Seconds spent by a renderer so far.

    Attributes:
        frames: how many were finished.
        build: building scenes in Mitsuba.
        update: moving meshes and camera, with Mitsuba's own update.
        trace: Mitsuba at work, to the last pixel.
        denoise: the denoiser.
    """

    frames: int = 0
    build: float = 0.0
    update: float = 0.0
    trace: float = 0.0
    denoise: float = 0.0

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Add the time that passes inside to a part."""
        began = time.perf_counter()
        yield
        setattr(self, part, getattr(self, part) + time.perf_counter() - began)

    @property
    def seconds(self) -> float:
        """All of it."""
        return self.build + self.update + self.trace + self.denoise


class Renderer:
    """Renders shots on one backend; builds a scene only when the shot needs another one.

    Args:
        backend: what Mitsuba is to run on.
        threads: how many Mitsuba uses, all processors unless said; pixels do not depend on it.

    Attributes:
        backend: what Mitsuba runs on.
        split: seconds spent so far.
        key_extra: all that a frame depends on besides its shot; frames are kept under both.
    """

    def __init__(self, backend: Backend, threads: int | None = None) -> None:
        backend.activate()
        # Imported here because Mitsuba must find the backend chosen when it is imported.
        import drjit

        from render.denoiser import Denoiser

        if threads is not None:
            drjit.set_thread_count(threads)
        self.backend = backend
        self.split = Split()
        self._denoiser = Denoiser()
        self._stage: Stage | None = None
        self.key_extra = f"{backend.key}; {self._denoiser.key}; look {look()}"

    def render(self, shot: Shot) -> Frame:
        """Render one shot.

        Raises:
            ShotError: the shot cannot be drawn.
            DenoiseError: the denoiser is missing or failed.
            DeviceMemoryShort: a graphics processor has too little memory.
        """
        film = shot.film.resolved()
        if film.denoise != "off":
            # Before the work that would be in vain without it.
            self._denoiser.require()
        with told_memory():
            stage = self._staged(shot)
            exposure = self._exposed(stage, shot, film)
        with self.split.timed("denoise"):
            light = self._denoiser.clean(exposure, film.denoise, wide=stage.wide)
        self.split.frames += 1
        return Frame(light, film.exposure)

    def _exposed(self, stage: Stage, shot: Shot, film: FullFilm) -> Exposure:
        """Return the mean of all moments that the shutter is open."""
        count = len(shot.moments)
        each = max(round(film.passes / count), 1)

        plate = stage.plate()
        for k, moment in enumerate(shot.moments):
            if k:
                with self.split.timed("update"):
                    stage.move(moment)
            passes = range(k * each, (k + 1) * each)
            with self.split.timed("trace"):
                plate.expose(stage.sensor, shot.seed, passes, count * each)
        with self.split.timed("trace"):
            return plate.exposure()

    def _staged(self, shot: Shot) -> Stage:
        from render.mitsuba_scene import Stage

        # Taken off while it is worked on: one that stopped half way is not used again.
        stage, self._stage = self._stage, None
        if stage is None or stage.build != shot.build:
            del stage  # frees the old scene before the new one is made
            with self.split.timed("build"):
                stage = Stage(shot)
        else:
            with self.split.timed("update"):
                stage.move(shot.moments[0])
        self._stage = stage
        return stage


@cache
def look() -> str:
    """Return a digest of the modules that decide what a frame looks like."""
    here = Path(__file__).parent
    # Words are in the digest of a shot, and a film is made of finished frames.
    others = {"backend.py", "codecs.py", "errors.py", "film_encoder.py", "image_files.py", "config"}
    files = sorted(f for f in here.rglob("*.py") if f.relative_to(here).parts[0] not in others)
    return hashlib.blake2b(b"".join(f.read_bytes() for f in files), digest_size=6).hexdigest()
