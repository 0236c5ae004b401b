"""Swing: the way of a foot from one foothold to the next.

    3. Find how far the ground rises above the straight way between them.
    4. Follow a spline that clears it, along its whole length.

Source: Sims 1987, 10.2, steps 3 and 4, and figure 10.1.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.curves import bump, ease
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

SPANS = 16
"""Pieces that a swing is divided into."""

POINTS = SPANS - 3
"""Control points that are free."""

KNOTS: Array = np.linspace(0.0, 1.0, SPANS + 1)
"""Parts of the swing between the pieces; the free points belong to all but two at each end."""


def offset_at(bend: Array, s: Array) -> Array:
    """Return bends (L, 3) at parts `s` (L,) of swings [m].

    Args:
        bend: (L, `POINTS`, 3) free control points [m].
        s: in 0..1.
    """
    piece = np.minimum((s * SPANS).astype(np.int64), SPANS - 1)
    t = s * SPANS - piece
    result = np.zeros((len(s), 3))
    rows = np.arange(len(s))
    for k, weight in enumerate(_weights(t)):
        point = piece + k - 3
        free = (point >= 0) & (point < POINTS)
        held = bend[rows, np.where(free, point, 0)]
        result += np.where(free, weight, 0.0)[:, None] * held
    return result


def _weights(t: Array) -> tuple[Array, Array, Array, Array]:
    """Return the weights of the four points around parts `t` of their pieces."""
    u = 1.0 - t
    return (
        u * u * u / 6.0,
        (4.0 + t * t * (3.0 * t - 6.0)) / 6.0,
        (4.0 + u * u * (3.0 * u - 6.0)) / 6.0,
        t * t * t / 6.0,
    )


def fit_offset(values: Array) -> Array:
    """Return the bends (..., `POINTS`, 3) that follow values at the `KNOTS`.

    Exact for cubics; otherwise of fourth order, and within the two pieces at each end what
    the fixed points leave.

    Args:
        values: (..., `SPANS` + 1, 3) [m].
    """
    curved = values[..., :-2, :] - 2.0 * values[..., 1:-1, :] + values[..., 2:, :]
    result: Array = values[..., 2:-2, :] - curved[..., 1:-1, :] / 6.0
    return result


RINGS = np.array([0.55, 0.92, 1.0])
"""Radii of the rings, in that of the ball; the last one feels walls."""

_ANGLES = np.arange(8) * (np.pi / 4.0)
_OUT = np.concatenate(
    [np.zeros((1, 2)), *(r * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1) for r in RINGS)]
)
_OUT_X, _OUT_Z = np.ascontiguousarray(_OUT.T)
_DOWN = np.sqrt(1.0 - (_OUT**2).sum(axis=-1))


def lowest_center_height(ground: Ground, x: Array, z: Array, sole: Array | float) -> Array:
    """Return the least heights (...) of a ball's middle at places x, z (...) [m].

    Args:
        ground: what it is not to sink into.
        x: places of its middle along x and
        z: along z, of equal shapes [m].
        sole: its radius, or those of all places [m].
    """
    radius = np.asarray(sole)[..., None]
    around = ground.height(x[..., None] + radius * _OUT_X, z[..., None] + radius * _OUT_Z)
    result: Array = (around + radius * _DOWN).max(axis=-1)
    return result


SAMPLES = np.linspace(0.0, 1.0, 42)[1:-1]
"""Places along the way at which the ground is looked at."""

FINE = np.linspace(0.0, 1.0, 162)[1:-1]
"""Places where it has walls."""


_EASE, _BUMP = ease(SAMPLES)[:, None], bump(SAMPLES)


def clearance_height(
    ground: Ground,
    start: Array,
    end: Array,
    sole: float,
    least: float,
    bend: Array | None = None,
    margin: float | None = None,
) -> float:
    """Return how high a swing must arch to clear the ground [m].

    Args:
        ground: what is to be cleared.
        start: (3,) tip at lifting [m].
        end: (3,) tip at coming down [m].
        sole: radius of the tip [m].
        least: height of the arch on level ground [m].
        bend: what the way has beside the arch, see `bend`.
        margin: by how much the top of an arch is to clear the ground; 0.4 of `least` if left
            out [m].
    """
    margin = 0.4 * least if margin is None else margin
    rise, wall = _rise(ground, start, end, sole, bend, SAMPLES)
    highest = max(float((rise / bump(SAMPLES)).max()), wall)
    if wall > 0.0:
        # Between walls there may be more of them, and narrow ones.
        rise, _ = _rise(ground, start, end, sole, bend, FINE)
        highest = max(highest, float((rise / bump(FINE)).max()))
    return max(highest + margin, least)


def clearance_heights(ground: Ground, start: Array, end: Array, sole: Array, least: Array) -> Array:
    """Return how high swings without a bend must arch to clear the ground (N,) [m].

    Infinite where there are walls, which want a closer look.

    Args:
        ground: what is to be cleared.
        start: (N, 3) tips at lifting [m].
        end: (N, 3) tips at coming down [m].
        sole: (N,) radii of the tips [m].
        least: (N,) heights of the arches on level ground [m].
    """
    way = start[:, None] + _EASE * (end - start)[:, None]
    rise = lowest_center_height(ground, way[..., 0], way[..., 2], sole[:, None]) - way[..., 1]
    arch = np.maximum((rise / _BUMP).max(axis=-1) + 0.4 * least, least)
    walls = (np.abs(np.diff(rise, axis=1)) > sole[:, None]).any(axis=1)
    return np.where(walls, np.inf, arch)


def _rise(
    ground: Ground, start: Array, end: Array, sole: float, bend: Array | None, s: Array
) -> tuple[Array, float]:
    """Return how far the ground rises above a way without arch (n,), and what walls ask for.

    Beside the footholds the arch grows with the square of the time and the ground can rise
    with its cube only, so rise / bump stays bounded there. A wall between two of the places
    is come to with the lower of their arches.

    Args:
        ground: what is to be cleared.
        start: (3,) tip at lifting [m].
        end: (3,) tip at coming down [m].
        sole: radius of the tip [m].
        bend: what the way has beside the arch.
        s: (n,) parts of the swing that are looked at.

    Returns:
        Rises (n,), and the arch that clears all walls, 0 if there are none [m].
    """
    n = len(s)
    bends = None if bend is None else _for_all(bend, s)
    way = swing_positions(np.tile(start, (n, 1)), np.tile(end, (n, 1)), np.zeros(n), s, bends)
    rise = lowest_center_height(ground, way[:, 0], way[:, 2], sole) - way[:, 1]
    walls = np.abs(rise[1:] - rise[:-1]) > sole
    if not walls.any():
        return rise, 0.0
    high, arch = np.maximum(rise[1:], rise[:-1]), bump(s)
    return rise, max(float((high / np.minimum(arch[1:], arch[:-1]))[walls].max()), 0.0)


def swing_positions(
    start: Array, end: Array, height: Array | float, s: Array, bend: Array | None = None
) -> Array:
    """Return the tips (L, 3) of feet at parts `s` (L,) of their swings [m].

    Horizontal way and height both begin and end at rest; see `bump`. What swings have beside
    that, their `bend` (L, m, 3), does so too. One foot at many parts of a swing is given by one
    start and end (3,) and one height.
    """
    along = ease(s)[:, None]
    p = start + along * (end - start)
    p[:, 1] += height * bump(s)
    return p if bend is None else p + offset_at(bend, s)


LAST = np.linspace(0.9, 1.0, 9)
_LAST_PARTS = np.diff(LAST)


def _for_all(bend: Array, parts: Array) -> Array:
    return np.broadcast_to(bend, (len(parts), *bend.shape))


def touchdown_speed(
    start: Array,
    end: Array,
    height: float,
    normal: Array,
    time: float,
    bend: Array | None = None,
) -> float:
    """Return the speed at which a foot comes down [m/s].

    A planned foot comes to rest as it touches, as an animal's does; what is heard is
    the speed that it loses within the last tenth of its swing.

    Args:
        start: (3,) tip at lifting [m].
        end: (3,) tip at coming down [m].
        height: of the arch [m].
        normal: (3,) of the ground.
        time: of the whole swing [s].
        bend: of the swing.
    """
    way = swing_positions(start, end, height, LAST, None if bend is None else _for_all(bend, LAST))
    speeds = -np.diff(way @ normal) / _LAST_PARTS / time
    return float(max(speeds.max(), 0.0))
