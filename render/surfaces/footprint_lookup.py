"""Footprint lookup: darkness and relief of footprints at the points of a kernel."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.footprints import BLOCK, MAX_FOOTPRINTS, MAX_SLOPE, FootprintRaster

FOOTPRINT_COUNT = "printed"
"""Name of the surface parameter that holds the number of footprints made so far."""


class FootprintLookup:
    """Reads a footprint raster at points on the ground.

    Args:
        raster: all footprints of the film.
        values: parameters of the surface, to which those of the raster are added.
    """

    def __init__(self, raster: FootprintRaster, values: dict[str, Any]) -> None:
        self._raster, self._values = raster, values
        values[FOOTPRINT_COUNT] = dr.opaque(mi.UInt32, 0)
        values["blocks"] = mi.UInt32(raster.blocks.ravel())
        values["prints"] = mi.UInt32(raster.texels.ravel())

    def at(self, p: Any) -> tuple[Any, Any]:
        """Return the darkness, 0 to 1, and the gradient in the world of the relief.

        Args:
            p: `mi.Point3f` on the ground [m].
        """
        raster = self._raster
        rows, columns = raster.blocks.shape
        x, z = ((at - c) / raster.spacing for at, c in zip((p.x, p.z), raster.corner, strict=True))
        i, j = mi.Int32(dr.floor(x)), mi.Int32(dr.floor(z))
        inside = (i >= 0) & (j >= 0) & (i < columns * BLOCK) & (j < rows * BLOCK)
        column, row = mi.UInt32(dr.select(inside, i, 0)), mi.UInt32(dr.select(inside, j, 0))
        place = row // BLOCK * columns + column // BLOCK
        block = dr.gather(mi.UInt32, self._values["blocks"], place, inside)
        inside &= block > 0
        side = BLOCK + 1
        first = block * (side * side) + (row % BLOCK) * side + column % BLOCK
        x, z = x - dr.floor(x), z - dr.floor(z)
        weights = ((1 - x) * (1 - z), x * (1 - z), (1 - x) * z, x * z)
        dark, along_x, along_z = mi.Float(0), mi.Float(0), mi.Float(0)
        for step, weight in zip((0, 1, side, side + 1), weights, strict=True):
            texel = dr.gather(mi.UInt32, self._values["prints"], first + step, inside)
            number = texel & MAX_FOOTPRINTS
            is_made = (number > 0) & (number <= self._values[FOOTPRINT_COUNT])
            share = dr.select(is_made, weight, 0.0)
            dark += share * mi.Float((texel >> 13) & 31)
            along_x += share * (mi.Float((texel >> 18) & 127) - 64)
            along_z += share * (mi.Float(texel >> 25) - 64)
        slope_step = MAX_SLOPE / 63
        return dark / 31, mi.Vector3f(along_x * slope_step, 0.0, along_z * slope_step)
