"""Branches: the ways in which a limb with a ball joint at its base comes to a goal.

Iterations go downhill from where they start. A limb that would have to bend to the other
side, or to swing over the top instead of back, ends at a limit with no way further down,
though its goal is within reach. Geometry knows the other ways: the distance from base to
tip is a matter of the inner joints, and several bends give the same; for each of them the
ball joint turns the tip towards the goal in two ways for every value of its last joint,
which is the swivel of the limb about the line from base to goal.

Notation: g goal and t tip, both from the base; a₁, a₂, a₃ axes of the ball joint.

Source: Murray, Li and Sastry 1994, ch. 3, 3.2 (subproblem 2 of Paden and Kahan); Tolani,
Goswami and Badler 2000 (swivel).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.extension import ball
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.spatial import Array, cross, rotation, turn

HALVINGS = 24
"""Steps of the search for the bend that gives a distance; the rest is for iterations."""

SWIVELS = 16
"""Values of the ball joint's last joint that are looked at."""


def branches(batch: LimbBatch, goals: Array) -> Array:
    """Return joint values (B, L, n) with the tips at `goals`, or what limits leave of them.

    Args:
        batch: limbs with ball joints at their bases; what others get is of no use.
        goals: (L, 3) relative to the body [m].
    """
    base = ball(batch)
    base[:, 3:] = False
    return np.concatenate([_turned(batch, q, goals, base) for q in _bent(batch, goals, base)])


def _bent(batch: LimbBatch, goals: Array, base: NDArray[np.bool_]) -> list[Array]:
    """Return several joint values (L, n), the `base` at rest, with tips as far off as the goals.

    From full extension all inner joints bend to one side, or to the other, or one alone does.
    """
    origin = batch.places[:, 0]
    asked = np.linalg.norm(goals - origin, axis=-1)
    straight = np.where(base, batch.preferred, np.clip(batch.extended, batch.lower, batch.upper))
    inner = ~base & batch.is_joint
    chosen = [inner]
    if (inner.sum(axis=1) > 1).any():
        one = np.eye(inner.shape[1], dtype=bool)
        chosen += [inner & row for row in one[inner.any(axis=0)]]
    result = []
    for which in chosen:
        for end in (batch.lower, batch.upper):
            way = np.where(which, end - straight, 0.0)
            low, high = np.zeros(len(asked)), np.ones(len(asked))
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                tips = batch.pose(straight + middle[:, None] * way).tips
                far = np.linalg.norm(tips - origin, axis=-1) > asked
                low, high = np.where(far, middle, low), np.where(far, high, middle)
            result.append(straight + high[:, None] * way)
    return result


def _turned(batch: LimbBatch, q: Array, goals: Array, base: NDArray[np.bool_]) -> Array:
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
    for v in _between(a_1, a_2, swung, g):
        turned = np.broadcast_to(q, (SWIVELS, *q.shape)).copy()
        turned[..., 0] = _angle(a_1, v, g)
        turned[..., 1] = _angle(a_2, swung, v)
        turned[..., third] = np.where(three, last, turned[..., third])
        found.append(_within(batch, turned))
    return np.concatenate(found)


def _between(a_1: Array, a_2: Array, t: Array, g: Array) -> tuple[Array, Array]:
    """Return the two v (..., 3) to which a turn about a₂ brings t, and one about a₁ then to g.

    They share the height above a₂ with t and that above a₁ with g. Where none do, v is the
    nearest in the plane of the axes.
    """
    c = _dot(a_1, a_2)
    along_1, along_2 = _dot(a_1, g), _dot(a_2, t)
    across = np.maximum(1.0 - c * c, 1e-12)
    flat = ((along_1 - c * along_2) * a_1 + (along_2 - c * along_1) * a_2) / across
    rest = _dot(t, t) - _dot(flat, flat)
    up = np.sqrt(np.maximum(rest, 0.0) / across) * cross(a_1, a_2)
    return flat + up, flat - up


def _angle(axis: Array, u: Array, v: Array) -> Array:
    """Return the angle (...) about `axis` that turns u (..., 3) into the half plane of v [rad]."""
    result: Array = np.arctan2(
        _dot(axis, cross(u, v))[..., 0],
        (_dot(u, v) - _dot(axis, u) * _dot(axis, v))[..., 0],
    )
    return result


def _within(batch: LimbBatch, q: Array) -> Array:
    """Return joint values, whole turns taken off those that are nearer to their limits so."""
    middle = 0.5 * (batch.lower + batch.upper)
    around = middle + np.remainder(q - middle + np.pi, 2.0 * np.pi) - np.pi
    result: Array = np.clip(np.where(batch.prismatic, q, around), batch.lower, batch.upper)
    return result


def _dot(a: Array, b: Array) -> Array:
    result: Array = np.sum(a * b, axis=-1, keepdims=True)
    return result
