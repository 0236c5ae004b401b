"""Forces: what legs give to slow a fall and to push off, constant within a phase.

From a change of velocity and a change of height follow the time, Δt = 2 Δy / (v_y0 + v_y1), the
acceleration, A = ΔV / Δt, and the force of all legs together, F = m (A - G).

Source: Sims 1987, 11.2 and 11.3; (11.5) is y_c - y_0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.spin import Vector
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, slots=True)
class Drive:
    """A constant force, and what it does.

    Attributes:
        force: of all legs together [N].
        acceleration: of the centre of mass [m/s²].
        time: how long it takes to change the vertical speed as asked; infinite if it cannot [s].
        saturated: whether more was asked for than legs have.
    """

    force: Vector
    acceleration: Vector
    time: float
    saturated: bool


def drive(mass: float, most: float, v0: Vector, v1: Vector, rise: float) -> Drive:
    """Return the force that changes the velocity within a change of height.

    Args:
        mass: [kg].
        most: force of all legs that touch [N].
        v0: velocity now [m/s].
        v1: velocity wanted [m/s]; v0_y + v1_y has the sign of `rise`.
        rise: change of height [m].
    """
    time = 2.0 * rise / (v0[1] + v1[1])
    x, y, z = ((b - a) / time for a, b in zip(v0, v1, strict=True))
    force = mass * x, mass * (y + GRAVITY), mass * z
    size = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    if size <= most:
        return Drive(force, (x, y, z), time, False)
    k = most / size
    force = k * force[0], k * force[1], k * force[2]
    x, y, z = force[0] / mass, force[1] / mass - GRAVITY, force[2] / mass
    change = v1[1] - v0[1]
    return Drive(force, (x, y, z), change / y if change * y > 0.0 else math.inf, True)


def shared(force: Array, moment: Array, levers: Array, most: float) -> Array:
    """Return the forces (n, 3) of legs: equal parts, and what of a moment their hips allow.

    The rest of the moment, all of it for one leg, is a torque at the hips, in equal parts. No
    leg pulls, and none gives more than `most`.

    Args:
        force: (3,) of all legs together [N].
        moment: (3,) that they are to give besides [N m].
        levers: (n, 3) hips of the legs that touch, from the centre of mass, in the world [m].
        most: of one leg [N].
    """
    count = len(levers)
    equal = np.tile(force / count, (count, 1))
    arms = levers - levers.mean(axis=0)
    spread = np.stack([np.ones(count), -arms[:, 2], arms[:, 0]])
    # L × (0, f, 0) = (-L_z f, 0, L_x f): f of least squares that add up to nothing.
    wanted = np.array([0.0, moment[0], moment[2]])
    couple = np.linalg.pinv(spread, rcond=1e-9) @ wanted
    couple -= couple.mean()
    size = float(np.sqrt((equal[0] ** 2).sum()))
    room = min(max(most - size, 0.0), float(equal[0, 1]))
    greatest = float(np.abs(couple).max(initial=0.0))
    part = min(1.0, room / greatest) if greatest > 0.0 else 0.0
    equal[:, 1] += part * couple
    return equal
