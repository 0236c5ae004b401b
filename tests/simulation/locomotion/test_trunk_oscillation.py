"""Trunk oscillation: pitch and roll by gait, against numerically integrated forces."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.locomotion.body_motion.trunk_oscillation import (
    MAX_PITCH,
    MAX_ROLL,
    PITCH_FRACTION,
    TrunkOscillation,
)
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.named_gaits import LegRows, available_gaits
from pipeline.simulation.spatial import Array

PHASES = np.arange(4096) / 4096
HIPS = np.array([[0.5, 0, -0.2], [-0.4, 0, -0.2], [0.5, 0, 0.2], [-0.4, 0, 0.2]])
MASS = MassProperties(80.0, np.array([0.05, 0.0, 0.0]), np.diag([4.0, 12.0, 11.0]))


def integrated_pitch(gait: Gait, cycle: float) -> Array:
    """Return the pitch by half-sine forces, integrated twice by the trapezoidal rule."""
    into = np.mod(PHASES[:, None] - gait.down, 1.0)
    pushes = np.where(into < gait.duty, np.sin(np.pi * into / gait.duty), 0.0)
    force = MASS.mass * GRAVITY * pushes / pushes.mean(axis=0) / len(HIPS)
    torque = (force * (HIPS[:, 0] - MASS.centre[0])).sum(axis=1)
    value = torque / MASS.inertia[2, 2]
    for _ in range(2):
        value = value - value.mean()
        value = np.cumsum(value + np.roll(value, 1)) * 0.5 * cycle / len(PHASES)
    return PITCH_FRACTION * (value - value.mean())


def test_pitch_is_the_torque_integrated_twice() -> None:
    """The cycle is so short that no bound applies."""
    gait = Gait.of(np.array([0.5, 0.0, 0.43, 0.1]), 0.25)
    trunk = TrunkOscillation.of(gait, HIPS, MASS, 0.12)
    pitch, _ = trunk.at(PHASES)
    expected = integrated_pitch(gait, 0.12)
    assert 0.0 < np.abs(expected).max() < 0.3 * MAX_PITCH
    assert np.abs(pitch - expected).max() < 0.02 * np.abs(expected).max()


def test_half_duty_is_not_singular() -> None:
    near, at = (
        TrunkOscillation.of(Gait.of(np.array([0.5, 0.0, 0.5, 0.0]), duty), HIPS, MASS, 0.2)
        for duty in (0.4999, 0.5)
    )
    np.testing.assert_allclose(near.pitch, at.pitch, atol=1e-4)


def test_three_stance_feet_keep_the_body_level() -> None:
    gait = Gait.of(np.array([0.0, 0.25, 0.5, 0.75]), 0.8)
    trunk = TrunkOscillation.of(gait, HIPS, MASS, 1.0)
    assert not trunk.pitch.any()
    assert not trunk.roll.any()


def rocking(figure: Figure, name: str) -> tuple[float, float]:
    """Greatest pitch and roll [degrees] of a horse in a gait, at a cycle of 0.6 s."""
    skeleton = figure.skeleton
    legs = LimbBatch.of([(skeleton, limb) for limb in skeleton.legs])
    rows = LegRows.of([leg.side for leg in skeleton.legs], legs.places[:, 0, 0].tolist())
    trunk = TrunkOscillation.of(
        available_gaits(rows)[name], legs.places[:, 0], FigureMass(figure).at_rest, 0.6
    )
    pitch, roll = (np.degrees(np.abs(angle)).max() for angle in trunk.at(PHASES))
    return float(pitch), float(roll)


def test_gallops_rock_more_than_trots(library: Callable[[str], Figure]) -> None:
    horse = library("horse")
    found = {
        name: rocking(horse, name)
        for name in ("trot", "pace", "canter", "transverse gallop", "rotary gallop", "bound")
    }
    assert max(found["trot"]) < 0.3
    for name in ("canter", "transverse gallop", "rotary gallop", "bound"):
        assert found[name][0] > 5.0 * max(found["trot"])
    assert found["bound"][0] > found["transverse gallop"][0] > found["canter"][0]
    assert found["bound"][1] < 1e-4
    assert found["pace"][1] > 1.0 > found["pace"][0]


def test_rocking_is_bounded() -> None:
    gait = Gait.of(np.array([0.5, 0.0, 0.4, 0.1]), 0.25)
    pitch, roll = TrunkOscillation.of(gait, HIPS, MASS, 30.0).at(PHASES)
    assert 0.9 * MAX_PITCH < np.abs(pitch).max() <= 1.001 * MAX_PITCH
    assert 0.9 * MAX_ROLL < np.abs(roll).max() <= 1.001 * MAX_ROLL


@pytest.mark.parametrize("turns", [1.0, 40.0])
def test_oscillation_is_periodic(turns: float) -> None:
    trunk = TrunkOscillation.of(Gait.of(np.array([0.5, 0.0, 0.4, 0.1]), 0.25), HIPS, MASS, 0.6)
    there, again = trunk.at(PHASES), trunk.at(PHASES + turns)
    np.testing.assert_allclose(there, again, atol=1e-12)
