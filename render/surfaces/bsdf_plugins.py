"""BSDF plugins in Python: diffuse, thin and glossy surfaces with a pattern shader.

The shader is called once per point, gives the colour and bends the normal; so a surface is asked
for its value, a sample and its albedo at once (`eval_pdf_albedo`). The diffuse surface
reflects at most its colour: the energy of a cosine about the bent normal, less what would go
below the surface. The glossy one wraps a BSDF of Mitsuba, which it hands the colour through a
texture.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import drjit as dr
import mitsuba as mi

from render.config import Material
from render.python_plugin import plugin
from render.surfaces.mitsuba_bsdf import opaque_bsdf
from render.surfaces.patterns import Shader

SUBSURFACE_FALLOFF = (0.30, 0.06, -0.08)
"""By how much the power of the cosine with which skin darkens differs from Lambert's 1: red, green,
blue. Red goes farthest below the surface, and around the edge of a shade."""

RIM_GAIN, RIM_WHITE, RIM_POWER = 4.0, 0.18, 4
"""Of thin sheets with sheen, such as strands of hair: how much stronger light is that goes on
nearly straight ahead, how much of it keeps its own colour besides, and its power of the cosine."""

LEAST_COSINE = 0.02
"""Cosine from which on light that grazes a surface is no longer strengthened."""


def eval_pdf_albedo(bsdf: Any, si: Any, wo: Any) -> tuple[Any, Any, Any, Any]:
    """Return what any BSDF is at points, whose shader is called once.

    Returns:
        The value towards `wo`, the density of sampling it, the albedo, and the normal of the relief
        in the world, `mi.Normal3f`: a unit vector, shorter where light from behind comes through.
    """
    with _shading_once(bsdf, si) as normal:
        found = bsdf.eval_pdf(mi.BSDFContext(), si, wo)
        return *found, bsdf.eval_diffuse_reflectance(si), normal


def eval_pdf_sample_albedo(
    bsdf: Any, si: Any, wo: Any, sample1: Any, sample2: Any
) -> tuple[Any, Any, Any, Any, Any, Any]:
    """Return the same of any BSDF with a sample and its weight before the albedo."""
    with _shading_once(bsdf, si) as normal:
        found = bsdf.eval_pdf_sample(mi.BSDFContext(), si, wo, sample1, sample2)
        return *found, bsdf.eval_diffuse_reflectance(si), normal


@contextmanager
def _shading_once(bsdf: Any, si: Any) -> Iterator[Any]:
    """Have a BSDF of this module call its shader for these points once, whatever it is asked.

    Yields the normal of `eval_pdf_albedo`. Dr.Jit does not see that a second call reads the same
    texels: its kernels would be a quarter longer, and be compiled for longer.
    """
    shader = getattr(bsdf, "shader", None)
    if shader is None:
        yield mi.Normal3f(si.sh_frame.n)
        return
    color, normal = shader(si)
    bsdf.shader = lambda si: (mi.Color3f(color), mi.Normal3f(normal))
    try:
        yield dr.normalize(normal) * (1.0 - 2.0 * getattr(bsdf, "translucency", 0.0))
    finally:
        bsdf.shader = shader


def diffuse_bsdf(shader: Shader, values: dict[str, Any]) -> Any:
    """Return a diffuse surface, `mi.BSDF`.

    Args:
        shader: its colour and normal.
        values: all arrays of Dr.Jit that the shader reads. They must be members of the surface,
            where frozen functions look for their inputs, and are scene parameters by these names.
    """
    surface = plugin(_DiffuseBsdf, "BSDF")
    surface.shader, surface.values = shader, values
    both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
    surface.m_flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.SpatiallyVarying | both
    surface.m_components = [surface.m_flags]
    return surface


def thin_bsdf(
    shader: Shader, values: dict[str, Any], translucency: float, sheen: float = 0.0
) -> Any:
    """Return a thin diffuse sheet, `mi.BSDF`, that some light passes through.

    Args:
        shader: its colour and normal.
        values: see `diffuse_bsdf`.
        translucency: share of the scattered light that leaves on the other side.
        sheen: strength of the bright rim that strands have before a light.
    """
    surface = plugin(_ThinBsdf, "BSDF")
    surface.shader, surface.values, surface.translucency = shader, values, translucency
    surface.sheen = sheen
    both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
    scattered = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.DiffuseTransmission
    surface.m_flags = scattered | mi.BSDFFlags.SpatiallyVarying | both
    surface.m_components = [surface.m_flags]
    return surface


def glossy_bsdf(material: Material, shader: Shader, values: dict[str, Any]) -> Any:
    """Return a glossy surface, `mi.BSDF`.

    Args:
        material: its reflection; colour and texture come from the shader.
        shader: its colour and normal.
        values: see `diffuse_bsdf`.
    """
    paint, surface = plugin(_Paint, "Texture"), plugin(_GlossyBsdf, "BSDF")
    surface.paint, surface.base = paint, mi.load_dict(opaque_bsdf(material, paint))
    surface.shader, surface.values = shader, values
    surface.falloff = tuple(material.subsurface * share for share in SUBSURFACE_FALLOFF)
    surface.set_flags()
    return surface


class _ShadedBsdf:
    """Methods of `mi.BSDF` for a surface with the colour and normal of a shader."""

    m_components: list[Any]
    m_flags: Any
    shader: Shader
    values: dict[str, Any]

    def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(ctx, si, wo, active)[1]

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        """Return the value towards `wo` and the density of sampling it."""
        raise NotImplementedError

    def traverse(self, callback: Any) -> None:
        for name, value in self.values.items():
            callback.put(name, value, mi.ParamFlags.NonDifferentiable)

    def parameters_changed(self, keys: Any) -> None:
        del keys


class _DiffuseBsdf(_ShadedBsdf):
    """Methods of `mi.BSDF` for a diffuse surface."""

    def sample(
        self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
    ) -> tuple[Any, Any]:
        return self.eval_pdf_sample(ctx, si, mi.Vector3f(0, 0, 1), sample1, sample2, active)[2:]

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        del ctx
        color, bent = self._shaded(si)
        return _diffuse(color, bent, _seen_side(si), wo, active)

    def eval_pdf_sample(
        self, ctx: Any, si: Any, wo: Any, sample1: Any, sample2: Any, active: Any = True
    ) -> tuple[Any, Any, Any, Any]:
        del ctx, sample1
        color, bent = self._shaded(si)
        side = _seen_side(si)
        value, pdf = _diffuse(color, bent, side, wo, active)
        local = mi.warp.square_to_cosine_hemisphere(sample2)
        out = mi.Frame3f(bent).to_world(local)
        is_above = active & (out.z > 0)
        found: Any = dr.zeros(mi.BSDFSample3f)
        found.wo = mi.Vector3f(out.x, out.y, out.z * side)
        found.pdf = dr.select(is_above, mi.warp.square_to_cosine_hemisphere_pdf(local), 0.0)
        found.eta = 1.0
        found.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
        found.sampled_component = 0
        return value, pdf, found, dr.select(is_above, color, 0.0)

    def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
        return dr.select(active, self._shaded(si)[0], 0.0)

    def _shaded(self, si: Any) -> tuple[Any, Any]:
        color, normal = self.shader(si)
        return color, _local_normal(si, normal)

    def to_string(self) -> str:
        return "DiffuseBsdf[]"


class _ThinBsdf(_DiffuseBsdf):
    """Methods of `mi.BSDF` for a thin diffuse sheet."""

    translucency: float
    sheen: float

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        del ctx
        color, bent = self._shaded(si)
        return self._scattered(color, bent, si.wi, wo, active)

    def eval_pdf_sample(
        self, ctx: Any, si: Any, wo: Any, sample1: Any, sample2: Any, active: Any = True
    ) -> tuple[Any, Any, Any, Any]:
        del ctx
        color, bent = self._shaded(si)
        value, pdf = self._scattered(color, bent, si.wi, wo, active)
        out = mi.Frame3f(bent).to_world(mi.warp.square_to_cosine_hemisphere(sample2))
        side = _side_of(si.wi) * dr.select(sample1 < self.translucency, mi.Float(-1), mi.Float(1))
        found: Any = dr.zeros(mi.BSDFSample3f)
        found.wo = mi.Vector3f(out.x, out.y, out.z * side)
        is_above = active & (out.z > 0) & (si.wi.z != 0)
        _, density = self._scattered(color, bent, si.wi, found.wo, is_above)
        found.pdf = density
        found.eta = 1.0
        found.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
        found.sampled_component = 0
        weight = self._rimmed(color, si.wi, found.wo)
        return value, pdf, found, dr.select(is_above, weight, 0.0)

    def _scattered(self, color: Any, bent: Any, wi: Any, wo: Any, active: Any) -> tuple[Any, Any]:
        """Return the value, times the cosine, and the density of scattering into `wo`."""
        side = _side_of(wi)
        mirrored = mi.Vector3f(wo.x, wo.y, dr.abs(wo.z) * side)
        value, pdf = _diffuse(self._rimmed(color, wi, wo), bent, side, mirrored, active)
        share = dr.select(wo.z * side > 0, 1.0 - self.translucency, self.translucency)
        return value * share, pdf * share

    def _rimmed(self, color: Any, wi: Any, wo: Any) -> Any:
        """Return the colour in which light goes on into `wo`.

        A stand-in for the forward lobes of hair, which shine before a light: what goes through a
        strand, in its colour, and what glances off it, in that of the light.

        Source: S. Marschner et al., Light scattering from human hair fibers, 2003.
        """
        if self.sheen == 0.0:
            return color
        ahead = self.sheen * dr.maximum(-dr.dot(wi, wo), 0.0) ** RIM_POWER
        return color * (1.0 + RIM_GAIN * ahead) + RIM_WHITE * ahead

    def to_string(self) -> str:
        return f"ThinBsdf[{self.translucency}]"


class _Paint:
    """Methods of `mi.Texture` for one that returns the colour it was given last."""

    color: Any = None

    def eval(self, si: Any, active: Any = True) -> Any:
        del si, active
        return mi.Color3f(0.5) if self.color is None else self.color

    def eval_3(self, si: Any, active: Any = True) -> Any:
        return self.eval(si, active)

    def eval_1(self, si: Any, active: Any = True) -> Any:
        return mi.luminance(self.eval(si, active))

    def mean(self) -> Any:
        return mi.Float(0.5)

    def is_spatially_varying(self) -> bool:
        return True

    def traverse(self, callback: Any) -> None:
        del callback

    def to_string(self) -> str:
        return "Paint[]"


class _GlossyBsdf(_ShadedBsdf):
    """Methods of `mi.BSDF` for a glossy surface."""

    paint: Any
    base: Any
    falloff: tuple[float, ...]

    def set_flags(self) -> None:
        """Copy the flags of the wrapped BSDF, for both sides."""
        parts = [self.base.flags(i) for i in range(self.base.component_count())]
        both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [part | both for part in parts]
        self.m_flags = self.base.flags() | both

    def sample(
        self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
    ) -> tuple[Any, Any]:
        here, frame, side = self._painted(si)
        found, weight = self.base.sample(ctx, here, sample1, sample2, active)
        self.paint.color = None
        return _from_bent(found, self._softened(weight, found.wo), frame, side)

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        here, frame, side = self._painted(si)
        out, is_above = _to_bent(wo, frame, side, active)
        value, pdf = self.base.eval_pdf(ctx, here, out, is_above)
        self.paint.color = None
        value = self._softened(value, out)
        return dr.select(is_above, value, 0.0), dr.select(is_above, pdf, 0.0)

    def eval_pdf_sample(
        self, ctx: Any, si: Any, wo: Any, sample1: Any, sample2: Any, active: Any = True
    ) -> tuple[Any, Any, Any, Any]:
        here, frame, side = self._painted(si)
        out, is_above = _to_bent(wo, frame, side, active)
        value, pdf = self.base.eval_pdf(ctx, here, out, is_above)
        found, weight = self.base.sample(ctx, here, sample1, sample2, active)
        self.paint.color = None
        value, weight = self._softened(value, out), self._softened(weight, found.wo)
        found, weight = _from_bent(found, weight, frame, side)
        return dr.select(is_above, value, 0.0), dr.select(is_above, pdf, 0.0), found, weight

    def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
        return dr.select(active, self.shader(si)[0], 0.0)

    def _softened(self, value: Any, out: Any) -> Any:
        """Return a value towards `out`, in the bent frame, with a soft edge of the shade.

        A stand-in for scattering below the surface that needs no light from below the horizon. The
        cosine of each channel gets a power p = 1 - falloff, and a factor (p + 1) / 2 with which its
        integral over the hemisphere stays π: diffuse energy is neither lost nor gained.
        """
        if not any(self.falloff):
            return value
        cosine = dr.maximum(out.z, LEAST_COSINE)
        return value * mi.Color3f(*((1.0 - 0.5 * f) * dr.power(cosine, -f) for f in self.falloff))

    def _painted(self, si: Any) -> tuple[Any, Any, Any]:
        """Return the interaction for the wrapped BSDF, the bent frame and the side."""
        color, normal = self.shader(si)
        self.paint.color = color
        side = _seen_side(si)
        frame = mi.Frame3f(_local_normal(si, normal))
        here = mi.SurfaceInteraction3f(si)
        wi = frame.to_local(mi.Vector3f(si.wi.x, si.wi.y, si.wi.z * side))
        # At grazing angles the bent surface may face away; it is then seen edge on.
        wi.z = dr.maximum(wi.z, 1e-3)
        here.wi = dr.normalize(wi)
        return here, frame, side

    def to_string(self) -> str:
        return "GlossyBsdf[]"


def _side_of(direction: Any) -> Any:
    """Return 1 for a direction above the surface and -1 for one below."""
    return dr.select(direction.z < 0, mi.Float(-1), mi.Float(1))


def _seen_side(si: Any) -> Any:
    """Return 1 for a surface seen from above and -1 for one seen from below.

    Its faces decide, not its smooth normals: just behind a crest these face away from the viewer,
    and the crest would have a black rim.
    """
    return dr.select(dr.dot(si.n, si.to_world(si.wi)) < 0, mi.Float(-1), mi.Float(1))


def _local_normal(si: Any, normal: Any) -> Any:
    """Return a normal of the world as unit `mi.Vector3f` in the frame of the surface."""
    bent = dr.normalize(si.to_local(normal))
    # A normal below the surface would have no hemisphere above it.
    bent.z = dr.maximum(bent.z, 0.05)
    return dr.normalize(bent)


def _diffuse(color: Any, bent: Any, side: Any, wo: Any, active: Any) -> tuple[Any, Any]:
    """Return the value, times the cosine, and the density of scattering into `wo`."""
    out = mi.Vector3f(wo.x, wo.y, wo.z * side)
    cosine = dr.maximum(dr.dot(out, bent), 0.0)
    is_above = active & (out.z > 0)
    pdf = dr.select(is_above, cosine * dr.inv_pi, 0.0)
    return color * pdf, pdf


def _to_bent(wo: Any, frame: Any, side: Any, active: Any) -> tuple[Any, Any]:
    """Return a direction in the bent frame, and whether it leaves the true surface."""
    out = mi.Vector3f(wo.x, wo.y, wo.z * side)
    return frame.to_local(out), active & (out.z > 0)


def _from_bent(found: Any, weight: Any, frame: Any, side: Any) -> tuple[Any, Any]:
    """Return a sample of the wrapped BSDF in the frame of the surface."""
    out = frame.to_world(found.wo)
    is_above = (out.z > 0) & (found.pdf > 0)
    found.wo = mi.Vector3f(out.x, out.y, out.z * side)
    found.pdf = dr.select(is_above, found.pdf, 0.0)
    return found, dr.select(is_above, weight, 0.0)
