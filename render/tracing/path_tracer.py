"""Mitsuba's own path tracer, behind the same door as ours.

It is the judge of ours, and traces what ours does not.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from render.exposure import GLEAM, Exposure, Image
from render.tracing.tracer import Plate, Tracer

STRIDE = 7919
"""Between the seeds of two passes."""


class PathTracer(Tracer):
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
        self._color = mi.load_dict({"type": "aov", "aovs": "color:albedo,far:depth"})

    def plate(self) -> Plate:
        """Return a plate on which nothing has fallen yet."""
        return _Plate(self)

    def moved(self) -> None:
        """Take note that the scene was changed in place: it keeps nothing of it."""

    def seen(self, sensor: Any, seed: int, samples: int) -> tuple[Image, Image]:
        """Return light and colour, (H, W, 3) each, the means of some samples."""
        light = self._rendered(self._light, sensor, seed, samples)
        # The same seed leads through the same places of the pixels.
        aovs = self._rendered(self._color, sensor, seed, samples)
        surface = aovs[..., -1:] > 0.0
        return light, (aovs[..., -4:-1].clip(0.0, 1.0) + np.float32(GLEAM)) * surface

    def _rendered(self, integrator: Any, sensor: Any, seed: int, samples: int) -> Image:
        image = integrator.render(self._scene, sensor, seed=seed, spp=samples * self._rays)
        # Reading the pixels waits for Mitsuba, so that times taken outside are honest.
        return np.array(image, np.float32)


class _Plate(Plate):
    """Light and colour; direct and indirect light are not parted.

    Args:
        tracer: what fills it.
    """

    def __init__(self, tracer: PathTracer) -> None:
        self._tracer = tracer
        self._sums: list[Image] = []
        self._passes = 0

    def expose(self, sensor: Any, seed: int, passes: range, of: int) -> None:
        """Add what the sensor sees now."""
        # Each moment has samples of its own, or its noise would be that of one.
        seed = (seed + STRIDE * passes.start) & 0xFFFFFFFF
        parts = self._tracer.seen(sensor, seed, len(passes))
        for part in parts:
            part *= np.float32(len(passes))
        if not self._sums:
            self._sums = list(parts)
        else:
            for total, part in zip(self._sums, parts, strict=True):
                total += part
        self._passes += len(passes)

    def exposure(self) -> Exposure:
        """Return the mean of all passes."""
        for total in self._sums:
            total /= np.float32(self._passes)
        light, color = self._sums
        return Exposure(np.zeros_like(light), color, light, color)
