"""Plumes for Dr.Jit: flames that glow and smoke that scatters, marched along rays.

The density is bent by the wind and eroded by noise that rises with the gas. Smoke is a body of
revolution, flames are tongues over their foot.
Flames give off the light of glowing soot, hotter inside, and hide little. Smoke scatters the key
light, which it dims itself on its way, the light of all directions, and that of the flames near it;
light scattered more than once and shadows of surfaces in the smoke are left out.

Sources: R. Bridson, Fluid Simulation for Computer Graphics, 2015, ch. 9, for the look of flames;
    M. Wrenninge, Production Volume Rendering, 2012, ch. 3 and 5, for noise carried by a flow and
    marches with a short one towards the light at each sample.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.lights.environment_map import Vector
from render.lights.lattice_noise import lattice, noise3
from render.plume import SMOKE_WIDENING, Plume

STEPS = {"flame": 40, "smoke": 22}
"""Samples along a ray through a plume."""

_LIGHT_STEPS = (0.25, 0.6, 1.1)
"""Places of the samples towards the key light, in radii of the smoke there."""
_SMOKE_DEPTH = 4.5
"""Optical depth across the foot of smoke."""
_FLAME_DEPTH = 0.35
"""Optical depth across flames."""
_FLAME_RIM, _FLAME_ROOT = 1.3, 0.5
"""Radius at which flames end, in radii of their foot, and the share of it at their root."""
_FLAME_LIGHT = 1.0
"""Radiant intensity of flames for each unit of glow and square metre of their outline."""


@dataclass(frozen=True, eq=False)
class PlumeLight:
    """What lights smoke.

    Attributes:
        direction: unit vector to the key light.
        key: (3,) its irradiance on a plane that faces it.
        ambient: (3,) mean radiance from all directions.
    """

    direction: Vector
    key: Vector
    ambient: Vector


class PlumeVolume:
    """One plume at one moment.

    Numbers that change are opaque, so that all plumes of a kind share one kernel.

    Args:
        plume: flames or smoke.
        light: on smoke.
        flames: that light it besides.
        time: since the film began [s].
    """

    def __init__(
        self, plume: Plume, light: PlumeLight, flames: Sequence[Plume], time: float
    ) -> None:
        def opaque(value: float) -> Any:
            return dr.opaque(mi.Float, float(value))

        def vector(values: Any) -> Any:
            return mi.Vector3f(*(opaque(v) for v in values))

        self.kind = plume.kind
        self._steps = STEPS[plume.kind]
        self._foot = vector(plume.p_WP)
        self._radius, self._height = opaque(plume.radius), opaque(plume.height)
        # Gas that rises for longer is carried farther.
        rise = max(plume.speed, 0.05)
        self._bend = opaque(plume.wind[0] / rise), opaque(plume.wind[1] / rise)
        self._risen = opaque(rise * time)
        self._seed = opaque(17.3 * (plume.seed % 101)), opaque(9.1 * (plume.seed % 89))
        self._glow = opaque(plume.glow)
        self._color: Any = mi.Color3f(*(opaque(v) for v in plume.color))
        self._sun = vector(light.direction)
        self._key: Any = mi.Color3f(*(opaque(v) for v in light.key / (4 * np.pi)))
        self._ambient: Any = mi.Color3f(*(opaque(v) for v in light.ambient))
        self._flames = [_Glow.of(flame) for flame in flames] if plume.kind == "smoke" else []
        self.low, self.high = (
            mi.Point3f(*(dr.opaque(mi.Float, float(v)) for v in corner)) for corner in plume.bounds
        )

    def seen(self, ray: Any, distance: Any, jitter: Any) -> tuple[Any, Any]:
        """Return the share of light that passes, `mi.Float`, and the light added, `mi.Color3f`.

        Args:
            ray: from the camera.
            distance: to the surface [m].
            jitter: 0 to 1, of each ray its own.
        """
        inverse = 1.0 / dr.select(dr.abs(ray.d) < 1e-6, 1e-6, ray.d)
        near, far = (self.low - ray.o) * inverse, (self.high - ray.o) * inverse
        start = dr.maximum(dr.max(dr.minimum(near, far)), 0.0)
        end = dr.minimum(dr.min(dr.maximum(near, far)), distance)
        step = dr.maximum(end - start, 0.0) / self._steps
        is_inside = end > start

        def body(i: Any, passed: Any, light: Any) -> Any:
            p = ray(start + (mi.Float(i) + jitter) * step)
            density, heat, wide = self._density(p, 3)

            def lit(passed: Any, light: Any) -> Any:
                dims = dr.exp(-density * step)
                source = self._source(p, density, heat, wide)
                return passed * dims, light + passed * (1.0 - dims) * source

            passed, light = dr.if_stmt(
                (passed, light),
                density > 1e-4,
                lit,
                lambda passed, light: (passed, light),
                rv_labels=("passed", "light"),
            )
            return i + 1, passed, light

        n = dr.width(distance)
        _, passed, light = dr.while_loop(
            (dr.zeros(mi.UInt32, n), dr.ones(mi.Float, n), dr.zeros(mi.Color3f, n)),
            lambda i, passed, light: is_inside & (i < self._steps) & (passed > 0.01),
            body,
            labels=("i", "passed", "light"),
        )
        return passed, light

    def middle(self) -> Any:
        """Return the middle of the plume's bounds [m]."""
        return 0.5 * (self.low + self.high)

    def _density(self, p: Any, octaves: int) -> tuple[Any, Any, Any]:
        """Return extinction [1/m], heat from 0 to 1, and radius, of flames that of the foot [m]."""
        q = p - self._foot
        s = dr.clip(q.y / self._height, 0.0, 1.0)
        x = q.x - self._bend[0] * q.y * (0.35 + 0.65 * s)
        z = q.z - self._bend[1] * q.y * (0.35 + 0.65 * s)
        if self.kind == "flame":
            return self._flame(x, q.y, z, s, octaves)
        return self._smoke(x, q.y, z, s, octaves)

    def _flame(self, x: Any, y: Any, z: Any, s: Any, octaves: int) -> tuple[Any, Any, Any]:
        size = 1.0 / self._radius
        up = (y - self._risen) * size
        # Tongues sway more the higher they are.
        sway = 0.55 * self._radius * s
        wave = 0.8 * up + self._seed[0]
        x = x + sway * (2.0 * noise3(wave, self._seed[1] + 0.0 * wave, 0.0 * wave + 2.5) - 1.0)
        z = z + sway * (2.0 * noise3(wave, self._seed[1] + 0.0 * wave, 0.0 * wave + 8.5) - 1.0)
        radius_squared = (x * x + z * z) * (size * size)
        # Gas leaves the whole foot. It is drawn to the middle as it rises, in tongues that are each
        # as tall as their part of the foot feeds them, so that the low flames of the rim lick
        # around what lies there.
        supply = noise3(1.5 * x * size + self._seed[1], 0.30 * up, 1.5 * z * size + self._seed[0])
        share_of_height = dr.clip(2.2 * supply - 0.25, 0.22, 1.0)
        # A flame is narrow where it leaves what burns.
        rim = _FLAME_RIM * (_FLAME_ROOT + (1.0 - _FLAME_ROOT) * dr.clip(1.5 * y * size, 0.0, 1.0))
        share_of_height *= dr.clip(1.0 - radius_squared / dr.square(rim), 0.0, 1.0)
        t = s / dr.maximum(share_of_height, 0.02)
        # Tongues curl: the noise that parts them is bent by a slower one.
        bend = 0.55 * (0.3 + s) * self._radius
        slow = 1.3 * size
        x, z = (
            x + bend * (2.0 * noise3(slow * x + 3.7, 0.9 * up, slow * z + self._seed[0]) - 1.0),
            z + bend * (2.0 * noise3(slow * x + 9.1, 0.9 * up, slow * z + self._seed[1]) - 1.0),
        )
        noise = self._noise(3.4 * x * size, 0.80 * up, 3.4 * z * size, octaves)
        body = 0.80 - t + (3.2 + 4.4 * dr.minimum(t, 1.0)) * (noise - 0.5)
        is_inside = (y > 0.0) & (y < self._height) & (share_of_height > 0.0)
        share = dr.clip(9.0 * body - 0.4, 0.0, 1.0) * dr.clip(20.0 * s, 0.0, 1.0)
        # Gas burns where it meets the air: flames are bright sheets about a darker core.
        sheet = dr.exp(-dr.square((body - 0.3) / 0.24))
        # Tips fade before the bounds cut them.
        share *= dr.clip(6.0 * (1.0 - s), 0.0, 1.0)
        share = dr.select(is_inside, share * (0.45 + 0.8 * sheet), 0.0)
        # Hottest low in the middle, where fuel burns; tips and rims cool.
        core = dr.exp(-2.6 * radius_squared - 4.0 * s * s)
        heat = dr.clip(0.44 * body + 0.13 + 0.44 * core - 0.14 * s, 0.0, 1.0)
        return share * (_FLAME_DEPTH / (2.0 * self._radius)), heat, self._radius

    def _smoke(self, x: Any, y: Any, z: Any, s: Any, octaves: int) -> tuple[Any, Any, Any]:
        wide = self._radius * (1.0 + SMOKE_WIDENING * s)
        size = 1.0 / (self._radius * (1.0 + 0.5 * SMOKE_WIDENING))
        up = (y - self._risen) * size
        wave = 0.55 * up + self._seed[1]
        sway = 0.7 * wide * s
        x = x + sway * (2.0 * noise3(wave, self._seed[0] + 0.0 * wave, 0.0 * wave + 1.5) - 1.0)
        z = z + sway * (2.0 * noise3(wave, self._seed[0] + 0.0 * wave, 0.0 * wave + 5.5) - 1.0)
        out = (x * x + z * z) / (wide * wide)
        noise = self._noise(1.9 * x * size, 1.5 * up, 1.9 * z * size, octaves)
        body = 0.55 - 0.75 * out + 4.6 * (noise - 0.5)
        is_inside = (y > 0.0) & (y < self._height) & (out < 2.2)
        share = dr.clip(1.1 * body, 0.0, 1.0) * dr.clip(2.2 - out, 0.0, 1.0)
        # It begins thin, and is spent where it ends.
        share *= dr.clip(7.0 * s, 0.0, 1.0) * dr.square(1.0 - s) * self._radius / wide
        extinction = _SMOKE_DEPTH / (2.0 * self._radius)
        return dr.select(is_inside, share * extinction, 0.0), s, wide

    def _noise(self, x: Any, y: Any, z: Any, octaves: int) -> Any:
        total, weight, sum_ = mi.Float(0.0), 0.5, 0.0
        x, z = x + self._seed[0], z + self._seed[1]
        for _ in range(octaves):
            total += weight * noise3(x, y, z)
            sum_ += weight
            weight *= 0.5
            x, y, z = 1.7 * x + 1.1 * z + 3.1, 2.05 * y + 1.9, -1.1 * x + 1.7 * z + 7.7
        return total / sum_

    def _source(self, p: Any, density: Any, heat: Any, wide: Any) -> Any:
        """Return the radiance of the plume at a place if it hid all behind it."""
        if self.kind == "flame":
            # Soot at 1200 to 2000 K: the cooler the redder, and by far the darker.
            tone = self._color * mi.Color3f(1.0, 0.22 + 1.9 * heat, 0.02 + 5.0 * heat * heat)
            return tone * (self._glow / _FLAME_DEPTH * (0.1 + 13.0 * heat * heat * heat))
        depth = mi.Float(0.0)
        before = 0.0
        for place in _LIGHT_STEPS:
            there, _, _ = self._density(p + self._sun * (place * wide), 2)
            depth += there * wide * (place - before)
            before = place
        # Light that was scattered more than once reaches deeper.
        arriving = 0.75 * dr.exp(-depth) + 0.25 * dr.exp(-0.25 * depth)
        light: Any = self._key * arriving + self._ambient
        for flame in self._flames:
            light = light + flame.radiance(p)
        return self._color * light


@dataclass
class _Glow:
    """Flames as smoke sees them: a soft point of light."""

    place: Any
    softness: Any
    intensity: Any

    @staticmethod
    def of(flame: Plume) -> _Glow:
        """Return the light of flames."""
        x, y, z = flame.p_WP
        strength = _FLAME_LIGHT * flame.glow * flame.radius * flame.height / (4 * np.pi)
        color = np.array(flame.color) * [1.0, 1.6, 2.4] * strength
        middle = (x, y + 0.35 * flame.height, z)
        return _Glow(
            mi.Point3f(*(dr.opaque(mi.Float, float(v)) for v in middle)),
            dr.opaque(mi.Float, flame.radius**2 + 0.02 * flame.height**2),
            mi.Color3f(*(dr.opaque(mi.Float, float(v)) for v in color)),
        )

    def radiance(self, p: Any) -> Any:
        """Return the light that a place scatters of it."""
        way = p - self.place
        return self.intensity / (dr.dot(way, way) + self.softness)


def ray_jitter(pixels: Any, k: Any) -> Any:
    """Return a number from 0 to 1 of each pixel and ray, which hides the steps of a march."""
    return lattice(pixels, k, mi.UInt32(77))
