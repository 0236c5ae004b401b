"""Hedges, walls and palms: lengths that join, joints that show, crowns that differ."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.edging.hedges import DEPTH, LENGTH, SHOOTS, hedge_length, hedge_tops
from pipeline.production.edging.masonry import wall_stone
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


@pytest.mark.parametrize("level", range(len(SHOOTS)))
def test_leaves_close_both_ends_of_a_hedge(level: int) -> None:
    shape = hedge_length(2, level)
    leaves = shape.vertices[shape.foliage].mean(axis=1)
    inner = (np.abs(leaves[:, 2]) < 0.2 * DEPTH) & (leaves[:, 1] < 0.7)
    for end in (-1.0, 1.0):
        # The dark inside ends at 0.54 of a length.
        outside = end * leaves[:, 0] > 0.54 * LENGTH
        # In squares of 0.15 by 0.2 m, where the dark inside would be seen.
        cells, *_ = np.histogram2d(
            *leaves[inner & outside][:, [1, 2]].T,
            bins=(3, 2),
            range=((0.05, 0.65), (-0.2 * DEPTH, 0.2 * DEPTH)),
        )
        # The leaves of far ones are larger than these squares.
        assert (cells >= (3, 3, 1)[level]).sum() >= (6, 6, 4)[level]


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


@pytest.mark.parametrize("across", [3, 4, 7])
def test_stones_of_a_wall_are_dark_where_they_meet(across: int) -> None:
    stone = wall_stone(3, across)
    rim = np.sort(np.abs(stone.vertices), axis=1)[:, 1]
    light = stone.colors.mean(axis=1)
    assert light[rim > 0.42].mean() < 0.55 * light[rim < 0.2].mean()
