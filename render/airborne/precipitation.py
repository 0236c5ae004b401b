"""Precipitation: rain and snow in the air, and drops that splash on the ground.

Drops and flakes lie in vertical planes that stand still in the world, one family across X and one
across Z, so that a moving camera passes them and none swims with it. In a plane they are cells of
a grid that slides down as fast as they fall: a hash of the cell says whether it holds one, and
where. Each ray meets the planes before its surface one after the other. Farther planes lie wider
apart and hold larger clusters, which stand for all drops between.

An image of a drop is as wide as the drop or the pixel, whichever is more, and fainter by their
ratio, so that nothing sparkles. Out of focus it is as wide as its circle of confusion, seen from
the middle of the lens: few rays from all over a lens would draw a near drop as single dots.

Sources: P. Rousseau et al., Realistic real-time rain rendering, 2006, for streaks as long as a
    drop falls while one sees it, which refract the sky; K. Garg and S. Nayar, Photorealistic
    rendering of rain streaks, 2006, for their length at a shutter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.config import Weather
from render.lights.environment_map import Vector
from render.lights.lattice_noise import lattice
from render.shot import CameraPose

BLURRED = 1.5
"""Width of what is out of focus, in radii of its circle of confusion, as that of a pixel counts."""

SEEN = 1 / 45
"""Time over which one sees a drop at once [s]."""


@dataclass(frozen=True)
class Layer:
    """Planes between two distances.

    Attributes:
        nearest, farthest: distances from the camera [m].
        apart: distance between two planes of a family [m].
        cell: width and height of a cell, which holds one drop at most [m].
        size: radius of what is in a cell [m].
        length: of a streak [m]; 0 for flakes. Far off, the streaks of drops one above the other
            run together.
        opacity: of what is in a cell.
    """

    nearest: float
    farthest: float
    apart: float
    cell: tuple[float, float]
    size: float
    length: float
    opacity: float


@dataclass(frozen=True)
class Kind:
    """A kind of precipitation.

    Attributes:
        speed: of its fall [m/s].
        sway: amplitude of its swaying [m].
        layers: of planes, from near to far.
    """

    speed: float
    sway: float
    layers: tuple[Layer, ...]


RAIN = Kind(
    8.0,
    0.0,
    (
        Layer(0.9, 7.0, 0.6, (0.17, 0.6), 0.001, 8.0 * SEEN, 0.2),
        Layer(7.0, 25.0, 2.0, (0.13, 0.9), 0.003, 0.5, 0.15),
        Layer(25.0, 70.0, 7.0, (0.24, 2.0), 0.010, 1.3, 0.12),
    ),
)
SNOW = Kind(
    1.3,
    0.05,
    (
        Layer(0.4, 6.0, 0.6, (0.26, 0.26), 0.0042, 0.0, 0.85),
        Layer(6.0, 22.0, 1.8, (0.21, 0.21), 0.0095, 0.0, 0.85),
        Layer(22.0, 70.0, 6.0, (0.30, 0.30), 0.028, 0.0, 0.85),
    ),
)

_SPLASH_CELL, _SPLASH_CYCLE, _SPLASH_TIME = 0.16, 0.45, 0.13
"""Of splashes: side of a cell [m], time after which it may have another, and how long one lasts."""
_SPLASH_REACH = 14.0
"""Distance from the camera at which splashes have vanished [m]."""


@dataclass(frozen=True)
class OpenLens:
    """A lens that blurs what is out of its focus, opaque to recordings.

    Attributes:
        middle: of the lens [m].
        axis: its viewing direction.
        radius: of its aperture [m].
        focus: distance of the plane of focus along the axis [m].
    """

    middle: Any
    axis: Any
    radius: Any
    focus: Any

    @staticmethod
    def of(camera: CameraPose) -> OpenLens | None:
        """Return the lens of a camera, None of a pinhole."""
        if camera.lens is None:
            return None
        middle = np.array(camera.p_WC, float)
        axis = np.array(camera.p_WT, float) - middle
        lens = OpenLens(
            mi.Point3f(*middle.tolist()),
            mi.Vector3f(*(axis / np.linalg.norm(axis)).tolist()),
            mi.Float(camera.lens.radius),
            mi.Float(camera.lens.focus),
        )
        dr.make_opaque(lens.middle, lens.axis, lens.radius, lens.focus)
        return lens

    def central(self, ray: Any) -> Any:
        """Return the ray from the middle of the lens to where a ray meets the plane of focus."""
        ahead = dr.dot(ray.d, self.axis)
        far = (self.focus - dr.dot(ray.o - self.middle, self.axis)) / ahead
        return mi.Ray3f(self.middle, dr.normalize(ray.o + far * ray.d - self.middle))

    def blur(self, distance: Any) -> Any:
        """Return the radius that a point has at a distance, as seen there [m]."""
        return self.radius * dr.abs(1.0 - distance / self.focus)


@dataclass
class Precipitation:
    """What falls at one moment, opaque to recordings.

    Attributes:
        rain, snow: amounts, 0 to 1.
        rain_light, snow_light: radiance of drops and flakes.
        wind: near the ground, along x and z [m/s].
        time: since the film began [s].
        lens: of the camera, None of a pinhole.
    """

    rain: mi.Float
    snow: mi.Float
    rain_light: mi.Color3f
    snow_light: mi.Color3f
    wind: mi.Vector2f
    time: mi.Float
    has_rain: bool
    has_snow: bool
    lens: OpenLens | None = None

    @staticmethod
    def of(
        weather: Weather,
        ambient: Vector,
        key: Vector,
        time: float,
        lens: OpenLens | None = None,
    ) -> Precipitation:
        """Return what falls.

        Args:
            weather: of the scene.
            ambient: (3,) mean radiance from all directions.
            key: (3,) irradiance of the key light on a plane that faces it.
            time: since the film began [s].
            lens: of the camera, None of a pinhole.
        """
        # Drops show the bright sky behind and above; flakes are white spheres.
        rain = 1.6 * ambient + 0.03 * key
        snow = 1.8 * ambient + key / (4 * math.pi)
        made = Precipitation(
            mi.Float(weather.rain),
            mi.Float(weather.snow),
            mi.Color3f(rain.tolist()),
            mi.Color3f(snow.tolist()),
            mi.Vector2f(*weather.ground_wind),
            mi.Float(time),
            weather.rain > 0.0,
            weather.snow > 0.0,
            lens,
        )
        dr.make_opaque(made.rain, made.snow, made.rain_light, made.snow_light)
        dr.make_opaque(made.wind, made.time)
        return made

    def seen(self, ray: Any, distance: Any, pixel_angle: Any) -> tuple[Any, Any]:
        """Return the share of light that passes, `mi.Float`, and the light added, `mi.Color3f`.

        Args:
            ray: from the camera.
            distance: to the surface [m].
            pixel_angle: width of a pixel [rad].
        """
        passed, light = mi.Float(1.0), mi.Color3f(0.0)
        if self.lens is not None:
            ray = self.lens.central(ray)
        if self.has_rain:
            through = self._through(RAIN, self.rain, ray, distance, pixel_angle)
            passed, light = through, self.rain_light * (1.0 - through)
        if self.has_snow:
            through = self._through(SNOW, self.snow, ray, distance, pixel_angle)
            light = light * through + self.snow_light * (1.0 - through)
            passed = passed * through
        return passed, light

    def splashes(self, point: Any, normal: Any, distance: Any, pixel_angle: Any) -> Any:
        """Return the share of a surface that splashes of rain hide, `mi.Float`.

        Args:
            point: of the surface [m].
            normal: of the surface.
            distance: from the camera [m].
            pixel_angle: width of a pixel [rad].
        """
        column, row = point.x / _SPLASH_CELL, point.z / _SPLASH_CELL
        i, j = dr.floor(column), dr.floor(row)
        a, b = mi.UInt32(mi.Int32(i)), mi.UInt32(mi.Int32(j))
        offset = lattice(a, b, mi.UInt32(31)) * _SPLASH_CYCLE
        cycle = (self.time + offset) / _SPLASH_CYCLE
        count = dr.floor(cycle)
        age = (cycle - count) * (_SPLASH_CYCLE / _SPLASH_TIME)
        turn = mi.UInt32(count) * 3
        is_there = lattice(a, b, turn) < 0.75 * self.rain
        # Far enough inside the cell for the whole ring.
        x = 0.3 + 0.4 * lattice(a, b, turn + 1)
        z = 0.3 + 0.4 * lattice(a, b, turn + 2)
        away = _SPLASH_CELL * _length(column - i - x, row - j - z)
        pixel = pixel_angle * distance
        if self.lens is not None:
            pixel += self.lens.blur(distance)
        size = 0.4 + 0.9 * dr.square(lattice(a, b, turn + 3))
        ring = size * (0.008 + 0.034 * age)
        width = 0.007 + 0.6 * pixel
        shape = dr.maximum(1.0 - dr.abs(away - ring) / width, 0.0) * (0.007 / width)
        shape = shape * shape
        center = dr.maximum(1.0 - away / (0.006 * size + pixel), 0.0)
        center *= dr.maximum(1.0 - 2.5 * age, 0.0)
        fade = dr.clip((normal.y - 0.75) / 0.15, 0.0, 1.0)
        fade *= dr.clip(2.0 - 2.0 * distance / _SPLASH_REACH, 0.0, 1.0)
        share = (1.0 - age) * size * (0.12 * shape + 0.4 * center) * fade
        return dr.select(is_there & (age < 1.0), dr.clip(share, 0.0, 1.0), 0.0)

    def _through(self, kind: Kind, amount: Any, ray: Any, distance: Any, pixel_angle: Any) -> Any:
        """Return the share of light that passes between all drops of a kind."""
        # Seen along their fall, drops stand still: their planes lean with the wind.
        lean = self.wind / kind.speed
        origin = ray.o.x + ray.o.y * lean.x, ray.o.z + ray.o.y * lean.y
        way = ray.d.x + ray.d.y * lean.x, ray.d.z + ray.d.y * lean.y
        level = dr.maximum(_length(ray.d.x, ray.d.z), 1e-3)
        ahead = ray.d.x / level, ray.d.z / level
        # How far aside something lies, seen from the camera, for each metre that it is higher.
        lean_aside = ahead[1] * lean.x - ahead[0] * lean.y
        through = mi.Float(1.0)
        for number, layer in enumerate(kind.layers):
            for family in (0, 1):
                place = _Grid(kind, layer, 2 * number + family, family)
                through *= self._through_planes(
                    place, amount, (origin, way, ray, ahead, lean_aside), distance, pixel_angle
                )
        return through

    def _through_planes(
        self, grid: _Grid, amount: Any, line: Any, distance: Any, pixel_angle: Any
    ) -> Any:
        """Return the share of light that passes one family of planes of a layer."""
        kind, layer = grid.kind, grid.layer
        origin, way, ray, ahead, lean_aside = line
        across, along = grid.family, 1 - grid.family
        o, d = origin[across], way[across]
        safe = dr.select(dr.abs(d) < 1e-4, dr.select(d < 0.0, -1e-4, 1e-4), d)
        is_ahead = safe > 0.0
        start = o + safe * layer.nearest
        first = dr.select(is_ahead, dr.ceil(start / layer.apart), dr.floor(start / layer.apart))
        step = dr.select(is_ahead, 1.0, -1.0)
        # Seen at a slant, drops keep their width.
        slant = ahead[0] if grid.family == 0 else -ahead[1]
        count = int((layer.farthest - layer.nearest) / layer.apart) + 1
        end = dr.minimum(distance, layer.farthest)

        def body(i: Any, through: Any) -> Any:
            plane = first + mi.Float(i) * step
            t = (plane * layer.apart - o) / safe
            u = origin[along] + way[along] * t
            y = ray.o.y + ray.d.y * t + kind.speed * self.time
            pixel = pixel_angle * t
            if self.lens is not None:
                pixel += BLURRED * self.lens.blur(t)
            shown = grid.opacity(
                mi.UInt32(mi.Int32(plane)),
                (u, y),
                slant,
                amount,
                (pixel, self.time, lean_aside),
            )
            # Layers fade into one another, and what touches the lens is not there.
            edge = dr.clip((t - layer.nearest) / (0.25 * layer.nearest), 0.0, 1.0)
            shown = dr.select((t > layer.nearest) & (t < end), shown * edge, 0.0)
            return i + 1, through * (1.0 - shown)

        n = dr.width(distance)
        _, through = dr.while_loop(
            (dr.zeros(mi.UInt32, n), dr.ones(mi.Float, n)),
            lambda i, through: i < count,
            body,
            labels=("i", "through"),
        )
        return through


def _length(x: Any, y: Any) -> Any:
    return dr.sqrt(x * x + y * y)


@dataclass(frozen=True)
class _Grid:
    """The grid of drops of a kind in one family of planes of a layer."""

    kind: Kind
    layer: Layer
    salt: int
    family: int

    def opacity(self, plane: Any, place: Any, slant: Any, amount: Any, view: Any) -> Any:
        """Return how much is hidden at a place of a plane."""
        kind, layer = self.kind, self.layer
        pixel, time, lean_aside = view
        u, y = place
        wide, high = layer.cell
        # Columns are shifted against one another, or rows of drops would show.
        column = dr.floor(u / wide)
        a = mi.UInt32(mi.Int32(column))
        shift = lattice(a, plane, mi.UInt32(101 + self.salt))
        y = y / high + 7.0 * shift
        row = dr.floor(y)
        b = mi.UInt32(mi.Int32(row)) + mi.UInt32(7919) * plane
        salt = 4 * self.salt
        is_there = lattice(a, b, mi.UInt32(salt)) < amount
        sway = kind.sway * dr.sin(2.1 * time + 6.3 * shift) if kind.sway else 0.0
        aside = (u / wide - column - 0.2 - 0.6 * lattice(a, b, mi.UInt32(salt + 1))) * wide - sway
        if layer.length:
            aside = dr.abs(aside * slant)
            margin = 0.5 * layer.length / high
            middle = margin + (1.0 - 2.0 * margin) * lattice(a, b, mi.UInt32(salt + 2))
            up = dr.abs(y - row - middle) * high
            # A streak has no hard ends, and small drops, the most of them, are hardly seen.
            ends = dr.maximum(1.0 - dr.square(up / (0.5 * layer.length)), 0.0)
            size = layer.size * (0.4 + 1.2 * dr.square(lattice(a, b, mi.UInt32(salt + 3))))
            width = size + 0.6 * pixel
            shape = dr.maximum(1.0 - aside / width, 0.0) * (size / width) * ends
        else:
            size = layer.size * (0.6 + 0.8 * lattice(a, b, mi.UInt32(salt + 3)))
            up = (y - row - 0.2 - 0.6 * lattice(a, b, mi.UInt32(salt + 2))) * high
            width = size + 0.7 * pixel
            # Round as it is seen, where the grid leans.
            away = _length(aside * slant + up * lean_aside, up) / width
            shape = dr.maximum(1.0 - away * away, 0.0) * dr.square(size / width)
        return dr.select(is_there, layer.opacity * dr.minimum(shape, 1.0), 0.0)
