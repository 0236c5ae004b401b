"""Task priority: lower goals never disturb higher ones."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.ik_goals import (
    dexterity,
    dexterity_gradient,
    rotation_vector,
    singular_values,
)
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.task_priority import Task, bounded_priority_step, solve_priorities
from pipeline.simulation.spatial import Array, rotation


def _tasks(rng: np.random.Generator, sizes: tuple[int, ...], n: int, count: int) -> list[Task]:
    tasks = []
    for m in sizes:
        J = rng.normal(size=(count, m, n))
        # A third nearly singular, a third exactly: rows that nearly or wholly repeat.
        J[::3, -1] = J[::3, 0] + 1e-7 * J[::3, -1]
        J[1::3, -1] = J[1::3, 0]
        tasks.append(Task(J, rng.normal(size=(count, m))))
    return tasks


def _left(task: Task, velocities: Array) -> Array:
    return task.velocity - (task.jacobian @ velocities[..., None])[..., 0]


def test_null_space_motion_moves_no_tip() -> None:
    """‖J (I - J⁺J) z‖ ≤ 1e-9 ‖z‖, undamped."""
    rng = np.random.default_rng(1)
    for n in (2, 3, 5, 8):
        first = Task(_tasks(rng, (3,), n, 60)[0].jacobian, np.zeros((60, 3)))
        z = rng.normal(size=(60, n))
        moved = (first.jacobian @ solve_priorities([first, Task.wish(z)])[..., None])[..., 0]
        assert (np.linalg.norm(moved, axis=-1) <= 1e-9 * np.linalg.norm(z, axis=-1)).all()


@pytest.mark.parametrize("damping", [0.0, 1e-3, 0.3])
def test_lower_tasks_never_worsen_higher_ones(damping: float) -> None:
    rng = np.random.default_rng(2)
    for sizes in ((3, 1, 2), (3, 3, 3), (2, 1, 1, 4), (6, 3)):
        tasks = _tasks(rng, sizes, 7, 60)
        for level in range(1, len(tasks)):
            before = solve_priorities(tasks[:level], damping)
            after = solve_priorities(tasks[: level + 1], damping)
            for higher in tasks[:level]:
                a = np.linalg.norm(_left(higher, before), axis=-1)
                b = np.linalg.norm(_left(higher, after), axis=-1)
                scale = 1.0 + np.linalg.norm(after, axis=-1)
                assert (b <= a + 1e-9 * scale).all()


def test_single_task_is_the_pseudo_inverse() -> None:
    rng = np.random.default_rng(3)
    for m, n in ((3, 6), (3, 3), (3, 2), (6, 4)):
        J, v = rng.normal(size=(20, m, n)), rng.normal(size=(20, m))
        expected = (np.linalg.pinv(J) @ v[..., None])[..., 0]
        assert np.allclose(solve_priorities([Task(J, v)]), expected, atol=1e-10)


def test_equations_b7_and_b9_agree() -> None:
    rng = np.random.default_rng(4)
    J, v = rng.normal(size=(20, 3, 6)), rng.normal(size=(20, 3))
    z = rng.normal(size=(20, 6))
    plus = np.linalg.pinv(J)
    least = (plus @ v[..., None])[..., 0]
    free = np.eye(6) - plus @ J
    b7 = least + (free @ z[..., None])[..., 0]
    b9 = least + (free @ (z - least)[..., None])[..., 0]
    assert np.allclose(b7, b9)
    assert np.allclose(solve_priorities([Task(J, v), Task.wish(z)]), b7)


def test_bounded_step_is_optimal_within_limits(beetle: Figure) -> None:
    """No small change of joint values within the limits lessens the first task's error."""
    legs = LimbBatch.of([(beetle.skeleton, leg) for leg in beetle.skeleton.legs])
    rng = np.random.default_rng(5)
    for _ in range(20):
        q = legs.lower + rng.random(legs.lower.shape) * (legs.upper - legs.lower)
        J = legs.pose(q).jacobian.transpose(0, 2, 1)
        task = Task(J, 3.0 * rng.normal(size=(len(q), 3)))
        after, _ = bounded_priority_step(legs, q, [task], 1e-2)

        def cost(values: Array, q: Array = q, task: Task = task) -> Array:
            off = _left(task, values - q)
            return (off**2).sum(axis=-1) + 1e-4 * ((values - q) ** 2).sum(axis=-1)

        assert (after >= legs.lower).all()
        assert (after <= legs.upper).all()
        for _ in range(50):
            other = np.clip(
                after + 0.05 * rng.normal(size=q.shape) * legs.is_joint, legs.lower, legs.upper
            )
            assert (cost(other) >= cost(after) - 1e-7).all()


def test_dexterity_gradient_matches_finite_differences(shipped: Figure) -> None:
    skeleton = shipped.skeleton
    limbs = LimbBatch.of([(skeleton, limb) for limb in skeleton.limbs])
    rng = np.random.default_rng(6)
    q = limbs.lower + rng.random(limbs.lower.shape) * (limbs.upper - limbs.lower)
    gradient = dexterity_gradient(limbs, limbs.pose(q))
    for k in range(q.shape[1]):
        h = np.zeros_like(q)
        h[:, k] = 1e-6
        rise = dexterity(limbs, limbs.pose(q + h)) - dexterity(limbs, limbs.pose(q - h))
        assert np.allclose(rise / 2e-6, gradient[:, k], atol=1e-6)


def test_a_straight_leg_is_singular(beetle: Figure) -> None:
    legs = LimbBatch.of([(beetle.skeleton, leg) for leg in beetle.skeleton.legs])
    rest = singular_values(legs, legs.pose(legs.preferred))[:, -1]
    straight = singular_values(legs, legs.pose(legs.extended))[:, -1]
    assert (straight < 0.15 * rest).all()
    assert (
        dexterity(legs, legs.pose(legs.extended)) < 0.2 * dexterity(legs, legs.pose(legs.preferred))
    ).all()


def test_rotation_vector_inverts_rotation() -> None:
    rng = np.random.default_rng(7)
    axis = rng.normal(size=(200, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    for angle in (1e-14, 1e-9, 1e-4, 0.5, 3.0, np.pi - 1e-9):
        found = rotation_vector(rotation(axis, np.full(200, angle)))
        assert np.allclose(found, angle * axis, rtol=1e-6, atol=1e-15)
