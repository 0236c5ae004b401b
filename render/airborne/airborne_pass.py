"""Airborne pass: what is in the air before the surfaces, laid over the traced light.

It is traced apart, by few rays through each pixel where it may be seen, up to the first surface,
and laid over the layers of light before they are denoised: rain has no noise, and what glows or
scatters in the air is no business of the surfaces behind. Reflections lack it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.airborne.picture_area import picture_area
from render.airborne.plumes import PlumeLight, PlumeVolume, ray_jitter
from render.airborne.precipitation import OpenLens, Precipitation
from render.airborne.puffs import Puffs
from render.airborne.sparks import Sparks
from render.config import Weather
from render.fire_streaks import fire_streaks, streak_spheres
from render.frame import Image, LightLayers
from render.lights.environment_map import Vector
from render.lights.key_light import KeyLight
from render.shot import Moment
from render.tracing.camera_rays import camera_ray, central_ray
from render.tracing.haze import Air
from render.tracing.stratification import PassStrata, stratum_grid
from render.tracing.tracer import in_chunks, pixels_of

PLUME_RAYS = 4
"""Rays through each pixel of a frame, at least, where there are flames or smoke."""
PUFF_RAYS = 2
"""The same where there is dust, which is fainter."""
LEAST_DIMMING = 1.0 / 1024.0
"""Share of light that a puff takes at least where it is shown: a quarter of a step of 8 bits."""
FAR = 1e6
"""Distance where there is no surface [m]."""
NOTHING = np.array([1.0, 0.0, 0.0, 0.0], np.float32)
"""What a ray meets in clear air: the share of light that passes, and the light added."""
MAX_FLAMES = 4
"""Fires that light smoke."""


@dataclass(frozen=True, eq=False)
class Contents:
    """What is in the air at one moment.

    Attributes:
        falling: rain and snow, or None.
        plumes: flames and smoke, from near to far.
        puffs: dust and spray, or None.
        sparks: of fires, or None.
    """

    falling: Precipitation | None
    plumes: tuple[PlumeVolume, ...]
    puffs: Puffs | None
    sparks: Sparks | None

    @property
    def lone_puffs(self) -> Puffs | None:
        """The puffs if there is nothing else, or None."""
        others = self.falling is not None or self.plumes or self.sparks is not None
        return None if others else self.puffs


class AirbornePass:
    """Traces what is in the air of one scene.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        area: (H, W) where something may be seen.
        air: haze before what is in the air, None without any.
    """

    def __init__(self, scene: Any, area: NDArray[np.bool_], air: Air | None) -> None:
        self._scene, self._air = scene, air
        self._size = (area.shape[1], area.shape[0])
        self._pixels = pixels_of(area)
        self._chunks = in_chunks(self._pixels)

    def begin(self) -> AirborneExposure:
        """Return what is in the air before the first moment of a frame."""
        return AirborneExposure(self, self._pixels)

    def traced(
        self,
        sensor: Any,
        fov_deg: float,
        contents: Contents,
        k: int,
        total: int,
        distances: Sequence[Any] = (),
    ) -> Image:
        """Return the share of light that passes, and the light added, (n, 4) of all pixels.

        Args:
            sensor: of the scene.
            fov_deg: vertical angle of view [degrees].
            contents: of the air at this moment.
            k: number of the ray through each pixel.
            total: rays through each pixel of the frame.
            distances: of the surfaces in a pixel, pixel by pixel, if they are known and there is
                dust alone. One ray is enough, for within a pixel dust hardly changes.
        """
        angle = 2 * math.tan(math.radians(fov_deg) / 2) / self._size[1]
        angle = dr.opaque(mi.Float, angle)
        number = dr.opaque(mi.UInt32, k)
        strata = PassStrata(0, k, stratum_grid(total))
        found = []
        for pixels in self._chunks:
            if contents.lone_puffs is not None:
                ends = [dr.gather(mi.Float, one, pixels) for one in distances]
                rays = central_ray(sensor, pixels, self._size)
                if not ends:
                    rays = camera_ray(sensor, pixels, self._size, strata.step(0))
                found.append(self._through_dust(contents.lone_puffs, rays, ends))
                continue
            ray = camera_ray(sensor, pixels, self._size, strata.step(0))
            hit = self._scene.ray_intersect_preliminary(ray, coherent=True)
            distance = dr.select(hit.is_valid(), hit.t, FAR)
            passed, light = mi.Float(1.0), mi.Color3f(0.0)
            if contents.falling is not None:
                passed, light = self._through_rain(contents.falling, ray, hit, distance, angle)
            if contents.puffs is not None:
                dr.eval(ray, distance, passed, light)
                share, added = contents.puffs.seen(ray, [distance])
                light += passed * added
                passed = passed * share
            for plume in contents.plumes:
                # A kernel for each: one of all would be compiled anew when they change places.
                dr.eval(ray, distance, passed, light)
                share, added = plume.seen(ray, distance, ray_jitter(pixels, number))
                light += passed * self._in_haze(ray, plume, share, added)
                passed = passed * share
            if contents.sparks is not None:
                dr.eval(ray, distance, passed, light)
                light += contents.sparks.seen(pixels, ray, distance, angle)
            lanes = dr.arange(mi.UInt32, dr.width(pixels))
            found.append(_written(passed, light, lanes, dr.width(pixels)))
        return np.concatenate(found)

    def _through_dust(self, puffs: Puffs, ray: Any, ends: Sequence[Any]) -> Image:
        """Return what `traced` does of rays through dust alone.

        Args:
            puffs: of dust.
            ray: from the camera.
            ends: distances of the surfaces in a pixel [m]; empty if they are not known.
        """
        n = dr.width(ray.d)
        lanes = dr.arange(mi.UInt32, n)
        if not ends:
            lanes = _dusty(puffs, ray)
            if dr.width(lanes) == 0:
                return np.tile(NOTHING, (n, 1))
            ray = dr.gather(mi.Ray3f, ray, lanes)
            hit = self._scene.ray_intersect_preliminary(ray, coherent=True)
            ends = [dr.select(hit.is_valid(), hit.t, FAR)]
        ends = [dr.minimum(end, FAR) for end in ends]
        dr.eval(ray, ends)
        return _written(*puffs.seen(ray, ends), lanes, n)

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


def _written(passed: Any, light: Any, lanes: Any, count: int) -> Image:
    """Return the share of light that passes, and the light added, (count, 4).

    Args:
        passed: of some rays, `mi.Float`.
        light: of the same, `mi.Color3f`.
        lanes: numbers of these rays.
        count: of all rays; the others meet nothing.
    """
    values = mi.Float(np.tile(NOTHING, count))
    for channel, value in enumerate((passed, *light)):
        dr.scatter(values, value, 4 * lanes + channel)
    return np.asarray(values).reshape(-1, 4)


def _dusty(puffs: Puffs, ray: Any) -> Any:
    """Return the numbers of rays that puffs dim where no surface is before them.

    Around a ragged puff most rays pass it, and need not look for a surface.
    """
    dr.eval(ray)
    share, _ = puffs.seen(ray, [dr.full(mi.Float, FAR, dr.width(ray.d))])
    return mi.UInt32(dr.compress(share < 1.0 - LEAST_DIMMING))


def airborne_area(
    moments: Sequence[Moment], size: tuple[int, int], weather: Weather
) -> NDArray[np.bool_]:
    """Return whether something in the air may be seen in a pixel at some moment, (H, W).

    Args:
        moments: of an exposure.
        size: width and height of the frame [pixels].
        weather: of the scene.
    """
    area = np.full((size[1], size[0]), weather.falls)
    if weather.falls:
        return area
    for moment in moments:
        spheres = [puff.bounding_sphere for puff in moment.puffs]
        spheres += [plume.bounding_sphere for plume in moment.plumes]
        area |= picture_area(moment.camera, np.array(spheres).reshape(-1, 4), size)
        for plume in moment.plumes:
            if plume.kind == "flame":
                sparks = streak_spheres(fire_streaks(plume, moment.time))
                area |= picture_area(moment.camera, sparks, size)
    return area


def airborne_contents(
    moment: Moment,
    weather: Weather,
    key: KeyLight | None,
    ambient: Vector,
    size: tuple[int, int],
) -> Contents:
    """Return what is in the air at a moment.

    Args:
        moment: of a shot.
        weather: of its scene.
        key: the key light, or None.
        ambient: (3,) mean radiance from all directions.
        size: width and height of the frame [pixels].
    """
    way = np.array([0.0, 1.0, 0.0]) if key is None else key.direction
    lit = PlumeLight(way, np.zeros(3) if key is None else key.irradiance, ambient)
    camera = np.array(moment.camera.p_WC)
    fires = [plume for plume in moment.plumes if plume.kind == "flame"]
    near = sorted(moment.plumes, key=lambda p: float(np.linalg.norm(np.array(p.p_WP) - camera)))
    falling = None
    if weather.falls:
        lens = OpenLens.of(moment.camera)
        falling = Precipitation.of(weather, ambient, lit.key, moment.time, lens)
    return Contents(
        falling,
        tuple(PlumeVolume(plume, lit, fires[:MAX_FLAMES], moment.time) for plume in near),
        Puffs.of(moment.puffs, lit) if moment.puffs else None,
        Sparks.of(fires, moment.time, moment.camera, size) if fires else None,
    )


class AirborneExposure:
    """What is in the air while the shutter is open.

    Args:
        tracer: of the scene.
        pixels: numbers of those that it traces.
    """

    def __init__(self, tracer: AirbornePass, pixels: NDArray[np.uint32]) -> None:
        self._tracer, self._pixels = tracer, pixels
        self._sum = np.zeros((len(pixels), 4), np.float32)
        self._count = 0

    def add(self, *moment: Any) -> None:
        """Add one ray through each pixel; see `AirbornePass.traced`."""
        if len(self._pixels):
            self._sum += self._tracer.traced(*moment)
        self._count += 1

    def lay_over(self, layers: LightLayers) -> None:
        """Lay what is in the air over the layers of light, in place."""
        if len(self._pixels) == 0:
            return
        width = layers.albedo.shape[1]
        # Pairs of rows, for light at half the size; frames have an even number of them.
        top = int(self._pixels.min()) // (2 * width) * 2
        bottom = (int(self._pixels.max()) // (2 * width) + 1) * 2
        seen = np.zeros(((bottom - top) * width, 4), np.float32)
        seen[:, 0] = 1.0
        seen[self._pixels - np.uint32(top * width)] = self._sum / np.float32(self._count)
        passed, added = np.split(seen.reshape(bottom - top, width, 4), [1], axis=-1)
        for layer in (layers.direct, layers.albedo, layers.air, layers.open_light):
            if layer is not None:
                layer[top:bottom] *= passed
        layers.air[top:bottom] += added
        if layers.indirect.shape != layers.direct.shape:
            # Light at half the size is dimmed where it is enlarged again: with its albedo.
            passed = passed.reshape((bottom - top) // 2, 2, width // 2, 2, 1).mean((1, 3))
            top, bottom = top // 2, bottom // 2
        for layer in (layers.indirect, layers.indirect_albedo):
            layer[top:bottom] *= passed
