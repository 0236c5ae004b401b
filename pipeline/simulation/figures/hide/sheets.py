"""Lofted parts of a hide: ears, horns, hooves and hair, made as the figure stands."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.spatial import Array, cross, normalized

Paint = Array
"""(V, 4) linear colour and its share."""

EAR_RINGS, EAR_POINTS, EAR_RIM = 11, 7, 0.75
"""Rings of an ear, points across it, and how much thinner it is at its rim."""

EAR_ROOT = 0.8
"""Width of the root of a leaf-shaped ear, in that which its outline would have there."""

HORN_RINGS, HORN_POINTS = 24, 7

HOOF_POINTS = 12
"""Vertices of a ring of a hoof."""

HOOF_RINGS = np.array(
    [
        *([0.92, 0.66, 1.0], [0.82, 0.81, 1.0], [0.60, 0.82, 0.95]),
        *([-0.25, 0.98, 0.4], [-0.94, 1.13, 0.0], [-1.08, 1.08, 0.0]),
    ]
)
"""Height, half width and share of the band's slant of the rings of a hoof, in the radius of its
ball. The first three are the coronet band; the last lies a little below the ground, as in turf."""

HOOF_AHEAD = 0.30
"""How far the middle of the sole lies ahead of that of the ball, in its radius."""

HOOF_SLOPES = (0.25, 0.62)
"""Least and greatest slope of the wall of a hoof, ahead for one down."""

HOOF_BAND = 0.20
"""How far the band sinks from toe to heel, in half of the radius of the ball."""


def linear_color(text: str) -> Array:
    """Return the linear colour (3,) of '#rrggbb'."""
    srgb = np.array([int(text[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def painted(count: int, color: str, share: float | Array = 1.0) -> Paint:
    """Return one colour for `count` vertices."""
    return np.concatenate(
        [np.tile(linear_color(color), (count, 1)), np.broadcast_to(share, (count,))[:, None]],
        axis=1,
    )


def lay(paint: Paint, color: str, share: Array) -> None:
    """Lay a colour over paint where its share says so."""
    before = paint[:, 3] * (1.0 - share)
    total = before + share
    mix = np.where(total > 1e-9, share / np.maximum(total, 1e-9), 0.0)[:, None]
    paint[:, :3] += mix * (linear_color(color) - paint[:, :3])
    paint[:, 3] = total


def outward(solid: Solid) -> Solid:
    """Return a closed surface with its faces counter-clockwise from outside."""
    a, b, c = (solid.vertices[solid.faces[:, k].astype(int)] for k in range(3))
    volume = float((a * cross(b, c)).sum())
    return solid if volume >= 0.0 else Solid(solid.vertices, solid.faces[:, ::-1].copy())


def ear(
    root: Array,
    way: Array,
    opening: Array,
    length: float,
    width: float,
    fold: float = 0.55,
    pointed: float = 0.0,
    wave: float = 0.0,
) -> tuple[Solid, Array]:
    """Return a cupped leaf, and the share of its inner side at each vertex.

    Args:
        root: (3,) place where it grows [m].
        way: (3,) unit direction to its tip.
        opening: (3,) direction to which it is open.
        length: from root to tip [m].
        width: at its widest [m].
        fold: depth of the cup, in half of the width.
        pointed: 0 for a leaf, 1 for a triangle.
        wave: height of the waves of its rim, in half of the width.
    """
    front = normalized(opening - float((opening * way).sum()) * way)
    across = cross(way, front)
    # Closer at the tip, where the outline turns.
    s = -0.12 + 1.12 * (1.0 - (1.0 - np.linspace(0.0, 1.0, EAR_RINGS)) ** 1.5)
    t = np.clip(s, 0.0, 1.0)
    half = 0.5 * width * (0.42 + 0.58 * np.sin(np.pi * np.minimum(t, 0.75) ** 0.8))
    half *= np.sqrt(np.clip(1.0 - t**3.2, 0.0, 1.0)) + 0.03
    # A funnel: a broad leaf would come out of the other side of the skull.
    half *= np.interp(t, [0.0, 0.3], [EAR_ROOT, 1.0])
    half += pointed * (0.5 * width * (0.03 + 0.97 * (1.0 - t) ** 0.85) - half)
    u = np.linspace(-1.0, 1.0, EAR_POINTS)
    thick = 0.10 * width * (1.0 - 0.6 * t)
    # Rolled into a tube at its root.
    deep = fold * (1.6 - 0.9 * t)
    rings, inner = [], []
    for k in range(len(s)):
        middle = root + s[k] * length * way - 0.10 * length * t[k] ** 2 * front
        bowl = -deep[k] * half[k] * (1.0 - u**2)
        bowl = bowl + wave * 0.5 * width * u**2 * np.sin(2.2 * np.pi * t[k] + 1.4 * u)
        sides = middle + half[k] * u[:, None] * across
        back = sides + (bowl - thick[k] * (1.0 - EAR_RIM * u**2))[:, None] * front
        face = sides + bowl[:, None] * front
        rings.append(np.concatenate([back, face[::-1]]))
        inner.append(np.concatenate([np.zeros(EAR_POINTS), 1.0 - np.abs(u[::-1]) ** 3]))
    ends = np.stack(
        [rings[0].mean(axis=0) - 0.02 * length * way, rings[-1].mean(axis=0) + 0.02 * length * way]
    )
    solid = outward(loft(np.array(rings), ends))
    return solid, np.concatenate([np.concatenate(inner), [0.0, 0.0]])


def horn(curve: Array, radius: float, rings: int, relief: float, blunt: float = 0.08) -> Solid:
    """Return a ringed horn along a curve (n, 3).

    Args:
        curve: from root to tip [m].
        radius: at its root [m].
        rings: number of ridges around it.
        relief: of the ridges, in the radius.
        blunt: radius of the tip, in that of the root.
    """
    t = np.linspace(0.0, 1.0, HORN_RINGS)
    s = np.linspace(0.0, 1.0, len(curve))
    middle = np.stack([np.interp(t, s, curve[:, k]) for k in range(3)], axis=-1)
    for _ in range(3):
        middle[1:-1] = 0.25 * middle[:-2] + 0.5 * middle[1:-1] + 0.25 * middle[2:]
    sizes = radius * (blunt + (1.0 - blunt) * (1.0 - t) ** 0.75)
    ridged = np.clip(1.0 - t / 0.75, 0.0, 1.0) ** 0.3
    sizes = sizes * (1.0 + relief * ridged * np.sin(2.0 * np.pi * rings * t))
    return tube(middle, sizes, HORN_POINTS)


def tube(
    middle: Array, sizes: Array, points: int, flat: float | Array = 1.0, up: Array | None = None
) -> Solid:
    """Return a tube of rings around a curve (n, 3), with radii (n,) [m].

    Args:
        middle: the curve [m].
        sizes: radii [m].
        points: vertices of a ring.
        flat: radius across the direction `up`, in that along it.
        up: (3,) direction that the rings are turned to; any if left out.
    """
    ways = normalized(np.gradient(middle, axis=0))
    across = np.eye(3)[int(np.abs(ways).max(axis=0).argmin())] if up is None else up
    y = normalized(across - (ways * across).sum(axis=-1, keepdims=True) * ways)
    z = cross(ways, y)
    angle = np.arange(points) * (2.0 * np.pi / points)
    wide = np.broadcast_to(flat, (len(middle),))[:, None, None]
    ring = np.cos(angle)[:, None] * y[:, None] + wide * np.sin(angle)[:, None] * z[:, None]
    rings = middle[:, None] + sizes[:, None, None] * ring
    ends = np.stack([middle[0] - 0.5 * sizes[0] * ways[0], middle[-1] + sizes[-1] * ways[-1]])
    return outward(loft(rings, ends))


def small_ball(centre: Array, radius: float, around: int = 8, rings: int = 5) -> Solid:
    """Return a sphere of few triangles."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, rings + 2)
    places = centre + radius * np.sin(angle[1:-1])[:, None] * np.array([1.0, 0.0, 0.0])
    turn = np.arange(around) * (2.0 * np.pi / around)
    flat = np.stack([np.zeros(around), np.cos(turn), np.sin(turn)], axis=-1)
    rings_at = places[:, None] + radius * np.cos(angle[1:-1])[:, None, None] * flat
    ends = centre + radius * np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    return outward(loft(rings_at, ends))


def hoof(sole: Array, ahead: Array, slope: float, radius: float, toes: int) -> Solid:
    """Return a hoof with a coronet band and a wall that goes on from the pastern, whole or cloven.

    Args:
        sole: (3,) the middle of the ball that touches the ground [m].
        ahead: (3,) level direction in which it points.
        slope: of the pastern, ahead for one down.
        radius: of that ball [m].
        toes: 1, or 2 for a cloven one.
    """
    side = cross(ahead, np.array([0.0, 1.0, 0.0]))
    angle = np.arange(HOOF_POINTS) * (2.0 * np.pi / HOOF_POINTS)
    heights, wide = HOOF_RINGS[:, 0], HOOF_RINGS[:, 1]
    slope = float(np.clip(slope, *HOOF_SLOPES))
    # The heel is as steep as the toe; the band is bent towards the heel.
    forward = HOOF_AHEAD - slope * (heights - heights[-1])
    parts = []
    for k in range(toes):
        away = 0.0 if toes == 1 else (k - 0.5) * 1.02
        narrow = 0.96 if toes == 1 else 0.54
        # Longer at the front than at the back; the toes of a cloven one are pointed.
        front = 1.0 + (0.14 if toes == 1 else 0.30) * np.cos(angle)
        x = (1.0 if toes == 1 else 0.84) * wide[:, None] * front * np.cos(angle) + forward[:, None]
        z = (
            wide[:, None] * narrow * np.sin(angle) * (1.0 - 0.22 * (toes > 1) * np.cos(angle))
            + away
        )
        # The band sinks from the toe to the heel.
        y = heights[:, None] + HOOF_BAND * HOOF_RINGS[:, 2:] * (np.cos(angle) - 1.0)
        places = sole + radius * (
            x[..., None] * ahead + y[..., None] * [0, 1, 0] + z[..., None] * side
        )
        ends = places.mean(axis=1)[[0, -1]]
        parts.append(outward(loft(places, ends)))
    starts = np.cumsum([0, *(len(p.vertices) for p in parts[:-1])])
    return Solid(
        np.concatenate([p.vertices for p in parts]),
        np.concatenate([p.faces + np.uint32(n) for p, n in zip(parts, starts, strict=True)]),
    )


def hair_tail(curve: Array, radii: Array, locks: int = 9) -> Solid:
    """Return hanging hair along a curve (n, 3) with radii (n,): deep locks, and a ragged end."""
    t, points = np.linspace(0.0, 1.0, 22), 2 * locks
    s = np.linspace(0.0, 1.0, len(curve))
    middle = np.stack([np.interp(t, s, curve[:, k]) for k in range(3)], axis=-1)
    for _ in range(2):
        middle[1:-1] = 0.25 * middle[:-2] + 0.5 * middle[1:-1] + 0.25 * middle[2:]
    sizes = np.interp(t, s, radii)
    smooth = tube(middle, sizes, points, 0.8, np.array([1.0, 0.0, 0.0]))
    rings = smooth.vertices[:-2].reshape(len(t), points, 3)
    number = np.arange(points)
    lock = 1.0 + 0.20 * np.where(number % 2 == 0, 1.0, -1.0) * np.clip(t * 3.0, 0.0, 1.0)[:, None]
    wave = 1.0 + 0.10 * np.sin(9.0 * t[:, None] + 2.4 * number)
    rings = middle[:, None] + (rings - middle[:, None]) * (lock * wave)[..., None]
    # Ends of locks hang to different lengths.
    drop = 0.16 * np.abs(np.sin(1.7 * number + 0.6)) * np.clip(t * 1.5 - 0.5, 0.0, 1.0)[:, None]
    length = float(np.linalg.norm(np.diff(middle, axis=0), axis=-1).sum())
    rings = rings - (drop * length)[..., None] * normalized(middle[-2] - middle[-1])
    ends = np.stack([smooth.vertices[-2], rings[-1].mean(axis=0)])
    return outward(loft(rings, ends))
