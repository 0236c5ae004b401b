"""Rough surfaces: a BSDF that scatters evenly, with a colour and a relief of its own.

Where a ground of nested textures, blends and bumps evaluates a pattern many times over,
this one looks once at the point that is hit: the pattern gives the colour and bends the
normal. What it gives back is at most its colour (the energy of a cosine about a bent
normal, less what would go below the surface).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi

from render.plugins import plugin

PIXEL = "pixel"
"""Name of the value that says how wide a pixel is at a distance of one metre [m]."""

Look = Callable[[Any], tuple[Any, Any]]
"""From `mi.SurfaceInteraction3f` the colour, `mi.Color3f`, and the normal in the world."""


def rough(look: Look, values: dict[str, Any]) -> Any:
    """Return a rough surface, `mi.BSDF`.

    Args:
        look: what it shows.
        values: all arrays of Dr.Jit that the look reads. They must stand in the surface
            itself, where recordings look for what may change, and are found among the scene's
            parameters by these names.
    """
    surface = plugin(_Rough, "BSDF")
    surface.look, surface.values = look, values
    both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
    surface.m_flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.SpatiallyVarying | both
    surface.m_components = [surface.m_flags]
    return surface


def set_pixel(values: Any, fov_deg: float, height: int) -> None:
    """Tell all looks of a scene how wide a pixel is.

    Args:
        values: the scene's parameters.
        fov_deg: vertical field of view [degrees].
        height: of the picture [pixels].
    """
    wide = 2.0 * math.tan(math.radians(fov_deg) / 2.0) / height
    for name in values.keys():
        if name.endswith(f".{PIXEL}"):
            values[name] = dr.opaque(type(values[name]), wide)


class _Rough:
    """The methods of `mi.BSDF` for a rough surface; see `render.plugins`."""

    m_components: list[Any]
    m_flags: Any
    look: Look
    values: dict[str, Any]

    def sample(
        self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
    ) -> tuple[Any, Any]:
        return self.eval_pdf_sample(ctx, si, mi.Vector3f(0, 0, 1), sample1, sample2, active)[2:]

    def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(ctx, si, wo, active)[1]

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        del ctx
        color, bent = self._seen(si)
        return _lit(color, bent, si.wi, wo, active)

    def eval_pdf_sample(
        self, ctx: Any, si: Any, wo: Any, sample1: Any, sample2: Any, active: Any = True
    ) -> tuple[Any, Any, Any, Any]:
        del ctx, sample1
        color, bent = self._seen(si)
        value, pdf = _lit(color, bent, si.wi, wo, active)
        around = mi.warp.square_to_cosine_hemisphere(sample2)
        side = side_of(si.wi)
        out = mi.Frame3f(bent).to_world(around)
        there = active & (out.z > 0) & (si.wi.z != 0)
        found: Any = dr.zeros(mi.BSDFSample3f)
        found.wo = mi.Vector3f(out.x, out.y, out.z * side)
        found.pdf = dr.select(there, mi.warp.square_to_cosine_hemisphere_pdf(around), 0.0)
        found.eta = 1.0
        found.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
        found.sampled_component = 0
        return value, pdf, found, dr.select(there, color, 0.0)

    def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
        return dr.select(active, self._seen(si)[0], 0.0)

    def _seen(self, si: Any) -> tuple[Any, Any]:
        color, normal = self.look(si)
        return color, bent_in(si, normal)

    def traverse(self, callback: Any) -> None:
        for name, value in self.values.items():
            callback.put(name, value, mi.ParamFlags.NonDifferentiable)

    def parameters_changed(self, keys: Any) -> None:
        del keys

    def to_string(self) -> str:
        return "Rough[]"


def side_of(direction: Any) -> Any:
    """Return 1 for a direction above the surface and -1 for one below."""
    return dr.select(direction.z < 0, mi.Float(-1), mi.Float(1))


def bent_in(si: Any, normal: Any) -> Any:
    """Return a normal of the world in the frame of the surface, `mi.Vector3f` of length one."""
    bent = dr.normalize(si.to_local(normal))
    # A normal that looks into the ground would have no hemisphere above it.
    bent.z = dr.maximum(bent.z, 0.05)
    return dr.normalize(bent)


def _lit(color: Any, bent: Any, wi: Any, wo: Any, active: Any) -> tuple[Any, Any]:
    """Return the value, times the cosine, and the density of scattering into `wo`."""
    side = side_of(wi)
    out = mi.Vector3f(wo.x, wo.y, wo.z * side)
    cosine = dr.maximum(dr.dot(out, bent), 0.0)
    there = active & (out.z > 0) & (wi.z != 0)
    pdf = dr.select(there, cosine * dr.inv_pi, 0.0)
    return color * pdf, pdf
