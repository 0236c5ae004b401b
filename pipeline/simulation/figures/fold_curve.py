"""Fold curve: the bends of a hanging limb from full extension through rest to a folded one.

All poses of the inner joints that have one distance from base to tip would do. Of these the curve
takes calm ones: it falls from rest towards the base along the gradient of the distance, so that
all joints share the work in proportion to their leverage, and joints slow down towards their
limits before they meet them. A foot, the last link of a leg, mostly keeps its angle to the line
from base to tip meanwhile: drawn flat, it has the longest lever, and would else fold alone. A
smooth line in the space of joints goes from full extension through rest to a place of that descent.
The place is chosen so that the limb folds farthest before a joint turns nearly twice as fast as one
of two equal links; there the curve ends.

Two equal links of length L/2 at the distance e L turn by 2 / (L sqrt(1 - e²)) per distance.

Source: gradients and leverage, Sims 1987, 5.2; the monotone cubic, Fritsch and Butland 1984.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.joint_limits import FOOT_LENGTH
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.spatial import Array, cross, turn

STRAIGHT = 0.05
"""Difference between preferred and extended value below which joints count as straight, as a part
of their way to the limit."""

FIRST_BEND = 0.1
"""Bend with which a limb that rests straight begins, as a part of the way to the limit."""

POINTS = 40
"""Points of a curve between two of its places."""

SAME_POSE = 1e-3
"""Difference of joint values below which poses count as one [rad or m]."""

STEADINESS = 0.75
"""How far a foot keeps its angle to the line from base to tip, 0 to 1: one that keeps it wholly
leaves many a leg too little to fold with."""

FEWEST_JOINTS = 5
"""Of a leg with a foot: a ball joint, a knee and an ankle."""


@dataclass(frozen=True, slots=True)
class Descent:
    """Constants of the way down the gradient of the distance.

    Attributes:
        steps: of the way.
        shortening: of the distance in one step, in lengths of the limb.
        longest: greatest turn of a joint in one step [rad or m].
        room: distance from a limit at which joints begin to slow down, in their range.
        every: steps from one end that is tried to the next.
        less: by which limbs whose joints fold together may fold less, in lengths of the limb.
        steady: by which the feet of such limbs may turn more than those of others [rad].
        idle: part of the fold of another joint, each as a part of the way to its limit, below which
            a joint is left out.
        apart: difference between folds of joints from which on one turns as fast as the fastest to
            catch up, as a part of the way to its limit.
    """

    steps: int = 80
    shortening: float = 0.0125
    longest: float = 0.08
    room: float = 0.05
    every: int = 5
    less: float = 0.03
    steady: float = 0.2
    idle: float = 0.25
    apart: float = 0.4


@dataclass(frozen=True, slots=True)
class CalmBends:
    """Bounds of the rates of joints, in rates of two equal links.

    Attributes:
        most: greatest rate.
        folded: distance below which no one sees the difference and joints may be quicker, in
            lengths of the limb.
        most_folded: greatest rate there.
        straight: distance above which rates do not count, because the limb stretches.
    """

    most: float = 1.9
    folded: float = 0.3
    most_folded: float = 4.0
    straight: float = 0.97


DESCENT, CALM_BENDS = Descent(), CalmBends()


def has_foot(batch: LimbBatch) -> NDArray[np.bool_]:
    """Return which limbs (L,) with hanging legs have a foot, as far as their links tell."""
    counts = batch.is_joint.sum(axis=1)
    last = np.maximum(counts - 1, 0)
    rows = np.arange(len(counts))
    length = np.linalg.norm(batch.tips - batch.places[rows, last], axis=-1)
    turns = ~batch.prismatic[rows, last]
    result: NDArray[np.bool_] = (
        (counts >= FEWEST_JOINTS) & turns & (length < FOOT_LENGTH * batch.lengths)
    )
    return result


def fold_curves(batch: LimbBatch, bending: NDArray[np.bool_]) -> list[Array]:
    """Return joint values (m, n) of L limbs, from full extension to their folds [rad or m].

    The distance from base to tip falls all the way.

    Args:
        batch: limbs.
        bending: (L, n) joints that change the distance; the others keep their preferred values.
    """
    extended = np.where(bending, batch.extended, batch.preferred)
    extended = np.clip(extended, batch.lower, batch.upper)
    turns = _folds(batch, bending)
    ends = [_descent(batch, bending, folds)[:: DESCENT.every] for folds in (turns, 0.0 * turns)]
    curves = list[Array]()
    for row in range(len(extended)):
        limb = batch.rows(np.array([row]))
        together, alone = (_calmest(limb, extended[row], own[:, row]) for own in ends)
        curves.append(together if _is_better(limb, turns[row], together, alone) else alone)
    return curves


def _is_better(limb: LimbBatch, folds: Array, together: Array, alone: Array) -> bool:
    """Return whether joints that fold together (m, n) fold a limb better than others (m, n).

    They leave no joint idle that is so alone, fold about as far, and keep the foot as steady.
    """
    ends = np.stack([together[-1], alone[-1]])
    far, turned = distances(limb, ends) / limb.lengths[0], _foot_turns(limb, ends)
    idle = _has_idle_joint(folds, alone[-1] - limb.preferred[0])
    return idle and far[0] < far[1] + DESCENT.less and turned[0] < turned[1] + DESCENT.steady


def _foot_turns(limb: LimbBatch, q: Array) -> Array:
    """Return how far (m,) the last link of one limb turns to the line from base to tip [rad].

    Args:
        limb: one.
        q: (m, n) joint values, compared with those at rest [rad or m].
    """
    many = limb.rows(np.zeros(len(q) + 1, dtype=np.int64))
    pose, last = many.pose(np.concatenate([limb.preferred, q])), int(limb.is_joint[0].sum()) - 1
    foot, arm = pose.tips - pose.X_BJ[:, last, :3, 3], pose.tips - many.places[:, 0]
    across = (foot * arm).sum(axis=-1)
    across /= np.maximum(np.linalg.norm(foot, axis=-1) * np.linalg.norm(arm, axis=-1), 1e-300)
    angle = np.arccos(np.clip(across, -1.0, 1.0))
    result: Array = np.abs(angle[1:] - angle[0])
    return result


def _has_idle_joint(folds: Array, turned: Array) -> bool:
    """Return whether one of the joints with folds (n,) hardly turned (n,) towards its own."""
    folding = folds != 0.0
    if folding.sum() < 2:
        return False
    done = turned[folding] / folds[folding]
    return bool(done.min() < DESCENT.idle * done.max())


def _descent(batch: LimbBatch, bending: NDArray[np.bool_], folds: Array) -> Array:
    """Return joint values (steps + 1, L, n) from rest down the gradient of the distance.

    Args:
        batch: limbs.
        bending: (L, n) joints that change the distance.
        folds: (L, n) turns from rest to the folds of joints that fold together, else zero.
    """
    away = np.where(
        batch.upper - batch.extended >= batch.extended - batch.lower,
        batch.upper - batch.extended,
        batch.lower - batch.extended,
    )
    straight = np.abs(batch.preferred - batch.extended) < STRAIGHT * np.abs(away)
    straight = np.all(straight | ~bending, axis=1)[:, None]
    # The distance of a straight limb has no gradient: it bends where its joints have most room.
    q = np.where(bending & straight, batch.extended + FIRST_BEND * away, batch.preferred)
    q = np.clip(q, batch.lower, batch.upper)
    found, has_last = [q], has_foot(batch)
    for _ in range(DESCENT.steps):
        pose = batch.pose(q)
        slope = _distance_slope(batch, pose) * bending
        turned = np.where(has_last[:, None], _foot_slope(batch, pose) * bending, 0.0)
        way = -_without(slope, turned, np.ones_like(slope))
        free = _room(batch, q, way)
        way = -free * _without(slope, turned, free)
        way = way + _catching_up(batch, q, folds, way)
        fall = np.maximum(-(way * slope).sum(axis=1), 1e-12)
        step = way * (DESCENT.shortening * batch.lengths / fall)[:, None]
        largest = np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-300)
        q = np.clip(q + step * np.minimum(1.0, DESCENT.longest / largest), batch.lower, batch.upper)
        found.append(q)
    return np.array(found)


def _folds(batch: LimbBatch, bending: NDArray[np.bool_]) -> Array:
    """Return the turns (L, n) from rest to the folds of the inner joints before the last.

    Zero for other joints.
    """
    up, down = batch.upper - batch.preferred, batch.lower - batch.preferred
    result = np.where(up >= -down, up, down) * bending
    last = np.maximum(batch.is_joint.sum(axis=1) - 1, 0)
    result[np.arange(len(result)), last] = 0.0
    return result


def _catching_up(batch: LimbBatch, q: Array, folds: Array, way: Array) -> Array:
    """Return how far joints (L, n) turn besides in a step that folds less than others.

    A joint on the line from base to tip has no leverage, and would stay straight: a horse's carpus.

    Args:
        batch: limbs.
        q: (L, n) joint values.
        folds: (L, n) see `_folds`.
        way: (L, n) of the step, down the gradient.
    """
    room = np.maximum(np.abs(folds), 1e-9)
    done = (q - batch.preferred) * np.sign(folds) / room
    most = done.max(axis=1, keepdims=True)
    behind = np.clip((most - done) / DESCENT.apart, 0.0, 1.0)
    fastest = np.abs(way).max(axis=1, keepdims=True)
    return np.sign(folds) * behind * fastest


def _room(batch: LimbBatch, q: Array, way: Array) -> Array:
    """Return how free joints (L, n) are to go on along `way`, from 0 at a limit to 1."""
    span = DESCENT.room * np.maximum(batch.upper - batch.lower, 1e-9)
    near = np.clip(np.where(way < 0.0, q - batch.lower, batch.upper - q) / span, 0.0, 1.0)
    result: Array = near * near * (3.0 - 2.0 * near)
    return result


def _without(slope: Array, turned: Array, free: Array) -> Array:
    """Return the slopes (L, n) without most of what turns feet, as far as ankles are free.

    Args:
        slope: of the distances.
        turned: slopes of the angles of feet; zero without a foot.
        free: of the joints, 0 to 1.
    """
    square = (turned * free * turned).sum(axis=1, keepdims=True)
    mixed = (turned * free * slope).sum(axis=1, keepdims=True)
    return slope - STEADINESS * free[:, -1:] * turned * mixed / np.maximum(square, 1e-12)


def _calmest(limb: LimbBatch, extended: Array, ends: Array) -> Array:
    """Return joint values (m, n) of the curve to one of `ends` that folds farthest.

    Args:
        limb: one.
        extended: (n,) joint values at full extension [rad or m].
        ends: (k, n) on the descent, the first of them at rest [rad or m].
    """
    rest = limb.preferred[0]
    best, lowest = np.stack([extended, rest]), np.inf
    straight = np.abs(rest - extended).max() < SAME_POSE
    ways = [(end,) for end in ends] + [(ends[k // 2], ends[k]) for k in range(2, len(ends))]
    for way in ways:
        curve = _curve(np.stack([extended, *way] if straight else [extended, rest, *way]))
        far = distances(limb, curve)
        # A limb that is longest between full extension and rest goes no farther than there.
        first = 0 if straight else int(far[: POINTS + 1].argmax())
        curve, far = curve[first:], far[first:]
        last = _calm_points(limb, curve, far, 0 if straight else POINTS - first)
        if far[last] < lowest:
            best, lowest = curve[: last + 1], float(far[last])
    return best


def _calm_points(limb: LimbBatch, curve: Array, far: Array, rest: int) -> int:
    """Return the number of the last point (m, n) up to which a limb folds and joints are calm.

    It is that at rest or a later one.
    """
    calm, length = CALM_BENDS, limb.lengths[0]
    fall = -np.diff(far)
    reach = 0.5 * (far[1:] + far[:-1]) / length
    turned = np.abs(np.diff(curve, axis=0)).max(axis=1)
    needed = 2.0 * fall / (length * np.sqrt(1.0 - np.minimum(reach, 0.99) ** 2))
    most = np.where(reach < calm.folded, calm.most_folded, calm.most)
    good = (fall > 0.0) & ((reach > calm.straight) | (turned <= most * needed))
    good[:rest] = True
    return len(good) if good.all() else int(good.argmin())


def _curve(places: Array) -> Array:
    """Return joint values (m, n) of a smooth line through `places` (k, n), without overshoot.

    It has `POINTS` from each place to the next.
    """
    turned = np.maximum(np.abs(np.diff(places, axis=0)).max(axis=1), 1e-9)[:, None]
    slopes = np.diff(places, axis=0) / turned
    before, after, first, second = slopes[:-1], slopes[1:], turned[:-1], turned[1:]
    same = before * after > 0.0
    # The weighted harmonic mean of both slopes, where they have one sign.
    mean = (2.0 * second + first) / np.where(same, before, 1.0)
    mean += (second + 2.0 * first) / np.where(same, after, 1.0)
    inner = np.where(same, 3.0 * (first + second) / mean, 0.0)
    slope = np.concatenate([slopes[:1], inner, slopes[-1:]])
    part = np.linspace(0.0, 1.0, POINTS + 1)[:, None]
    pieces = [
        _cubic(part, a, b, h * v, h * w)[1:]
        for a, b, h, v, w in zip(places, places[1:], turned, slope, slope[1:], strict=False)
    ]
    return np.concatenate([places[:1], *pieces])


def _cubic(t: Array, a: Array, b: Array, v: Array, w: Array) -> Array:
    """Return the cubic from `a` with slope `v` to `b` with slope `w`, at parts `t` (m, 1)."""
    result: Array = a + t * (v + t * (3.0 * (b - a) - 2.0 * v - w + t * (2.0 * (a - b) + v + w)))
    return result


def _distance_slope(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return the derivatives (L, n) of the distances from base to tip by the joint values."""
    arm = pose.tips - batch.places[:, 0]
    arm /= np.maximum(np.linalg.norm(arm, axis=-1, keepdims=True), 1e-300)
    result: Array = np.einsum("lni,li->ln", pose.jacobian, arm)
    return result


def _foot_slope(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return the derivatives (L, n) of the angles from lines from base to tip to last links."""
    axes = turn(pose.X_BJ[..., :3, :3], batch.axes)
    rows, last = np.arange(len(axes)), np.maximum(batch.is_joint.sum(axis=1) - 1, 0)
    normal = axes[rows, last]
    arm = pose.tips - batch.places[:, 0]
    round_base = cross(normal, arm) / np.maximum((arm * arm).sum(axis=-1), 1e-300)[:, None]
    turns = np.where(batch.prismatic, 0.0, (axes * normal[:, None]).sum(axis=-1))
    result: Array = turns - np.einsum("lni,li->ln", pose.jacobian, round_base)
    return result * batch.is_joint


def distances(limb: LimbBatch, q: Array) -> Array:
    """Return the distances (m,) from base to tip of one limb at joint values (m, n) [m]."""
    many = limb.rows(np.zeros(len(q), dtype=np.int64))
    result: Array = np.linalg.norm(many.pose(q).tips - many.places[:, 0], axis=-1)
    return result
