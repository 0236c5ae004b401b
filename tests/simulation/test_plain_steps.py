"""Plain steps, planned together, are the steps that are planned one by one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from pipeline.simulation.figures.rest_ik import solve_each_near_rest, solve_near_rest
from pipeline.simulation.locomotion.foot_placement.foothold_planner import Lift, PlainSteps
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.routes.route_progress import SLOPE_SAMPLES_PER_SECOND
from pipeline.simulation.locomotion.walking import Walkers
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene

KINDS = ("beetle", "horse", "spider", "person", "antelope")


def herd_of(terrain: str) -> Walkers:
    cast = "\n".join(
        f"- {{name: c{i}, figure: {kind}, at: [{2 * i - 4}, {i % 3}], heading_deg: {97 * i},"
        " walk: {}}"
        for i, kind in enumerate(KINDS)
    )
    text = f"pronk: 1\nduration: 1\nseed: 5\nterrain: {terrain}\ncast:\n{cast}\n"
    (walkers,) = Simulation(read_scene(text)).troupes
    assert isinstance(walkers, Walkers)
    return walkers


@pytest.fixture(params=["{preset: hills, height: 2}", "boulders"])
def walkers(request: pytest.FixtureRequest) -> Walkers:
    return herd_of(request.param)


def lifts_of(walkers: Walkers) -> list[Lift]:
    """Return a step of every leg, each from a little after the start."""
    herd, paces = walkers.herd, walkers.going.paces
    found = []
    for leg, owner in enumerate(herd.owner.tolist()):
        phase = 0.3 + 0.01 * leg
        way = phase * float(herd.stride[owner])
        found.append(Lift(leg, way, phase, paces.step(leg, phase), 1.0, walkers.feet.end[leg]))
    return found


def test_steps_together_are_the_steps_one_by_one(walkers: Walkers) -> None:
    plain, lifts = PlainSteps(walkers.feet.footholds), lifts_of(walkers)
    plain.foresee(lifts)
    together = [plain.of(lift.leg) for lift in lifts]
    assert sum(place is not None for place in together) > len(lifts) / 2
    for lift, place in zip(lifts, together, strict=True):
        if place is None:
            continue
        assert lift.present is not None
        alone = walkers.feet.footholds.next(
            lift.leg, lift.present, lift.travelled, lift.step, lift.drive
        )
        assert alone is not None
        assert (place.place == alone.place).all()
        assert (place.tip == alone.tip).all()
        assert (place.normal == alone.normal).all()
        assert (place.stoop, place.arch) == (alone.stoop, alone.arch)


def test_no_bit_depends_on_who_else_lifts(walkers: Walkers) -> None:
    plain, lifts = PlainSteps(walkers.feet.footholds), lifts_of(walkers)
    plain.foresee(lifts)
    together = [plain.of(lift.leg) for lift in lifts]
    for lift, place in zip(lifts, together, strict=True):
        # Another one, which knows nothing yet.
        apart = PlainSteps(walkers.feet.footholds)
        apart.foresee([lift])
        assert_same(apart.of(lift.leg), place)


def assert_same(one: Foothold | None, other: Foothold | None) -> None:
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        assert (one.tip == other.tip).all()
        assert one.arch == other.arch


@pytest.mark.slow
@pytest.mark.parametrize("off", [0.0, 1e-3])
def test_steps_planned_early_are_those_planned_in_time(walkers: Walkers, off: float) -> None:
    early, lifts = PlainSteps(walkers.feet.footholds), lifts_of(walkers)
    expected = [replace(lift, travelled=lift.travelled + off) for lift in lifts[1:]]
    early.foresee(lifts[:1], lambda: expected)
    assert all(early.of(lift.leg) is None for lift in expected)
    known = {leg for leg, plan in early._plans.items() if plan.place is not None}
    assert len(known) > len(lifts) / 2
    for lift in lifts[1:]:
        in_time = PlainSteps(walkers.feet.footholds)
        in_time.foresee([lift])
        early.foresee([lift])
        assert_same(early.of(lift.leg), in_time.of(lift.leg))


@pytest.mark.slow
def test_no_plan_of_a_whole_walk_is_made_twice(
    walkers: Walkers, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = list[int]()
    planned = PlainSteps._planned

    def counted(self: PlainSteps, lifts: Sequence[Lift]) -> list[Foothold | None]:
        asked.append(len(lifts))
        return planned(self, lifts)

    monkeypatch.setattr(PlainSteps, "_planned", counted)
    before, lifted = walkers.feet.lifted.copy(), 0
    for step in range(walkers.world.clock.last_step):
        walkers.read({})
        walkers.advance(step)
        lifted += int((walkers.feet.lifted != before).sum())
        before = walkers.feet.lifted.copy()
    # What is expected in the last steps lifts after them.
    assert sum(asked) <= lifted + len(before)
    # One call between two looks at slopes, or a second one for who went otherwise.
    assert len(asked) <= 2 * SLOPE_SAMPLES_PER_SECOND


def test_a_step_is_forgotten_when_its_creature_is_led_elsewhere(walkers: Walkers) -> None:
    plain, lifts = PlainSteps(walkers.feet.footholds), lifts_of(walkers)
    plain.foresee(lifts)
    foreseen = [lift.leg for lift in lifts if plain.of(lift.leg) is not None]
    owner = walkers.herd.owner[foreseen[0]]
    path = walkers.going.path
    path.lead(int(owner), path.routes[owner].upto(5.0))
    left = [leg for leg in foreseen if plain.of(leg) is not None]
    assert left == [leg for leg in foreseen if walkers.herd.owner[leg] != owner]
    plain.foresee([])
    assert all(plain.of(leg) is None for leg in foreseen)


@pytest.mark.slow
def test_misses_are_how_far_limbs_settle_from_their_goals(walkers: Walkers) -> None:
    legs, chains = walkers.herd.legs, walkers.herd.chains
    chance = np.random.default_rng(2).normal(size=(3, len(legs.lengths), 3))
    goals = legs.tips + 0.3 * legs.lengths[:, None] * chance
    settled = solve_near_rest(legs, chains, goals).residual
    rows = np.tile(np.arange(len(legs.lengths)), 3)
    _, asked = solve_each_near_rest(legs, chains, rows, goals.reshape(-1, 3))
    assert (settled > 1e-3 * legs.lengths).any()
    assert np.allclose(asked, settled.ravel(), rtol=0.0, atol=1e-12)
