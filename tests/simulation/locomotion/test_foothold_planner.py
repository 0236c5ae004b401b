"""Footholds predicted in batches equal those found one by one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from pipeline.simulation.figures.tip_ik import solve_each_tip, solve_tips
from pipeline.simulation.locomotion.foot_placement import foothold_planner
from pipeline.simulation.locomotion.foot_placement.foothold_planner import FootholdPlanner
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.foot_placement.step_batch import StepBatch, StepRequest
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.speed_control import SLOPE_SAMPLES_PER_SECOND
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene

KINDS = ("beetle", "horse", "spider", "person", "antelope")


@pytest.fixture(
    params=["boulders", pytest.param("{preset: hills, height: 2}", marks=pytest.mark.nightly)]
)
def walkers(request: pytest.FixtureRequest) -> WalkerTroupe:
    cast = "\n".join(
        f"- {{name: c{i}, figure: {kind}, at: [{2 * i - 4}, {i % 3}], heading_deg: {97 * i},"
        " walk: {speed: 0.7}}"
        for i, kind in enumerate(KINDS)
    )
    text = f"pronk: 1\nduration: 1\nseed: 5\nterrain: {request.param}\ncast:\n{cast}\n"
    (walkers,) = Simulation(read_scene(text)).troupes
    assert isinstance(walkers, WalkerTroupe)
    return walkers


def planner_of(walkers: WalkerTroupe) -> FootholdPlanner:
    """Return a planner without predictions."""
    return FootholdPlanner(walkers.herd, walkers.world.ground, walkers.progress.trajectory)


def requests_of(walkers: WalkerTroupe) -> list[StepRequest]:
    """Return a step request of every leg, shortly after the start."""
    herd, paces = walkers.herd, walkers.progress.paces
    requests = []
    for leg, owner in enumerate(herd.owner.tolist()):
        phase = 0.3 + 0.01 * leg
        distance = phase * float(herd.stride[owner])
        timing, present = paces.step(leg, phase), walkers.sequencer.feet.end[leg]
        requests.append(StepRequest(leg, distance, phase, timing, 1.0, present))
    return requests


def test_batched_footholds_equal_those_of_single_searches(walkers: WalkerTroupe) -> None:
    planner, requests = planner_of(walkers), requests_of(walkers)
    planner.predict(requests)
    together = [planner.predicted(request.leg) for request in requests]
    assert sum(hold is not None for hold in together) > len(requests) / 2
    for request, hold in zip(requests, together, strict=True):
        if hold is None:
            continue
        alone = planner.search.find(request)
        assert alone is not None
        assert (hold.place == alone.place).all()
        assert (hold.tip == alone.tip).all()
        assert (hold.normal == alone.normal).all()
        assert (hold.lowering, hold.swing_height) == (alone.lowering, alone.swing_height)


@pytest.mark.nightly
def test_a_foothold_does_not_depend_on_other_lifting_feet(walkers: WalkerTroupe) -> None:
    planner, requests = planner_of(walkers), requests_of(walkers)
    planner.predict(requests)
    together = [planner.predicted(request.leg) for request in requests]
    for request, hold in zip(requests, together, strict=True):
        alone = planner_of(walkers)
        alone.predict([request])
        assert_same(alone.predicted(request.leg), hold)


def assert_same(one: Foothold | None, other: Foothold | None) -> None:
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        assert (one.tip == other.tip).all()
        assert one.swing_height == other.swing_height


@pytest.mark.slow
@pytest.mark.parametrize("off", [pytest.param(0.0, marks=pytest.mark.nightly), 1e-3])
@pytest.mark.nightly
def test_early_predictions_equal_late_ones(walkers: WalkerTroupe, off: float) -> None:
    early, requests = planner_of(walkers), requests_of(walkers)
    upcoming = [replace(r, distance=r.distance + off) for r in requests[1:]]
    early.predict(requests[:1], lambda: upcoming)
    assert all(early.predicted(r.leg) is None for r in upcoming)
    for request in requests[1:]:
        in_time = planner_of(walkers)
        in_time.predict([request])
        early.predict([request])
        assert_same(early.predicted(request.leg), in_time.predicted(request.leg))


@pytest.mark.nightly
def test_each_foothold_of_a_walk_is_predicted_once(
    walkers: WalkerTroupe, monkeypatch: pytest.MonkeyPatch
) -> None:
    batches = list[int]()

    class Counted(StepBatch):
        @staticmethod
        def of(herd: Herd, requests: Sequence[StepRequest]) -> StepBatch:
            batches.append(len(requests))
            return StepBatch.of(herd, requests)

    monkeypatch.setattr(foothold_planner, "StepBatch", Counted)
    feet = walkers.sequencer.feet
    before, lifted = feet.lift_phase.copy(), 0
    for step in range(walkers.world.clock.last_step):
        walkers.read({})
        walkers.advance(step)
        lifted += int((feet.lift_phase != before).sum())
        before = feet.lift_phase.copy()
    # Feet predicted in the last steps lift after the end.
    assert sum(batches) <= lifted + len(before)
    # One batch between two slope samples, and a second one for redirected creatures.
    assert len(batches) <= 2 * SLOPE_SAMPLES_PER_SECOND


@pytest.mark.nightly
def test_predictions_of_a_redirected_creature_are_discarded(walkers: WalkerTroupe) -> None:
    planner, requests = planner_of(walkers), requests_of(walkers)
    planner.predict(requests)
    known = [r.leg for r in requests if planner.predicted(r.leg) is not None]
    owner = walkers.herd.owner[known[0]]
    trajectory = walkers.progress.trajectory
    trajectory.set_route(int(owner), trajectory.routes[owner].upto(5.0))
    left = [leg for leg in known if planner.predicted(leg) is not None]
    assert left == [leg for leg in known if walkers.herd.owner[leg] != owner]
    planner.predict([])
    assert all(planner.predicted(leg) is None for leg in known)


@pytest.mark.nightly
def test_residuals_equal_those_of_solved_limbs(walkers: WalkerTroupe) -> None:
    legs, chains = walkers.herd.legs, walkers.herd.chains
    rng = np.random.default_rng(2).normal(size=(3, len(legs.lengths), 3))
    goals = legs.tips + 0.3 * legs.lengths[:, None] * rng
    settled = solve_tips(legs, chains, goals).residual
    rows = np.tile(np.arange(len(legs.lengths)), 3)
    _, residuals = solve_each_tip(legs, chains, rows, goals.reshape(-1, 3))
    assert (settled > 1e-3 * legs.lengths).any()
    assert np.allclose(residuals, settled.ravel(), rtol=0.0, atol=1e-12)
