"""Carriage: what creatures do beside their legs, all of it together.

Heads look where they are to and stay level, tails and feelers sway and wander; then all of
them trail behind what they hang on. It is worked out for many rows at once, in their order:
springs remember the row before.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.curves import hinge
from pipeline.simulation.figures.network import ARM
from pipeline.simulation.locomotion.body_motion.damped_springs import Oscillators, Trailing
from pipeline.simulation.locomotion.body_motion.follow_through import FollowThrough
from pipeline.simulation.locomotion.body_motion.gaze import (
    BodyMotion,
    Gaze,
    gaze_angles,
    looks_ahead,
)
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.route import heading_vector
from pipeline.simulation.spatial import Array, cross, turn
from pipeline.simulation.terrain import Ground

SOON = 0.2
"""How long before they are there ends of limbs are raised [s]."""

ROUNDED = 0.1
"""Height above the ground at which a limb begins to rise, in its length."""

LIFTS = 0.05
"""Least part of its length by which a limb's joints have to lift it to be used at all."""


class LimbClearance:
    """What the joints of a herd do to keep limbs off the ground.

    Attributes:
        herd: the creatures.
        ground: what they go over.
    """

    def __init__(self, herd: Herd, idlers: FreeJoints, ground: Ground) -> None:
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

    def wishes(self, rows: BodyMotion, others: Array) -> Array:
        """Return what joints (n, M) do for it, beside what they do otherwise (n, M) [rad]."""
        if self._is_level or not len(self._owner):
            return np.zeros_like(others)
        own, herd = self._owner, self.herd
        p = rows.p_WB[:, own] + turn(rows.R_WB[:, own], self._tips)
        lifts = others[:, self._joints] * self._lift
        y = p[..., 1] + np.add.reduceat(lifts, self._first, axis=1)
        speed = (herd.stride / herd.cycle * rows.drive)[:, own]
        along = heading_vector(rows.turned)[:, own]
        low = np.zeros(p.shape[:2])
        # Under the back of what is at the end, under its middle, and where it will be soon.
        for out in (-self._radius, 0.0 * speed, self._radius + SOON * speed):
            x, z = p[..., 0] + out * along[..., 0], p[..., 2] + out * along[..., 1]
            high = self.ground.height(x, z) + self._radius
            low = np.maximum(low, hinge(high - y, self._width))
        result = np.zeros_like(others)
        result[:, self._joints] = low[:, self._limb] * self._turn
        return result


QUICKEST = 0.15
"""How fast heads are turned at most, in the frequencies of the necks' springs [rad]."""

NECK_DAMPING = 0.8
"""Ratio to the critical damping with which a head comes to where it is to look."""

ROUNDS = 3
"""In which eyes that look at something come to where they look from."""


class FreeLimbMotion:
    """The carriage of a herd of C creatures with M joints that carry nothing.

    Attributes:
        herd: the creatures.
        idlers: the joints.
        clearing: what keeps limbs off the ground.
        gaze: the heads, H of them.
        overlap: what trails.
    """

    def __init__(self, herd: Herd, idlers: FreeJoints, ground: Ground, dt: float) -> None:
        self.herd, self.idlers = herd, idlers
        self.clearing = LimbClearance(herd, idlers, ground)
        self.gaze = Gaze(herd.figures, idlers.numbers)
        self.overlap = FollowThrough(idlers.tree, idlers.room, idlers.owner, idlers.limbs, dt)
        frequency = self.overlap.springs.frequency[self.gaze.numbers[:, 0]]
        self._look = Trailing(Oscillators(frequency, np.full_like(frequency, NECK_DAMPING), dt))
        self._most = QUICKEST * frequency[:, None] * dt
        self._last: Array | None = None

    def values(self, rows: BodyMotion) -> Array:
        """Return the values of the joints (n, M), for rows one after the other [rad or m]."""
        idlers, gaze = self.idlers, self.gaze
        wanders = idlers.wanders(rows.time, rows.bearing)
        wishes = idlers.sways(rows.phase, rows.drive, rows.bearing) + wanders
        heads, joints = self._heads(rows, wanders), gaze.necks.is_joint
        wishes[:, gaze.numbers[joints]] = heads[:, joints]
        wishes += self.clearing.wishes(rows, wishes)
        trailing = self.overlap.trail(wishes, rows.R_WB, rows.p_WB, rows.bearing.looseness)
        return idlers.room.at(trailing)

    def _heads(self, rows: BodyMotion, wanders: Array) -> Array:
        """Return what the joints of necks (n, H, k) do [rad]."""
        gaze = self.gaze
        R = rows.R_WB[:, gaze.owner]
        tilt = np.arcsin(np.clip(R[..., 1, 0], -1.0, 1.0)), np.arctan2(-R[..., 1, 2], R[..., 1, 1])
        raised = rows.bearing.head_raise[:, gaze.owner]
        own, wander = raised[..., None] * gaze.neck, wanders[:, gaze.numbers]
        looks = self._looks(rows)
        if any(rows.looks):
            # A neck takes the eyes elsewhere, from where a near thing is seen elsewhere.
            for _ in range(ROUNDS):
                looks = self._looks(rows, gaze.eyes(gaze.wishes(looks, tilt, own)))
        looks = self._followed(looks)
        looks[..., 0] += (wander * gaze.yaw).sum(axis=-1)
        looks[..., 1] += (wander * gaze.neck).sum(axis=-1) + gaze.nods * raised
        return gaze.wishes(looks, tilt, own)

    def _looks(self, rows: BodyMotion, eyes: Array | None = None) -> Array:
        """Return where heads are to look (n, H, 2), see `gaze_angles` [rad].

        Args:
            rows: what is known of them.
            eyes: (n, H, 3) where they are, if that is known [m].
        """
        gaze, looks = self.gaze, np.zeros((len(rows.time), len(self.gaze.owner), 2))
        for h, c in enumerate(gaze.owner):
            if looks_ahead(rows, int(c)):
                continue
            head = gaze.necks.places[h, 0], gaze.end[h]
            own = None if eyes is None else eyes[:, h]
            looks[:, h, 0], looks[:, h, 1] = gaze_angles(
                self.herd, rows, int(c), head, float(gaze.most[h]), own
            )
        return looks

    def _followed(self, wanted: Array) -> Array:
        """Return where heads look (n, H, 2) that follow at no more than a certain speed [rad]."""
        goals, least = np.empty_like(wanted), -self._most
        if self._last is not None and (wanted == self._last).all():
            # Most look straight ahead all the time.
            return wanted + self._look.follow(wanted)
        for row, goal in enumerate(wanted):
            before = goal if self._last is None else self._last
            ahead = goal - before
            np.minimum(np.maximum(ahead, least, out=ahead), self._most, out=ahead)
            goals[row] = self._last = before + ahead
        return goals + self._look.follow(goals)
