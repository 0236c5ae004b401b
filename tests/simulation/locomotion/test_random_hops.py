"""Invariants of hops with random figures, terrains and parameters."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from tests.simulation.locomotion.hop_recorder import hop_through
from tests.simulation.locomotion.random_hop_scenes import random_hop


def check_invariants(number: int, folder: Path) -> None:
    hops = hop_through(random_hop(number, folder).scene)
    states, tips, herd = hops.states[0], hops.tips(), hops.troupe.herd
    assert np.isfinite(tips).all()
    down = np.array([s.down for s in states])
    same = np.array([a.jumps == b.jumps for a, b in itertools.pairwise(states)])
    stay = down[1:] & down[:-1] & same[:, None]
    moved = np.linalg.norm(np.diff(tips, axis=0), axis=-1)
    assert moved[stay].max(initial=0.0) < 1e-3
    ground = hops.simulation.world.ground
    over = tips[..., 1] - herd.foot_radius - ground.height(tips[..., 0], tips[..., 2])
    assert over[down].min(initial=0.0) > -1e-3
    # Feet in the air stay above the ground too, until a fall.
    upright = np.array([s.phase != "fallen" for s in states])
    assert over[upright].min(initial=0.0) > -1e-3
    most = hops.troupe.hoppers[0].max_leg_force
    for moment in states:
        assert np.linalg.norm(moment.forces, axis=-1).max() <= most * (1.0 + 1e-9)
    skeleton = herd.figures[0].skeleton
    joints = [j for limb in skeleton.legs for j in limb.joints]
    q = hops.simulation.recorder.values[:, 2 : 2 + len(joints)]
    # A ragdoll exceeds its limits for a moment, by 14 degrees at most.
    slack = np.where(upright, 1e-9, np.radians(20.0))[:, None]
    assert (q >= skeleton.lower[joints] - slack).all()
    assert (q <= skeleton.upper[joints] + slack).all()


@pytest.mark.nightly
@pytest.mark.parametrize("number", range(300))
def test_invariants_of_hopping_hold_in_random_scenes(number: int, tmp_path: Path) -> None:
    check_invariants(number, tmp_path)
