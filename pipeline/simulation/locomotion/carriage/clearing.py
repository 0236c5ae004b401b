"""Clearing: heads, feelers and tails are kept out of ground that rises around a body.

Legs carry a body over the ground; what reaches beyond its feet would go into a slope before
they are on it. Where the end of a limb is to come too low, now or in a moment, its joints
raise it, by what each of them lifts it.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.curves import hinge
from pipeline.simulation.figures.network import ARM
from pipeline.simulation.locomotion.carriage.idle import Idlers
from pipeline.simulation.locomotion.carriage.looking import Rows
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.ways.route import direction
from pipeline.simulation.spatial import Array, cross, turn
from pipeline.simulation.terrain import Ground

SOON = 0.2
"""How long before they are there ends of limbs are raised [s]."""

ROUNDED = 0.1
"""Height above the ground at which a limb begins to rise, in its length."""

LIFTS = 0.05
"""Least part of its length by which a limb's joints have to lift it to be used at all."""


class Clearing:
    """What the joints of a herd do to keep limbs off the ground.

    Attributes:
        herd: the creatures.
        ground: what they go over.
    """

    def __init__(self, herd: Herd, idlers: Idlers, ground: Ground) -> None:
        self.herd, self.ground = herd, ground
        tree, found = idlers.tree, []
        rest = tree.pose(idlers.room.preferred)
        for limb in idlers.limbs:
            own = list(limb.joints)
            X = rest[own]
            tip = X[-1, :3, 3] + X[-1, :3, :3] @ (limb.tip - tree.places[own[-1]])
            lift = cross(turn(X[:, :3, :3], tree.axes[own]), tip - X[:, :3, 3])[:, 1]
            lift = np.where(tree.prismatic[own], 0.0, lift)
            square = float((lift * lift).sum())
            if limb.kind != ARM and square > (LIFTS * limb.length) ** 2:
                found.append((idlers.owner[own[0]], tip, limb, own, lift))
        self._owner = np.array([c for c, *_ in found], dtype=np.int64)
        self._tips = np.array([tip for _, tip, *_ in found]).reshape(-1, 3)
        self._width = ROUNDED * np.array([limb.length for _, _, limb, *_ in found])
        self._radius = np.array([limb.tip_radius for _, _, limb, *_ in found])
        # Joints of these limbs, one limb after the other: how far they lift its end, and turn
        # a metre that it is to be raised.
        counts = [len(own) for *_, own, _ in found]
        self._joints = np.array([j for *_, own, _ in found for j in own], dtype=np.int64)
        self._limb = np.repeat(np.arange(len(found)), counts)
        self._first = np.cumsum([0, *counts[:-1]])
        self._lift = np.concatenate([lift for *_, lift in found]) if found else np.zeros(0)
        self._turn = np.concatenate([v / (v @ v) for *_, v in found]) if found else np.zeros(0)
        self._is_level = float(np.ptp(ground.field.heights)) == 0.0

    def wishes(self, rows: Rows, others: Array) -> Array:
        """Return what joints (n, M) do for it, beside what they do otherwise (n, M) [rad]."""
        if self._is_level or not len(self._owner):
            return np.zeros_like(others)
        own, herd = self._owner, self.herd
        p = rows.p_WB[:, own] + turn(rows.R_WB[:, own], self._tips)
        lifts = others[:, self._joints] * self._lift
        y = p[..., 1] + np.add.reduceat(lifts, self._first, axis=1)
        speed = (herd.stride / herd.cycle * rows.drive)[:, own]
        along = direction(rows.turned)[:, own]
        low = np.zeros(p.shape[:2])
        # Under the back of what is at the end, under its middle, and where it will be soon.
        for out in (-self._radius, 0.0 * speed, self._radius + SOON * speed):
            x, z = p[..., 0] + out * along[..., 0], p[..., 2] + out * along[..., 1]
            high = self.ground.height(x, z) + self._radius
            low = np.maximum(low, hinge(high - y, self._width))
        result = np.zeros_like(others)
        result[:, self._joints] = low[:, self._limb] * self._turn
        return result
