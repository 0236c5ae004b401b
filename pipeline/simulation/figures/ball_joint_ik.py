"""Inverse kinematics of limbs with a ball joint at their base: full extension, and other branches.

Full extension: a stretched limb has no joint velocity that brings its tip nearer to its base, and
near it the velocities are unbounded. In that region the distance from base to tip is set first, by
a binary search between two sets of joint values: towards the extended ones to lengthen, towards
the preferred ones to shorten. Then the ball joint, which does not change that distance, brings the
tip to its place. As in the thesis this needs a ball joint at the base, handles this singularity
alone, and leaves the orientation of the tip free.

Branches: iterations go downhill from their start. A limb that would have to bend to the other
side, or swing over the top instead of back, ends at a limit though its goal is within reach.
Geometry gives the other solutions: the distance from base to tip depends on the inner joints
alone, and several bends give the same; for each of them the ball joint turns the tip towards the
goal in two ways for every value of its last joint, the swivel of the limb about the line from base
to goal.

Notation: g goal and t tip, both from the base; a₁, a₂, a₃ axes of the ball joint.

Source: Sims 1987, 6.3.1; Murray, Li and Sastry 1994, ch. 3, 3.2 (subproblem 2 of Paden and Kahan);
Tolani, Goswami and Badler 2000 (swivel).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.ik_goals import TipPlacement
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.task_priority import Task, bounded_priority_step
from pipeline.simulation.spatial import Array, cross, rotation, turn

EXTENSION_REGION = 0.97
"""Distance from base to tip where the region of full extension begins, in the greatest."""

EXTENSION_HALVINGS = 48
AIM_ITERATIONS = 30


BEND_HALVINGS = 24
"""Steps of the search for the bend with a given distance; iterations do the rest."""

SWIVELS = 16
"""Tried values of the ball joint's last joint."""


def base_ball_joint(batch: LimbBatch) -> NDArray[np.bool_]:
    """Return the joints (L, n) of a ball joint at the base; all False without one.

    They stand at one place, turn, and do not all turn about one axis.
    """
    here = np.abs(batch.places - batch.places[:, :1]).max(axis=-1) < 1e-9 * batch.lengths[:, None]
    own = np.logical_and.accumulate(here & ~batch.prismatic & batch.is_joint, axis=1)
    across = np.linalg.norm(np.cross(batch.axes[:, :1], batch.axes), axis=-1) > 1e-6
    return own & (across & own).any(axis=1, keepdims=True)


def full_reach(batch: LimbBatch) -> Array:
    """Return the distances (L,) from base to tip of the fully extended limbs [m]."""
    return _distance(batch, batch.pose(np.clip(batch.extended, batch.lower, batch.upper)).tips)


def is_near_extension(batch: LimbBatch, pose: LimbPose, goals: Array) -> NDArray[np.bool_]:
    """Return which limbs (L,) have a tip or a goal near full extension, and a ball joint."""
    most = np.maximum(_distance(batch, pose.tips), _distance(batch, goals))
    return (most > EXTENSION_REGION * full_reach(batch)) & base_ball_joint(batch).any(axis=1)


def solve_extended(batch: LimbBatch, start: LimbPose, goals: Array) -> LimbPose:
    """Return limbs whose tips are at `goals` (L, 3), or as far towards them as they reach.

    For limbs in the region of full extension; elsewhere the search may fail, with a tip that stays
    away from a goal within reach.
    """
    base = base_ball_joint(batch)
    asked = _distance(batch, goals)
    longer = asked > _distance(batch, start.tips)
    end = np.clip(batch.extended, batch.lower, batch.upper)
    end = np.where(longer[:, None], end, batch.preferred)
    way = np.where(base | ~batch.is_joint, 0.0, end - start.q)
    # At `low` the tip is on its initial side, at `high` past the requested distance; where even the
    # end of the way is not, the search converges to that end.
    low, high = np.zeros(len(asked)), np.ones(len(asked))
    for _ in range(EXTENSION_HALVINGS):
        middle = 0.5 * (low + high)
        far = _distance(batch, batch.pose(start.q + middle[:, None] * way).tips)
        past = (far > asked) == longer
        low, high = np.where(past, low, middle), np.where(past, middle, high)
    return _aim_ball_joint(batch, batch.pose(start.q + high[:, None] * way), goals, base)


def _aim_ball_joint(
    batch: LimbBatch, pose: LimbPose, goals: Array, base: NDArray[np.bool_]
) -> LimbPose:
    """Turn the ball joints `base` until the tips lie in the direction of `goals`."""
    origin = batch.places[:, 0]
    arm = goals - origin
    length = np.maximum(np.linalg.norm(arm, axis=-1, keepdims=True), 1e-300)
    aim = TipPlacement(origin + arm / length * _distance(batch, pose.tips)[:, None])
    for _ in range(AIM_ITERATIONS):
        task = aim.task(batch, pose)
        error = np.linalg.norm(task.velocity, axis=-1)
        if (error < 1e-13).all():
            break
        masked = Task(task.jacobian * base[:, None, :], task.velocity)
        # Damping shortens long chords, which would lead through the sphere.
        q, _ = bounded_priority_step(batch, pose.q, [masked], 1e-6 + 0.1 * error)
        pose = batch.pose(np.where(base, q, pose.q))
    return pose


def _distance(batch: LimbBatch, tips: Array) -> Array:
    return np.linalg.norm(tips - batch.places[:, 0], axis=-1)


def ball_joint_branches(batch: LimbBatch, goals: Array) -> Array:
    """Return joint values (B, L, n) with the tips at `goals`, as far as limits allow.

    Args:
        batch: limbs with ball joints at their bases; results for others are meaningless.
        goals: (L, 3) relative to the body [m].
    """
    base = base_ball_joint(batch)
    base[:, 3:] = False
    return np.concatenate(
        [_turn_to_goals(batch, q, goals, base) for q in _bend_to_distance(batch, goals, base)]
    )


def _bend_to_distance(batch: LimbBatch, goals: Array, base: NDArray[np.bool_]) -> list[Array]:
    """Return joint values (L, n), the `base` at rest, with tips as far off as the goals.

    From full extension all inner joints bend to one side, or to the other, or one alone does.
    """
    origin = batch.places[:, 0]
    asked = np.linalg.norm(goals - origin, axis=-1)
    straight = np.where(base, batch.preferred, np.clip(batch.extended, batch.lower, batch.upper))
    inner = ~base & batch.is_joint
    chosen = [inner]
    if (inner.sum(axis=1) > 1).any():
        single = np.eye(inner.shape[1], dtype=bool)
        chosen += [inner & row for row in single[inner.any(axis=0)]]
    result = []
    for which in chosen:
        for end in (batch.lower, batch.upper):
            way = np.where(which, end - straight, 0.0)
            low, high = np.zeros(len(asked)), np.ones(len(asked))
            for _ in range(BEND_HALVINGS):
                middle = 0.5 * (low + high)
                tips = batch.pose(straight + middle[:, None] * way).tips
                far = np.linalg.norm(tips - origin, axis=-1) > asked
                low, high = np.where(far, middle, low), np.where(far, high, middle)
            result.append(straight + high[:, None] * way)
    return result


def _turn_to_goals(batch: LimbBatch, q: Array, goals: Array, base: NDArray[np.bool_]) -> Array:
    """Return `q` (B, L, n) with the ball joints turned so that the tips point at the goals."""
    g = goals - batch.places[:, 0]
    t = batch.pose(np.where(base, 0.0, q)).tips - batch.places[:, 0]
    three = base.sum(axis=1) == 3
    third = min(2, q.shape[1] - 1)
    share = np.linspace(0.0, 1.0, SWIVELS)[:, None]
    last = batch.lower[:, third] + share * (batch.upper - batch.lower)[:, third]
    swung = turn(rotation(batch.axes[:, third], np.where(three, last, 0.0)), t)
    a_1, a_2 = batch.axes[:, 0], batch.axes[:, 1]
    found = []
    for v in _intermediate_directions(a_1, a_2, swung, g):
        turned = np.broadcast_to(q, (SWIVELS, *q.shape)).copy()
        turned[..., 0] = _angle_about(a_1, v, g)
        turned[..., 1] = _angle_about(a_2, swung, v)
        turned[..., third] = np.where(three, last, turned[..., third])
        found.append(_wrap_into_limits(batch, turned))
    return np.concatenate(found)


def _intermediate_directions(a_1: Array, a_2: Array, t: Array, g: Array) -> tuple[Array, Array]:
    """Return both v (..., 3) to which a turn about a₂ takes t, and one about a₁ then leads to g.

    They share the height above a₂ with t and that above a₁ with g. Where there is none, v is the
    nearest in the plane of the axes.
    """
    c = _dot(a_1, a_2)
    along_1, along_2 = _dot(a_1, g), _dot(a_2, t)
    across = np.maximum(1.0 - c * c, 1e-12)
    flat = ((along_1 - c * along_2) * a_1 + (along_2 - c * along_1) * a_2) / across
    rest = _dot(t, t) - _dot(flat, flat)
    up = np.sqrt(np.maximum(rest, 0.0) / across) * cross(a_1, a_2)
    return flat + up, flat - up


def _angle_about(axis: Array, u: Array, v: Array) -> Array:
    """Return the angle (...) about `axis` from u (..., 3) to the half plane of v [rad]."""
    return np.arctan2(
        _dot(axis, cross(u, v))[..., 0],
        (_dot(u, v) - _dot(axis, u) * _dot(axis, v))[..., 0],
    )


def _wrap_into_limits(batch: LimbBatch, q: Array) -> Array:
    """Return joint values without whole turns that lead away from the limits, clipped to them."""
    middle = 0.5 * (batch.lower + batch.upper)
    around = middle + np.remainder(q - middle + np.pi, 2.0 * np.pi) - np.pi
    return np.clip(np.where(batch.prismatic, q, around), batch.lower, batch.upper)


def _dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1, keepdims=True)
