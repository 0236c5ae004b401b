"""Haze between the camera and what it sees, for Dr.Jit.

The air dims what lies behind it and shines itself with the light that it scatters: with the colour
of the clear sky in the same direction, or at the horizon where the camera looks down, as if all
air were lit alike. Its density falls off exponentially with the height.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.lights.haze import COLUMNS, ROWS, TOP, Haze

_OPAQUE = 12.0
"""Optical depth from which nothing more is seen."""

_MAX_FALL = 20.0
"""Heights of the haze that a ray may fall: below, its density is taken to grow no more."""


@dataclass
class Air:
    """The haze of a scene, opaque to recordings.

    Attributes:
        extinction: at height 0 [1/m].
        height: in which the density falls to 1/e [m].
        light: of the clear sky, a table of `ROWS` by `COLUMNS` directions, row by row:
            `mi.Color3f`, or a list of colours in a variant without arrays.
    """

    extinction: mi.Color3f
    height: mi.Float
    light: Any

    @staticmethod
    def of(haze: Haze) -> Air:
        """Return the haze for Dr.Jit."""
        extinction = mi.Color3f(haze.extinction.tolist())
        table = haze.light.reshape(-1, 3)
        if not dr.is_jit_v(mi.Float):
            return Air(
                extinction, mi.Float(haze.height), [mi.Color3f(color) for color in table.tolist()]
            )
        light = mi.Color3f(np.ascontiguousarray(table.T, np.float32))
        air = Air(extinction, mi.Float(haze.height), light)
        dr.make_opaque(air)
        return air

    def transmittance(self, origin: Any, direction: Any, distance: Any) -> Any:
        """Return the share of light that arrives, `mi.Color3f`; 1 at no distance.

        Args:
            origin: of the rays [m].
            direction: of the rays, unit vectors.
            distance: along the rays [m].
        """
        rise = dr.maximum(direction.y * distance / self.height, -_MAX_FALL)
        is_level = dr.abs(rise) < 1e-3
        # The mean of exp(-x) from 0 to `rise`, by its series near 0.
        safe = dr.select(is_level, 1.0, rise)
        mean = dr.select(is_level, 1.0 - 0.5 * rise, (1.0 - dr.exp(-safe)) / safe)
        depth = distance * mean * dr.exp(dr.clip(-origin.y / self.height, -_MAX_FALL, _MAX_FALL))
        # A little is left, by which the denoiser can divide.
        return dr.exp(-dr.minimum(self.extinction * depth, _OPAQUE))

    def scattered(self, direction: Any) -> Any:
        """Return the light of endless haze in a direction, `mi.Color3f`."""
        row = dr.clip(direction.y / TOP, 0.0, 1.0) * (ROWS - 1)
        column = dr.atan2(direction.x, -direction.z) * (0.5 * COLUMNS / dr.pi) + COLUMNS
        r0 = dr.minimum(mi.UInt32(row), ROWS - 2)
        c0 = mi.UInt32(column)
        down, across = row - mi.Float(r0), column - mi.Float(c0)
        c1 = (c0 + 1) % COLUMNS
        c0 = c0 % COLUMNS

        def at(r: Any) -> Any:
            near, far = self._entry(r * COLUMNS + c0), self._entry(r * COLUMNS + c1)
            return near + across * (far - near)

        low, high = at(r0), at(r0 + 1)
        return low + down * (high - low)

    def _entry(self, index: Any) -> Any:
        if isinstance(self.light, list):
            return self.light[index]
        return dr.gather(mi.Color3f, self.light, index)
