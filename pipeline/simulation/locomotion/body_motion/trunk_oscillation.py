"""Trunk: how bodies pitch and roll under the forces of their own legs.

Each foot that stands bears the body for its stance, all feet alike over a cycle. A force
in front of the centre of mass lifts the nose, one beside it rolls the body; legs that
stand together on either side, as in a trot, leave it level, and those that stand one after
the other, as in a gallop, rock it. The angle is what two integrations over a cycle make of
the torque. While three feet are down they hold the body as legs do a table.

With m g / n the mean force of each of n legs and d the part of a cycle that its foot is
down, the force is a half-sine, and its coefficient at k times the cycle's frequency is

    c_k = m g / n  cos(π k d) / (1 - (2 k d)²)  e^(-2πik φ),

φ being the phase in the middle of the stance.

Source: Sims 1987, 10.1, for what a body does with the gait; Alexander 1989 for the half-sine.
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
from pipeline.simulation.locomotion.gaits.gait_transition import PaceSchedule
from pipeline.simulation.locomotion.gaits.pace import Pace
from pipeline.simulation.spatial import Array

HARMONICS = np.arange(1, 7)
"""Of the cycle, which count; what is faster moves a body by less than a tenth of a degree."""

MOST_PITCH, MOST_ROLL = math.radians(8.0), math.radians(4.0)
"""A muscled body holds itself: it does not rock farther."""

PITCHES, ROLLS = 0.5, 0.2
"""Parts of the torques that move the body: legs push towards the centre of mass rather than
straight up, and more so from the sides."""

HOLD = 3
"""Feet that hold a body."""

MOMENTS = 256
"""Of a cycle, at which it is looked at."""

Wave = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class TrunkOscillation:
    """How one body rocks over a cycle, or several do.

    Attributes:
        pitch: (..., K) coefficients of its pitch, nose up, at the harmonics [rad].
        roll: (..., K) those of its roll about its X, which points ahead [rad].
    """

    pitch: Wave
    roll: Wave

    @staticmethod
    def of(gait: Gait, hips: Array, mass: MassProperties, cycle: float) -> TrunkOscillation:
        """Return how a body rocks in a gait.

        Args:
            gait: phases of its legs.
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
        moments = (np.arange(MOMENTS) + 0.5) / MOMENTS
        free = float((gait.standing(moments).sum(axis=-1) < HOLD).mean())
        return TrunkOscillation(
            _within(MOST_PITCH, -free * PITCHES * about_z / speed**2),
            _within(MOST_ROLL, -free * ROLLS * about_x / speed**2),
        )

    @staticmethod
    def still(*shape: int) -> TrunkOscillation:
        """Return the trunk, or several, that does not rock."""
        none = np.zeros((*shape, len(HARMONICS)), dtype=complex)
        return TrunkOscillation(none, none.copy())

    def at(self, phase: Array, which: NDArray[np.int64] | None = None) -> tuple[Array, Array]:
        """Return pitch and roll (N,) [rad] at phases (N,).

        Args:
            phase: of the gait.
            which: (N,) of several trunks; leave it out for one.
        """
        angle = 2.0 * np.pi * HARMONICS * np.mod(phase, 1.0)[:, None]
        cosine, sine = np.cos(angle), np.sin(angle)
        pitch, roll = (
            2.0 * (wave.real * cosine - wave.imag * sine).sum(axis=-1)
            for wave in (
                (self.pitch, self.roll) if which is None else (self.pitch[which], self.roll[which])
            )
        )
        return pitch, roll

    def put(self, c: int, other: TrunkOscillation) -> None:
        """Let the trunk number `c` of several rock as `other` does from now on."""
        self.pitch[c], self.roll[c] = other.pitch, other.roll


class HerdTrunks:
    """How the bodies of a herd rock, also while they go over into other gaits.

    Attributes:
        paces: how they go.
    """

    def __init__(self, paces: PaceSchedule) -> None:
        self.paces = paces
        herd = paces.herd
        self._masses: dict[tuple[str, float], MassProperties] = {}
        self._first = TrunkOscillation.still(len(herd.names))
        for c in np.flatnonzero(herd.walks):
            self._first.put(int(c), self._of(int(c), herd.paces[c]))
        self._later: dict[int, list[tuple[TrunkOscillation, TrunkOscillation]]] = {}

    def at(self, phase: Array, creature: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return pitch and roll (N,) of creatures (N,) [rad] at phases (N,) of their gaits."""
        pitch, roll = self._first.at(phase, creature)
        for c, changes in self.paces.changes.items():
            own = creature == c
            for change, (before, after) in zip(changes, self._changes(c), strict=True):
                done = change.done(phase[own])
                (p0, r0), (p1, r1) = before.at(phase[own]), after.at(phase[own])
                pitch[own] += done * (p1 - p0)
                roll[own] += done * (r1 - r0)
        return pitch, roll

    def _changes(self, c: int) -> list[tuple[TrunkOscillation, TrunkOscillation]]:
        """Return how a body rocks before and after each of its changes of pace."""
        known = self._later.setdefault(c, [])
        for change in self.paces.changes[c][len(known) :]:
            known.append((self._of(c, change.before), self._of(c, change.after)))
        return known

    def _of(self, c: int, pace: Pace) -> TrunkOscillation:
        herd = self.paces.herd
        # One figure at one scale is the same for all who share it.
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


def _within(most: float, wave: Wave) -> Wave:
    """Return the wave made smaller, as a whole, so that it stays within ±`most` [rad]."""
    none = np.zeros_like(wave)
    highest = float(np.abs(TrunkOscillation(wave, none).at(np.arange(MOMENTS) / MOMENTS)[0]).max())
    if highest == 0.0:
        return wave
    result: Wave = wave * float(most * bounded(np.array(highest / most)) / highest)
    return result
