"""Cloud shade: the shadows of clouds on the key light, for Dr.Jit.

They dim samples of the key light, wherever a surface is lit by it, and its disc where it is seen.
Mitsuba's own path tracer knows nothing of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.lights.cloud_shadows import CELLS, LENGTH, CloudShadows

_LOWEST = 0.12
"""Sine of the lowest key light whose shadows are thrown as far as they fall."""


@dataclass
class CloudShade:
    """Shadows of clouds, opaque to recordings.

    Attributes:
        passed: share of the key light that arrives, a tile row by row.
        slope: way of the shadow along x and z for each metre of height.
        drift: of the clouds along x and z [m].
        key: the emitter that they dim.
    """

    passed: mi.Float
    slope: mi.Vector2f
    drift: mi.Vector2f
    key: mi.EmitterPtr

    @staticmethod
    def of(shadows: CloudShadows, key: Any) -> CloudShade:
        """Return shadows for Dr.Jit.

        Args:
            shadows: of clouds.
            key: the emitter of the key light.
        """
        x, y, z = (float(v) for v in shadows.key)
        up = max(y, _LOWEST)
        shade = CloudShade(
            mi.Float(np.ascontiguousarray(shadows.passed.ravel())),
            mi.Vector2f(x / up, z / up),
            mi.Vector2f(*shadows.drift),
            mi.EmitterPtr(key),
        )
        dr.make_opaque(shade.slope, shade.drift)
        return shade

    def dimmed(self, emitter: Any, place: Any) -> Any:
        """Return the share of an emitter's light that arrives: 1 unless it is the key light.

        Args:
            emitter: `mi.EmitterPtr`.
            place: that it lights [m].
        """
        return dr.select(emitter == self.key, self._passed_at(place), 1.0)

    def _passed_at(self, place: Any) -> Any:
        # Along the light down to height 0.
        x = place.x - place.y * self.slope.x - self.drift.x
        z = place.z - place.y * self.slope.y - self.drift.y
        column, row = x * (CELLS / LENGTH), z * (CELLS / LENGTH)
        left, top = dr.floor(column), dr.floor(row)
        across, down = column - left, row - top
        c, r = mi.Int32(left), mi.Int32(top)

        def at(i: Any, j: Any) -> Any:
            # The number of cells is a power of two, so that this is the remainder, also below 0.
            return dr.gather(
                mi.Float, self.passed, mi.UInt32((i & (CELLS - 1)) * CELLS + (j & (CELLS - 1)))
            )

        high = at(r, c) + across * (at(r, c + 1) - at(r, c))
        low = at(r + 1, c) + across * (at(r + 1, c + 1) - at(r + 1, c))
        return high + down * (low - high)


def dimmed(shade: CloudShade | None, emitter: Any, place: Any) -> Any:
    """Return `CloudShade.dimmed`, 1 without clouds."""
    return 1.0 if shade is None else shade.dimmed(emitter, place)
