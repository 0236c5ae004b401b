"""Foot link: the last link of a leg, a hoof, paw or foot, turned towards a wanted direction.

A leg by itself folds along its bend path, which gives its foot one direction for each distance from
hip to tip. To turn the foot away from that, the ankle turns and the leg folds more or less, so
that the distance remains. How far a foot may turn is found once for each leg: as far as no joint
has to be much quicker than those of two equal links, whatever way the tip goes. So the foot of a
stretched leg follows the leg, a heel rises, and the foot of one that bends in its middle can stay
flat.

Notation: n axis of the ankle, a its turn, e distance from base to tip in lengths of the leg, δ
turn of the foot relative to the line from base to tip.

Source: the geometry is elementary; Sims 1987, 6.3.1 for bends as a function of the distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease
from pipeline.simulation.figures.bend_path import CELLS, BendPath
from pipeline.simulation.figures.fold_curve import FEWEST_JOINTS
from pipeline.simulation.figures.joint_limits import LEVEL
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.spatial import Array, cross, turn

TURNS: Array = np.linspace(-1.4, 1.4, 57)
"""Turns of the ankle that are tried [rad]."""

OFFSETS: Array = np.linspace(-1.2, 1.2, 33)
"""Turns of the foot in the tables [rad]."""

ROUNDING = 10
"""Cells on either side over which the range of a foot is rounded."""

SOFT = 0.25
"""Least turn over which a foot meets the end of its range [rad]."""

OPPOSITE = 1.8
"""Angle to the wanted direction from which on a foot gives it up, because either way round would
do [rad]."""

IN_PLANE = 0.5
"""Part of the wanted direction within the plane of the leg below which it means little."""


STEEP = 0.7
"""Sine of the slope of a last link at rest from which on it stands on its toe; up to `LEVEL` it
stands on its sole."""


@dataclass(frozen=True, slots=True)
class CalmFeet:
    """Bounds of the rates of joints, in those of two equal links.

    Attributes:
        most: greatest rate while a foot turns as far as it may.
        turning: greatest rate while a foot turns as the tip goes round the base.
        stretching: factor of both for legs with soles and one knee that are not far folded, so that
            people stand, walk and sit with level soles.
        nearly: distances between which it begins to count, in lengths of the leg.
        roll: by which feet turn besides, per distance of the tip in leg lengths [rad].
        widening: changes of the range of a foot with the bend of two equal links, of which the one
            is taken that leaves most range about rest.
        sole_widening: the same of feet that stand on their soles.
        near: distance from that at rest to which this counts, in lengths of the leg.
        folded: distance below which no one sees the difference and joints may be quicker, in
            lengths of the leg.
        most_folded: greatest rate there.
        straight: distance above which rates do not count, because the leg stretches.
    """

    most: float = 1.9
    turning: float = 2.1
    stretching: float = 3.0
    nearly: tuple[float, float] = (0.45, 0.62)
    roll: float = 1.5
    widening: tuple[float, ...] = (2.0, 1.5, 1.0, 0.7)
    sole_widening: tuple[float, ...] = (4.0, 3.0, 2.0, 1.5, 1.0, 0.7)
    near: float = 0.12
    folded: float = 0.3
    most_folded: float = 3.0
    straight: float = 0.97


CALM_FEET = CalmFeet()


@dataclass(frozen=True, eq=False)
class FootLink:
    """Bends of L legs with turned feet.

    Attributes:
        depths: (CELLS + 1, n, L) places on the bend paths, by depth and turn of the foot.
        turns: (CELLS + 1, n, L) turns of the ankles beside those of the paths [rad].
    """

    depths: Array
    turns: Array

    @staticmethod
    def of(batch: LimbBatch, path: BendPath) -> FootLink:
        """Return the feet of limbs with as many joints each, and with bend paths."""
        found = [_leg_tables(batch.rows(np.array([k])), path, k) for k in range(len(path.longest))]
        depths, turns = (np.stack(tables, axis=-1) for tables in zip(*found, strict=True))
        return FootLink(depths, turns)

    def bends(self, own: NDArray[np.int64], depth: Array, offset: Array) -> tuple[Array, Array]:
        """Return places on the bend paths and turns of the ankles (l, m) [rad].

        Args:
            own: (l, 1) numbers of the limbs.
            depth: (l, m) on the bend paths, of feet that do not turn, see `BendPath.depth`.
            offset: (l, m) turns of the feet [rad].
        """
        row, rows = _weights(CELLS * depth, CELLS)
        last = len(OFFSETS) - 1
        column, columns = _weights((offset - OFFSETS[0]) / (OFFSETS[1] - OFFSETS[0]), last)
        results = np.zeros((2, *depth.shape))
        for i, by_depth in enumerate(rows):
            k = np.clip(row + i - 1, 0, CELLS)
            for j, by_offset in enumerate(columns):
                at = k, np.clip(column + j - 1, 0, last), own
                weight = by_depth * by_offset
                for result, table in zip(results, (self.depths, self.turns), strict=True):
                    result += weight * table[at]
        return results[0], results[1]


def last_links(batch: LimbBatch) -> Array:
    """Return the ways (L, 3) along the last links of limbs at rest [m]."""
    rows, pose = np.arange(len(batch.lengths)), batch.pose(batch.preferred)
    last = np.maximum(batch.is_joint.sum(axis=1) - 1, 0)
    result: Array = pose.tips - pose.X_BJ[rows, last, :3, 3]
    return result


def slopes(links: Array) -> Array:
    """Return the sines of the slopes (n,) of `last_links` (n, 3), downwards."""
    result: Array = -np.sin(np.arctan2(links[:, 1], links[:, 0]))
    return result


def wanted_offset(natural: Array, wanted: Array, n: Array) -> Array:
    """Return the turns (l, m) from directions that feet have to those they should have [rad].

    Args:
        natural: (3, l, m) ways from ankle to tip.
        wanted: (3, l, m) directions; their lengths are the parts of the way to them, 0 to 1.
        n: (3, l, m) axes of the ankles.
    """
    d = natural / np.maximum(_norm(natural), 1e-300)
    along, aside = _dot(wanted, d), _dot(wanted, _cross(n, d))
    part = _norm(wanted)
    within = np.sqrt(along * along + aside * aside) / (IN_PLANE * np.maximum(part, 1e-300))
    part = part * ease(np.minimum(within, 1.0))
    angle = np.arctan2(aside, along)
    beyond = np.clip((np.abs(angle) - OPPOSITE) / (np.pi - OPPOSITE), 0.0, 1.0)
    result: Array = part * (1.0 - ease(beyond)) * angle
    return np.clip(result, OFFSETS[0], OFFSETS[-1])


def _weights(place: Array, last: int) -> tuple[NDArray[np.int64], tuple[Array, ...]]:
    """Return cells and the weights of the four values around places, by cubics (Catmull-Rom)."""
    cell = np.minimum(np.maximum(place, 0.0).astype(np.int64), last - 1)
    t = np.clip(place - cell, 0.0, 1.0)
    u = 1.0 - t
    return cell, (
        -0.5 * t * u * u,
        u * (1.0 + t - 1.5 * t * t),
        t * (1.0 + u - 1.5 * u * u),
        -0.5 * u * t * t,
    )


# --- the tables of one leg ------------------------------------------------------------


def _leg_tables(leg: LimbBatch, path: BendPath, row: int) -> tuple[Array, Array]:
    """Return places on the path and turns of the ankle (CELLS + 1, n) by depth and offset."""
    own = np.full((1, 1), row)
    depth = np.linspace(0.0, 1.0, CELLS + 1)
    distance = path.distance(own, depth[None])[0]
    q = path.at_depth(own, depth[None])[:, 0].T
    far, angle = _turned_feet(leg, q)
    places, offsets = _at_distances(distance, depth, far, angle)
    middle = len(TURNS) // 2
    natural = offsets[:, middle].copy()
    offsets -= natural[:, None]
    depths, turns = np.full((2, CELLS + 1, len(OFFSETS)), np.nan)
    for k in range(CELLS + 1):
        first, last = _rising(offsets[k], middle)
        here = slice(first, last + 1)
        for table, values in ((depths, places[k]), (turns, TURNS)):
            table[k] = np.interp(OFFSETS, offsets[k, here], values[here], np.nan, np.nan)
    low, high = _calm_range(leg, path, own, (depths, turns), distance, natural)
    side = np.where(OFFSETS > 0.0, high[:, None], -low[:, None])
    # Soft bounds: the foot comes to rest slowly where it may not turn on.
    limited = side * OFFSETS / np.sqrt(side**2 + SOFT**2 + OFFSETS**2)
    for k in range(CELLS + 1):
        good = np.isfinite(depths[k])
        if good.sum() < 2:
            depths[k], turns[k] = depth[k], 0.0
            continue
        for table in (depths, turns):
            table[k] = np.interp(limited[k], OFFSETS[good], table[k][good])
    return depths, turns


def _turned_feet(leg: LimbBatch, q: Array) -> tuple[Array, Array]:
    """Return distances of tips [m] and angles of feet (m, n) [rad], for each of `TURNS`.

    Args:
        leg: one.
        q: (m, k) joint values along its path.
    """
    pose = leg.rows(np.zeros(len(q), dtype=np.int64)).pose(q)
    ankle = pose.X_BJ[:, -1, :3, 3]
    n = turn(pose.X_BJ[:, -1, :3, :3], leg.axes[:, -1])
    foot, up_to = pose.tips - ankle, ankle - leg.places[:, 0]
    along = n * (n * foot).sum(axis=-1, keepdims=True)
    c, s = np.cos(TURNS)[:, None], np.sin(TURNS)[:, None]
    v = along[:, None] + c * (foot - along)[:, None] + s * cross(n, foot)[:, None]
    tip = up_to[:, None] + v
    far = np.linalg.norm(tip, axis=-1)
    side = np.broadcast_to(n[:, None], tip.shape)
    angle = np.arctan2((side * cross(tip, v)).sum(axis=-1), (tip * v).sum(axis=-1))
    return far, np.unwrap(angle, axis=1)


def _at_distances(distance: Array, depth: Array, far: Array, angle: Array) -> tuple[Array, Array]:
    """Return places on the path and angles of the foot (m, n) at distances (m,), by turn.

    NaN where the turned foot keeps the leg from that distance.
    """
    places, angles = np.full((2, len(distance), far.shape[1]), np.nan)
    for j, reached in enumerate(far.T):
        # A turned foot shortens the leg; it folds on from where it is longest.
        first = int(reached.argmax())
        falls = np.diff(reached[first:]) < 0.0
        last = first + (len(falls) if falls.all() else int(falls.argmin()))
        if last == first:
            continue
        x = -reached[first : last + 1]
        places[:, j] = np.interp(-distance, x, depth[first : last + 1], np.nan, np.nan)
        angles[:, j] = np.interp(-distance, x, angle[first : last + 1, j], np.nan, np.nan)
    middle = far.shape[1] // 2
    places[:, middle] = depth
    angles[:, middle] = angle[:, middle]
    return places, angles


def _rising(values: Array, middle: int) -> tuple[int, int]:
    """Return the first and last number around `middle` between which values rise."""
    rises = np.diff(values) > 0.0
    after, before = rises[middle:], rises[:middle][::-1]
    last = middle + (len(after) if after.all() else int(after.argmin()))
    first = middle - (len(before) if before.all() else int(before.argmin()))
    return first, last


def _calm_range(
    leg: LimbBatch,
    path: BendPath,
    own: NDArray[np.int64],
    tables: tuple[Array, Array],
    distance: Array,
    natural: Array,
) -> tuple[Array, Array]:
    """Return the least and greatest turns (m,) of a foot for which joints are calm [rad].

    Args:
        leg: one.
        path: of its bends.
        own: (1, 1) its number there.
        tables: places on the path and turns of the ankle (m, n).
        distance: (m,) from base to tip [m].
        natural: (m,) angles of the foot at offset zero [rad].
    """
    calm, (depths, turns) = CALM_FEET, tables
    q = path.at_depth(own, np.nan_to_num(depths).reshape(1, -1))[:, 0]
    q = q.reshape(-1, *depths.shape)
    q[-1] += turns
    margin = 1e-6
    held = (q[-1] < leg.lower[0, -1] - margin) | (q[-1] > leg.upper[0, -1] + margin)
    q = np.where(np.isfinite(depths) & ~held, q, np.nan)[3:]
    e = distance / leg.lengths[0]
    bend = np.sqrt(1.0 - np.minimum(e, 0.99) ** 2)[:, None]
    needed = 2.0 / (leg.lengths[0] * bend)
    by_offset = np.gradient(q, OFFSETS, axis=2)
    by_distance = np.gradient(q, distance, axis=1)
    turning = np.gradient(natural, distance)[:, None]
    round_base = (
        np.abs(by_offset)
        * (1.0 / np.maximum(e, 0.1)[:, None] + calm.roll)
        / (leg.lengths[0] * needed)
    )
    level = np.hypot((by_distance - by_offset * turning) / needed, round_base)
    first, last = calm.nearly
    stretched = ease(np.clip((e - first) / (last - first), 0.0, 1.0))
    scale, widenings = np.ones_like(e), calm.widening
    # Joints between knee and ankle help to keep a sole level.
    has_one_knee = int(leg.is_joint[0].sum()) == FEWEST_JOINTS
    if has_one_knee and abs(slopes(last_links(leg))[0]) < LEVEL:
        scale, widenings = 1.0 + stretched * (calm.stretching - 1.0), calm.sole_widening
    scale = np.where(e < calm.folded, calm.most_folded / calm.most, scale)[:, None]
    at_rest = leg.pose(leg.preferred).tips - leg.places[:, 0]
    near = np.exp(-(((e - np.linalg.norm(at_rest) / leg.lengths[0]) / calm.near) ** 2))
    best = np.zeros((2, len(e)))
    fold = np.arccos(np.minimum(distance / distance[0], 1.0))
    for widening in widenings:
        at_edge = np.abs(by_distance) / needed + 0.5 * widening * np.abs(by_offset)
        good = (at_edge < calm.most * scale) & (level < calm.turning * scale)
        good |= (e > calm.straight)[:, None] & np.isfinite(by_offset)
        found = _ranges(good.all(axis=0))
        # A stretched leg has no choice, and ranges widen slowly from there.
        found[:, 0] = 0.0
        apart = widening * np.abs(fold[:, None] - fold)
        found = (found[:, None] + apart).min(axis=-1)
        if (near * found).sum() > (near * best).sum():
            best = found
    # Without corners, which would jerk the ankle.
    rounding = np.hanning(2 * ROUNDING + 3)[1:-1]
    padded = np.pad(best, ((0, 0), (ROUNDING, ROUNDING)), mode="edge")
    low, high = (np.convolve(row, rounding / rounding.sum(), mode="valid") for row in padded)
    return -low, high


def _ranges(good: NDArray[np.bool_]) -> Array:
    """Return how far (2, m) good values (m, n) go on from the middle, down and up [rad]."""
    middle = len(OFFSETS) // 2
    found = np.zeros((2, len(good)))
    for k in np.flatnonzero(good[:, middle]):
        for side, values in enumerate((good[k, middle::-1], good[k, middle:])):
            count = len(values) if values.all() else int(values.argmin())
            found[side, k] = OFFSETS[middle + count - 1]
    return found


def _norm(v: Array) -> Array:
    return np.sqrt(_dot(v, v))


def _dot(a: Array, b: Array) -> Array:
    result: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return result


def _cross(a: Array, b: Array) -> Array:
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
