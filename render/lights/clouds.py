"""Clouds: painted into the map of the sky, lit by its sun or moon.

Cumulus is a layer with a flat base: where the cover is thick it towers up, and puffs of noise erode
its sides. Each direction marches through the layer, and a short way from each sample towards the
sun tells how much light arrives. Cirrus is a thin sheet of drawn-out noise far above. Both sink to
the horizon with the curvature of the earth and fade there into haze. Heaps drift; see
`drifting_sky`.

Sources: A. Schneider and N. Vos, The Real-time Volumetric Cloudscapes of Horizon: Zero Dawn, 2015,
    for towers shaped by the cover and eroded by noise, and for more light inside than extinction
    alone lets in.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.config import Clouds, Sun
from render.lights.environment_map import Map, Vector, resized
from render.lights.key_light import KeyLight
from render.lights.lattice_noise import fbm2, lattice, puffs

_EARTH_RADIUS = 6.371e6
_BASE, _TOP = 900.0, 1650.0
"""Heights between which cumulus lies [m]."""
_CIRRUS = 7500.0
"""Height of the cirrus [m]."""

_STEPS = 64
"""Samples along a direction through the layer."""
_LONGEST = 9000.0
"""Longest way through the layer [m]: what lies behind is as good as hidden."""
_LIGHT_STEPS = (35.0, 80.0, 170.0, 340.0)
"""Steps towards the sun [m]."""
_EXTINCTION = 0.028
"""Of the densest cloud [1/m]."""

_PATCH = 1800.0
"""Size of the largest patches of cover [m]."""
_PUFF = 340.0
"""Size of the largest puffs [m]."""

_HAZE_LENGTH = 22_000.0
"""Distance over which clouds take 1 - 1/e of the colour of the horizon [m]."""

_LOWEST = 0.002
"""Sine of the lowest elevation with clouds."""

_OPEN_DEG = (6.0, 15.0)
"""Angles from the sun within which no cumulus hides it, and from which all is covered."""


@dataclass(frozen=True, eq=False)
class CloudLight:
    """What lights the clouds, in the units of the sky.

    Attributes:
        key: sun or moon.
        above: (3,) mean radiance of the sky, which lights them from all sides.
        below: (3,) radiance of the ground.
    """

    key: KeyLight
    above: Vector
    below: Vector


def cloud_seed(sun: Sun) -> int:
    """Return the seed of the places of clouds: no two skies of other days or hours are alike."""
    return zlib.crc32(f"{sun.day} {sun.hour:.4f} {sun.latitude_deg:.4f}".encode())


def has_clouds(clouds: Clouds) -> bool:
    """Return whether there are any clouds to paint."""
    return max(clouds.cumulus, clouds.cirrus, clouds.overcast) > 0.0


@dataclass(frozen=True, eq=False)
class Heaps:
    """A layer of cumulus as it is seen, above the horizon.

    Attributes:
        color: (H / 2, W, 3) light of the clouds and of the air before them.
        cover: (H / 2, W) share of the sky behind that they hide.
    """

    color: NDArray[np.float32]
    cover: NDArray[np.float32]


def painted(
    sky: Map, clouds: Clouds, light: CloudLight, seed: int, width: int
) -> NDArray[np.float32]:
    """Return a sky with its clouds except heaps, (width / 2, width, 3).

    A variant of Mitsuba without arrays returns it without them: a march by single numbers would
    take minutes.

    Args:
        sky: (H, W, 3) map, at least a few pixels high.
        clouds: which ones.
        light: on them.
        seed: of their places.
        width: of the map that is returned [pixels].
    """
    if not dr.is_jit_v(mi.Float):
        return np.asarray(resized(sky, width, width // 2), np.float32)
    d, row, column = _directions(width, width // 2)
    below = _sampled(sky, row, column)
    is_up = d.y > _LOWEST
    horizon = _sampled(sky, dr.opaque(mi.Float, 0.5), column)
    painter = _Painter(clouds, light, seed)
    seen = below
    if clouds.cirrus > 0.0:
        seen = painter.cirrus(d, is_up, seen, horizon)
    if clouds.overcast > 0.0:
        seen = painter.stratus(d, is_up, seen)
    image = dr.ravel(dr.select(is_up, seen, below))
    return np.array(image, np.float32).reshape(width // 2, width, 3)


def heaps(
    sky: Map,
    clouds: Clouds,
    light: CloudLight,
    seed: int,
    width: int,
    drift: tuple[float, float],
) -> Heaps:
    """Return the cumulus before a sky; see `painted`. It needs a variant with arrays.

    Args:
        sky: (H, W, 3) map, whose horizon tints what is far.
        clouds: which ones.
        light: on them.
        seed: of their places.
        width: of the whole map [pixels].
        drift: way of the clouds along x and z since the film began [m].
    """
    rows = width // 4
    d, _, column = _directions(width, rows)
    horizon = _sampled(sky, dr.opaque(mi.Float, 0.5), column)
    color, cover = _Painter(clouds, light, seed, drift).cumulus(d, d.y > _LOWEST, horizon)
    return Heaps(
        np.array(dr.ravel(color), np.float32).reshape(rows, width, 3),
        np.array(cover, np.float32).reshape(rows, width),
    )


def _directions(width: int, rows: int) -> tuple[Any, Any, Any]:
    """Return direction, row and column, from 0 to 1, of the pixels in the upper rows of a map."""
    pixel = dr.arange(mi.UInt32, width * rows)
    row, column = mi.Float(pixel // width) + 0.5, mi.Float(pixel % width) + 0.5
    theta, phi = row * (2 * dr.pi / width), column * (2 * dr.pi / width)
    flat = dr.sin(theta)
    d = mi.Vector3f(flat * dr.sin(phi), dr.cos(theta), -flat * dr.cos(phi))
    return d, row * (2.0 / width), column / width


def _sampled(sky: Map, row: Any, column: Any) -> Any:
    """Return the map at places from 0 to 1, linear between pixels."""
    height, width = sky.shape[:2]
    table = mi.Color3f(np.ascontiguousarray(sky.reshape(-1, 3).T, np.float32))
    y = dr.clip(row * height - 0.5, 0.0, height - 1.001)
    x = column * width - 0.5 + width
    top, left = mi.UInt32(y), mi.UInt32(x)
    down, across = y - mi.Float(top), x - mi.Float(left)

    def at(r: Any) -> Any:
        near = dr.gather(mi.Color3f, table, r * width + left % width)
        far = dr.gather(mi.Color3f, table, r * width + (left + 1) % width)
        return near + across * (far - near)

    high, low = at(top), at(top + 1)
    return high + down * (low - high)


class _Painter:
    """Paints clouds of one sky.

    Numbers that a scene may change are opaque, so that all scenes share one kernel.
    """

    def __init__(
        self,
        clouds: Clouds,
        light: CloudLight,
        seed: int,
        drift: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        def opaque(value: float) -> Any:
            return dr.opaque(mi.Float, float(value))

        def color(values: Vector) -> Any:
            return mi.Color3f(*(opaque(v) for v in values))

        self._cover, self._veil = opaque(clouds.cumulus), opaque(clouds.overcast)
        self._cirrus = opaque(clouds.cirrus)
        self._sun = mi.Vector3f(*(opaque(v) for v in light.key.direction))
        # White in full sun, as snow is.
        self._key = color(light.key.irradiance * (0.9 / np.pi))
        self._above, self._below = color(light.above), color(light.below)
        x, z = 1.7 * _PATCH * (seed % 97), -2.3 * _PATCH * (seed % 61)
        self._shift = opaque(x), opaque(z)
        self._drifted = opaque(x - drift[0]), opaque(z - drift[1])

    def cumulus(self, d: Any, active: Any, horizon: Any) -> tuple[Any, Any]:
        """Return the light of the layer of cumulus, and the share that it hides of what is behind.

        Args:
            d: directions.
            active: which of them look up.
            horizon: light of the horizon below each direction.
        """
        start = distance_to(d, _BASE)
        end = dr.minimum(distance_to(d, _TOP), start + _LONGEST)
        step = (end - start) / _STEPS
        # Of each direction its own, or the samples would show as terraces.
        first = start + step * lattice(
            dr.arange(mi.UInt32, dr.width(d)), mi.UInt32(0), mi.UInt32(7)
        )
        cosine = dr.dot(d, self._sun)
        angle = dr.rad2deg(dr.acos(dr.clip(cosine, -1.0, 1.0)))
        # The sun of the scene shines, so it stands in a gap.
        opened = _smooth((angle - _OPEN_DEG[0]) / (_OPEN_DEG[1] - _OPEN_DEG[0]))
        phase = 0.62 + 1.9 * _forward(cosine, 0.72) + 0.25 * _forward(-cosine, 0.3)

        def body(i: Any, through: Any, color: Any, far: Any) -> Any:
            t = first + mi.Float(i) * step
            p = d * t
            height = self._height(d, t)
            tower = self._tower(p, height, opened, 4)

            def marched(through: Any, color: Any, far: Any) -> Any:
                density = _eroded(tower, p, height, self._drifted, 4)
                lit = self._light_at(p, height, opened)
                side = 0.55 + 0.45 * height
                around = self._above * (1.15 * side) + self._below * (0.55 * (1.0 - height))
                passed = dr.exp(-_EXTINCTION * density * step)
                share = through * (1.0 - passed)
                seen = self._key * (lit * phase) + around
                return through * passed, color + share * seen, far + share * t

            # Most of the layer is empty, and is passed quickly.
            through, color, far = dr.if_stmt(
                (through, color, far),
                tower > 0.0,
                marched,
                lambda *state: state,
                rv_labels=("through", "color", "far"),
            )
            return i + 1, through, color, far

        def going(i: Any, through: Any, color: Any, far: Any) -> Any:
            return active & (i < _STEPS) & (through > 0.01)

        n = dr.width(d)
        _, through, color, far = dr.while_loop(
            (
                dr.zeros(mi.UInt32, n),
                dr.ones(mi.Float, n),
                dr.zeros(mi.Color3f, n),
                dr.zeros(mi.Float, n),
            ),
            going,
            body,
            labels=("i", "through", "color", "far"),
        )
        cover = 1.0 - through
        mean = far / dr.maximum(cover, 1e-4)
        clear: Any = dr.exp(-mean / _HAZE_LENGTH)
        color = color * clear + horizon * (cover * (1.0 - clear))
        # Where the layer is a line, it is air.
        low = _smooth((d.y - 0.004) / 0.03)
        return dr.select(active, color * low, 0.0), dr.select(active, cover * low, 0.0)

    def cirrus(self, d: Any, active: Any, behind: Any, horizon: Any) -> Any:
        """Return the light that arrives through a thin sheet of ice."""
        t = distance_to(d, _CIRRUS)
        x, z = d.x * t + self._shift[0], d.z * t + self._shift[1]
        # Drawn out by the wind.
        along, across = 0.83 * x + 0.56 * z, -0.56 * x + 0.83 * z
        bend = fbm2(along / 16_000.0 + 3.1, across / 16_000.0, 2) - 0.5
        wisps = fbm2(along / 14_000.0 + 0.6 * bend, across / 2600.0 + 2.2 * bend, 6)
        field = fbm2(along / 26_000.0 + 7.7, across / 22_000.0 + 1.3, 3)
        share = _smooth((wisps + 0.9 * field - 1.16 + 0.5 * self._cirrus) / 0.5)
        cosine = dr.dot(d, self._sun)
        forward: Any = 0.42 + 1.3 * _forward(cosine, 0.75)
        light = self._key * forward + 0.55 * self._above
        clear = dr.exp(-t / (5.0 * _HAZE_LENGTH))
        light = light * clear + horizon * (1.0 - clear)
        share = 0.62 * share * _smooth((d.y - 0.01) / 0.12)
        return behind + share * (light - behind)

    def stratus(self, d: Any, active: Any, behind: Any) -> Any:
        """Return an overcast sky with the folds of its clouds: its mean brightness stays."""
        t = distance_to(d, _BASE)
        x, z = d.x * t + self._shift[0], d.z * t + self._shift[1]
        bend = fbm2(x / 2600.0, z / 2600.0 + 5.2, 3) - 0.5
        folds = fbm2(x / 3400.0 + 0.9 * bend, z / 2400.0 - 0.9 * bend, 6) - 0.5
        strength = self._veil * _smooth((d.y - 0.01) / 0.16)
        return behind * (1.0 + 1.15 * strength * folds)

    def _tower(self, p: Any, height: Any, opened: Any, octaves: int) -> Any:
        """Return how far inside a tower of cumulus, before its erosion, a place is.

        Args:
            p: place relative to the camera [m].
            height: in the layer, 0 to 1.
            opened: share of the cover that the gap before the sun leaves.
            octaves: of the cover.
        """
        x, z = p.x + self._drifted[0], p.z + self._drifted[1]
        field = fbm2(x / _PATCH, z / _PATCH, octaves)
        # Of the field, which is about 0.5 in the mean, a share as large as the cover is above.
        cover = (field - 0.66 + 0.34 * self._cover) * (3.4 * opened) - 0.6 * (1.0 - opened)
        return cover - 0.85 * height * height - 0.12 * height

    def _light_at(self, p: Any, height: Any, opened: Any) -> Any:
        """Return the share of the key light that arrives at a place in the layer."""
        depth = mi.Float(0.0)
        way = 0.0
        thickness = _TOP - _BASE
        for length in _LIGHT_STEPS:
            middle = way + 0.5 * length
            at = p + self._sun * middle
            higher = height + self._sun.y * middle / thickness
            tower = self._tower(at, higher, opened, 3)
            there = _eroded(tower, at, higher, self._drifted, 2)
            depth += dr.select(higher < 1.0, there, 0.0) * length
            way += length
        depth = _EXTINCTION * depth
        # Light that was scattered many times reaches far deeper than extinction alone tells.
        return 0.72 * dr.exp(-depth) + 0.28 * dr.exp(-0.18 * depth)

    def _height(self, d: Any, t: Any) -> Any:
        """Return the height in the layer, 0 at its base to 1, at a distance."""
        rise = d.y * t + (t * t) * (0.5 * (1.0 - d.y * d.y) / _EARTH_RADIUS)
        return (rise - _BASE) / (_TOP - _BASE)


def _eroded(tower: Any, p: Any, height: Any, shift: tuple[Any, Any], octaves: int) -> Any:
    """Return the density of cumulus at a place, 0 to 1, after puffs have eroded its tower."""
    x, z = p.x + shift[0], p.z + shift[1]
    rounded = puffs(x / _PUFF, p.y / _PUFF, z / _PUFF, octaves)
    body = tower - 0.62 * (1.0 - rounded) * (0.35 + 0.65 * dr.minimum(4.0 * height, 1.0))
    return dr.clip(5.0 * body, 0.0, 1.0) * dr.clip(height / 0.06, 0.0, 1.0)


def distance_to(d: Any, height: float) -> Any:
    """Return the distance at which directions reach a height above the round earth [m]."""
    up = dr.maximum(d.y, 0.0)
    # Equal to R (-y + sqrt(y^2 + 2 h / R)), without its difference of large numbers.
    ratio = 2.0 * height / _EARTH_RADIUS
    return _EARTH_RADIUS * ratio / (up + dr.sqrt(up * up + ratio))


def _forward(cosine: Any, g: float) -> Any:
    """Return light scattered forward, 1 straight on and less aside (Henyey and Greenstein)."""
    return ((1.0 - g) ** 2 / (1.0 + g * g - 2.0 * g * cosine)) ** 1.5


def _smooth(t: Any) -> Any:
    edge = dr.clip(t, 0.0, 1.0)
    return edge * edge * (3.0 - 2.0 * edge)
