"""Many characters: random heaps stay whole, come to rest, and do not interpenetrate."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters.body_plan import character_arrays
from tests.simulation.characters.character_yard import (
    DT,
    depth,
    least_bend,
    lengths_off,
    pile,
    random_crowd,
)

pytestmark = pytest.mark.slow

FEW, SOME, ALL = range(8), range(8, 100), range(100, 1000)
ONCE_FAILED = (145, 349, 748, 769, 777, 229, 347)
"""An edge between the balls of a limb; knotted legs; a light foot below a bench; a knee pressed
into the ground by its own hip; a shin between those of somebody asleep."""

LONGEST = 40.0
"""In which all lie still: balls roll for long [s]."""


def holds(seed: int) -> None:
    yard, rng = random_crowd(seed), np.random.default_rng(seed + 10**6)
    arrays, off, reversed_by = yard.arrays, 0.0, 0.0
    for step in range(round(LONGEST / DT)):
        if step in (60, 120):
            # Pushed at 20 m/s, any one node in any direction.
            node, way = int(rng.integers(len(arrays.nodes))), rng.normal(size=3)
            before = arrays.p[node] - yard.h * 20.0 * way / np.linalg.norm(way)
            arrays.nodes["previous"][node] = before
        yard.step()
        off = max(off, lengths_off(arrays))
        if len(arrays.limbs):
            reversed_by = max(reversed_by, -least_bend(arrays.nodes, arrays.limbs))
        if step > 150 and arrays.owners["asleep"].all():
            break
    assert np.isfinite(arrays.p).all()
    assert off < 0.05
    assert math.degrees(reversed_by) < 2.0
    assert arrays.owners["asleep"].all()
    # At rest.
    before = arrays.p.copy()
    yard.step()
    assert np.abs(arrays.p - before).max() / DT < 1e-3
    assert lengths_off(arrays) < 0.005
    assert depth(arrays.nodes, arrays.links) < 0.005
    assert (arrays.nodes["radius"] - arrays.p[:, 1]).max() < 0.005


@pytest.mark.parametrize("seed", [*FEW, *ONCE_FAILED])
def test_nothing_explodes(seed: int) -> None:
    holds(seed)


@pytest.mark.slow
def test_nothing_explodes_a_hundred_times() -> None:
    for seed in SOME:
        holds(seed)


@pytest.mark.nightly
@pytest.mark.parametrize("tenth", range(9))
def test_nothing_explodes_a_thousand_times(tenth: int) -> None:
    for seed in ALL[100 * tenth : 100 * (tenth + 1)]:
        holds(seed)


def comes_to_rest(seed: int) -> None:
    yard = pile(seed)
    arrays, off = yard.arrays, 0.0
    for step in range(round(LONGEST / DT)):
        yard.step()
        off = max(off, lengths_off(arrays))
        if step > 150 and arrays.owners["asleep"].all():
            break
    assert np.isfinite(arrays.p).all()
    assert off < 0.05
    before = arrays.p.copy()
    yard.step()
    assert np.abs(arrays.p - before).max() / DT < 1e-3
    assert lengths_off(arrays) < 0.005
    # An edge lies between the balls of which limbs are made for a box.
    assert depth(arrays.nodes, arrays.links) < 0.01
    assert (arrays.nodes["radius"] - arrays.p[:, 1]).max() < 0.005


@pytest.mark.parametrize("seed", [22, 53, 84])
def test_boxes_that_lie_on_people_come_to_rest(seed: int) -> None:
    comes_to_rest(seed)


@pytest.mark.nightly
def test_a_hundred_piles_of_boxes_on_people_come_to_rest() -> None:
    for seed in range(100):
        comes_to_rest(seed)


def test_motion_is_bitwise_independent_of_distant_characters() -> None:

    from tests.simulation.characters.character_yard import PLANS, Yard

    plans = PLANS[:5]
    places = [plan.rest + np.array([0.4 * k, 0.3 * k, 0.2]) for k, plan in enumerate(plans)]
    far = [plan.rest + np.array([25.0, 0.5, 1.5 * k]) for k, plan in enumerate(plans)]
    alone = Yard(character_arrays(plans, places))
    beside = Yard(character_arrays([*plans, *plans], [*places, *far]))
    for yard in (alone, beside):
        yard.step(150)
    np.testing.assert_array_equal(alone.arrays.p, beside.arrays.p[: len(alone.arrays.p)])
