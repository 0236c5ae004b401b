"""Gaze: where creatures look, and how their necks bring their heads to it.

A creature looks where it will be in a moment, so its head turns before it does. However
the body pitches and rolls, the head stays level. All joints of a neck share in that, those
nearer to the head more; each within its limits.

Source: Grasso et al. 1998, for heads that go ahead of a walk along a curve.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.network import HEAD
from pipeline.simulation.figures.skeleton import BODY, Limb, Skeleton
from pipeline.simulation.locomotion.carriage.joint_room import JointRoom
from pipeline.simulation.locomotion.ways.body_path import pitched_and_rolled
from pipeline.simulation.spatial import Array, heading, turn

ROUNDS = 3
"""Of Newton's method; the error of an angle of 1 is then less than a thousandth."""

DAMPING = 1e-3
"""Of the inverse, for necks that cannot turn some way."""

FIRST_JOINT = 0.25
"""Share of a neck's first joint in bowing and raising the head; that of the last is 1."""

MOST_RAISE = 0.35
"""Part of a raised neck by which the head looks up; all of it where the neck is one joint."""

MOST_TURN = 0.9
"""How far heads turn, as a part of their joints' room."""


class Gaze:
    """The heads of a herd that sit on bodies.

    Attributes:
        owner: (H,) creature of each.
        numbers: (H, k) its joints, by their numbers among the herd's that carry nothing.
        yaw, neck: (H, k) which of them turn it, and which raise the neck, by how much.
        room: (H, k) of its joints.
        most: (H,) how far it turns [rad].
        rest: (H, 3, 3) how it is turned at rest in the body's frame.
        end: (H, 3) where the neck ends then [m].
        nods: (H,) part of a raised neck by which it looks up.
        necks: the joints.
    """

    def __init__(self, figures: Sequence[Figure], numbers: dict[tuple[int, int], int]) -> None:
        found = [
            (c, figure.skeleton, limb)
            for c, figure in enumerate(figures)
            for limb in figure.skeleton.limbs
            if limb.kind == HEAD and figure.skeleton.parents[limb.joints[0]] == BODY
        ]
        self.owner = np.array([c for c, _, _ in found], dtype=np.int64)
        self.necks = LimbBatch.of([(skeleton, limb) for _, skeleton, limb in found])
        shape = self.necks.is_joint.shape
        self.numbers, names = np.zeros(shape, dtype=np.int64), np.full(shape, "", dtype="<U8")
        self._shares, self.neck = np.ones(shape), np.zeros(shape)
        for row, (c, skeleton, limb) in enumerate(found):
            here = row, slice(len(limb.joints))
            self.numbers[here] = [numbers[c, j] for j in limb.joints]
            names[here] = _turns(skeleton, limb)
            nods = np.flatnonzero(np.isin(names[row], ("pitch", "bend")))
            self._shares[row, nods] = np.linspace(FIRST_JOINT, 1.0, len(nods))
            self.neck[row, nods[:1]] = 1.0
        self.yaw = names == "yaw"
        self.nods = np.where(np.isin(names, ("pitch", "bend")).sum(axis=-1) > 1, MOST_RAISE, 1.0)
        self.room = JointRoom(self.necks.lower, self.necks.preferred, self.necks.upper)
        rooms = np.minimum(
            self.room.upper - self.room.preferred, self.room.preferred - self.room.lower
        )
        self.most = MOST_TURN * (rooms * self.yaw).sum(axis=-1)
        rest = self.necks.pose(self.necks.preferred)
        self.rest, self.end = rest.R_BF, rest.tips
        self._many: tuple[int, LimbBatch] | None = None

    def eyes(self, wishes: Array) -> Array:
        """Return where the necks end (n, H, 3) in the body's frame, for wishes (n, H, k) [m]."""
        n, count, k = wishes.shape
        batch = self._necks_at(n)
        return batch.pose(self.room.at(wishes).reshape(-1, k)).tips.reshape(n, count, 3)

    def _necks_at(self, moments: int) -> LimbBatch:
        """Return all necks, one moment after the other; mostly as many as the last time."""
        if self._many is None or self._many[0] != moments:
            rows = np.tile(np.arange(len(self.owner)), moments)
            self._many = moments, self.necks.rows(rows)
        return self._many[1]

    def wishes(self, looks: Array, tilt: tuple[Array, Array], start: Array) -> Array:
        """Return what the joints (n, H, k) are to do, as `JointRoom` takes it [rad].

        Args:
            looks: (n, H, 2) azimuth from the body's heading and elevation of the look [rad].
            tilt: pitch and roll (n, H) of the bodies [rad].
            start: (n, H, k) wishes that the neck has of its own [rad].
        """
        n, count, k = start.shape
        if not count:
            return start
        batch = self._necks_at(n)
        R_WB = pitched_and_rolled(tilt[0].ravel(), tilt[1].ravel())
        azimuth, elevation = looks.reshape(-1, 2).T
        R_look = heading(azimuth) @ pitched_and_rolled(elevation, np.zeros(len(elevation)))
        R_wanted = R_WB.transpose(0, 2, 1) @ R_look @ np.tile(self.rest, (n, 1, 1))
        wish, eye = start, DAMPING * np.eye(3)
        for _ in range(ROUNDS):
            pose = batch.pose(self.room.at(wish).reshape(-1, k))
            error = _rotation_vector(R_wanted @ pose.R_BF.transpose(0, 2, 1))
            J = turn(pose.X_BJ[..., :3, :3], batch.axes) * ~batch.prismatic[..., None]
            J = (J * self.room.slope(wish).reshape(-1, k, 1)).transpose(0, 2, 1)
            JW = J * np.tile(self._shares, (n, 1))[:, None]
            pull = np.linalg.solve(JW @ J.transpose(0, 2, 1) + eye, error[..., None])
            wish = wish + (JW.transpose(0, 2, 1) @ pull)[..., 0].reshape(wish.shape)
        return wish


def _turns(skeleton: Skeleton, limb: Limb) -> list[str]:
    """Return what each joint of a limb does: yaw, pitch, roll or bend."""
    return [skeleton.joint_names[j].rsplit("_", 1)[1] for j in limb.joints]


def _rotation_vector(R: Array) -> Array:
    """Return the rotation vectors (N, 3) of turns (N, 3, 3), by half angles: 2 tan(θ/2).

    Near the angle where it is small, and still growing up to half a turn.
    """
    axis = np.stack(
        [R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=-1
    )
    trace = R[:, 0, 0] + R[:, 1, 1] + R[:, 2, 2]
    result: Array = 2.0 * axis / np.maximum(1.0 + trace, 0.2)[:, None]
    return result
