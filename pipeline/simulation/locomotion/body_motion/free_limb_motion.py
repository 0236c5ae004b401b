"""Free limb motion: heads, tails, feelers and arms, all their motions together.

Heads look and stay level, tails and feelers sway and wander and keep off the ground; then all of
them follow through. Rows are worked out in order, many at once: springs remember the row before.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.curves import hinge
from pipeline.simulation.figures.network import ARM
from pipeline.simulation.locomotion.body_motion.damped_springs import Oscillators, SpringFollower
from pipeline.simulation.locomotion.body_motion.follow_through import FollowThrough
from pipeline.simulation.locomotion.body_motion.gaze import (
    EYE_ITERATIONS,
    BodyMotion,
    Necks,
    gaze_angles,
)
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.route import heading_vector
from pipeline.simulation.spatial import Array, cross, turn
from pipeline.simulation.terrain import Ground

# Greatest speed of a head, in frequencies of the neck's springs [rad]; and damping ratio with which
# it comes to where it is to look.
MAX_HEAD_SPEED, NECK_DAMPING = 0.15, 0.8

# How long before it is there the end of a limb is raised over ground [s].
CLEARANCE_LEAD = 0.2

# Height above the ground at which a limb begins to rise, and least lift by its joints for it to be
# raised at all, in its length.
CLEARANCE_WIDTH, MIN_LIFT = 0.1, 0.05


class FreeLimbMotion:
    """The motion of a herd's free limbs.

    Attributes:
        herd: the creatures.
        joints: M free joints.
        clearance: keeps limbs off the ground.
        necks: of the heads, H of them.
        follow_through: of all limbs.
    """

    def __init__(self, herd: Herd, joints: FreeJoints, ground: Ground, dt: float) -> None:
        self.herd, self.joints = herd, joints
        self.clearance = LimbClearance(herd, joints, ground)
        self.necks = Necks(herd.figures, joints.numbers)
        self.follow_through = FollowThrough(
            joints.tree, joints.limits, joints.owner, joints.limbs, dt
        )
        frequency = self.follow_through.springs.frequency[self.necks.numbers[:, 0]]
        damping = np.full_like(frequency, NECK_DAMPING)
        self._gaze = SpringFollower(Oscillators(frequency, damping, dt))
        self._max_step = MAX_HEAD_SPEED * frequency[:, None] * dt
        self._last: Array | None = None

    def values(self, motion: BodyMotion) -> Array:
        """Return the values of the joints (n, M), for rows one after the other [rad or m]."""
        joints, necks = self.joints, self.necks
        wandering = joints.wandering(motion.time, motion.style)
        wishes = joints.swaying(motion) + joints.standing(motion) + wandering
        heads, is_joint = self._heads(motion, wandering), necks.joints.is_joint
        wishes[:, necks.numbers[is_joint]] = heads[:, is_joint]
        wishes += self.clearance.wishes(motion, wishes)
        looseness = motion.style.looseness
        wishes = self.follow_through.apply(wishes, motion.R_WB, motion.p_WB, looseness)
        return joints.limits.at(wishes)

    def _heads(self, motion: BodyMotion, wandering: Array) -> Array:
        """Return the wishes of the joints of necks (n, H, k) [rad]."""
        necks = self.necks
        R = motion.R_WB[:, necks.owner]
        tilt = np.arcsin(np.clip(R[..., 1, 0], -1.0, 1.0)), np.arctan2(-R[..., 1, 2], R[..., 1, 1])
        raised = motion.style.head_raise[:, necks.owner]
        own, wander = raised[..., None] * necks.raises, wandering[:, necks.numbers]
        gazes = self._gazes(motion)
        if any(motion.look_targets):
            # A neck moves the eyes, from which a near target is seen elsewhere.
            for _ in range(EYE_ITERATIONS):
                gazes = self._gazes(motion, necks.ends(necks.solve(gazes, tilt, own)))
        gazes = self._limited(gazes + self._glances(motion))
        gazes[..., 0] += (wander * necks.yaw).sum(axis=-1)
        gazes[..., 1] += (wander * necks.raises).sum(axis=-1) + necks.nods * raised
        return necks.solve(gazes, tilt, own)

    def _gazes(self, motion: BodyMotion, eyes: Array | None = None) -> Array:
        """Return the wanted gazes (n, H, 2), see `gaze_angles` [rad].

        Args:
            motion: of the bodies.
            eyes: (n, H, 3) if they are known [m].
        """
        necks = self.necks
        gazes = np.zeros((len(motion.time), len(necks.owner), 2))
        for h, c in enumerate(necks.owner.tolist()):
            if not motion.looks_straight(c):
                head, most = (necks.joints.places[h, 0], necks.end[h]), float(necks.most[h])
                own = None if eyes is None else eyes[:, h]
                angles = gaze_angles(self.herd, motion, c, head, most, own)
                gazes[:, h, 0], gazes[:, h, 1] = angles
        return gazes

    def _glances(self, motion: BodyMotion) -> Array:
        """Return where heads (n, H, 2) look aside that stand and are to look at nothing [rad]."""
        necks = self.necks
        carriage = self.joints.standing(motion)[:, necks.numbers]
        free = [[c not in targets for c in necks.owner.tolist()] for targets in motion.look_targets]
        turns = np.stack(
            [(carriage * necks.yaw).sum(axis=-1), (carriage * necks.raises).sum(axis=-1)], axis=-1
        )
        return np.asarray(turns * np.array(free, dtype=float).reshape(*turns.shape[:2], 1))

    def _limited(self, wanted: Array) -> Array:
        """Return gazes (n, H, 2) that follow the wanted ones at a limited speed [rad]."""
        if self._last is not None and (wanted == self._last).all():
            # Most look straight ahead all the time.
            return wanted + self._gaze.follow(wanted)
        goals, least = np.empty_like(wanted), -self._max_step
        for row, goal in enumerate(wanted):
            before = goal if self._last is None else self._last
            step = goal - before
            np.minimum(np.maximum(step, least, out=step), self._max_step, out=step)
            goals[row] = self._last = before + step
        return goals + self._gaze.follow(goals)


class LimbClearance:
    """Keeps a herd's heads, feelers and tails out of ground that rises around a body.

    Where the end of a limb will come too low, now or in a moment, its joints raise it, by what each
    of them lifts it.
    """

    def __init__(self, herd: Herd, joints: FreeJoints, ground: Ground) -> None:
        self.herd, self.ground = herd, ground
        tree, found = joints.tree, []
        rest = tree.pose(joints.limits.preferred)
        for limb in joints.limbs:
            own = list(limb.joints)
            X, tip = rest[own], limb.tip_at(tree, rest)
            lift = cross(turn(X[:, :3, :3], tree.axes[own]), tip - X[:, :3, 3])[:, 1]
            lift = np.where(tree.prismatic[own], 0.0, lift)
            if limb.kind != ARM and float((lift * lift).sum()) > (MIN_LIFT * limb.length) ** 2:
                found.append((joints.owner[own[0]], tip, limb, own, lift))
        self._owner = np.array([c for c, *_ in found], dtype=np.int64)
        self._tips = np.array([tip for _, tip, *_ in found]).reshape(-1, 3)
        self._width = CLEARANCE_WIDTH * np.array([limb.length for _, _, limb, *_ in found])
        self._radius = np.array([limb.tip_radius for _, _, limb, *_ in found])
        # Joints of these limbs, one limb after the other: lift of its end per turn, and turn per
        # metre by which it is raised.
        counts = [len(own) for *_, own, _ in found]
        self._joints = np.array([j for *_, own, _ in found for j in own], dtype=np.int64)
        self._limb = np.repeat(np.arange(len(found)), counts)
        self._first = np.cumsum([0, *counts[:-1]])
        self._lift = np.concatenate([lift for *_, lift in found]) if found else np.zeros(0)
        self._turn = np.concatenate([v / (v @ v) for *_, v in found]) if found else np.zeros(0)
        self._is_level = float(np.ptp(ground.field.heights)) == 0.0

    def wishes(self, motion: BodyMotion, others: Array) -> Array:
        """Return the wishes of joints (n, M) beside other wishes (n, M) [rad]."""
        if self._is_level or not len(self._owner):
            return np.zeros_like(others)
        own, herd = self._owner, self.herd
        p = motion.p_WB[:, own] + turn(motion.R_WB[:, own], self._tips)
        lifts = others[:, self._joints] * self._lift
        y = p[..., 1] + np.add.reduceat(lifts, self._first, axis=1)
        speed = (herd.stride / herd.cycle * motion.speed_fraction)[:, own]
        along = heading_vector(motion.headings)[:, own]
        low = np.zeros(p.shape[:2])
        # Under the back of the limb's end, under its middle, and where it will be soon.
        for out in (-self._radius, 0.0 * speed, self._radius + CLEARANCE_LEAD * speed):
            x, z = p[..., 0] + out * along[..., 0], p[..., 2] + out * along[..., 1]
            high = self.ground.height(x, z) + self._radius
            low = np.maximum(low, hinge(high - y, self._width))
        result = np.zeros_like(others)
        result[:, self._joints] = low[:, self._limb] * self._turn
        return result
