"""Hedges and palms: lengths that join, crowns that differ."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.edging.hedges import DEPTH, LENGTH, SHOOTS, hedge_length, hedge_tops
from pipeline.production.edging.palms import HABITS, LEAFLETS, palm


@pytest.mark.parametrize("level", range(len(SHOOTS)))
def test_shoots_of_a_hedge_reach_over_the_next_length(level: int) -> None:
    shape = hedge_length(1, level)
    x, y, z = shape.vertices.T
    assert x.min() < -0.5 * LENGTH - 0.05
    assert x.max() > 0.5 * LENGTH + 0.05
    assert np.abs(z).max() < DEPTH
    assert 0.9 < y.max() < 1.45
    inside = shape.vertices[np.unique(shape.solid)]
    assert np.abs(inside[:, 2]).max() < 0.4 * DEPTH
    again = hedge_length.__wrapped__(1, level)
    assert (again.vertices == shape.vertices).all()


def test_the_top_of_a_hedge_rises_and_falls_without_steps() -> None:
    along = np.stack([np.arange(0.0, 200.0, 0.95), np.zeros(211)], axis=-1)
    tops = hedge_tops(along, 4)
    assert np.ptp(tops) > 0.1
    assert tops.min() >= 0.8
    assert np.abs(np.diff(tops)).max() < 0.15


@pytest.mark.parametrize("seed", range(len(HABITS)))
def test_a_palm_has_a_crown_all_round_its_trunk(seed: int) -> None:
    near, far = (palm(seed, level) for level in range(len(LEAFLETS)))
    assert near.triangles > far.triangles > 0
    crown = near.vertices[np.unique(near.foliage)].astype(float)
    trunk = crown.mean(axis=0)
    out = crown - trunk
    around = np.arctan2(out[:, 2], out[:, 0])
    counts, _ = np.histogram(around, 8, (-np.pi, np.pi))
    assert counts.min() > 0.04 * len(crown)
    assert np.hypot(out[:, 0], out[:, 2]).max() > 1.2
    assert near.vertices[:, 1].min() > -0.3


def test_palms_differ() -> None:
    tops = [palm(seed, 1).vertices[:, 1].max() for seed in range(len(HABITS))]
    assert np.ptp(tops) > 0.5
