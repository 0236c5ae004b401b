"""Light of a water surface: what it reflects, what is seen through it, and how paths go on.

Both directions are followed from every place where the camera sees the surface, so that water is
as free of noise as the ground. Paths of indirect light take one of them by chance.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.tracing.cloud_shade import CloudShade, dimmed
from render.tracing.direct_light import finite, passed_air, surface_light
from render.tracing.haze import Air
from render.tracing.scene_pair import emitters_of
from render.tracing.sky_relief import SkyRelief
from render.tracing.stratification import BSDF_PAIR, EMITTER_PAIR, StepStrata, sample_1d, sample_2d
from render.tracing.tracer import Sums
from render.tracing.water import FAR, KEY_LIGHT_FROM, Interface, Water

_LEAST_CHANCE = 0.15
"""Least chance of a path to be reflected, or to be refracted."""

_CLEARANCE = 1e-3
"""Length by which rays start off the surface [m]."""


def add_water(
    scene: Any,
    air: Air | None,
    shade: CloudShade | None,
    water: Water,
    relief: SkyRelief | None,
    lanes: Any,
    pixels: Any,
    ray: Any,
    has_lamps: bool,
    sums: list[Any],
    strata: StepStrata,
) -> Sums:
    """Add what is seen in and through the water that rays meet before any other surface.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        air: haze before the camera, None without any.
        shade: of clouds, None without any.
        water: of the scene.
        relief: see `surface_light`.
        lanes: of the rays in the sums.
        pixels: of the rays.
        ray: from the camera.
        has_lamps: whether surfaces are lit at all.
        sums: of light, albedo and air, with what lies before the water; of light without shadows
            if it is asked for.
        strata: of the step.
    """
    t = water.crossing(ray)
    face = water.interface(ray, t)
    passed = _before(air, water, ray, t)
    parts = [mi.Color3f(0.0) for _ in sums]
    # What is refracted first: it tells how deep the water is, and so where foam lies.
    ways = (
        (1.0 - face.reflectance, face.refracted, face.is_above, BSDF_PAIR),
        (face.reflectance, face.reflected, ~face.is_above, EMITTER_PAIR),
    )
    foamy: Any = mi.Color3f(0.0)
    for share, direction, is_under, pair in ways:
        way = mi.Ray3f(face.p + _CLEARANCE * direction, direction)
        u = sample_2d(pixels, strata, pair), sample_1d(pixels, strata)
        hit = scene.ray_intersect_preliminary(way, coherent=False)
        light, open_light, albedo, shining, distance = surface_light(
            scene, shade, water, relief, way, hit, u, has_lamps
        )
        if pair == BSDF_PAIR:
            depth = dr.minimum(distance, FAR) * dr.abs(direction.y)
            bottom = hit.compute_surface_interaction(way, mi.RayFlags.Minimal)
            foam = water.foam.share(face.p, depth, bottom.n)
            foam = dr.select(face.is_above, foam, 0.0)
            passed, foamy = passed * (1.0 - foam), passed * foam
        if pair == EMITTER_PAIR:
            mirrored = _mirrored_sky(scene, water, face, ray, strata)
            is_sky = face.is_above & ~dr.isfinite(distance)
            shining = dr.select(is_sky, mirrored, shining)
        # The disc of the key light is in the glitter, which spreads it over the waves.
        is_key = (distance > KEY_LIGHT_FROM) & dr.isfinite(distance) & (face.is_above != is_under)
        shining = dr.select(is_key, 0.0, shining)
        left, added = mi.Color3f(1.0), mi.Color3f(0.0)
        if air is not None:
            left = passed_air(air, way, distance)
            added = air.scattered(direction) * (1.0 - left)
        left = dr.select(is_under, water.transmittance(distance), left)
        added = dr.select(is_under, water.scattered(way.o, direction, distance), added)
        shining = shining * left + added
        values = light * left, albedo * left, shining, open_light * left
        for i, value in enumerate(values[: len(parts)]):
            parts[i] += share * passed * finite(value)
    parts[2] += foamy * water.foam.radiance
    parts[2] += passed * _sun_glitter(scene, shade, water, face, ray, sample_2d(pixels, strata, 0))
    for total, part in zip(sums, parts, strict=True):
        dr.scatter(total, dr.gather(mi.Color3f, total, lanes) + part, lanes)
    return tuple(sums)


def beyond_water(
    scene: Any, air: Air | None, water: Water, ray: Any, hit: Any, u: Any
) -> tuple[Any, Any, Any]:
    """Return rays that go on from the water that they meet, their hits and their throughput.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        air: haze before the camera, None without any.
        water: of the scene.
        ray: from the camera.
        hit: what they meet other than water.
        u: a number that chooses between reflection and refraction.
    """
    surface = water.crossing(ray)
    distance = dr.select(hit.is_valid(), hit.t, dr.inf)
    meets = surface < distance
    passed = _before(air, water, ray, dr.minimum(surface, distance))
    face = water.interface(ray, dr.select(meets, surface, 0.0))
    chance = dr.clip(face.reflectance, _LEAST_CHANCE, 1.0 - _LEAST_CHANCE)
    reflects = u < chance
    share = dr.select(
        reflects, face.reflectance / chance, (1.0 - face.reflectance) / (1.0 - chance)
    )
    direction = dr.select(reflects, face.reflected, face.refracted)
    way = mi.Ray3f(face.p + _CLEARANCE * direction, direction)
    beyond = scene.ray_intersect_preliminary(way, coherent=False, active=meets)
    is_under = face.is_above != reflects
    left = dr.select(is_under, water.transmittance(beyond.t), 1.0)
    passed *= dr.select(meets, share * left, mi.Color3f(1.0))
    onward = mi.Ray3f(dr.select(meets, way.o, ray.o), dr.select(meets, way.d, ray.d))
    return onward, dr.select(meets, beyond, hit), finite(passed)


def _before(air: Air | None, water: Water, ray: Any, distance: Any) -> Any:
    """Return the share of light that arrives at the camera from the first surface."""
    is_below = water.is_below(ray.o)
    passed = dr.select(is_below, water.transmittance(distance), mi.Color3f(1.0))
    if air is not None:
        passed *= dr.select(is_below, 1.0, passed_air(air, ray, distance))
    return passed


def _mirrored_sky(scene: Any, water: Water, face: Interface, ray: Any, strata: StepStrata) -> Any:
    """Return the light of the sky in waves that are too short to be seen one by one."""
    sky = emitters_of(scene).environment()
    if sky is None:
        return mi.Color3f(0.0)

    def radiance(direction: Any) -> Any:
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.wi = -direction
        return sky.eval(si)

    passes = strata.grid[0] * strata.grid[1]
    return water.mirrored(face, ray, radiance, strata.k, passes)


def _sun_glitter(
    scene: Any, shade: CloudShade | None, water: Water, face: Interface, ray: Any, u: Any
) -> Any:
    """Return the key light's reflection in waves that are too short to be seen one by one."""
    place = dr.zeros(mi.SurfaceInteraction3f, dr.width(ray.d))
    place.p, place.n = face.p + _CLEARANCE * face.normal, mi.Normal3f(face.normal)
    sample, arriving = scene.sample_emitter_direction(place, u, False)
    sky = emitters_of(scene).environment()
    is_key = (sample.dist > KEY_LIGHT_FROM) & (sample.pdf > 0.0)
    if sky is not None:
        is_key &= sample.emitter != mi.EmitterPtr(sky)
    arriving = arriving * dimmed(shade, sample.emitter, face.p)
    light = finite(water.glitter(face, ray, sample, arriving))
    is_key &= dr.max(light) > 0.0
    occluded = scene.ray_test(place.spawn_ray_to(sample.p), False, is_key)
    return dr.select(is_key & ~occluded, light, 0.0)
