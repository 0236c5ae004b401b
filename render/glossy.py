"""Glossy surfaces: Mitsuba's own BSDF under a look that gives its colour and bends its normal.

The look is asked once a point. What it found is handed to the BSDF below through a
texture that knows nothing else.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.config import Material
from render.plain import plain
from render.plugins import plugin
from render.surfaces.bsdf_plugins import Look, bent_in, side_of


def glossy(words: Material, look: Look, values: dict[str, Any]) -> Any:
    """Return a surface, `mi.BSDF`, that shines as the material says.

    Args:
        words: the material; its colour and texture are those of the look.
        look: what it shows.
        values: see `render.surfaces.bsdf_plugins.rough`.
    """
    paint, surface = plugin(_Paint, "Texture"), plugin(_Glossy, "BSDF")
    surface.paint, surface.below = paint, mi.load_dict(plain(words, paint))
    surface.look, surface.values = look, values
    surface.describe()
    return surface


class _Paint:
    """The methods of `mi.Texture` for one that shows what it was given last."""

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


class _Glossy:
    """The methods of `mi.BSDF` for a glossy surface."""

    m_components: list[Any]
    m_flags: Any
    look: Look
    values: dict[str, Any]
    paint: Any
    below: Any

    def describe(self) -> None:
        """Say of itself what holds of the BSDF below."""
        parts = [self.below.flags(i) for i in range(self.below.component_count())]
        both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [part | both for part in parts]
        self.m_flags = self.below.flags() | both

    def sample(
        self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
    ) -> tuple[Any, Any]:
        here, frame, side = self._painted(si)
        found, weight = self.below.sample(ctx, here, sample1, sample2, active)
        self.paint.color = None
        return _raised(found, weight, frame, side)

    def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(ctx, si, wo, active)[1]

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        here, frame, side = self._painted(si)
        out, there = _lowered(wo, frame, side, active)
        value, pdf = self.below.eval_pdf(ctx, here, out, there)
        self.paint.color = None
        return dr.select(there, value, 0.0), dr.select(there, pdf, 0.0)

    def eval_pdf_sample(
        self, ctx: Any, si: Any, wo: Any, sample1: Any, sample2: Any, active: Any = True
    ) -> tuple[Any, Any, Any, Any]:
        here, frame, side = self._painted(si)
        out, there = _lowered(wo, frame, side, active)
        value, pdf = self.below.eval_pdf(ctx, here, out, there)
        found, weight = self.below.sample(ctx, here, sample1, sample2, active)
        self.paint.color = None
        found, weight = _raised(found, weight, frame, side)
        return dr.select(there, value, 0.0), dr.select(there, pdf, 0.0), found, weight

    def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
        return dr.select(active, self.look(si)[0], 0.0)

    def _painted(self, si: Any) -> tuple[Any, Any, Any]:
        """Return the point as the BSDF below sees it, the bent frame and the side."""
        color, normal = self.look(si)
        self.paint.color = color
        side = side_of(si.wi)
        frame = mi.Frame3f(bent_in(si, normal))
        here = mi.SurfaceInteraction3f(si)
        wi = frame.to_local(mi.Vector3f(si.wi.x, si.wi.y, si.wi.z * side))
        # Seen so flatly that the bent surface turns away, it is seen along itself.
        wi.z = dr.maximum(wi.z, 1e-3)
        here.wi = dr.normalize(wi)
        return here, frame, side

    def traverse(self, callback: Any) -> None:
        for name, value in self.values.items():
            callback.put(name, value, mi.ParamFlags.NonDifferentiable)

    def parameters_changed(self, keys: Any) -> None:
        del keys

    def to_string(self) -> str:
        return "Glossy[]"


def _lowered(wo: Any, frame: Any, side: Any, active: Any) -> tuple[Any, Any]:
    """Return a direction in the bent frame, and whether it leaves the true surface."""
    out = mi.Vector3f(wo.x, wo.y, wo.z * side)
    return frame.to_local(out), active & (out.z > 0)


def _raised(found: Any, weight: Any, frame: Any, side: Any) -> tuple[Any, Any]:
    """Return a sample of the BSDF below in the frame of the surface."""
    out = frame.to_world(found.wo)
    there = (out.z > 0) & (found.pdf > 0)
    found.wo = mi.Vector3f(out.x, out.y, out.z * side)
    found.pdf = dr.select(there, found.pdf, 0.0)
    return found, dr.select(there, weight, 0.0)
