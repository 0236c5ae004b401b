"""Limp bodies: no energy but what gravity and the hands of carriers give."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters.body_arrays import LOCKED
from pipeline.simulation.characters.character_plans import RAGDOLL, person_plan
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.people.proportions import ADULT, CHILD, Proportions
from pipeline.simulation.spatial import Array
from tests.simulation.characters.character_yard import DT, Yard, build_yard, random_rotation

BODIES = (ADULT, CHILD, RAGDOLL)
ENDS = (8, 9, 14, 15)
"""Hands and feet."""

HIGH = 50.0  # above the ground [m]


def thrown(body: Proportions, rng: np.random.Generator, height: float, **settings: object) -> Yard:
    """Return a limp body, turned at random, at a height of its middle [m]."""
    plan = person_plan(body)
    places = plan.rest @ random_rotation(rng).T
    return build_yard([plan], [places - places.mean(axis=0) + [0.0, height, 0.0]], **settings)


def masses(yard: Yard) -> Array:
    result: Array = 1.0 / yard.arrays.nodes["inverse_mass"]
    return result


def kinetic_energy(yard: Yard) -> float:
    return float(0.5 * (masses(yard) * (yard.velocities**2).sum(axis=1)).sum())


def fastest_node(yard: Yard) -> float:
    """Advance by a step; return the speed of the fastest node, as it is seen [m/s]."""
    before = yard.arrays.p.copy()
    yard.step()
    return float(np.linalg.norm(yard.arrays.p - before, axis=1).max() / DT)


@pytest.mark.parametrize("seed", range(24))
def test_a_tumbling_body_gains_no_energy(seed: int) -> None:
    rng, body = np.random.default_rng(seed), BODIES[seed % 3]
    yard = thrown(body, rng, HIGH, gravity=0.0)
    turning = np.cross(4.0 * rng.normal(size=3), yard.arrays.p - [0.0, HIGH, 0.0])
    yard.set_velocities(turning + rng.normal(scale=1.5 * body.height, size=turning.shape))
    yard.step()
    least = kinetic_energy(yard)
    margin = 0.02 * least
    for _ in range(299):
        yard.step()
        assert kinetic_energy(yard) < 1.05 * least + margin
        least = min(least, kinetic_energy(yard))


@pytest.mark.parametrize("seed", [0, 1, 5, 8, 9, 10, 12, 15])
def test_a_swung_body_has_the_energy_that_the_hand_gives(seed: int) -> None:
    rng, body = np.random.default_rng(seed), BODIES[seed % 3]
    yard = thrown(body, rng, HIGH)
    nodes, mass, held = yard.arrays.nodes, masses(yard), int(rng.choice(ENDS))
    mass[held] = 0.0
    start, v = nodes["p"][held].copy(), np.zeros(3)
    place, fastest = start.copy(), 0.75 * math.sqrt(GRAVITY * body.height)
    weight, work, first, momentum = mass.sum() * GRAVITY, 0.0, None, np.zeros(3)
    nodes["lock"][held], nodes["lock_place"][held] = LOCKED, start
    for step in range(700):
        if step % 96 == 0:
            goal = start + rng.uniform(-1.5, 1.5, size=3) * body.height
        way = goal - place
        change = way * min(fastest / max(math.hypot(*way), 1e-9), 6.0) - v
        v += change * min(30.0 * DT / max(math.hypot(*change), 1e-9), 1.0)
        place = place + v * DT
        nodes["lock_place"][held] = place
        yard.step()
        energy = float((mass * (0.5 * (yard.velocities**2).sum(axis=1))).sum())
        energy += GRAVITY * float((mass * yard.arrays.p[:, 1]).sum())
        before, momentum = momentum, (mass[:, None] * yard.velocities).sum(axis=0)
        if first is None:
            first = energy
            continue
        # The force of the hand is what changes the momentum, beside the weight.
        work += float(((momentum - before) / DT + [0.0, weight, 0.0]) @ v) * DT
        assert energy - first - work < 0.25 * weight * body.height


@pytest.mark.parametrize("seed", [1, 3, 7, 8, 12, 16, 18, 23])
def test_a_carried_body_is_as_fast_as_hands_and_a_fall_explain(seed: int) -> None:
    rng, body = np.random.default_rng(seed), BODIES[seed % 3]
    size = body.height
    yard = thrown(body, rng, size)
    nodes, hands = yard.arrays.nodes, rng.choice(ENDS, size=1 + seed % 2, replace=False)
    places, fastest = nodes["p"][hands].copy(), 0.75 * math.sqrt(GRAVITY * size)
    nodes["lock"][hands] = LOCKED
    # Hands turn on the spot, and what hangs from them is pulled straight at twice their speed.
    bound = 2.0 * (fastest + math.sqrt(2.0 * GRAVITY * 2.0 * size))
    for step in range(900):
        if step % 96 == 0:
            middle = rng.uniform([-2.0, 0.3, -2.0], [2.0, 1.4, 2.0])
            goals = size * (middle + rng.uniform(-0.35, 0.35, size=places.shape) * [1.0, 0.3, 1.0])
        ways = goals - places
        left = np.linalg.norm(ways, axis=1, keepdims=True)
        places = places + ways * np.minimum(fastest * DT / np.maximum(left, 1e-9), 1.0)
        nodes["lock_place"][hands] = places
        assert fastest_node(yard) < bound
