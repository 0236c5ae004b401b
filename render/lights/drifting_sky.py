"""Drifting sky: the map of a sky whose cumulus moves with the wind.

A layer takes seconds to paint. So it is painted once for each hundred metres that it drifts, and
for each frame every direction looks up where in the painting the air was that is there now. Towards
the end of each stretch the next painting fades in.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.lights.clouds import Heaps, distance_to

STRETCH = 100.0
"""Drift for which a painting serves [m]: a tenth of the height of the clouds."""
_FADE = 0.5
"""Share of a stretch after which the next painting fades in."""
_HEIGHT = 1100.0
"""Height of most of what is seen of the clouds [m]."""

Drift = tuple[float, float]


class DriftingSky:
    """The map of a sky at any time.

    Args:
        behind: (H, W, 3) sky behind the cumulus.
        paint: returns the cumulus at a drift along x and z [m].
        speed: of the clouds [m/s].
        drift: returns the drift at a time [s].
    """

    def __init__(
        self,
        behind: NDArray[np.floating],
        paint: Callable[[Drift], Heaps],
        speed: float,
        drift: Callable[[float], Drift],
    ) -> None:
        self._height, self._width = behind.shape[:2]
        self._paint, self._speed, self._drift = paint, speed, drift
        # Mitsuba keeps a column more on each side, which repeats the first of the other.
        padded = np.pad(behind, ((0, 0), (1, 1), (0, 0)), mode="wrap").astype(np.float32)
        half = self._height // 2
        self._above = mi.Color3f(np.ascontiguousarray(padded[:half].reshape(-1, 3).T))
        self._below = mi.Float(padded[half:].ravel())
        self._paintings: dict[int, tuple[Any, Any]] = {}

    def at(self, time: float) -> Any:
        """Return the data of an `envmap` at a time [s], `mi.TensorXf`."""
        stretch = self._speed * time / STRETCH
        k = int(stretch)
        color, cover = self._moved(k, time)
        fade = (stretch - k - _FADE) / (1.0 - _FADE)
        if fade > 0.0:
            fade = fade * fade * (3.0 - 2.0 * fade)
            color2, cover2 = self._moved(k + 1, time)
            w = dr.opaque(mi.Float, fade)
            color, cover = color + w * (color2 - color), cover + w * (cover2 - cover)
        self._paintings = {i: p for i, p in self._paintings.items() if i in (k, k + 1)}
        seen = self._above * (1.0 - cover) + color
        # Written at its place: maps are large, and each step that makes one keeps its memory.
        upper, lower = 3 * dr.width(self._above), dr.width(self._below)
        data = dr.empty(mi.Float, upper + lower)
        dr.scatter(data, self._below, upper + dr.arange(mi.UInt32, lower))
        dr.scatter(data, seen, dr.arange(mi.UInt32, upper // 3))
        return mi.TensorXf(data, (self._height, self._width + 2, 3))

    def image(self, time: float) -> NDArray[np.float32]:
        """Return the map (H, W, 3) at a time [s]."""
        return np.array(self.at(time), np.float32)[:, 1:-1]

    def _moved(self, k: int, time: float) -> tuple[Any, Any]:
        """Return colour and cover of the k-th painting, carried to a time."""
        painted_at = k * STRETCH / self._speed if self._speed > 0.0 else 0.0
        (x0, z0), (x1, z1) = self._drift(painted_at), self._drift(time)
        if k not in self._paintings:
            layer = self._paint((x0, z0))
            color = np.ascontiguousarray(layer.color.reshape(-1, 3).T)
            self._paintings[k] = mi.Color3f(color), mi.Float(layer.cover.ravel())
        return self._looked_up(*self._paintings[k], x0 - x1, z0 - z1)

    def _looked_up(self, color: Any, cover: Any, back_x: float, back_z: float) -> tuple[Any, Any]:
        """Return a painting, seen as if it had stood by some metres elsewhere."""
        width, rows = self._width, self._height // 2
        pixel = dr.arange(mi.UInt32, rows * (width + 2))
        # The column outside on the left is the last one of the map.
        across = mi.Float(pixel % (width + 2)) - 0.5
        theta = (mi.Float(pixel // (width + 2)) + 0.5) * (dr.pi / self._height)
        phi = across * (2 * dr.pi / width)
        flat = dr.sin(theta)
        d = mi.Vector3f(flat * dr.sin(phi), dr.cos(theta), -flat * dr.cos(phi))
        p = d * distance_to(d, _HEIGHT)
        p.x += dr.opaque(mi.Float, back_x)
        p.z += dr.opaque(mi.Float, back_z)
        p = dr.normalize(p)
        row = dr.acos(dr.clip(p.y, -1.0, 1.0)) * (self._height / dr.pi) - 0.5
        column = dr.atan2(p.x, -p.z) * (width / (2 * dr.pi)) - 0.5 + 2 * width
        row = dr.clip(row, 0.0, rows - 1.001)
        top, left = mi.UInt32(row), mi.UInt32(column)
        down, side = row - mi.Float(top), column - mi.Float(left)
        left, right = left % width, (left + 1) % width

        def mixed(kind: Any, table: Any) -> Any:
            def along(r: Any) -> Any:
                near = dr.gather(kind, table, r * width + left)
                return near + side * (dr.gather(kind, table, r * width + right) - near)

            high = along(top)
            return high + down * (along(top + 1) - high)

        return mixed(mi.Color3f, color), mixed(mi.Float, cover)
