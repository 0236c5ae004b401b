"""Pops: joints that turn much faster than the motion of their foot explains.

A leg of two equal links, of length L in all, that is stretched to e L bends at
2 v / (L sqrt(1 - e²)) while its foot moves at v. A joint that is twice as fast, and faster than
300 degrees a second, draws the eye. Nearly straight and tightly folded legs do not count. The
length of a leg is that from hip to foot when it is stretched out: one that is drawn as a zigzag
and bends across it is never as long as its links together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array

LEAST_SPEED = np.radians(300.0)
"""Speed of a joint below which it does not pop [rad/s]."""

STRETCHES = 0.3, 0.97
"""Distances of the foot from the hip between which joints count, in lengths of the leg."""

BALL = 3
"""Joints of the hip, which point the leg and do not bend it."""


@dataclass(frozen=True)
class Pop:
    """A joint that pops.

    Attributes:
        leg: its name.
        row: of the take.
        speed: of the joint [rad/s].
        needed: by two equal links [rad/s].
        stretch: of the leg.
    """

    leg: str
    row: int
    speed: float
    needed: float
    stretch: float


def joint_pops(
    herd: Herd, q: Array, tips: Array, bodies: tuple[Array, Array], dt: float
) -> list[Pop]:
    """Return the pops of the legs of one creature.

    Args:
        herd: of the creature alone.
        q: (K, L, n) joint values [rad].
        tips: (K, L, 3) feet [m].
        bodies: rotations (K, 3, 3) and places (K, 3) of the body [m].
        dt: duration of a row [s].
    """
    R, p = bodies
    arm = np.einsum("kji,klj->kli", R, tips - p[:, None]) - herd.hips
    length = herd.legs.lengths
    speed = np.linalg.norm(np.gradient(arm, dt, axis=0), axis=-1)
    speed = np.maximum.reduce([speed, np.roll(speed, 1, axis=0), np.roll(speed, -1, axis=0)])
    stretch = np.linalg.norm(arm, axis=-1) / length
    needed = 2.0 * speed / (length * np.sqrt(1.0 - np.clip(stretch, 0.0, 0.99) ** 2))
    turned = np.zeros(stretch.shape)
    bends = herd.legs.is_joint[:, BALL:]
    if bends.shape[1]:
        turned[1:] = (np.abs(np.diff(q[..., BALL:], axis=0)) * bends).max(axis=-1) / dt
    low, high = STRETCHES
    hits = (turned > LEAST_SPEED) & (turned > 2.0 * needed) & (stretch > low) & (stretch < high)
    return [
        Pop(herd.leg_names[leg], int(k), turned[k, leg], needed[k, leg], stretch[k, leg])
        for k, leg in np.argwhere(hits)
    ]
