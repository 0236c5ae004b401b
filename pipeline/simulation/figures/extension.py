"""Full extension: where the pseudo-inverse fails, and natural limbs feel at home.

A stretched limb has no joint velocity that brings its tip nearer to its base, and close
to it those there are become boundless. In that region the distance from base to tip is
set first, by a binary search between two sets of joint values: towards the extended ones
to get longer, towards the preferred ones to get shorter. Then the ball joint at the base,
which does not change that distance, brings the tip to its place.

The thesis's limits hold: it needs a ball joint at the base, deals with this singularity
alone, and leaves the orientation of the tip open.

Source: Sims 1987, 6.3.1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.goals import Placement
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.priority import Task, bounded_step
from pipeline.simulation.spatial import Array

REGION = 0.97
"""Distance from base to tip, as a part of the greatest, where the region begins."""

HALVINGS = 48
TURNS = 30


def ball(batch: LimbBatch) -> NDArray[np.bool_]:
    """Return which joints (L, n) are those of a ball joint at the base; none for many limbs.

    They stand at one place, turn, and do not all turn about one axis.
    """
    here = np.abs(batch.places - batch.places[:, :1]).max(axis=-1) < 1e-9 * batch.lengths[:, None]
    own = np.logical_and.accumulate(here & ~batch.prismatic & batch.is_joint, axis=1)
    across = np.linalg.norm(np.cross(batch.axes[:, :1], batch.axes), axis=-1) > 1e-6
    result: NDArray[np.bool_] = own & (across & own).any(axis=1, keepdims=True)
    return result


def reach_of(batch: LimbBatch) -> Array:
    """Return the distances (L,) from base to tip of the fully extended limbs [m]."""
    return _distance(batch, batch.pose(np.clip(batch.extended, batch.lower, batch.upper)).tips)


def in_region(batch: LimbBatch, pose: LimbPose, goals: Array) -> NDArray[np.bool_]:
    """Return which limbs (L,) have a tip or a goal near full extension, and a ball joint."""
    most = np.maximum(_distance(batch, pose.tips), _distance(batch, goals))
    return (most > REGION * reach_of(batch)) & ball(batch).any(axis=1)


def extend(batch: LimbBatch, start: LimbPose, goals: Array) -> LimbPose:
    """Return limbs whose tips are at `goals` (L, 3), or as far towards them as they reach.

    Meant for limbs in the region; of others the search may come to nothing, and a tip that
    stays away from a goal within reach says so.
    """
    base = ball(batch)
    asked = _distance(batch, goals)
    longer = asked > _distance(batch, start.tips)
    end = np.clip(batch.extended, batch.lower, batch.upper)
    end = np.where(longer[:, None], end, batch.preferred)
    way = np.where(base | ~batch.is_joint, 0.0, end - start.q)
    # At `low` the tip is on the side it comes from, at `high` past the distance asked for;
    # where even the end of the way is not, the search runs into that end.
    low, high = np.zeros(len(asked)), np.ones(len(asked))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        far = _distance(batch, batch.pose(start.q + middle[:, None] * way).tips)
        past = (far > asked) == longer
        low, high = np.where(past, low, middle), np.where(past, middle, high)
    return _aim(batch, batch.pose(start.q + high[:, None] * way), goals, base)


def _aim(batch: LimbBatch, pose: LimbPose, goals: Array, base: NDArray[np.bool_]) -> LimbPose:
    """Turn the ball joints `base` until the tips lie in the direction of `goals`."""
    origin = batch.places[:, 0]
    arm = goals - origin
    length = np.maximum(np.linalg.norm(arm, axis=-1, keepdims=True), 1e-300)
    aim = Placement(origin + arm / length * _distance(batch, pose.tips)[:, None])
    for _ in range(TURNS):
        task = aim.task(batch, pose)
        error = np.linalg.norm(task.velocity, axis=-1)
        if (error < 1e-13).all():
            break
        masked = Task(task.jacobian * base[:, None, :], task.velocity)
        # Far off, a chord is cut short: it would lead through the sphere.
        q, _ = bounded_step(batch, pose.q, [masked], 1e-6 + 0.1 * error)
        pose = batch.pose(np.where(base, q, pose.q))
    return pose


def _distance(batch: LimbBatch, tips: Array) -> Array:
    result: Array = np.linalg.norm(tips - batch.places[:, 0], axis=-1)
    return result
