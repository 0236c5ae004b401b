"""Swing trajectory: the path of a foot from one foothold to the next.

    3. Find how far the ground rises above the straight line between them.
    4. Follow a spline that clears it along its whole length.

A bend is a deviation from that path: a uniform cubic B-spline over the swing whose first and last
three control points are zero, so that it changes no place, speed or acceleration at either end.

Source: Sims 1987, 10.2, steps 3 and 4, and figure 10.1; de Boor 1978 for B-splines.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.curves import bump, ease
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

# Samples of the ground along a swing, and finer ones where it has walls.
SAMPLES, FINE_SAMPLES = np.linspace(0.0, 1.0, 42)[1:-1], np.linspace(0.0, 1.0, 162)[1:-1]
_EASE, _BUMP = ease(SAMPLES)[:, None], bump(SAMPLES)

# Clearance under the top of an arch, in step heights.
CLEARANCE = 0.4

# Samples of the last tenth of a swing, in which the touchdown speed is measured.
LAST_TENTH = np.linspace(0.9, 1.0, 9)


def _samples_below(radii: Array, around: int) -> Array:
    """Return samples (n, 3) of the lower half of the unit sphere: x, z, and how far down."""
    angles = np.arange(around) * (2.0 * np.pi / around)
    rings = radii[:, None, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    out = np.concatenate([np.zeros((1, 2)), rings.reshape(-1, 2)])
    down = np.sqrt(np.maximum(1.0 - (out**2).sum(axis=-1), 0.0))
    return np.column_stack([out, down])


# Rings of samples around the lowest point of the spherical foot, so that it clears what rises
# beside it; radii in that of the foot. The last one feels walls. Where a foot stands for long,
# there are more.
RING_RADII = np.array([0.55, 0.92, 1.0])
_SWINGING = _samples_below(RING_RADII, 8)
_STANDING = _samples_below(np.array([0.3, 0.5, 0.65, 0.78, 0.88, 0.95, 1.0]), 16)

# Pieces of a bend, its free control points, and its knots; the free points belong to all knots but
# two at each end.
PIECES = 16
POINTS = PIECES - 3
KNOTS: Array = np.linspace(0.0, 1.0, PIECES + 1)


# Swings from which on feet begin to be quick, and to be quickest, in cycles; and by how much the
# rate at their ends is then higher than that of others.
QUICK_SWINGS, QUICKNESS = (0.45, 0.6), 1.2


# --- timing -------------------------------------------------------------------------


def quickness(swing: Array) -> Array:
    """Return how quick feet leave and reach the ground in swings of so many cycles, 0 to 1.

    In a run the body goes far while a foot swings. One that left the ground as slowly as a walker's
    would be left behind.
    """
    slow, quick = QUICK_SWINGS
    return np.clip((swing - slow) / (quick - slow), 0.0, 1.0)


def part_of_path(s: Array, swing: Array | float) -> Array:
    """Return how far along their paths feet are at fractions `s` of swings, 0 to 1.

    The path stays the same; the ends of it take less of the time, the middle more.

    Args:
        s: fractions of time, 0 to 1.
        swing: duration of the swings, in cycles.
    """
    faster = QUICKNESS * quickness(np.asarray(swing))
    return s + faster * s * (1.0 - s) * (1.0 - 2.0 * s)


# --- the path -----------------------------------------------------------------------


def swing_positions(
    start: Array, end: Array, height: Array | float, s: Array, bend: Array | None = None
) -> Array:
    """Return the tips (L, 3) of feet at fractions `s` (L,) of their swings [m].

    Horizontal motion, height and bends (L, m, 3) all begin and end at rest. One foot at many
    fractions of a swing is given by one start and end (3,) and one height.
    """
    along = ease(s)[:, None]
    p = start + along * (end - start)
    p[:, 1] += height * bump(s)
    return p if bend is None else p + bend_at(bend, s)


def bend_at(bend: Array, s: Array) -> Array:
    """Return the values (L, 3) of bends (L, `POINTS`, 3) at fractions `s` (L,) of swings [m]."""
    piece = np.minimum((s * PIECES).astype(np.int64), PIECES - 1)
    t = s * PIECES - piece
    u = 1.0 - t
    weights = (
        u * u * u / 6.0,
        (4.0 + t * t * (3.0 * t - 6.0)) / 6.0,
        (4.0 + u * u * (3.0 * u - 6.0)) / 6.0,
        t * t * t / 6.0,
    )
    result = np.zeros((len(s), 3))
    rows = np.arange(len(s))
    for k, weight in enumerate(weights):
        point = piece + k - 3
        free = (point >= 0) & (point < POINTS)
        held = bend[rows, np.where(free, point, 0)]
        result += np.where(free, weight, 0.0)[:, None] * held
    return result


def fit_bend(values: Array) -> Array:
    """Return the bends (..., `POINTS`, 3) through values (..., `PIECES` + 1, 3) at the knots [m].

    Exact for cubics; otherwise of fourth order, except in the two pieces at each end, whose fixed
    control points leave less freedom.
    """
    curved = values[..., :-2, :] - 2.0 * values[..., 1:-1, :] + values[..., 2:, :]
    return values[..., 2:-2, :] - curved[..., 1:-1, :] / 6.0


def touchdown_speed(
    start: Array, end: Array, height: float, normal: Array, time: float, bend: Array | None = None
) -> float:
    """Return the speed at which a foot comes down [m/s].

    A planned foot comes to rest as it touches, as an animal's does. The sound has the speed that
    the foot loses within the last tenth of its swing.

    Args:
        start: (3,) tip at lift-off [m].
        end: (3,) tip at touchdown [m].
        height: of the arch [m].
        normal: (3,) of the ground.
        time: duration of the swing, as long as its end at that rate would be [s].
        bend: of the swing (m, 3).
    """
    path = swing_positions(start, end, height, LAST_TENTH, _repeated(bend, LAST_TENTH))
    speeds = -np.diff(path @ normal) / np.diff(LAST_TENTH) / time
    return float(max(speeds.max(), 0.0))


def _repeated(bend: Array | None, s: Array) -> Array | None:
    return None if bend is None else np.broadcast_to(bend, (len(s), *bend.shape))


# --- clearance ----------------------------------------------------------------------


def clearance_height(
    ground: Ground,
    start: Array,
    end: Array,
    foot_radius: float,
    least: float,
    bend: Array | None = None,
    margin: float | None = None,
) -> float:
    """Return the height of the arch with which a swing clears the ground [m].

    Args:
        ground: under the swing.
        start: (3,) tip at lift-off [m].
        end: (3,) tip at touchdown [m].
        foot_radius: [m].
        least: step height on level ground [m].
        bend: of the swing (m, 3).
        margin: clearance under the top of the arch; `CLEARANCE` of `least` if None [m].
    """
    margin = CLEARANCE * least if margin is None else margin
    rise, wall = _rise(ground, start, end, foot_radius, bend, SAMPLES)
    highest = max(float((rise / bump(SAMPLES)).max()), wall)
    if wall > 0.0:
        # Between walls there may be more of them, and narrow ones.
        rise, _ = _rise(ground, start, end, foot_radius, bend, FINE_SAMPLES)
        highest = max(highest, float((rise / bump(FINE_SAMPLES)).max()))
    return max(highest + margin, least)


def clearance_heights(
    ground: Ground, start: Array, end: Array, foot_radius: Array, least: Array
) -> Array:
    """Return the heights of the arches (N,) with which plain swings clear the ground [m].

    Infinite where there are walls, which need `clearance_height`.

    Args:
        ground: under the swings.
        start: (N, 3) tips at lift-off [m].
        end: (N, 3) tips at touchdown [m].
        foot_radius: (N,) [m].
        least: (N,) step heights on level ground [m].
    """
    path = start[:, None] + _EASE * (end - start)[:, None]
    rise = (
        lowest_center_height(ground, path[..., 0], path[..., 2], foot_radius[:, None])
        - path[..., 1]
    )
    swing_height = np.maximum((rise / _BUMP).max(axis=-1) + CLEARANCE * least, least)
    has_walls = (np.abs(np.diff(rise, axis=1)) > foot_radius[:, None]).any(axis=1)
    return np.where(has_walls, np.inf, swing_height)


def _rise(
    ground: Ground, start: Array, end: Array, foot_radius: float, bend: Array | None, s: Array
) -> tuple[Array, float]:
    """Return how far the ground rises above a path without arch, and the arch that clears walls.

    Beside the footholds the arch grows with the square of the time and the ground can rise with its
    cube only, so rise / bump stays bounded there. A wall between two samples must be cleared with
    the lower of their arches.

    Returns:
        Rises (n,) at the samples `s`, and the arch that clears all walls, 0 without walls [m].
    """
    n = len(s)
    ends = np.tile(start, (n, 1)), np.tile(end, (n, 1))
    path = swing_positions(*ends, np.zeros(n), s, _repeated(bend, s))
    rise = lowest_center_height(ground, path[:, 0], path[:, 2], foot_radius) - path[:, 1]
    walls = np.abs(rise[1:] - rise[:-1]) > foot_radius
    if not walls.any():
        return rise, 0.0
    high, shape = np.maximum(rise[1:], rise[:-1]), bump(s)
    return rise, max(float((high / np.minimum(shape[1:], shape[:-1]))[walls].max()), 0.0)


def lowest_center_height(ground: Ground, x: Array, z: Array, foot_radius: Array | float) -> Array:
    """Return the least heights (...) of a spherical foot's centre at x, z (...) [m].

    Args:
        ground: that the foot must not sink into.
        x: of the centre [m].
        z: of the centre [m].
        foot_radius: of one foot, or at all places [m].
    """
    return _lowest(ground, x, z, foot_radius, _SWINGING)


def lowest_standing_height(ground: Ground, x: Array, z: Array, foot_radius: Array | float) -> Array:
    """Return `lowest_center_height` more exactly, for feet that stay there."""
    return _lowest(ground, x, z, foot_radius, _STANDING)


def _lowest(ground: Ground, x: Array, z: Array, foot_radius: Array | float, below: Array) -> Array:
    """Return the least heights (...) of spheres that none of their samples is in the ground [m]."""
    radius = np.asarray(foot_radius)[..., None]
    out_x, out_z, down = below.T
    around = ground.height(x[..., None] + radius * out_x, z[..., None] + radius * out_z)
    return (around + radius * down).max(axis=-1)
