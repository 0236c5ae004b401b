"""Random pairs of a figure and a terrain: what must hold at every step, whatever they are.

Creatures that are put before ground which they cannot go over stop, and say so; nothing
else excuses them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.take import Contact
from tests.simulation.conftest import Walk, walk_through
from tests.simulation.locomotion.random_walk_scenes import HELD_OUT, KINDS, SEED, WALKERS, pair

MILLIMETRE = 1e-3

COUNT = 300

LIFT = 10.0 / np.sqrt(3.0) * 0.4 / 0.5**2
"""Greatest acceleration of a body, in leg lengths and cycles: where its ground rises by as
much as legs can step, 0.4 of their length, within half a cycle, along the path of least
jerk, whose acceleration is at most 10 / √3 · d / t². To it comes what bounces, up to 2 g."""

TURNS = 50.0
"""Greatest speed of a joint [rad] in a cycle: it folds up by half a turn and opens again
within a swing of a quarter of a cycle, along the path of least jerk: 2 · 15 / 8 · π / (1/4)."""

_POINTS = np.random.default_rng(0).normal(size=(40, 3))
BALL = _POINTS / np.linalg.norm(_POINTS, axis=-1, keepdims=True)


def _pairs(seed: int, tenth: pytest.MarkDecorator) -> list[object]:
    """Return all pairs of a seed: every tenth in the tier `tenth`, the others at night."""
    found = []
    for number in range(COUNT):
        marks = [tenth if number % 10 == 0 else pytest.mark.nightly]
        found.append(pytest.param(number, marks=marks))
    return found


@pytest.mark.parametrize("number", _pairs(SEED, pytest.mark.nightly))
def test_what_must_hold_holds(number: int, tmp_path: Path) -> None:
    _all_holds(number, SEED, tmp_path)


@pytest.mark.parametrize("number", _pairs(HELD_OUT, pytest.mark.nightly))
def test_what_must_hold_holds_for_pairs_that_nothing_was_tuned_on(
    number: int, tmp_path: Path
) -> None:
    _all_holds(number, HELD_OUT, tmp_path)


def _all_holds(number: int, seed: int, folder: Path) -> None:
    walk = walk_through(pair(number, folder, seed).scene)
    # A foot that does not come to its place is noted as clamped.
    assert {note.kind for note in walk.take.notes} <= {"stopped"}
    _feet_keep_to_the_ground(walk)
    _joints_keep_their_limits(walk)
    _bodies_move_smoothly(walk)
    _feet_keep_to_the_gait(walk)


def _feet_keep_to_the_ground(walk: Walk) -> None:
    ground, herd = walk.simulation.world.ground, walk.walkers.herd
    down = walk.standing[1:] & walk.standing[:-1]
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)
    assert moved[down].max(initial=0.0) < MILLIMETRE
    p = walk.tips[:, :, None] + herd.foot_radius[:, None, None] * BALL
    assert (p[..., 1] - ground.height(p[..., 0], p[..., 2])).min() > -MILLIMETRE
    places = np.array([contact.place for contact in _touches(walk)]).reshape(-1, 3)
    holds = np.array([hold.place for hold in walk.walkers.sequencer.feet.footholds])
    for x, _, z in (places.T, holds.T):
        assert ground.steppable(x, z).all()


def _touches(walk: Walk) -> list[Contact]:
    """Return the contacts of feet that come down, not of those that scuff."""
    return [contact for contact in walk.take.contacts if contact.kind == "touch"]


def _joints_keep_their_limits(walk: Walk) -> None:
    legs, q = walk.walkers.herd.legs, walk.q
    assert (q >= legs.lower).all()
    assert (q <= legs.upper).all()
    speed = np.abs(np.diff(q, axis=0)).max() / walk.simulation.world.clock.dt
    assert speed < TURNS / float(walk.walkers.herd.cycle[0])


def _bodies_move_smoothly(walk: Walk) -> None:
    herd, dt = walk.walkers.herd, walk.simulation.world.clock.dt
    bound = LIFT * herd.legs.lengths.mean() / herd.cycle[0] ** 2 + 2.0 * GRAVITY
    acceleration = np.diff(walk.take.positions[:, 0], 2, axis=0) / dt**2
    assert np.abs(acceleration).max() < bound


def _feet_keep_to_the_gait(walk: Walk) -> None:
    herd = walk.walkers.herd
    if herd.paces[0].flight is None:
        assert walk.standing.any(axis=1).all()
    names = [f"{herd.names[0]}.{leg}" for leg in herd.leg_names]
    for contact in _touches(walk):
        leg = names.index(contact.part)
        before, after = (walk.phases[contact.step + k][0] for k in (0, 1))
        off = before + contact.fraction * (after - before) - herd.down[leg]
        assert abs(off - round(off)) < 1e-9


def test_pairs_hold_every_figure_and_every_kind_of_terrain() -> None:
    seen = {(n % len(WALKERS), (n // len(WALKERS) + n) % len(KINDS)) for n in range(COUNT)}
    assert len(seen) == len(WALKERS) * len(KINDS)
