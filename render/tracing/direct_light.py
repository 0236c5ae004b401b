"""Direct light on the surfaces that rays meet, for Dr.Jit."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.frame import ALBEDO_BIAS
from render.surfaces.bsdf_plugins import eval_pdf_albedo
from render.tracing.cloud_shade import CloudShade, dimmed
from render.tracing.emitter_choice import emitter_sample
from render.tracing.haze import Air
from render.tracing.scene_pair import emitters_of
from render.tracing.shadow_origin import shadow_offset
from render.tracing.sky_relief import SkyRelief, sky_share
from render.tracing.water import Water


def surface_light(
    scene: Any,
    shade: CloudShade | None,
    water: Water | None,
    relief: SkyRelief | None,
    ray: Any,
    hit: Any,
    u: tuple[Any, Any],
    has_lamps: bool,
    *,
    coherent: bool = False,
) -> tuple[Any, Any, Any, Any, Any]:
    """Return what rays meet.

    That is direct light, what it would be without shadows, albedo, light that surfaces send out
    themselves, and distance.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        shade: of clouds, None without any.
        water: of the scene, None without any.
        relief: of surfaces in the light of the sky, which goes into the albedo.
        ray: from camera or water.
        hit: what it meets, `mi.PreliminaryIntersection3f`.
        u: pair of numbers for a point on an emitter, and one that chooses between emitters.
        has_lamps: whether surfaces are lit at all.
        coherent: whether neighbouring rays are close to each other.
    """
    si = hit.compute_surface_interaction(ray, mi.RayFlags.All)
    emitter = si.emitter(emitters_of(scene))
    shining = emitter.eval(si, emitter != None)  # noqa: E711  (compared lane by lane)
    shining *= dimmed(shade, emitter, ray.o)
    sample, arriving = emitter_sample(scene, si, *u, si.is_valid())
    arriving *= dimmed(shade, sample.emitter, si.p)

    def evaluate(bsdf: Any, si: Any, wo: Any) -> Any:
        return *eval_pdf_albedo(bsdf, si, wo), mi.Bool(not hasattr(bsdf, "translucency"))

    found = dr.dispatch(si.bsdf(), evaluate, si, si.to_local(sample.d))
    value, bsdf_pdf, albedo, normal, is_solid = found
    albedo = (albedo + ALBEDO_BIAS) * sky_share(relief, si, normal)
    albedo = dr.select(si.is_valid(), albedo, 0.0)
    if water is not None:
        wet = water.wetness(si.p, si.n)
        albedo *= wet
        arriving *= wet * water.reaching(si.p, sample)
    light, open_light = mi.Color3f(0.0), mi.Color3f(0.0)
    if has_lamps:
        si.p += shadow_offset(hit, si, sample.d, is_solid, si.is_valid())
        light, open_light = unoccluded(
            scene, si, sample, bsdf_pdf, value * arriving, si.is_valid(), coherent=coherent
        )
    return light, open_light, albedo, shining, dr.select(si.is_valid(), si.t, dr.inf)


def unoccluded(
    scene: Any,
    si: Any,
    sample: Any,
    bsdf_pdf: Any,
    light: Any,
    active: Any,
    *,
    coherent: bool = False,
) -> tuple[Any, Any]:
    """Return the light of an emitter sample where nothing occludes it, and anywhere.

    Both have their MIS weight.
    """
    mis = dr.select(sample.delta, 1.0, sample.pdf / (sample.pdf + bsdf_pdf))
    light = finite(light * mis)
    active = active & (sample.pdf > 0.0) & (dr.max(light) > 0.0)
    occluded = scene.ray_test(si.spawn_ray_to(sample.p), coherent, active)
    light = dr.select(active, light, 0.0)
    return dr.select(occluded, 0.0, light), light


def passed_air(air: Air, ray: Any, distance: Any) -> Any:
    """Return the share that haze lets through of light from a distance, 1 if that is infinite."""
    is_near = dr.isfinite(distance)
    passed = air.transmittance(ray.o, ray.d, dr.select(is_near, distance, 0.0))
    return dr.select(is_near, passed, 1.0)


def finite(values: Any) -> Any:
    """Return values with those of failed samples set to 0."""
    return dr.select(dr.isfinite(values), values, 0.0)
