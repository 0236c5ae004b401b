"""Invariants of walking, at every step, in random scenes.

A creature may stop at ground that it cannot cross, with a note.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.take import Contact
from tests.simulation.conftest import Walk, walk_through
from tests.simulation.locomotion.random_walk_scenes import (
    HELD_OUT,
    KINDS,
    SEED,
    WALKERS,
    random_walk,
)

MILLIMETRE = 1e-3

COUNT = 300

MAX_BODY_ACCELERATION = 10.0 / np.sqrt(3.0) * 0.4 / 0.5**2
"""Greatest acceleration of a body [leg lengths per cycle²], without its bounce of up to 2 g.

The ground rises by at most 0.4 leg lengths within half a cycle, and the body follows on a path of
least jerk, whose acceleration is at most 10 / √3 · d / t².
"""

MAX_JOINT_SPEED = 50.0
"""Greatest speed of a joint [rad per cycle].

It folds by half a turn and opens again within a swing of a quarter of a cycle, on a path of least
jerk: 2 · 15 / 8 · π / (1/4).
"""

_POINTS = np.random.default_rng(0).normal(size=(40, 3))
BALL = _POINTS / np.linalg.norm(_POINTS, axis=-1, keepdims=True)


@pytest.mark.nightly
@pytest.mark.parametrize("number", range(COUNT))
@pytest.mark.parametrize("seed", [SEED, HELD_OUT])
def test_invariants_of_walking_hold_in_random_scenes(
    seed: int, number: int, tmp_path: Path
) -> None:
    walk = walk_through(random_walk(number, tmp_path, seed).scene)
    # A foot that misses its foothold is noted as clamped; knees may graze rough ground.
    assert {note.kind for note in walk.take.notes} <= {"stopped", "passes_through"}
    assert_feet_on_the_ground(walk)
    assert_joint_limits(walk)
    assert_smooth_body_motion(walk)
    assert_gait_timing(walk)


def assert_feet_on_the_ground(walk: Walk) -> None:
    ground, herd = walk.simulation.world.ground, walk.walkers.herd
    down = walk.standing[1:] & walk.standing[:-1]
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)
    assert moved[down].max(initial=0.0) < MILLIMETRE
    p = walk.tips[:, :, None] + herd.foot_radius[:, None, None] * BALL
    assert (p[..., 1] - ground.height(p[..., 0], p[..., 2])).min() > -MILLIMETRE
    places = np.array([contact.place for contact in _touchdowns(walk)]).reshape(-1, 3)
    holds = np.array([hold.place for hold in walk.walkers.sequencer.feet.footholds])
    for x, _, z in (places.T, holds.T):
        assert ground.steppable(x, z).all()


def _touchdowns(walk: Walk) -> list[Contact]:
    """Return the contacts of feet at touchdown, without scuffs."""
    return [contact for contact in walk.take.contacts if contact.kind == "touch"]


def assert_joint_limits(walk: Walk) -> None:
    legs, q = walk.walkers.herd.legs, walk.q
    assert (q >= legs.lower).all()
    assert (q <= legs.upper).all()
    speed = np.abs(np.diff(q, axis=0)).max() / walk.simulation.world.clock.dt
    assert speed < MAX_JOINT_SPEED / float(walk.walkers.herd.cycle[0])


def assert_smooth_body_motion(walk: Walk) -> None:
    herd, dt = walk.walkers.herd, walk.simulation.world.clock.dt
    bound = MAX_BODY_ACCELERATION * herd.legs.lengths.mean() / herd.cycle[0] ** 2 + 2.0 * GRAVITY
    acceleration = np.diff(walk.take.positions[:, 0], 2, axis=0) / dt**2
    assert np.abs(acceleration).max() < bound


def assert_gait_timing(walk: Walk) -> None:
    herd = walk.walkers.herd
    if herd.paces[0].flight is None:
        assert walk.standing.any(axis=1).all()
    names = [f"{herd.names[0]}.{leg}" for leg in herd.leg_names]
    for contact in _touchdowns(walk):
        leg = names.index(contact.part)
        before, after = (walk.phases[contact.step + k][0] for k in (0, 1))
        off = before + contact.fraction * (after - before) - herd.down[leg]
        assert abs(off - round(off)) < 1e-9


def test_random_scenes_cover_every_figure_on_every_terrain() -> None:
    seen = {(n % len(WALKERS), (n // len(WALKERS) + n) % len(KINDS)) for n in range(COUNT)}
    assert len(seen) == len(WALKERS) * len(KINDS)
