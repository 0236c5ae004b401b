"""Mitsuba's own path tracer behind the tracer interface.

It is the reference for the wavefront tracer, and traces what that one does not support.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from render.frame import ALBEDO_BIAS, Image, LightLayers
from render.tracing.tracer import Accumulator, Tracer

SEED_STRIDE = 7919
"""Difference of the seeds of two passes."""


class PathTracer(Tracer):
    """Traces one scene with `path`, and its albedo in a pass of its own.

    Args:
        scene: of Mitsuba.
        depth: longest path, in segments.
        rays: paths per pixel in a pass.
    """

    def __init__(self, scene: Any, depth: int, rays: int = 1) -> None:
        self._scene, self._rays = scene, rays
        self._light = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": depth + 1})
        # Around the path tracer it would double the time.
        self._albedo = mi.load_dict({"type": "aov", "aovs": "color:albedo,far:depth"})

    def accumulator(self) -> Accumulator:
        """Return an empty accumulator."""
        return _Accumulator(self)

    def scene_changed(self) -> None:
        """Do nothing: the tracer keeps no state of the scene."""

    def render(self, sensor: Any, seed: int, samples: int) -> tuple[Image, Image]:
        """Return light and albedo, (H, W, 3) each, as means of some samples."""
        light = self._integrate(self._light, sensor, seed, samples)
        # The same seed draws the same positions within pixels.
        aovs = self._integrate(self._albedo, sensor, seed, samples)
        surface = aovs[..., -1:] > 0.0
        return light, (aovs[..., -4:-1].clip(0.0, 1.0) + np.float32(ALBEDO_BIAS)) * surface

    def _integrate(self, integrator: Any, sensor: Any, seed: int, samples: int) -> Image:
        image = integrator.render(self._scene, sensor, seed=seed, spp=samples * self._rays)
        # Reading the pixels waits for Mitsuba, so that callers can time this.
        return np.array(image, np.float32)


class _Accumulator(Accumulator):
    """Sums light and albedo; direct and indirect light are not separated."""

    def __init__(self, tracer: PathTracer) -> None:
        self._tracer = tracer
        self._sums: list[Image] = []
        self._passes = 0

    def add_passes(self, sensor: Any, seed: int, passes: range, total: int) -> None:
        """Add what the sensor sees now."""
        # Each moment has its own samples, or their noise would add up coherently.
        seed = (seed + SEED_STRIDE * passes.start) & 0xFFFFFFFF
        parts = self._tracer.render(sensor, seed, len(passes))
        for part in parts:
            part *= np.float32(len(passes))
        if not self._sums:
            self._sums = list(parts)
        else:
            for summed, part in zip(self._sums, parts, strict=True):
                summed += part
        self._passes += len(passes)

    def layers(self) -> LightLayers:
        """Return the mean of all passes."""
        for summed in self._sums:
            summed /= np.float32(self._passes)
        light, albedo = self._sums
        return LightLayers(np.zeros_like(light), albedo, light, albedo)
