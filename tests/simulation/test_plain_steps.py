"""Plain steps, planned together, are the steps that are planned one by one."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.figures.settling import brought, settle
from pipeline.simulation.locomotion.footing.plain_steps import Lift, PlainSteps
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
        plain.foresee([lift])
        alone = plain.of(lift.leg)
        assert (alone is None) == (place is None)
        if alone is not None and place is not None:
            assert (alone.tip == place.tip).all()
            assert alone.arch == place.arch


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


def test_misses_are_how_far_limbs_settle_from_their_goals(walkers: Walkers) -> None:
    legs, chains = walkers.herd.legs, walkers.herd.chains
    chance = np.random.default_rng(2).normal(size=(3, len(legs.lengths), 3))
    goals = legs.tips + 0.3 * legs.lengths[:, None] * chance
    settled = settle(legs, chains, goals).residual
    rows = np.tile(np.arange(len(legs.lengths)), 3)
    _, asked = brought(legs, chains, rows, goals.reshape(-1, 3))
    assert (settled > 1e-3 * legs.lengths).any()
    assert np.allclose(asked, settled.ravel(), rtol=0.0, atol=1e-12)
