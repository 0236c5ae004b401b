"""What must hold of figures, terrains and parameters of hops that nobody thought of."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from .hops import hop_through
from .triples import triple

SOME, ALL = range(0, 300, 20), [n for n in range(300) if n % 20]


def holds(number: int, folder: Path) -> None:
    hops = hop_through(triple(number, folder).scene)
    seen, tips, herd = hops.seen[0], hops.tips(), hops.troupe.herd
    assert np.isfinite(tips).all()
    down = np.array([s.down for s in seen])
    same = np.array([a.jumps == b.jumps for a, b in itertools.pairwise(seen)])
    stay = down[1:] & down[:-1] & same[:, None]
    moved = np.linalg.norm(np.diff(tips, axis=0), axis=-1)
    assert moved[stay].max(initial=0.0) < 1e-3
    ground = hops.simulation.world.ground
    over = tips[..., 1] - herd.sole - ground.height(tips[..., 0], tips[..., 2])
    assert over[down].min(initial=0.0) > -1e-3
    # In the air as well, until it falls and is a body like others.
    upright = np.array([s.phase != "fallen" for s in seen])
    assert over[upright].min(initial=0.0) > -1e-3
    most = hops.troupe.hoppers[0].max_leg_force
    for one in seen:
        assert np.linalg.norm(one.forces, axis=-1).max() <= most * (1.0 + 1e-9)
    skeleton = herd.figures[0].skeleton
    joints = [j for limb in skeleton.legs for j in limb.joints]
    q = hops.simulation.recorder.values[:, 2 : 2 + len(joints)]
    # The limits of a ragdoll give way for a moment: 14 degrees at most were seen.
    slack = np.where(upright, 1e-9, np.radians(20.0))[:, None]
    assert (q >= skeleton.lower[joints] - slack).all()
    assert (q <= skeleton.upper[joints] + slack).all()


@pytest.mark.nightly
@pytest.mark.parametrize("number", SOME)
def test_what_must_hold_holds(number: int, tmp_path: Path) -> None:
    holds(number, tmp_path)


@pytest.mark.nightly
@pytest.mark.parametrize("number", ALL)
def test_what_must_hold_holds_for_the_others(number: int, tmp_path: Path) -> None:
    holds(number, tmp_path)
