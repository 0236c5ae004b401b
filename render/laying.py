"""Laying: how patterns come to lie on a surface, and what is seen of it at a point.

A pattern is laid from that side of the world's box which the surface faces, so that no
wall has streaks; where two sides meet, the border is ragged, which hides it in any
natural ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

RAGGED = 0.10
"""How far, as a part of a normal's length, the border between two sides wanders."""


@dataclass(frozen=True, eq=False)
class Laid:
    """Points of a surface on the side of the box that they are laid from.

    Attributes:
        u: `mi.Float`, first coordinate in the plane of that side [m].
        v: second coordinate [m].
        faces_x: `mi.Bool`, the side is that of the X axis.
        faces_y: the side is that of the Y axis.
    """

    u: Any
    v: Any
    faces_x: Any
    faces_y: Any

    def gradient(self, slope_u: Any, slope_v: Any) -> Any:
        """Return the gradient in the world, `mi.Vector3f`, of a relief with these slopes."""
        none = mi.Float(0)
        return mi.Vector3f(
            dr.select(self.faces_x, none, slope_u),
            dr.select(self.faces_y, none, slope_v),
            dr.select(self.faces_x, slope_u, dr.select(self.faces_y, slope_v, none)),
        )


def laid(p: Any, n: Any, ragged: Any) -> Laid:
    """Return where points lie on the box.

    Args:
        p: `mi.Point3f` in the world [m].
        n: `mi.Normal3f`, geometric.
        ragged: `mi.Float`, -1 to 1, which moves the borders between the sides.
    """
    shift = RAGGED * ragged
    x, y, z = dr.abs(n.x) + shift, dr.abs(n.y), dr.abs(n.z) - shift
    faces_y = (y >= x) & (y >= z)
    faces_x = ~faces_y & (x >= z)
    return Laid(dr.select(faces_x, p.z, p.x), dr.select(faces_y, p.z, p.y), faces_x, faces_y)


def ragged_wave(p: Any) -> Any:
    """Return a number, -1 to 1, that changes over some decimetres and is never seen to repeat."""
    # Lengths without a common measure, as in a play of waves.
    first = dr.sin(5.1 * p.x + 1.7 * p.z + 2.3 * p.y)
    return 0.5 * (first + dr.sin(3.3 * p.z - 4.4 * p.x + 1.9 * p.y + 1.1))


def turned(u: Any, v: Any, degrees: float) -> tuple[Any, Any]:
    """Return coordinates, or slopes, turned about the corner."""
    c, s = float(np.cos(np.radians(degrees))), float(np.sin(np.radians(degrees)))
    return c * u - s * v, s * u + c * v
