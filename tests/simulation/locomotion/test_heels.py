"""Tests of feet that stand on their soles, as those of people."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.figures.foot_link import last_links
from tests.simulation.conftest import scene_of, walk_through

FLAT_WITHIN = np.radians(8.0)
"""Angle to the ground of a sole that counts as flat [rad]."""

UNDER = 30
"""Rows from a touchdown until the foot is under the body."""

BEFORE = 8
"""Rows before the touchdown in which the toe is up, of a swing of some forty rows."""


def test_soles_come_down_toe_up_and_flat_and_leave_the_ground_over_the_toe() -> None:
    walk = walk_through(scene_of("{figure: person, walk: {}}", duration=3))
    herd, nodes = walk.walkers.herd, walk.take.nodes
    assert (herd.soles > 0.0).all()
    ankle = max(k for k, node in enumerate(nodes) if node.name.startswith("person.l1"))
    way = walk.tips[:, 0] - walk.take.positions[:, ankle]
    pitch = np.arctan2(way[:, 1], np.hypot(way[:, 0], way[:, 2]))
    down = walk.standing[:, 0].astype(int)
    touches, lifts = (np.flatnonzero(np.diff(down) == way) + 1 for way in (1, -1))
    # The sole is flat as it is at rest.
    rest = last_links(herd.legs)[0]
    flat = np.arctan2(rest[1], np.hypot(rest[0], rest[2]))
    inner = [touch for touch in touches if touch > BEFORE + 60]
    assert len(inner) >= 1
    for touch in inner:
        # First the heel, then all of the sole, until the foot is under the body.
        assert 0.0 < pitch[touch] - flat < FLAT_WITHIN
        assert pitch[touch - BEFORE] - flat > np.radians(3.0)
        assert np.abs(pitch[touch : touch + UNDER] - flat).max() < FLAT_WITHIN
    for lift in lifts:
        assert flat - pitch[lift] > np.radians(20.0)
