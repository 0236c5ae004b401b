"""Inverse kinematics: where a tip shall be -> joint values, for many limbs at once.

Pseudo-inverse iterations along a path that is cut into segments no longer than the
linearisation bears; what redundancy is left pulls towards the preferred values.

Notation of the thesis: x tip position, θ joint values (here q), J Jacobian.

Source: Sims 1987, 6.1, 6.2 and appendix B.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.kinematics import ONE, LimbBatch, LimbPose
from pipeline.simulation.spatial import Array

SEGMENT = 0.15
"""Longest step of a tip in one iteration, as a part of the limb's length."""

DAMPING = 1e-4
"""λ as a part of the limb's length: bounds joint speeds near singularities and, the
tip being corrected again in the next iteration, leaves no error behind."""

ALPHA = 0.25
"""Gain of the secondary goal (α in eq. B.7): the part of the way to the preferred
values that one iteration may go."""

NEAR = 1e-2
"""Once a tip is this near its goal, as a part of the limb's length, the redundancy is
left alone after the first iteration: what it stirs up would have to be settled again."""

TOLERANCE = 1e-6
"""Accepted distance of tip from goal, as a part of the limb's length."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What the iterations came to.

    Attributes:
        batch: the limbs.
        pose: their pose, joint values within their limits.
        residual: (L,) distance of tip from goal [m].
        iterations: how many there were.
        turn: (L,) angle of tip from goal [rad]; None where no orientation was asked for.
    """

    batch: LimbBatch
    pose: LimbPose
    residual: Array
    iterations: int
    turn: Array | None = None

    @property
    def at_limit(self) -> NDArray[np.bool_]:
        """(L, n) which joints have come to one of their limits."""
        q, batch = self.pose.q, self.batch
        result: NDArray[np.bool_] = (q <= batch.lower) | (q >= batch.upper)
        return result & batch.is_joint


def solve(batch: LimbBatch, start: LimbPose, goals: Array, most: int = 40) -> Solution:
    """Bring the tips to `goals`, starting from the pose `start`.

    Args:
        batch: the limbs.
        start: where to start from, within the limits; along a motion the pose of the
            step before, so that a limb keeps its branch and its knee never flips.
        goals: (L, 3) relative to the body [m]. An unreachable goal gives the closest
            pose that the iterations find, with its residual.
        most: bound on the iterations.
    """
    pose, error = start, goals - start.tips
    distance = _norm(error)
    enough, near = TOLERANCE * batch.lengths, NEAR * batch.lengths
    longest, damping = batch.lengths * SEGMENT, damping_of(batch)
    iteration = 0
    while iteration < most and (far := distance > enough).any():
        # A limb that has arrived stays as it is: what it does must not depend on others.
        part = far * np.minimum(1.0, longest / np.maximum(distance, enough))
        gain = np.where(far if iteration == 0 else distance > near, ALPHA, 0.0)
        candidate = batch.pose(iterate(batch, pose, error * part[:, None], gain, damping))
        error_then = goals - candidate.tips
        distance_then = _norm(error_then)
        iteration += 1
        # A segment after which the tip is further away was too long: take it back and
        # shorten it. One that went well may be longer next time (Sims 1987, figure 6.3).
        good = distance_then < distance + enough
        longest = np.where(good, np.minimum(longest * 2.0, batch.lengths), longest * 0.25)
        if good.all():
            pose, error, distance = candidate, error_then, distance_then
        else:
            pose = candidate.where(good, pose)
            error = np.where(good[:, None], error_then, error)
            distance = np.where(good, distance_then, distance)
    return Solution(batch, pose, distance, iteration)


def damping_of(batch: LimbBatch) -> Array:
    """Return λ² I (L, 3, 3) [m²], which all iterations of these limbs share."""
    result: Array = ((DAMPING * batch.lengths) ** 2)[:, None, None] * ONE
    return result


def iterate(batch: LimbBatch, pose: LimbPose, dx: Array, gain: Array, damping: Array) -> Array:
    """Return the joint values (L, n) after one step of the tips, within the limits.

    Joints that the step would push through a limit are held there and the others
    carry the motion, by a second pass with their columns taken out.

    Args:
        batch: the limbs.
        pose: where they are.
        dx: (L, 3) the step [m].
        gain: (L,) α, the part of the way to the preferred values that redundancy goes.
        damping: see `damping_of`.
    """
    q, jacobian = pose.q, pose.jacobian
    z = gain[:, None] * (batch.preferred - q)
    wanted = q + _pseudo_inverse_step(jacobian, dx, z, damping)
    bounded = np.minimum(np.maximum(wanted, batch.lower), batch.upper)
    held = bounded != wanted
    if not held.any():
        return wanted
    free = ~held
    moved = np.where(held, bounded - q, 0.0)
    rest = dx - _times(jacobian, moved)
    again = _pseudo_inverse_step(jacobian * free[..., None], rest, z * free, damping)
    again = q + np.where(held, moved, again)
    result: Array = np.minimum(np.maximum(again, batch.lower), batch.upper)
    return result


def _pseudo_inverse_step(jacobian: Array, dx: Array, z: Array, damping: Array) -> Array:
    """Return J⁺ dx + (I - J⁺ J) z with the damped J⁺ = Jᵀ (J Jᵀ + λ² I)⁻¹, λ² I being given.

    Written as z + J⁺ (dx - J z), which needs no projector.

    Source: Sims 1987, eq. B.4 and B.7, with z = preferred - q (B.2 has the sign the
    other way round); damping after Wampler 1986.
    """
    square = np.add.reduce(jacobian[..., None] * jacobian[..., None, :], axis=1)
    square += damping
    y = np.linalg.solve(square, (dx - _times(jacobian, z))[..., None])[..., 0]
    result: Array = z + (jacobian @ y[..., None])[..., 0]
    return result


def _times(jacobian: Array, q: Array) -> Array:
    """Return J q (L, 3) for Jᵀ (L, n, 3) and q (L, n).

    Summed joint after joint, as a BLAS would not: padding then leaves the last bit alone.
    """
    result: Array = np.add.reduce(jacobian * q[..., None], axis=1)
    return result


def _norm(v: Array) -> Array:
    result: Array = np.sqrt(np.einsum("li,li->l", v, v))
    return result
