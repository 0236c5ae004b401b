"""Mitsuba's own path tracer behind the tracer interface.

It is the reference for the wavefront tracer, and traces what that one does not support.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.frame import ALBEDO_BIAS, Image, LightLayers
from render.tracing.camera_rays import CameraView
from render.tracing.haze import Air
from render.tracing.tracer import Accumulator, Tracer

SEED_STRIDE = 7919
"""Difference of the seeds of two passes."""


class PathTracer(Tracer):
    """Traces one scene with `path`.

    Args:
        scene: of Mitsuba.
        depth: longest path, in segments.
        rays: paths per pixel in a pass.
        air: haze before the camera, None without any.
    """

    def __init__(self, scene: Any, depth: int, rays: int = 1, air: Air | None = None) -> None:
        self._scene, self._rays = scene, rays
        self._layers = _layered_path(depth, air)

    def accumulator(self, kept_distances: int = 0) -> Accumulator:
        """Return an empty accumulator, which keeps no distances."""
        del kept_distances
        return _Accumulator(self)

    def scene_changed(self) -> None:
        """Do nothing: the tracer keeps no state of the scene."""

    def render(self, sensor: Any, seed: int, samples: int) -> Image:
        """Return reflected light, albedo and air, (H, W, 9), as means of some samples."""
        image = self._layers.render(self._scene, sensor, seed=seed, spp=samples * self._rays)
        # Reading the pixels waits for Mitsuba, so that callers can time this.
        return np.array(image, np.float32)


def _layered_path(depth: int, air: Air | None) -> Any:
    """Return `path` with what the first surface is, and its auxiliary layers, as extra channels.

    The base class depends on the variant of Mitsuba, which is chosen later than this is imported.
    """
    path = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": depth + 1})

    class LayeredPath(mi.SamplingIntegrator):
        def sample(
            self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True
        ) -> tuple[Any, Any, list[Any]]:
            si = scene.ray_intersect(ray, active)
            light, *_ = path.sample(scene, sampler, ray, medium, active)
            shining, albedo = _emission(scene, si, active), _albedo(si)
            # What the first surface sends out itself is part of both.
            light = light - shining
            if air is not None:
                passed = dr.select(si.is_valid(), air.transmittance(ray.o, ray.d, si.t), 1.0)
                light, albedo = light * passed, albedo * passed
                shining = shining * passed + air.scattered(ray.d) * (1.0 - passed)
            return light, si.is_valid(), [*albedo, *shining]

        def aov_names(self) -> list[str]:
            return [f"{part}.{channel}" for part in ("albedo", "air") for channel in "RGB"]

    return LayeredPath(mi.Properties())


def _emission(scene: Any, si: Any, active: Any) -> Any:
    emitter = si.emitter(scene)
    if emitter is None:
        return mi.Color3f(0.0)
    return mi.Color3f(emitter.eval(si, active & (emitter != None)))  # noqa: E711  (lane by lane)


def _albedo(si: Any) -> Any:
    """Return the albedo of surfaces plus `ALBEDO_BIAS`, 0 where there is none."""
    if not dr.is_jit_v(mi.Float) and not si.is_valid():
        # A ray by itself, which met nothing, has no surface to ask.
        return mi.Color3f(0.0)
    albedo = dr.clip(si.bsdf().eval_diffuse_reflectance(si, si.is_valid()), 0.0, 1.0) + ALBEDO_BIAS
    return mi.Color3f(dr.select(si.is_valid(), albedo, 0.0))


class _Accumulator(Accumulator):
    """Sums light, albedo and air; direct and indirect light are not separated."""

    def __init__(self, tracer: PathTracer) -> None:
        self._tracer = tracer
        self._sum: Image | None = None
        self._passes = 0

    def add_passes(self, view: CameraView, seed: int, passes: range, total: int) -> None:
        """Add what the sensor sees now."""
        # Each moment has its own samples, or their noise would add up coherently.
        seed = (seed + SEED_STRIDE * passes.start) & 0xFFFFFFFF
        part = self._tracer.render(view.sensor, seed, len(passes)) * np.float32(len(passes))
        self._sum = part if self._sum is None else self._sum + part
        self._passes += len(passes)

    def layers(self) -> LightLayers:
        """Return the mean of all passes."""
        if self._sum is None:
            raise ValueError("there are no passes")
        light, albedo, air = np.split(self._sum / np.float32(self._passes), 3, axis=-1)
        self._sum = None
        return LightLayers(np.zeros_like(light), albedo, light, albedo, air)
