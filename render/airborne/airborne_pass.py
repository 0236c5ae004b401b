"""Airborne pass: what is in the air before the surfaces, laid over the traced light.

It is traced apart, by few rays through each pixel up to the first surface, and laid over the layers
of light before they are denoised: rain has no noise, and what glows or scatters in the air is no
business of the surfaces behind. Reflections lack it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.airborne.plumes import PlumeLight, PlumeVolume, ray_jitter
from render.airborne.precipitation import Precipitation
from render.airborne.puffs import Puffs
from render.config import Weather
from render.frame import Image, LightLayers
from render.lights.environment_map import Vector
from render.lights.key_light import KeyLight
from render.shot import Moment
from render.tracing.camera_rays import camera_ray
from render.tracing.haze import Air
from render.tracing.stratification import PassStrata, stratum_grid
from render.tracing.tracer import PixelLanes

PLUME_RAYS = 4
"""Rays through each pixel of a frame, at least, where there are flames or smoke."""
PUFF_RAYS = 2
"""The same where there is dust, which is fainter."""
MAX_FLAMES = 4
"""Fires that light smoke."""


@dataclass(frozen=True, eq=False)
class Contents:
    """What is in the air at one moment.

    Attributes:
        falling: rain and snow, or None.
        plumes: flames and smoke, from near to far.
        puffs: dust and spray, or None.
    """

    falling: Precipitation | None
    plumes: tuple[PlumeVolume, ...]
    puffs: Puffs | None


class AirbornePass:
    """Traces what is in the air of one scene.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        size: width and height of the frame [pixels].
        air: haze before what is in the air, None without any.
    """

    def __init__(self, scene: Any, size: tuple[int, int], air: Air | None) -> None:
        self._scene, self._air = scene, air
        self._lanes = PixelLanes(size)

    def begin(self) -> AirborneExposure:
        """Return what is in the air before the first moment of a frame."""
        return AirborneExposure(self)

    def traced(
        self,
        sensor: Any,
        fov_deg: float,
        contents: Contents,
        k: int,
        total: int,
    ) -> Image:
        """Return the share of light that passes, and the light added, (H, W, 4).

        Args:
            sensor: of the scene.
            fov_deg: vertical angle of view [degrees].
            contents: of the air at this moment.
            k: number of the ray through each pixel.
            total: rays through each pixel of the frame.
        """
        width, height = self._lanes.size
        angle = dr.opaque(mi.Float, 2 * math.tan(math.radians(fov_deg) / 2) / height)
        number = dr.opaque(mi.UInt32, k)
        strata = PassStrata(0, k, stratum_grid(total))
        values = dr.empty(mi.Float, 4 * width * height)
        for pixels in self._lanes.chunks:
            ray = camera_ray(sensor, pixels, self._lanes.size, strata.step(0))
            hit = self._scene.ray_intersect_preliminary(ray, coherent=True)
            distance = dr.select(hit.is_valid(), hit.t, 1e6)
            passed, light = mi.Float(1.0), mi.Color3f(0.0)
            if contents.falling is not None:
                passed, light = self._through_rain(contents.falling, ray, hit, distance, angle)
            if contents.puffs is not None:
                dr.eval(ray, distance, passed, light)
                share, added = contents.puffs.seen(ray, distance)
                light += passed * added
                passed = passed * share
            for plume in contents.plumes:
                # A kernel for each: one of all would be compiled anew when they change places.
                dr.eval(ray, distance, passed, light)
                share, added = plume.seen(ray, distance, ray_jitter(pixels, number))
                light += passed * self._in_haze(ray, plume, share, added)
                passed = passed * share
            for channel, value in enumerate((passed, *light)):
                dr.scatter(values, value, 4 * pixels + channel)
            dr.eval(values)
        return np.array(values, np.float32).reshape(height, width, 4)

    def _through_rain(
        self, falling: Precipitation, ray: Any, hit: Any, distance: Any, angle: Any
    ) -> tuple[Any, Any]:
        passed, light = falling.seen(ray, distance, angle)
        if falling.has_rain:
            si = hit.compute_surface_interaction(ray, mi.RayFlags.Minimal, hit.is_valid())
            splashed = falling.splashes(si.p, si.n, distance, angle)
            splashed = dr.select(hit.is_valid(), splashed, 0.0)
            light += passed * splashed * falling.rain_light
            passed = passed * (1.0 - splashed)
        return passed, light

    def _in_haze(self, ray: Any, plume: PlumeVolume, share: Any, light: Any) -> Any:
        """Return the light of a plume behind the haze before it."""
        if self._air is None:
            return light
        away = dr.norm(plume.middle() - ray.o)
        clear = self._air.transmittance(ray.o, ray.d, away)
        return light * clear + self._air.scattered(ray.d) * ((1.0 - clear) * (1.0 - share))


def airborne_contents(
    moment: Moment, weather: Weather, key: KeyLight | None, ambient: Vector
) -> Contents:
    """Return what is in the air at a moment.

    Args:
        moment: of a shot.
        weather: of its scene.
        key: the key light, or None.
        ambient: (3,) mean radiance from all directions.
    """
    way = np.array([0.0, 1.0, 0.0]) if key is None else key.direction
    lit = PlumeLight(way, np.zeros(3) if key is None else key.irradiance, ambient)
    camera = np.array(moment.camera.p_WC)
    flames = [plume for plume in moment.plumes if plume.kind == "flame"][:MAX_FLAMES]
    near = sorted(moment.plumes, key=lambda p: float(np.linalg.norm(np.array(p.p_WP) - camera)))
    return Contents(
        Precipitation.of(weather, ambient, lit.key, moment.time) if weather.falls else None,
        tuple(PlumeVolume(plume, lit, flames, moment.time) for plume in near),
        Puffs.of(moment.puffs, lit) if moment.puffs else None,
    )


class AirborneExposure:
    """What is in the air while the shutter is open."""

    def __init__(self, tracer: AirbornePass) -> None:
        self._tracer = tracer
        self._sum: Image | None = None
        self._count = 0

    def add(self, *moment: Any) -> None:
        """Add one ray through each pixel; see `AirbornePass.traced`."""
        seen = self._tracer.traced(*moment)
        self._sum = seen if self._sum is None else self._sum + seen
        self._count += 1

    def over(self, layers: LightLayers) -> LightLayers:
        """Return the layers of light with what is in the air before them."""
        if self._sum is None:
            return layers
        mean = self._sum / np.float32(self._count)
        passed, added = mean[..., :1], mean[..., 1:]
        soft = passed
        if layers.indirect.shape != layers.direct.shape:
            # Light at half the size is dimmed where it is enlarged again: with its albedo.
            height, width = layers.indirect.shape[:2]
            soft = passed[: 2 * height, : 2 * width].reshape(height, 2, width, 2, 1).mean((1, 3))
        return replace(
            layers,
            direct=layers.direct * passed,
            albedo=layers.albedo * passed,
            indirect=layers.indirect * soft,
            indirect_albedo=layers.indirect_albedo * soft,
            air=layers.air * passed + added,
        )
