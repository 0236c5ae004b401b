"""Pressed: what is seen of prints in the ground at the points of a kernel."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.footprints import BLOCK, MOST, STEEPEST, Prints

PRINTED = "printed"
"""Name of the value that says how many prints have been made."""


class Pressed:
    """What is pressed into the ground at points of a kernel.

    Args:
        prints: all of the film.
        values: of the surface, to which those of the prints are added.
    """

    def __init__(self, prints: Prints, values: dict[str, Any]) -> None:
        self._prints, self._values = prints, values
        values[PRINTED] = dr.opaque(mi.UInt32, 0)
        values["blocks"] = mi.UInt32(prints.blocks.ravel())
        values["prints"] = mi.UInt32(prints.texels.ravel())

    def at(self, p: Any) -> tuple[Any, Any]:
        """Return how dark it is, and the gradient in the world of what is pressed in.

        Args:
            p: `mi.Point3f` on the ground [m].
        """
        of = self._prints
        rows, columns = of.blocks.shape
        x, z = ((at - c) / of.spacing for at, c in zip((p.x, p.z), of.corner, strict=True))
        i, j = mi.Int32(dr.floor(x)), mi.Int32(dr.floor(z))
        there = (i >= 0) & (j >= 0) & (i < columns * BLOCK) & (j < rows * BLOCK)
        column, row = mi.UInt32(dr.select(there, i, 0)), mi.UInt32(dr.select(there, j, 0))
        place = row // BLOCK * columns + column // BLOCK
        block = dr.gather(mi.UInt32, self._values["blocks"], place, there)
        there &= block > 0
        side = BLOCK + 1
        first = block * (side * side) + (row % BLOCK) * side + column % BLOCK
        x, z = x - dr.floor(x), z - dr.floor(z)
        weights = ((1 - x) * (1 - z), x * (1 - z), (1 - x) * z, x * z)
        dark, along_x, along_z = mi.Float(0), mi.Float(0), mi.Float(0)
        for step, weight in zip((0, 1, side, side + 1), weights, strict=True):
            word = dr.gather(mi.UInt32, self._values["prints"], first + step, there)
            number = word & MOST
            share = dr.select((number > 0) & (number <= self._values[PRINTED]), weight, 0.0)
            dark += share * mi.Float((word >> 13) & 31)
            along_x += share * (mi.Float((word >> 18) & 127) - 64)
            along_z += share * (mi.Float(word >> 25) - 64)
        steep = STEEPEST / 63
        return dark / 31, mi.Vector3f(along_x * steep, 0.0, along_z * steep)
