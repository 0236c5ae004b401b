"""How feet share a load: by hand, and against least squares."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.simulation.dynamics.ground_reaction import GroundReaction, ground_reaction
from pipeline.simulation.spatial import Array

WEIGHT = np.array([[0.0, 100.0, 0.0]])


def carried(points: list[list[float]], moment: Array | None = None) -> GroundReaction:
    """Return how feet, all down, carry a weight at the origin."""
    stands = np.ones((1, len(points)), dtype=bool)
    about = np.zeros((1, 3)) if moment is None else moment
    return ground_reaction(np.array([points]), stands, WEIGHT, about)


def test_two_feet_share_by_the_lever() -> None:
    borne = carried([[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0]])
    assert borne.forces[0, :, 1] == pytest.approx([75.0, 25.0])
    assert np.abs(borne.moment).max() < 1e-12


def test_a_foot_alone_passes_the_force_on() -> None:
    borne = carried([[0.2, -1.0, -0.1]])
    assert np.allclose(borne.forces[0, 0], WEIGHT[0])
    assert np.allclose(borne.moment[0], -np.cross([0.2, -1.0, -0.1], WEIGHT[0]))


def test_no_foot_pulls_and_the_rest_stays_unbalanced() -> None:
    """Of three feet in a row all on one side, the nearest carries everything."""
    borne = carried([[0.5, -1.0, 0.0], [1.0, -1.0, 0.0], [2.0, -1.0, 0.0]])
    assert borne.forces[0, :, 1] == pytest.approx([100.0, 0.0, 0.0])
    assert np.allclose(borne.moment[0], [0.0, 0.0, -50.0])


def test_in_the_air_nobody_carries() -> None:
    borne = ground_reaction(
        np.zeros((1, 2, 3)), np.zeros((1, 2), dtype=bool), WEIGHT, np.ones((1, 3))
    )
    assert not borne.forces.any()
    assert np.allclose(borne.force, WEIGHT)
    assert np.allclose(borne.moment, 1.0)


@given(seed=st.integers(0, 2**32 - 1), feet=st.integers(1, 8))
def test_all_of_the_force_and_the_best_of_the_moment(seed: int, feet: int) -> None:
    chance = np.random.default_rng(seed)
    points = chance.normal(size=(4, feet, 3))
    stands = chance.random((4, feet)) < 0.8
    force, moment = chance.normal(size=(2, 4, 3)) + 20.0 * np.array([0.0, 1.0, 0.0])
    borne = ground_reaction(points, stands, force, moment)
    down = stands.any(axis=1)
    assert np.allclose(borne.force[down], 0.0)
    assert not borne.forces[~stands].any()
    assert (borne.forces[..., 1] >= -1e-9).all() or feet == 1
    for k in np.flatnonzero(down):
        # Among those feet that bear, no other share leaves less.
        own = np.flatnonzero(np.abs(borne.forces[k]).max(axis=-1))
        arms = [np.cross(points[k, i], axis) for i in own for axis in np.eye(3)]
        wide = np.concatenate([np.tile(np.eye(3), len(own)) * 1e4, np.transpose(arms)])
        wanted = np.concatenate([force[k] * 1e4, moment[k]])
        best, *_ = np.linalg.lstsq(wide, wanted, rcond=1e-12)
        left = float(np.linalg.norm(wide[3:] @ best - moment[k]))
        assert np.linalg.norm(borne.moment[k]) <= left * (1 + 1e-5) + 1e-5
