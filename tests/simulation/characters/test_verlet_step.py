"""Verlet step: flight, damping, momentum, step rates, locks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters.body_arrays import FREE, LANDING, LOCKED
from pipeline.simulation.characters.character_plans import person_plan
from pipeline.simulation.characters.playthings import ball_plan
from pipeline.simulation.people.proportions import ADULT, CHILD
from tests.simulation.characters.character_yard import DT, build_yard, random_rotation, undamped

HIGH = np.array([0.0, 50.0, 0.0])


@pytest.mark.parametrize("count", [3, 7])
def test_flight_matches_the_closed_form_of_the_recurrence(count: int) -> None:
    plan = ball_plan(0.1, 0.4)._replace(air_damping=0.0)
    yard = build_yard([plan], [plan.rest + HIGH], count=count)
    start, v = yard.arrays.p.copy(), np.array([[3.0, 4.0, -1.0]])
    yard.set_velocities(v)
    steps = 60
    yard.step(steps)
    n, h = steps * count, yard.h
    # p(n) = p(0) + n v h - g h² n (n + 1) / 2.
    fall = np.array([0.0, -9.81 * h * h * n * (n + 1) / 2.0, 0.0])
    np.testing.assert_allclose(yard.arrays.p, start + n * h * v + fall, rtol=0, atol=1e-9)


@pytest.mark.parametrize("rate", [0.5, 8.0])
def test_damping_matches_its_formula(rate: float) -> None:
    plan = ball_plan(0.1, 0.4)._replace(air_damping=rate)
    yard = build_yard([plan], [plan.rest + HIGH], gravity=0.0)
    start, v = yard.arrays.p.copy(), np.array([[3.0, 0.0, -1.0]])
    yard.set_velocities(v)
    yard.step(48)
    # (2 - d) p(t) - (1 - d) p(t - h) keeps 1 - d of a step, d = 1 - exp(-c h).
    kept = np.exp(-rate * yard.h * np.arange(1, 48 * 3 + 1)).sum()
    np.testing.assert_allclose(yard.arrays.p, start + kept * yard.h * v, rtol=0, atol=1e-12)


def momentum(yard) -> np.ndarray:  # type: ignore[no-untyped-def, type-arg]
    return (yard.velocities / yard.arrays.nodes["inverse_mass"][:, None]).sum(axis=0)


def test_an_undamped_person_keeps_its_momentum() -> None:
    rng = np.random.default_rng(3)
    plan = undamped(person_plan(ADULT))
    yard = build_yard([plan], [plan.rest @ random_rotation(rng).T + HIGH], gravity=0.0)
    yard.set_velocities(rng.normal(scale=4.0, size=plan.rest.shape))
    before, size = momentum(yard), ADULT.mass * 4.0
    for _ in range(200):
        yard.step()
        np.testing.assert_allclose(momentum(yard), before, rtol=0, atol=1e-9 * size)


def test_colliding_people_keep_their_momentum() -> None:
    plans = [undamped(person_plan(body)) for body in (ADULT, CHILD)]
    places = [plans[0].rest + HIGH, plans[1].rest + HIGH + [1.0, 0.2, 0.1]]
    yard = build_yard(plans, places, gravity=0.0)
    v = np.zeros_like(yard.arrays.p)
    v[:16, 0], v[16:, 0] = 3.0, -2.0
    yard.set_velocities(v)
    before, met = momentum(yard), False
    for _ in range(150):
        yard.step()
        met = met or bool(yard.log.filled[0])
        np.testing.assert_allclose(momentum(yard), before, rtol=0, atol=1e-8)
    assert met


def test_motion_converges_across_step_rates() -> None:
    rng = np.random.default_rng(8)
    plan, turn = person_plan(CHILD), random_rotation(np.random.default_rng(2))
    v, w = np.array([2.0, 3.0, 1.0]), rng.normal(size=3)
    ends = []
    for count in (3, 6, 12):
        yard = build_yard([plan], [plan.rest @ turn.T + HIGH], count=count)
        yard.set_velocities(v + np.cross(w, yard.arrays.p - HIGH))
        yard.step(48)
        ends.append(yard.arrays.p.copy())
    # After half a second of tumbling: the method is of first order.
    errors = [np.abs(end - ends[-1]).max() for end in ends[:2]]
    assert errors[0] < 0.15
    assert errors[1] < 0.7 * errors[0]


def test_locked_nodes_stay_and_landing_nodes_lock() -> None:
    plan = person_plan(CHILD)
    yard = build_yard([plan], [plan.rest + np.array([0.0, 0.3, 0.0])])
    nodes, foot, hand = yard.arrays.nodes, 14, 8
    nodes["lock"][hand], nodes["lock"][foot] = LOCKED, LANDING
    held = yard.arrays.p[hand].copy()
    nodes["lock_place"][hand] = held
    yard.step(96)
    assert nodes["lock"][foot] == LOCKED
    np.testing.assert_array_equal(yard.arrays.p[hand], held)
    np.testing.assert_array_equal(yard.arrays.p[foot], nodes["lock_place"][foot])
    assert yard.arrays.p[foot, 1] == pytest.approx(nodes["radius"][foot], abs=5e-3)
    nodes["lock"][hand] = FREE
    yard.step(96)
    assert yard.arrays.p[hand, 1] < held[1] - 0.1


def test_a_ball_bounces_by_its_bounciness() -> None:
    plan = ball_plan(0.12, 0.4)._replace(air_damping=0.0, ground_damping=0.0)
    yard = build_yard([plan], [plan.rest + np.array([0.0, 1.0, 0.0])], count=30)
    heights = []
    for _ in range(round(1.4 / DT)):
        yard.step()
        heights.append(float(yard.arrays.p[0, 1]) - 0.12)
    low = int(np.argmax(np.array(heights) < 0.05))
    assert max(heights[low:]) == pytest.approx(plan.bounciness**2, rel=0.05)


def test_a_rolling_ball_slows_by_its_friction() -> None:
    plan = ball_plan(0.12, 0.4)._replace(air_damping=0.0, ground_damping=0.0)
    yard = build_yard([plan], [plan.rest])
    yard.set_velocities(np.array([[2.0, 0.0, 0.0]]))
    yard.step(96)
    assert yard.velocities[0, 0] == pytest.approx(2.0 - plan.friction * 9.81, rel=0.01)
    assert math.isclose(yard.arrays.p[0, 1], 0.12, abs_tol=5e-4)
