"""Renderer: shots in, frames out, with timings."""

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
from render.camera_sweep import camera_sweep
from render.config import FullFilm
from render.edge_smoothing import smoothed_edges
from render.errors import device_memory_errors
from render.frame import Frame, Image, LensBlur, LightLayers
from render.passes.pass_images import PassImages
from render.shot import Shot
from render.specks import without_specks

if TYPE_CHECKING:
    from render.mitsuba_scene import MitsubaScene


FEW_SAMPLES = 8
"""Samples of a pixel up to which soft shadows, as in the shade of leaves, are noisy, and edges
stepped."""


KEPT_PIXELS = 1280 * 720
"""Pixels of a frame up to which the memory of its buffers is kept for the next."""


@dataclass
class Timings:
    """Seconds spent by a renderer so far.

    Attributes:
        frames: number of finished frames.
        build: building Mitsuba scenes.
        update: updating them in place.
        trace: tracing, to the last pixel.
        denoise: denoising.
    """

    frames: int = 0
    build: float = 0.0
    update: float = 0.0
    trace: float = 0.0
    denoise: float = 0.0

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Add the time spent in the block to a part."""
        start = time.perf_counter()
        yield
        setattr(self, part, getattr(self, part) + time.perf_counter() - start)

    @property
    def seconds(self) -> float:
        """The sum of all parts."""
        return self.build + self.update + self.trace + self.denoise


class Renderer:
    """Renders shots on one backend; builds a scene only when `Shot.build` changes.

    Args:
        backend: that Mitsuba runs on.
        threads: of Mitsuba, all processors by default; pixels do not depend on it.

    Attributes:
        backend: that Mitsuba runs on.
        timings: seconds spent so far.
        key_extra: all that a frame depends on besides its shot; part of its key.
    """

    def __init__(self, backend: Backend, threads: int | None = None) -> None:
        backend.activate()
        # Mitsuba reads the backend when it is imported.
        import drjit

        from render.denoiser import Denoiser

        if threads is not None:
            drjit.set_thread_count(threads)
        self.backend = backend
        self.timings = Timings()
        self._denoiser = Denoiser()
        self._scene: MitsubaScene | None = None
        self.key_extra = f"{backend.key}; {self._denoiser.key}; look {code_digest()}"

    def render(self, shot: Shot) -> Frame:
        """Render one shot.

        Raises:
            ShotError: the shot cannot be drawn.
            DenoiseError: the denoiser is missing or failed.
            DeviceMemoryShort: the GPU has too little memory.
        """
        import drjit

        film = shot.film.resolved()
        if film.denoise != "off":
            self._denoiser.require()
        with device_memory_errors():
            scene = self.scene_for(shot)
            layers, passes, blur = self._trace(scene, shot, film)
        with self.timings.timed("denoise"):
            # The denoiser needs as much memory as Dr.Jit keeps of the buffers of a trace. To ask
            # the system for it again takes a thirtieth of the time of a preview.
            if film.size[0] * film.size[1] > KEPT_PIXELS:
                drjit.flush_malloc_cache()
            is_noisy = scene.has_soft_lights or film.samples <= FEW_SAMPLES
            light = self._denoiser.clean(layers, film.denoise, has_soft_lights=is_noisy)
            if blur is not None and film.denoise != "off":
                light = self._denoiser.clean_blur(light, blur, film.denoise)
            if film.denoise != "off" and film.samples <= FEW_SAMPLES:
                light = smoothed_edges(light, shot.development.tone.stops)
        self.timings.frames += 1
        return Frame(light, shot.development, passes)

    def measure(self, shot: Shot) -> Image:
        """Return the light of the first moment of a shot as a small picture, for the meter.

        It is the same for every size and quality of the film.

        Raises:
            ShotError: the shot cannot be drawn.
            DeviceMemoryShort: the GPU has too little memory.
        """
        with device_memory_errors():
            scene = self.scene_for(shot)
            with self.timings.timed("trace"):
                layers = scene.measure(shot.moments[0], shot.seed)
        return layers.light

    def _trace(
        self, scene: MitsubaScene, shot: Shot, film: FullFilm
    ) -> tuple[LightLayers, PassImages, LensBlur | None]:
        """Return the mean of all moments of the exposure, the passes, and the blur of the lens.

        The blur is None where nothing is out of focus, or nothing is to be denoised.
        """
        count = len(shot.moments)
        each = max(round(film.rounds / count), 1)
        airborne, exposure = scene.airborne_exposure(shot), scene.pass_exposure(shot)
        # The camera may go on between moments, by which rays to what stands still are spread.
        is_still = airborne is not None and count == 1
        accumulator = scene.accumulator(has_airborne=is_still)
        poses = [moment.camera for moment in shot.moments]
        for k, moment in enumerate(shot.moments):
            if k:
                with self.timings.timed("update"):
                    scene.update(moment)
            passes = range(k * each, (k + 1) * each)
            with self.timings.timed("trace"):
                view = scene.view(camera_sweep(poses, k))
                accumulator.add_passes(view, shot.seed, passes, count * each)
                if airborne:
                    scene.add_airborne(airborne, moment, k, count, accumulator.distances)
                if exposure:
                    exposure.add(scene.sensor, k)
        with self.timings.timed("trace"):
            layers = accumulator.layers()
            blur = None
            if film.denoise != "off":
                blur = scene.lens_blur(shot.moments[-1].camera)
                if film.samples <= FEW_SAMPLES:
                    layers = without_specks(layers, None if blur is None else blur.soft)
            if airborne:
                airborne.lay_over(layers)
            return layers, exposure.images() if exposure else PassImages(), blur

    def scene_for(self, shot: Shot) -> MitsubaScene:
        """Return the Mitsuba scene of a shot, updated in place where the build is the same."""
        from render.mitsuba_scene import MitsubaScene

        # A scene whose update raised must not be used again.
        scene, self._scene = self._scene, None
        if scene is None or scene.build != shot.build:
            del scene  # frees the old scene before the new one is made
            with self.timings.timed("build"):
                scene = MitsubaScene(shot)
        else:
            with self.timings.timed("update"):
                scene.update(shot.moments[0])
        self._scene = scene
        return scene


@cache
def code_digest() -> str:
    """Return a digest of the modules that decide what a frame looks like."""
    here = Path(__file__).parent
    # The configuration is in the digest of a shot, and a film is made of finished frames.
    others = {
        "backend.py",
        "config",
        "errors.py",
        "film_codecs.py",
        "film_comparison.py",
        "film_encoder.py",
        "film_file.py",
        "film_segments.py",
        "film_sound.py",
        "image_files.py",
    }
    files = sorted(f for f in here.rglob("*.py") if f.relative_to(here).parts[0] not in others)
    return hashlib.blake2b(b"".join(f.read_bytes() for f in files), digest_size=6).hexdigest()
