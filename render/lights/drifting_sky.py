"""Drifting sky: an emitter around a scene whose cumulus moves with the wind.

A layer takes seconds to paint. So it is painted once for each hundred metres that it drifts, and
every direction looks up where in the painting the air was that is there now. Towards the end of
each stretch the next painting fades in. No map of a moment is made: one that is as fine as a frame
takes longer than all that is looked up in it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.lights.clouds import Heaps, distance_to
from render.lights.environment_map import pixel_directions, resized
from render.python_plugin import plugin

STRETCH = 100.0
"""Drift for which a painting serves [m]: a tenth of the height of the clouds."""
_FADE = 0.5
"""Share of a stretch after which the next painting fades in."""
_HEIGHT = 1100.0
"""Height of most of what is seen of the clouds [m]."""
_DISTANCE = 1e4
"""Distance of the sky, to which shadow rays go [m]."""

Drift = tuple[float, float]


class DriftingSky:
    """The radiance of a sky at any time.

    Args:
        behind: (H, W, 3) sky behind the cumulus.
        paint: returns the cumulus at a drift along x and z [m].
        speed: of the clouds [m/s].
        drift: returns the drift at a time [s].

    Attributes:
        values: all arrays that it looks up now, by name; see `emitter`.
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
        self._behind = _table(behind, np.zeros(behind.shape[:2]))
        self._paintings: dict[int, Any] = {}
        self.values: dict[str, Any] = {}
        self.set_time(0.0)

    def set_time(self, time: float) -> None:
        """Let the cumulus drift to a time [s]."""
        stretch = self._speed * time / STRETCH
        k = int(stretch)
        fade = max((stretch - k - _FADE) / (1.0 - _FADE), 0.0)
        fade = fade * fade * (3.0 - 2.0 * fade)
        shown = (k, k + 1) if fade > 0.0 else (k,)
        self._paintings = {i: p for i, p in self._paintings.items() if i in (k, k + 1)}
        x1, z1 = self._drift(time)
        self.values = {"behind": self._behind, "fade": dr.opaque(mi.Float, fade)}
        for name, i in zip(("now", "next"), shown, strict=False):
            x0, z0 = self._drift(i * STRETCH / self._speed if self._speed > 0.0 else 0.0)
            if i not in self._paintings:
                layer = self._paint((x0, z0))
                self._paintings[i] = _table(layer.color, layer.cover)
            self.values[name] = self._paintings[i]
            back = dr.opaque(mi.Float, x0 - x1), dr.opaque(mi.Float, z0 - z1)
            self.values[f"{name} back"] = mi.Vector2f(*back)

    def radiance(self, d: Any) -> Any:
        """Return the light from directions, unit vectors, `mi.Color3f`."""
        seen = self._looked_up(self.values["behind"], d, self._height)
        layer = self._layer("now", d)
        if "next" in self.values:
            layer += self.values["fade"] * (self._layer("next", d) - layer)
        # Within the row of pixels at the horizon, the layer ends.
        row = dr.acos(dr.clip(d.y, -1.0, 1.0)) * (self._height / dr.pi)
        layer *= dr.clip(0.5 * self._height + 0.5 - row, 0.0, 1.0)
        color = mi.Color3f(seen.x, seen.y, seen.z) * (1.0 - layer.w)
        return color + mi.Color3f(layer.x, layer.y, layer.z)

    def image(self, time: float) -> NDArray[np.float32]:
        """Return a map (H, W, 3) of the radiance at a time [s]."""
        self.set_time(time)
        directions = pixel_directions(self._width, self._height).reshape(-1, 3)
        d = mi.Vector3f(np.ascontiguousarray(directions.T, np.float32))
        found = np.array(self.radiance(d), np.float32).T
        return np.ascontiguousarray(found).reshape(self._height, self._width, 3)

    def emitter(self, sampling_weight: float) -> Any:
        """Return the sky as `mi.Emitter`, as it is at the time that is set.

        Args:
            sampling_weight: of Mitsuba, 0 for a sky that only rays which meet it see.
        """
        # Clouds are broad: directions are chosen by a small map.
        small = mi.Bitmap(np.asarray(resized(self.image(0.0).astype(np.float64)), np.float32))
        made = plugin(_SkyEmitter, "Emitter", {"sampling_weight": sampling_weight})
        made.m_flags = mi.EmitterFlags.Infinite | mi.EmitterFlags.SpatiallyVarying
        made.sky, made.values = self, self.values
        made.chooser = mi.load_dict({"type": "envmap", "bitmap": small})
        return made

    def _layer(self, name: str, d: Any) -> Any:
        """Return colour and cover of a painting, carried to the time that is set."""
        back = self.values[f"{name} back"]
        p = d * distance_to(d, _HEIGHT)
        p = dr.normalize(mi.Vector3f(p.x + back.x, p.y, p.z + back.y))
        return self._looked_up(self.values[name], p, self._height // 2)

    def _looked_up(self, table: Any, d: Any, rows: int) -> Any:
        """Return the values of a map in directions, linear between pixels, `mi.Vector4f`."""
        width = self._width
        row = dr.acos(dr.clip(d.y, -1.0, 1.0)) * (self._height / dr.pi) - 0.5
        column = dr.atan2(d.x, -d.z) * (width / (2 * dr.pi)) - 0.5 + 2 * width
        row = dr.clip(row, 0.0, rows - 1.001)
        top, left = mi.UInt32(row), mi.UInt32(column)
        down, side = row - mi.Float(top), column - mi.Float(left)
        left, right = left % width, (left + 1) % width

        def along(r: Any) -> Any:
            near = dr.gather(mi.Vector4f, table, r * width + left)
            return near + side * (dr.gather(mi.Vector4f, table, r * width + right) - near)

        high = along(top)
        return high + down * (along(top + 1) - high)


class _SkyEmitter:
    """Methods of `mi.Emitter` for a sky."""

    sky: DriftingSky
    values: dict[str, Any]
    chooser: Any

    def set_time(self, time: float) -> None:
        """Let the cumulus drift to a time [s]."""
        self.sky.set_time(time)
        # Members of the emitter, where frozen functions look for their inputs.
        self.values = self.sky.values

    def eval(self, si: Any, active: Any = True) -> Any:
        return dr.select(active, self.sky.radiance(-si.wi), 0.0)

    def sample_direction(self, it: Any, sample: Any, active: Any = True) -> tuple[Any, Any]:
        found, _ = self.chooser.sample_direction(it, sample, active)
        found.dist, found.p = _DISTANCE, it.p + _DISTANCE * found.d
        found.emitter = mi.EmitterPtr(self)
        light = self.sky.radiance(found.d) / found.pdf
        return found, dr.select(active & (found.pdf > 0.0), light, 0.0)

    def pdf_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
        return self.chooser.pdf_direction(it, ds, active)

    def eval_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
        del it
        return dr.select(active, self.sky.radiance(ds.d), 0.0)

    def bbox(self) -> Any:
        return mi.ScalarBoundingBox3f()

    def traverse(self, callback: Any) -> None:
        del callback

    def parameters_changed(self, keys: Any) -> None:
        del keys

    def to_string(self) -> str:
        return "DriftingSky[]"


def _table(color: NDArray[np.floating], share: NDArray[np.floating]) -> Any:
    """Return a map (H, W, 3) with a fourth channel (H, W) pixel by pixel, `mi.Float`."""
    return mi.Float(np.concatenate([color, share[..., None]], axis=-1).astype(np.float32).ravel())
