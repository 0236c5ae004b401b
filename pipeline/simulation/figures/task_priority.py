"""Task priority: several goals for the joints of a limb, none at the cost of one before it.

Each goal acts in the null space of all goals above it. The projector onto that space is exact
whatever the damping: the rows of the Jacobians are turned into an orthonormal basis, the damped
inverse works inside it, and the remainder belongs to the goals below. A damped pseudo-inverse in
place of J⁺ in (I - J⁺J) would let them leak through.

Notation of the thesis: J Jacobian, θ̇ joint velocities, z those that a lower goal asks for.

Source: Sims 1987, eq. B.7 and B.9, B.3; Siciliano and Slotine 1991.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.spatial import Array

LOWER_DAMPING = 1e-3
"""λ of all tasks but the first."""

RANK_TOLERANCE = 1e-10
"""Singular values below this fraction of the greatest count as zero."""


INWARD_PULL = 1e-12
"""The same for the least squares, whose minimum is unique."""

RELEASE_GAIN = 1e-9
"""Reduction of squared error, for a joint's movement, that releases it from its limit."""


@dataclass(frozen=True, eq=False)
class Task:
    """The demand of a goal at a certain pose.

    Attributes:
        jacobian: (L, m, n) J, without units of length; a row of zeros demands nothing.
        velocity: (L, m) ẋ, in one step.
        is_wish: whether it demands joint velocities themselves.
    """

    jacobian: Array
    velocity: Array
    is_wish: bool = False

    @staticmethod
    def wish(z: Array) -> Task:
        """Return a demand for joint velocities `z` (L, n) themselves."""
        count, n = z.shape
        return Task(np.broadcast_to(np.eye(n), (count, n, n)), z, True)


def solve_priorities(
    tasks: Sequence[Task], damping: Array | float = 0.0, lower: float = 0.0
) -> Array:
    """Return joint velocities θ̇ (L, n) that serve the tasks in order of priority.

    For one task it is J⁺ẋ; a second one that wishes for z makes it J⁺ẋ + (I - J⁺J)(z - J⁺ẋ), which
    is eq. B.9 with α = 1. Undamped it equals eq. B.7, as J⁺ẋ has no part in the null space.

    Args:
        tasks: at least one.
        damping: (L,) or one number: λ of the first task's inverse.
        lower: λ of all others, whose Jacobians may be near singular once projected.
    """
    count, _, n = tasks[0].jacobian.shape
    velocities = np.zeros((count, n))
    N = np.broadcast_to(np.eye(n), (count, n, n)).copy()
    for level, task in enumerate(tasks):
        if task.is_wish and level == len(tasks) - 1:
            # The remainder of a wish needs no inverse, only projection.
            rest = task.jacobian.transpose(0, 2, 1) @ _remaining(task, velocities)[..., None]
            return velocities + (N @ rest)[..., 0]
        basis, step = _serve_task(task, velocities, N, damping if level == 0 else lower)
        velocities = velocities + step
        N -= basis @ basis.transpose(0, 2, 1)
    return velocities


def _serve_task(
    task: Task, velocities: Array, N: Array, damping: Array | float
) -> tuple[Array, Array]:
    """Return an orthonormal basis (L, n, k) of the directions a task uses, and its step (L, n)."""
    U, σ, Vt = np.linalg.svd(task.jacobian @ N, full_matrices=False)
    largest = np.linalg.norm(task.jacobian, axis=(1, 2))[:, None]
    real = σ > RANK_TOLERANCE * np.maximum(largest, 1e-300)
    # Directions of small σ carry rounding from outside the null space: project again.
    V = N @ (Vt.transpose(0, 2, 1) * real[:, None, :])
    basis = np.linalg.qr(V)[0] * real[:, None, :]
    rest = _remaining(task, velocities)
    λ = np.broadcast_to(damping, (len(σ),))[:, None]
    inverse = np.where(real, σ / np.maximum(σ * σ + λ * λ, 1e-300), 0.0)
    along = (U.transpose(0, 2, 1) @ rest[..., None])[..., 0] * inverse
    wanted = V @ along[..., None]
    step: Array = (basis @ (basis.transpose(0, 2, 1) @ wanted))[..., 0]
    return basis, step


def bounded_priority_step(
    batch: LimbBatch, q: Array, tasks: Sequence[Task], damping: Array | float
) -> tuple[Array, NDArray[np.bool_]]:
    """Return joint values (L, n) one step on, within the limits, and which were held there.

    Joints that the step would push through a limit are held at it and the others carry the motion.
    The result is the minimum of the first task's damped error between the limits.
    """
    λ = np.broadcast_to(damping, (len(q),))

    def step(going: NDArray[np.int64], held: NDArray[np.bool_], moved: Array) -> _Step:
        own = tasks if len(going) == len(q) else [_rows(task, going) for task in tasks]
        reduced = [
            Task(task.jacobian * ~held[:, None, :], _remaining(task, moved), task.is_wish)
            for task in own
        ]
        here = np.where(held, moved, solve_priorities(reduced, λ[going], LOWER_DAMPING))
        pull = (_remaining(own[0], here)[:, None] @ own[0].jacobian)[:, 0]
        return _Step(here, pull - λ[going, None] ** 2 * here)

    return _pivoted(batch, q, step, RELEASE_GAIN)


def bounded_least_squares_step(
    batch: LimbBatch, q: Array, task: Task, wish: Array, damping: Array
) -> Array:
    """Return the joint values (L, n) within the limits that serve a task, and a wish a little.

    They have the least |ẋ - Jθ̇|² + λ²|θ̇ - z|². That minimum is unique and moves continuously with
    all that it depends on, where `bounded_priority_step` may change from one solution to another
    as a joint reaches its limit.

    Args:
        batch: the limbs, or one that serves for all rows.
        q: (L, n) within the limits [rad or m].
        task: served first.
        wish: (L, n) z.
        damping: (L,) λ.
    """
    J, Jt = task.jacobian, task.jacobian.transpose(0, 2, 1)
    square = (damping * damping)[:, None]
    unit = np.eye(J.shape[1])

    def step(going: NDArray[np.int64], held: NDArray[np.bool_], moved: Array) -> _Step:
        own, own_t, λ, z = J[going], Jt[going], square[going], wish[going]
        start = np.where(held, moved, z)
        rest = task.velocity[going] - (own @ start[..., None])[..., 0]
        free = own * ~held[:, None, :]
        y = np.linalg.solve(free @ own_t + λ[..., None] * unit, rest[..., None])
        here = start + np.where(held, 0.0, (own_t @ y)[..., 0])
        left = task.velocity[going] - (own @ here[..., None])[..., 0]
        return _Step(here, (own_t @ left[..., None])[..., 0] + λ * (z - here))

    return _pivoted(batch, q, step, INWARD_PULL)[0]


class _Step(NamedTuple):
    """Movements (k, n) of joints, and the slopes (k, n) of what they serve."""

    here: Array
    pull: Array


def _pivoted(
    batch: LimbBatch,
    q: Array,
    step: Callable[[NDArray[np.int64], NDArray[np.bool_], Array], _Step],
    release: float,
) -> tuple[Array, NDArray[np.bool_]]:
    """Return joint values (L, n) one step on, within the limits, and which are held there.

    A joint whose return from its limit would serve the goal is released again; a limb would else
    stall, its joints held by steps computed before others were held. The iteration ends where no
    joint changes sides.

    Args:
        batch: the limbs, or one that serves for all rows.
        q: (L, n) within the limits [rad or m].
        step: of rows (k,) whose joints (k, n) are held at movements (k, n).
        release: pull inwards beyond which a joint is released.

    Source: Júdice and Pires 1994 (block principal pivoting).
    """
    is_joint = np.broadcast_to(batch.is_joint, q.shape)
    lower, upper = batch.lower - q, batch.upper - q
    held, moved, result = ~is_joint, np.zeros_like(q), np.zeros_like(q)
    # Limbs that change no side are done; the others go on without them.
    going = np.arange(len(q))
    for turn in range(6 * q.shape[1]):
        fixed, there = held[going], moved[going]
        here, pull = step(going, fixed, there)
        result[going] = here
        bounded = np.minimum(np.maximum(here, lower[going]), upper[going])
        over = (bounded != here) & ~fixed
        inward = np.where(there <= lower[going], pull, -pull) > release
        inward &= fixed & is_joint[going]
        changed = (over | inward).any(axis=1)
        if not changed.any():
            break
        if turn >= q.shape[1]:
            # Changing all at once may cycle; changing the last joint alone cannot (Murty's rule).
            last = (over | inward) & (np.cumsum((over | inward)[:, ::-1], axis=1)[:, ::-1] == 1)
            over, inward = over & last, inward & last
        moved[going] = np.where(over, bounded, np.where(inward, 0.0, there))
        held[going] = (fixed | over) & ~inward
        going = going[changed]
    return np.clip(q + result, batch.lower, batch.upper), held & is_joint


def _rows(task: Task, chosen: NDArray[np.int64]) -> Task:
    return Task(task.jacobian[chosen], task.velocity[chosen], task.is_wish)


def _remaining(task: Task, velocities: Array) -> Array:
    """Return the part (L, m) of a task that joint velocities leave."""
    return task.velocity - (task.jacobian @ velocities[..., None])[..., 0]
