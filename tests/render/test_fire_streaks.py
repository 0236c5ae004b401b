"""Sparks: they rise from their fire, are continuous in time, and glow no more than it does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from render.fire_streaks import fire_streaks, streak_spheres
from render.plume import Plume

FIRE = Plume("flame", (1.0, 0.2, -2.0), 0.3, 1.2, 2.0, (0.3, 0.1), (1.0, 0.2, 0.01), 11.0, 3)


def test_sparks_rise_from_their_fire() -> None:
    times = np.linspace(0.0, 9.0, 40)
    found = [fire_streaks(FIRE, t) for t in times]
    heads = np.concatenate([one.head for one in found])
    assert (np.linalg.norm(heads - FIRE.p_WP, axis=-1) < 3.5 * FIRE.height).all()
    for one in found:
        middle, radius = np.split(streak_spheres(one), [3], axis=1)
        for end in (one.head, one.tail):
            assert (np.linalg.norm(end - middle, axis=-1) < radius[:, 0]).all()
    flies = np.concatenate([(one.head != one.tail).any(axis=-1) for one in found])
    rise = np.concatenate([one.head[:, 1] - one.tail[:, 1] for one in found])
    assert 0.1 < flies.mean() < 0.9
    assert (rise[flies] > 0.0).all()
    assert heads[:, 1].max() > FIRE.p_WP[1] + 1.2 * FIRE.height


def test_a_spark_is_where_it_was_a_moment_ago() -> None:
    before, after = fire_streaks(FIRE, 4.0), fire_streaks(FIRE, 4.001)
    moved = np.linalg.norm(after.head - before.head, axis=-1)
    # A few are spent and begin again at the foot.
    assert np.quantile(moved, 0.9) < 0.01
    assert (fire_streaks(FIRE, 4.0).radiance == before.radiance).all()


def test_larger_fires_have_more_sparks_and_those_of_another_seed_are_others() -> None:
    torch = replace(FIRE, radius=0.06, height=0.4)
    assert 1 < len(fire_streaks(torch, 1.0).radius) < 0.4 * len(fire_streaks(FIRE, 1.0).radius)
    other = fire_streaks(replace(FIRE, seed=4), 1.0)
    assert not np.allclose(other.head, fire_streaks(FIRE, 1.0).head)
    dark = fire_streaks(replace(FIRE, glow=0.0), 1.0)
    assert dark.radiance.max() == 0.0 < other.radiance.min(axis=-1).max()
