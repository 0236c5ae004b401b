"""Wear lookup: the share of bare soil at the points of a kernel, with the pattern of soil."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.ground_wear import GroundWear
from render.surfaces.texture_mapping import (
    PIXEL_WIDTH,
    Mipmap,
    Projection,
    Sample,
    device_texture,
    fine_copy,
    lookup,
    mip_level,
    pattern_mipmap,
    share_mipmap,
)
from render.textures.layers import SOIL_LAYER

SOIL_SIZE = 2.6
"""Size of a tile of soil [m]."""

RAGGED = 2.4
"""By how much the pattern of the ground frays the border of its soil."""


class WearLookup:
    """Reads worn ground at points on it.

    Args:
        wear: of the ground.
        values: parameters of the surface, to which its own are added.
    """

    def __init__(self, wear: GroundWear, values: dict[str, Any]) -> None:
        self._wear, self._values = wear, values
        self._mipmap: Mipmap = share_mipmap(wear.texels)
        values["worn"] = mi.UInt32(self._mipmap.texels)
        values["soil"] = mi.Color3f(*(dr.opaque(mi.Float, float(c)) for c in wear.color))
        self._soil = device_texture(pattern_mipmap("soil"), values, "clods")

    def at(self, si: Any, projection: Projection, shade: Any) -> tuple[Any, Any, Sample]:
        """Return the share of soil, its colour without pattern, and its pattern.

        Args:
            si: points on the ground.
            projection: of them.
            shade: of the ground's own pattern there.
        """
        wear = self._wear
        u, v = ((at - c) / wear.size for at, c in zip((si.p.x, si.p.z), wear.corner, strict=True))
        inside = (u > 0.0) & (u < 1.0) & (v > 0.0) & (v < 1.0)
        level = mip_level(si, wear.size, self._values[PIXEL_WIDTH])
        share = lookup(self._values["worn"], self._mipmap, u, v, level).shade
        # Between grass and soil, soil shows first where the pattern is dark.
        share += RAGGED * share * (1.0 - share) * (1.0 - dr.clip(shade, 0.4, 1.6))
        share = dr.clip(1.35 * share - 0.1, 0.0, 1.0)
        layout = SOIL_LAYER
        near = mip_level(si, SOIL_SIZE * layout.scale, self._values[PIXEL_WIDTH])
        soil = self._soil.on(projection, SOIL_SIZE * layout.scale, layout.turn_deg, near)
        soil = soil.under(
            fine_copy(si, projection, self._soil, SOIL_SIZE, self._values[PIXEL_WIDTH])
        )
        return dr.select(inside & projection.is_along_y, share, 0.0), self._values["soil"], soil
