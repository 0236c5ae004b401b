"""Gaze: where creatures look, and how their necks turn their heads there.

A creature looks where it will be in a moment, so its head turns before its body does, or where its
author has it look. However the body pitches and rolls, the head stays level. All joints of a neck
share in that, those nearer to the head more; each within its limits.

Source: Grasso et al. 1998, for heads that turn ahead on a curved walk.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.curves import hinge
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.network import HEAD
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.locomotion.body_motion.follow_through import SoftJointLimits, joint_turns
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import pitched_and_rolled
from pipeline.simulation.locomotion.routes.route import Route, heading_vector
from pipeline.simulation.members import MemberState
from pipeline.simulation.spatial import Array, heading, turn
from pipeline.spec.creature import Creature
from pipeline.spec.model_base import Target

# How long before it is somewhere a creature looks there [s]; and least speed fraction for that, so
# that it looks ahead where it brakes.
LEAD_TIME, MIN_SPEED_FRACTION = 0.8, 0.35

# How far beyond its eyes' future place it looks, in half lengths of its stance.
BEYOND = 2.0

# Greatest elevation of a gaze [rad].
MAX_ELEVATION = math.radians(60.0)

# Iterations in which the eyes' own motion is taken into account.
EYE_ITERATIONS = 3

# Iterations of Newton's method for necks: the error of an angle of 1 is then below a thousandth;
# and damping of the inverse, for necks that cannot turn some way.
NECK_ITERATIONS, NECK_REGULARIZATION = 3, 1e-3

# Share of a neck's first joint in nodding; that of the last is 1.
FIRST_JOINT_SHARE = 0.25

# Part of a raised neck by which the head looks up; all of it where the neck is one joint.
RAISED_GAZE = 0.35

# Greatest turn of a head, as a fraction of its joints' room.
MAX_TURN = 0.9

# A place (3,) [m], or the number of a creature.
LookTarget = Array | int


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """The motion of C bodies at n rows, on which heads and free limbs depend.

    Attributes:
        time: (n,) since the start [s].
        distance: (n, C) gone [m].
        phase, speed_fraction: (n, C) of the gaits.
        running: (n, C) how far they are runs, 0 to 1.
        style: (n, C).
        routes: (n) lists of C, the same object until a route changes.
        look_targets: (n) ordered, by creature.
        R_WB, p_WB: (n, C, 3, 3) and (n, C, 3) of the bodies [m].
    """

    time: Array
    distance: Array
    phase: Array
    speed_fraction: Array
    running: Array
    style: MotionStyle
    routes: Sequence[Sequence[Route]]
    look_targets: Sequence[Mapping[int, LookTarget]]
    R_WB: Array
    p_WB: Array

    @cached_property
    def headings(self) -> Array:
        """(n, C) of the bodies [rad]."""
        return np.arctan2(-self.R_WB[..., 2, 0], self.R_WB[..., 0, 0])

    @cached_property
    def spans(self) -> Sequence[slice]:
        """Rows between changes of routes."""
        count = len(self.routes)
        changes = [k for k in range(1, count) if self.routes[k] is not self.routes[k - 1]]
        return [slice(a, b) for a, b in itertools.pairwise([0, *changes, count])] if count else []

    def looks_straight(self, c: int) -> bool:
        """Return whether a creature goes straight in all rows, and is to look at nothing."""
        if any(c in targets for targets in self.look_targets):
            return False
        return all(self.routes[span.start][c].goes_straight for span in self.spans)


# --- look targets -------------------------------------------------------------------


class LookTargets:
    """What the creatures of a herd are to look at.

    Args:
        herd: the creatures.
        cast: place in the scene's cast, config and figure of each.

    Attributes:
        current: target by creature; the others look where they go. Replaced, never changed.

    Raises:
        SceneError: if a creature cannot look where its config says.
    """

    def __init__(self, herd: Herd, cast: Sequence[tuple[int, Creature, Figure]]) -> None:
        self.current: Mapping[int, LookTarget] = {}
        self._herd = herd
        self._watched: dict[int, str] = {}
        problems = []
        for c, (number, member, _) in enumerate(cast):
            try:
                if member.look_at is not None:
                    self.set(c, member.look_at)
            except ValueError as error:
                problems.append(Problem(f"cast[{number}].look_at", str(error)))
        if problems:
            raise SceneError(problems)

    @property
    def members_needed(self) -> set[str]:
        """Members of other herds that are looked at."""
        return set(self._watched.values())

    def set(self, c: int, target: Target | None) -> None:
        """Lets creature `c` look at another target; ahead again if None.

        Raises:
            ValueError: with the reason why it cannot.
        """
        herd = self._herd
        if target is not None and all(limb.kind != HEAD for limb in herd.figures[c].skeleton.limbs):
            raise ValueError(f"'{herd.names[c]}' has no head to turn")
        self._watched.pop(c, None)
        others = {owner: known for owner, known in self.current.items() if owner != c}
        if isinstance(target, str) and target not in herd.names:
            self._watched[c] = target
            self.current = others
        elif target is not None:
            own = herd.names.index(target) if isinstance(target, str) else np.array(target)
            self.current = {**others, c: own}
        else:
            self.current = others

    def see_members(self, members: Mapping[str, MemberState]) -> None:
        """Follows the members of other herds that are looked at."""
        if self._watched:
            places = {c: members[name].face for c, name in self._watched.items() if name in members}
            self.current = {**self.current, **places}


# --- gaze angles --------------------------------------------------------------------


def gaze_angles(
    herd: Herd,
    motion: BodyMotion,
    c: int,
    head: tuple[Array, Array],
    most: float,
    eyes: Array | None,
) -> tuple[Array, Array]:
    """Return azimuth from the body's heading, and elevation, (n,) of a gaze [rad].

    Args:
        herd: the creatures.
        motion: of their bodies.
        c: number of the creature.
        head: base of its neck (3,) and the neck's end at rest (3,), relative to the body [m].
        most: greatest azimuth [rad].
        eyes: (n, 3) the neck's end, if it is known [m].
    """
    azimuth, elevation = np.zeros((2, len(motion.time)))
    ordered = np.array([c in targets for targets in motion.look_targets], dtype=bool)
    out = float(np.hypot(*head[1][[0, 2]]))
    for span in motion.spans:
        route = motion.routes[span.start][c]
        own = np.arange(span.start, span.stop)[~ordered[span]]
        if not route.goes_straight and len(own):
            targets = _places_ahead(herd, motion, c, route, own, out)
            aside = _angles_from_neck(motion, c, own, targets, *head)[0]
            azimuth[own] = motion.style.head_turn[own, c] * aside
    if ordered.any():
        own = np.flatnonzero(ordered)
        targets = np.array([_target_place(motion, c, k) for k in own.tolist()])
        if eyes is None:
            azimuth[own], up = _angles_from_neck(motion, c, own, targets, *head)
        else:
            from_eyes = targets - motion.p_WB[own, c] - turn(motion.R_WB[own, c], eyes[own])
            azimuth[own], up = _angles(from_eyes, motion.headings[own, c])
        elevation[own] = soft_clip(up, MAX_ELEVATION)
    return soft_clip(azimuth, most), elevation


def soft_clip(angle: Array, most: float) -> Array:
    """Return angles unchanged up to 0.7 of `most`, and then ever less, up to `most` [rad]."""
    width = max(0.15 * most, 1e-6)
    result: Array = angle - np.sign(angle) * hinge(np.abs(angle) - (most - width), width)
    return np.clip(result, -most, most)


def _places_ahead(
    herd: Herd, motion: BodyMotion, c: int, route: Route, own: NDArray[np.int64], out: float
) -> Array:
    """Return places (n, 3) at which a creature on its route looks, its eyes `out` before it [m]."""
    fraction = np.maximum(motion.speed_fraction[own, c], MIN_SPEED_FRACTION)
    speed = herd.stride[c] / herd.cycle[c] * fraction
    xz, headings = route.at(motion.distance[own, c] + LEAD_TIME * speed)
    xz = xz + (out + BEYOND * herd.footprint[c, 0]) * heading_vector(headings)
    return np.stack([xz[:, 0], motion.p_WB[own, c, 1], xz[:, 1]], axis=-1)


def _target_place(motion: BodyMotion, c: int, row: int) -> Array:
    """Return the place (3,) at which a creature is ordered to look in a row [m]."""
    target = motion.look_targets[row][c]
    return motion.p_WB[row, target] if isinstance(target, int) else target


def _angles_from_neck(
    motion: BodyMotion, c: int, own: NDArray[np.int64], targets: Array, base: Array, eye: Array
) -> tuple[Array, Array]:
    """Return azimuths and elevations (n,) of places (n, 3) from the eyes that look at them."""
    R, p, headings = motion.R_WB[own, c], motion.p_WB[own, c], motion.headings[own, c]
    azimuth = elevation = np.zeros(len(own))
    for _ in range(EYE_ITERATIONS):
        out = turn(heading(azimuth), np.broadcast_to(eye - base, p.shape))
        azimuth, elevation = _angles(targets - p - turn(R, base + out), headings)
    return azimuth, elevation


def _angles(way: Array, headings: Array) -> tuple[Array, Array]:
    """Return azimuths from headings (n,), and elevations (n,), of vectors (n, 3) [rad]."""
    x, y, z = way.T
    azimuth = np.remainder(np.arctan2(-z, x) - headings + np.pi, 2.0 * np.pi) - np.pi
    return azimuth, np.arctan2(y, np.hypot(x, z))


# --- necks --------------------------------------------------------------------------


class Necks:
    """The necks of a herd whose heads sit on bodies.

    Attributes:
        owner: (H,) creature of each.
        numbers: (H, k) its joints, by their numbers among the herd's free joints.
        yaw, raises: (H, k) weights of the joints in turning the head and in raising the neck.
        limits: (H, k) of the joints.
        most: (H,) greatest turn [rad].
        rest: (H, 3, 3) orientation of the head at rest in the body's frame.
        end: (H, 3) end of the neck at rest [m].
        nods: (H,) part of a raised neck by which the head looks up.
        joints: of the necks.
    """

    def __init__(self, figures: Sequence[Figure], numbers: dict[tuple[int, int], int]) -> None:
        found = [
            (c, figure.skeleton, limb)
            for c, figure in enumerate(figures)
            for limb in figure.skeleton.limbs
            if limb.kind == HEAD and figure.skeleton.parents[limb.joints[0]] == BODY
        ]
        self.owner = np.array([c for c, _, _ in found], dtype=np.int64)
        self.joints = LimbBatch.of([(skeleton, limb) for _, skeleton, limb in found])
        shape = self.joints.is_joint.shape
        self.numbers, names = np.zeros(shape, dtype=np.int64), np.full(shape, "", dtype="<U8")
        self._shares, self.raises = np.ones(shape), np.zeros(shape)
        for row, (c, skeleton, limb) in enumerate(found):
            here = row, slice(len(limb.joints))
            self.numbers[here] = [numbers[c, j] for j in limb.joints]
            names[here] = joint_turns(skeleton, limb)
            nods = np.flatnonzero(np.isin(names[row], ("pitch", "bend")))
            self._shares[row, nods] = np.linspace(FIRST_JOINT_SHARE, 1.0, len(nods))
            self.raises[row, nods[:1]] = 1.0
        self.yaw = names == "yaw"
        self.nods = np.where(np.isin(names, ("pitch", "bend")).sum(axis=-1) > 1, RAISED_GAZE, 1.0)
        limits = SoftJointLimits(self.joints.lower, self.joints.preferred, self.joints.upper)
        rooms = np.minimum(limits.upper - limits.preferred, limits.preferred - limits.lower)
        self.limits = limits
        self.most = MAX_TURN * (rooms * self.yaw).sum(axis=-1)
        rest = self.joints.pose(self.joints.preferred)
        self.rest, self.end = rest.R_BF, rest.tips
        self._repeated: tuple[int, LimbBatch] | None = None

    def ends(self, wishes: Array) -> Array:
        """Return the ends of the necks (n, H, 3) in the body's frame, for wishes (n, H, k) [m]."""
        n, count, k = wishes.shape
        batch = self._at_rows(n)
        return batch.pose(self.limits.at(wishes).reshape(-1, k)).tips.reshape(n, count, 3)

    def _at_rows(self, n: int) -> LimbBatch:
        """Return all necks, one row after the other; mostly as many as the last time."""
        if self._repeated is None or self._repeated[0] != n:
            rows = np.tile(np.arange(len(self.owner)), n)
            self._repeated = n, self.joints.rows(rows)
        return self._repeated[1]

    def solve(self, gazes: Array, tilt: tuple[Array, Array], start: Array) -> Array:
        """Return the wishes of the joints (n, H, k), see `SoftJointLimits` [rad].

        Args:
            gazes: (n, H, 2) azimuth from the body's heading, and elevation [rad].
            tilt: pitch and roll (n, H) of the bodies [rad].
            start: (n, H, k) angles that the neck has without a target [rad].
        """
        n, count, k = start.shape
        if not count:
            return start
        batch = self._at_rows(n)
        R_WB = pitched_and_rolled(tilt[0].ravel(), tilt[1].ravel())
        azimuth, elevation = gazes.reshape(-1, 2).T
        R_gaze = heading(azimuth) @ pitched_and_rolled(elevation, np.zeros(len(elevation)))
        R_wanted = R_WB.transpose(0, 2, 1) @ R_gaze @ np.tile(self.rest, (n, 1, 1))
        wish, damping = start, NECK_REGULARIZATION * np.eye(3)
        for _ in range(NECK_ITERATIONS):
            pose = batch.pose(self.limits.at(wish).reshape(-1, k))
            error = _rotation_vector(R_wanted @ pose.R_BF.transpose(0, 2, 1))
            J = turn(pose.X_BJ[..., :3, :3], batch.axes) * ~batch.prismatic[..., None]
            J = (J * self.limits.slope(wish).reshape(-1, k, 1)).transpose(0, 2, 1)
            JW = J * np.tile(self._shares, (n, 1))[:, None]
            pull = np.linalg.solve(JW @ J.transpose(0, 2, 1) + damping, error[..., None])
            wish = wish + (JW.transpose(0, 2, 1) @ pull)[..., 0].reshape(wish.shape)
        return wish


def _rotation_vector(R: Array) -> Array:
    """Return rotation vectors (N, 3) of rotations (N, 3, 3), of length 2 tan(θ/2).

    Near the angle where it is small, and still growing up to half a turn.
    """
    axis = np.stack(
        [R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=-1
    )
    trace = R[:, 0, 0] + R[:, 1, 1] + R[:, 2, 2]
    return 2.0 * axis / np.maximum(1.0 + trace, 0.2)[:, None]
