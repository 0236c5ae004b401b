"""Trunk oscillation: how bodies pitch and roll under the forces of their own legs.

Each standing foot bears the body, all feet alike over a cycle. A force in front of the centre of
mass lifts the nose, one beside it rolls the body; legs that stand together on either side, as in a
trot, leave it level, and legs that stand one after the other, as in a gallop, rock it. The angle is
the torque integrated twice over a cycle. While three feet are down they hold the body like a table.

With m g / n the mean force of each of n legs and d its duty factor, the force is a half-sine, and
its coefficient at k times the cycle's frequency is

    c_k = m g / n  cos(π k d) / (1 - (2 k d)²)  e^(-2πik φ),

φ being the phase in the middle of the stance.

Source: Sims 1987, 10.1, for bodies that move with the gait; Alexander 1989 for the half-sine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import bounded
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.pace import Pace
from pipeline.simulation.locomotion.gaits.pace_schedule import PaceSchedule
from pipeline.simulation.spatial import Array

# Harmonics of the cycle; faster ones move a body by less than a tenth of a degree.
HARMONICS = np.arange(1, 7)

# Greatest pitch and roll: a muscled body holds itself [rad].
MAX_PITCH, MAX_ROLL = math.radians(8.0), math.radians(4.0)

# Parts of the torques that move the body: legs push towards the centre of mass rather than straight
# up, and more so from the sides.
PITCH_FRACTION, ROLL_FRACTION = 0.5, 0.2

# Number of feet that hold a body like a table.
HOLDING_FEET = 3

# Samples of a cycle.
SAMPLES = 256

Wave = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class TrunkOscillation:
    """The oscillation of one body, or several, over a cycle.

    Attributes:
        pitch: (..., K) coefficients of the pitch, nose up, at the harmonics [rad].
        roll: (..., K) coefficients of the roll about X, which points ahead [rad].
    """

    pitch: Wave
    roll: Wave

    @staticmethod
    def of(gait: Gait, hips: Array, mass: MassProperties, cycle: float) -> TrunkOscillation:
        """Return the oscillation of a body in a gait.

        Args:
            gait: of its legs.
            hips: (n, 3) bases of its legs [m].
            mass: of the whole figure, in the same frame.
            cycle: duration [s].
        """
        arms = hips - mass.centre
        k = HARMONICS[:, None]
        turned = np.exp(-2j * np.pi * k * (gait.down + 0.5 * gait.duty))
        weight = mass.mass * GRAVITY / max(len(hips), 1)
        forces = weight * _half_sine(k * gait.duty) * turned
        speed = 2.0 * np.pi * HARMONICS / cycle
        # Up at x turns about +Z by x F, up at z about -X by z F.
        about_z = (forces * arms[:, 0]).sum(axis=-1) / mass.moment(np.array([0.0, 0.0, 1.0]))
        about_x = -(forces * arms[:, 2]).sum(axis=-1) / mass.moment(np.array([1.0, 0.0, 0.0]))
        samples = (np.arange(SAMPLES) + 0.5) / SAMPLES
        free = float((gait.standing(samples).sum(axis=-1) < HOLDING_FEET).mean())
        return TrunkOscillation(
            _limited(MAX_PITCH, -free * PITCH_FRACTION * about_z / speed**2),
            _limited(MAX_ROLL, -free * ROLL_FRACTION * about_x / speed**2),
        )

    @staticmethod
    def none(*shape: int) -> TrunkOscillation:
        """Return no oscillation, of one body or several."""
        zero = np.zeros((*shape, len(HARMONICS)), dtype=complex)
        return TrunkOscillation(zero, zero.copy())

    def at(self, phase: Array, number: NDArray[np.int64] | None = None) -> tuple[Array, Array]:
        """Return pitch and roll (N,) [rad] at phases (N,).

        Args:
            phase: of the gait.
            number: (N,) of several bodies; None for one.
        """
        angle = 2.0 * np.pi * HARMONICS * np.mod(phase, 1.0)[:, None]
        cosine, sine = np.cos(angle), np.sin(angle)
        waves = self.pitch, self.roll
        if number is not None:
            waves = self.pitch[number], self.roll[number]
        pitch, roll = (2.0 * (wave.real * cosine - wave.imag * sine).sum(axis=-1) for wave in waves)
        return pitch, roll


class HerdTrunks:
    """The oscillations of the bodies of a herd, also while they change their gaits."""

    def __init__(self, paces: PaceSchedule) -> None:
        self.paces = paces
        herd = paces.herd
        self._masses: dict[tuple[str, float], MassProperties] = {}
        self._first = TrunkOscillation.none(len(herd.names))
        for c in np.flatnonzero(herd.walks):
            own = self._oscillation(int(c), herd.paces[c])
            self._first.pitch[c], self._first.roll[c] = own.pitch, own.roll
        self._transitions: dict[int, list[tuple[TrunkOscillation, TrunkOscillation]]] = {}

    def at(self, phase: Array, creature: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return pitch and roll (N,) of creatures (N,) [rad] at phases (N,) of their gaits."""
        pitch, roll = self._first.at(phase, creature)
        for c, changes in self.paces.changes.items():
            own = creature == c
            known = self._transitions.setdefault(c, [])
            for change in changes[len(known) :]:
                both = change.before, change.after
                before, after = (self._oscillation(c, pace) for pace in both)
                known.append((before, after))
            for change, (before, after) in zip(changes, known, strict=True):
                done = change.done(phase[own])
                (p0, r0), (p1, r1) = before.at(phase[own]), after.at(phase[own])
                pitch[own] += done * (p1 - p0)
                roll[own] += done * (r1 - r0)
        return pitch, roll

    def _oscillation(self, c: int, pace: Pace) -> TrunkOscillation:
        herd = self.paces.herd
        figure = herd.figures[c]
        key = figure.name, figure.scale
        if key not in self._masses:
            self._masses[key] = FigureMass(figure).at_rest
        hips = herd.hips[herd.owner == c][~pace.held]
        return TrunkOscillation.of(pace.carrying, hips, self._masses[key], pace.cycle)


def _half_sine(kd: Array) -> Array:
    """Return cos(π kd) / (1 - (2 kd)²), which is π/4 at kd = 1/2."""
    at_pole = np.abs(kd - 0.5) < 1e-6
    safe = np.where(at_pole, 0.0, kd)
    return np.where(at_pole, np.pi / 4.0, np.cos(np.pi * safe) / (1.0 - (2.0 * safe) ** 2))


def _limited(most: float, wave: Wave) -> Wave:
    """Return the wave scaled so that it stays within ±`most` [rad]."""
    oscillation = TrunkOscillation(wave, np.zeros_like(wave))
    highest = float(np.abs(oscillation.at(np.arange(SAMPLES) / SAMPLES)[0]).max())
    if highest == 0.0:
        return wave
    return wave * float(most * bounded(np.array(highest / most)) / highest)
