"""Mitsuba's own path tracer, behind the same door as ours.

It is the judge of ours, and traces what ours does not.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from render.exposure import Exposure, Image

STRIDE = 7919
"""Between the seeds of two passes."""


class PathTracer:
    """Traces one scene with `path`; colours have a pass of their own.

    Args:
        scene: of Mitsuba.
        depth: longest path, in segments.
        rays: paths through each pixel in a pass.
    """

    def __init__(self, scene: Any, depth: int, rays: int = 1) -> None:
        self._scene, self._rays = scene, rays
        self._light = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": depth + 1})
        # Around the path tracer it would double the time.
        self._color = mi.load_dict({"type": "aov", "aovs": "color:albedo"})

    def expose(self, sensor: Any, seed: int, passes: range, of: int) -> Exposure:
        """Return light and colour; see `tracer.Tracer`. It does not part direct from indirect."""
        # Each moment has samples of its own, or its noise would be that of one.
        seed = (seed + STRIDE * passes.start) & 0xFFFFFFFF
        light = self._rendered(self._light, sensor, seed, len(passes))
        # The same seed leads through the same places of the pixels.
        color = self._rendered(self._color, sensor, seed, len(passes))[..., -3:].clip(0.0, 1.0)
        return Exposure(np.zeros_like(light), color, light, color)

    def moved(self) -> None:
        """Take note that the scene was changed in place: it keeps nothing of it."""

    def _rendered(self, integrator: Any, sensor: Any, seed: int, samples: int) -> Image:
        image = integrator.render(self._scene, sensor, seed=seed, spp=samples * self._rays)
        # Reading the pixels waits for Mitsuba, so that times taken outside are honest.
        return np.array(image, np.float32)
