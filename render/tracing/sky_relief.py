"""Sky relief: how much of the sky's light a surface gets by the way it is turned, for Dr.Jit.

Bumps of a ground in the shade are seen only by this: the side that is turned up to the sky is
brighter and bluer than the other. Soft light is traced with few samples at half the size, which
loses it; so soft light is divided by it before it is denoised and enlarged, and multiplied by it
again, pixel by pixel, as it is by the albedo. It need not be exact, because it is divided out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from render.lights.environment_map import Map

LEAST = 0.45
"""Least share; places turned from the sky get light from other surfaces."""


@dataclass
class SkyRelief:
    """Irradiance by a map of all directions, relative to its mean; opaque to recordings.

    Attributes:
        x: slope of the share along the normal's first axis, by colour.
        y: along the second.
        z: along the third.
    """

    x: mi.Color3f
    y: mi.Color3f
    z: mi.Color3f

    @staticmethod
    def of(slopes: Map) -> SkyRelief:
        """Return the relief for slopes of the irradiance, see `irradiance_slopes`."""
        relief = SkyRelief(*(mi.Color3f(slope.tolist()) for slope in slopes))
        dr.make_opaque(relief)
        return relief

    def share(self, si: Any, normal: Any) -> Any:
        """Return the share of the sky's light, about 1, `mi.Color3f`.

        Args:
            si: interaction with the surface.
            normal: see `eval_pdf_albedo`.
        """
        side = dr.select(dr.dot(si.n, si.to_world(si.wi)) < 0.0, -1.0, mi.Float(1.0))
        turned = 1.0 + side * (self.x * normal.x + self.y * normal.y + self.z * normal.z)
        return dr.maximum(turned, LEAST)


def sky_share(relief: SkyRelief | None, si: Any, normal: Any) -> Any:
    """Return `SkyRelief.share`, 1 without a relief."""
    return 1.0 if relief is None else relief.share(si, normal)
