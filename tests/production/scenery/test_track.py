"""Track: along a long way there are ruts, past other casts a footpath, and none for a small one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.track import GAUGE, Track

AHEAD = np.array([0.0, -1.0])
CELL = 0.1


def clearings(length: float, width: float) -> Clearings:
    """Return those of a cast that uses a rectangle about the origin [m]."""
    used = np.zeros((301, 301), bool)
    i, j = (round(0.5 * side / CELL) for side in (length, width))
    used[150 - j : 151 + j, 150 - i : 151 + i] = True
    far = np.minimum(distance_transform_edt(~used) * CELL / Clearings.UNIT, 255)
    return Clearings((-15.0, -15.0), CELL, far.astype(np.uint8), np.zeros(used.shape, bool))


def test_a_long_way_is_a_cart_track() -> None:
    track = Track.of(clearings(14.0, 1.0), AHEAD, 3)
    assert track is not None
    assert track.has_ruts
    z = np.array([-GAUGE, 0.0, GAUGE, 3.0])
    for x in (-6.0, 0.0, 6.0):
        bare = track.bare(np.stack([np.full(4, x), z], axis=-1), np.zeros(4))
        assert bare[[0, 2]].min() > 0.9
        assert 0.0 < bare[1] < 0.5
        assert bare[3] == 0.0


@pytest.mark.parametrize("seed", [3, 4])
def test_a_wide_cast_has_a_footpath_that_leads_into_the_depth(seed: int) -> None:
    track = Track.of(clearings(7.0, 6.0), AHEAD, seed)
    assert track is not None
    assert not track.has_ruts
    way = np.array([np.cos(track.heading), np.sin(track.heading)])
    assert 0.85 < way @ AHEAD < 0.95
    assert track.bare(np.zeros((1, 2)), np.zeros(1))[0] > 0.8


def test_a_small_cast_or_none_has_no_track() -> None:
    assert Track.of(clearings(2.0, 0.5), AHEAD, 3) is None
    assert Track.of(None, AHEAD, 3) is None
