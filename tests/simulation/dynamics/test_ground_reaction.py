"""Ground reaction: how feet share a load, by hand and against least squares."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.simulation.dynamics.ground_reaction import GroundReaction, ground_reaction
from pipeline.simulation.spatial import Array

WEIGHT = np.array([[0.0, 100.0, 0.0]])


def react_to_weight(points: list[list[float]], moment: Array | None = None) -> GroundReaction:
    """Return the reaction of feet, all down, to a weight at the origin."""
    stands = np.ones((1, len(points)), dtype=bool)
    moments = np.zeros((1, 3)) if moment is None else moment
    return ground_reaction(np.array([points]), stands, WEIGHT, moments)


def test_two_feet_share_a_load_by_the_lever_rule() -> None:
    reaction = react_to_weight([[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0]])
    assert reaction.forces[0, :, 1] == pytest.approx([75.0, 25.0])
    assert np.abs(reaction.moment).max() < 1e-12


def test_a_single_foot_carries_the_whole_force() -> None:
    reaction = react_to_weight([[0.2, -1.0, -0.1]])
    assert np.allclose(reaction.forces[0, 0], WEIGHT[0])
    assert np.allclose(reaction.moment[0], -np.cross([0.2, -1.0, -0.1], WEIGHT[0]))


def test_feet_only_push_and_leave_a_moment_unbalanced() -> None:
    """Of three feet in a row all on one side, the nearest carries everything."""
    reaction = react_to_weight([[0.5, -1.0, 0.0], [1.0, -1.0, 0.0], [2.0, -1.0, 0.0]])
    assert reaction.forces[0, :, 1] == pytest.approx([100.0, 0.0, 0.0])
    assert np.allclose(reaction.moment[0], [0.0, 0.0, -50.0])


def test_feet_in_the_air_carry_nothing() -> None:
    reaction = ground_reaction(
        np.zeros((1, 2, 3)), np.zeros((1, 2), dtype=bool), WEIGHT, np.ones((1, 3))
    )
    assert not reaction.forces.any()
    assert np.allclose(reaction.force, WEIGHT)
    assert np.allclose(reaction.moment, 1.0)


@given(seed=st.integers(0, 2**32 - 1), feet=st.integers(1, 8))
def test_the_force_is_balanced_and_the_moment_as_well_as_possible(seed: int, feet: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(4, feet, 3))
    stands = rng.random((4, feet)) < 0.8
    force, moment = rng.normal(size=(2, 4, 3)) + 20.0 * np.array([0.0, 1.0, 0.0])
    reaction = ground_reaction(points, stands, force, moment)
    down = stands.any(axis=1)
    assert np.allclose(reaction.force[down], 0.0)
    assert not reaction.forces[~stands].any()
    assert (reaction.forces[..., 1] >= -1e-9).all() or feet == 1
    for k in np.flatnonzero(down):
        # No other distribution over the loaded feet leaves a smaller moment.
        own = np.flatnonzero(np.abs(reaction.forces[k]).max(axis=-1))
        arms = [np.cross(points[k, i], axis) for i in own for axis in np.eye(3)]
        wide = np.concatenate([np.tile(np.eye(3), len(own)) * 1e4, np.transpose(arms)])
        wanted = np.concatenate([force[k] * 1e4, moment[k]])
        best, *_ = np.linalg.lstsq(wide, wanted, rcond=1e-12)
        left = float(np.linalg.norm(wide[3:] @ best - moment[k]))
        assert np.linalg.norm(reaction.moment[k]) <= left * (1 + 1e-5) + 1e-5
