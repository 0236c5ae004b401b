"""Gaze: where creatures look, and how their necks bring their heads to it.

A creature looks where it will be in a moment, so its head turns before it does. However
the body pitches and rolls, the head stays level. All joints of a neck share in that, those
nearer to the head more; each within its limits.

Source: Grasso et al. 1998, for heads that go ahead of a walk along a curve.
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
from pipeline.simulation.figures.skeleton import BODY, Limb, Skeleton
from pipeline.simulation.locomotion.body_motion.follow_through import SoftJointLimits
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import pitched_and_rolled
from pipeline.simulation.locomotion.routes.route import Route, heading_vector
from pipeline.simulation.spatial import Array, heading, turn
from pipeline.spec.creature import Creature
from pipeline.spec.model_base import Target

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
        self.room = SoftJointLimits(self.necks.lower, self.necks.preferred, self.necks.upper)
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
        """Return what the joints (n, H, k) are to do, as `SoftJointLimits` takes it [rad].

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


LEAD = 0.8
"""How long before it is somewhere a creature looks there [s]."""

LEAST = 0.35
"""Part of its speed at which it looks ahead at least, so that it does where it brakes."""

BEYOND = 2.0
"""How far beyond its eyes' place there it looks, in half lengths of its stance."""

MOST_UP = math.radians(60.0)
"""How far heads look up or down."""

EYE_ITERATIONS = 3
"""In which the eyes' own turning is taken into account."""

LookTarget = Array | int
"""A place (3,) [m], or the number of a creature."""


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """What the carriage of a herd of C depends on, at n rows.

    Attributes:
        time: (n,) since the start [s].
        way: (n, C) way gone [m].
        phase, drive: (n, C) of the gaits.
        bearing: (n, C).
        routes: (n) lists of C, the same object as long as nobody is led elsewhere.
        looks: (n) what somebody is told to look at, by creature.
        R_WB, p_WB: (n, C, 3, 3) and (n, C, 3) of the bodies [m].
    """

    time: Array
    way: Array
    phase: Array
    drive: Array
    bearing: MotionStyle
    routes: Sequence[Sequence[Route]]
    looks: Sequence[Mapping[int, LookTarget]]
    R_WB: Array
    p_WB: Array

    @cached_property
    def turned(self) -> Array:
        """(n, C) headings of the bodies [rad]."""
        result: Array = np.arctan2(-self.R_WB[..., 2, 0], self.R_WB[..., 0, 0])
        return result

    @cached_property
    def spans(self) -> Sequence[slice]:
        """The rows during which nobody is led elsewhere, one after the other."""
        count = len(self.routes)
        led = [k for k in range(1, count) if self.routes[k] is not self.routes[k - 1]]
        return [slice(a, b) for a, b in itertools.pairwise([0, *led, count])] if count else []


def resolve_look_target(herd: Herd, c: int, words: Target) -> LookTarget:
    """Return what the creature `c` of a herd is told to look at.

    Raises:
        ValueError: it cannot; says why.
    """
    if all(limb.kind != HEAD for limb in herd.figures[c].skeleton.limbs):
        raise ValueError(f"'{herd.names[c]}' has no head to turn")
    if not isinstance(words, str):
        return np.array(words)
    if words not in herd.names:
        raise ValueError(f"'{words}' is not on the same ground on legs; give a place, [x, y, z]")
    return herd.names.index(words)


def set_look_target(
    looks: Mapping[int, LookTarget], herd: Herd, c: int, words: Target | None
) -> Mapping[int, LookTarget]:
    """Return what creatures look at once `c` is told to, ahead again where `words` is None.

    Raises:
        ValueError: see `resolve_look_target`.
    """
    others = {who: look for who, look in looks.items() if who != c}
    return others if words is None else {**others, c: resolve_look_target(herd, c, words)}


def initial_look_targets(
    herd: Herd, cast: Sequence[tuple[int, Creature, Figure]]
) -> Mapping[int, LookTarget]:
    """Return what the creatures of a herd are told to look at, by creature.

    Args:
        herd: of the cast.
        cast: place in the scene's cast, words and figure of each.

    Raises:
        SceneError: one cannot.
    """
    looks, problems = dict[int, LookTarget](), []
    for c, (number, member, _) in enumerate(cast):
        try:
            if member.look_at is not None:
                looks[c] = resolve_look_target(herd, c, member.look_at)
        except ValueError as error:
            problems.append(Problem(f"cast[{number}].look_at", str(error)))
    if problems:
        raise SceneError(problems)
    return looks


def looks_ahead(rows: BodyMotion, c: int) -> bool:
    """Tell whether a creature goes straight on in all rows, and is told to look at nothing."""
    if any(c in looks for looks in rows.looks):
        return False
    return all(rows.routes[span.start][c].goes_straight for span in rows.spans)


def gaze_angles(
    herd: Herd, rows: BodyMotion, c: int, head: tuple[Array, Array], most: float, eyes: Array | None
) -> tuple[Array, Array]:
    """Return where a head is to look (n,): left of its body's heading, and up [rad].

    Args:
        herd: the creatures.
        rows: what is known of them.
        c: whose head.
        head: base of its neck (3,) and the neck's end at rest (3,), relative to the body [m].
        most: how far it turns [rad].
        eyes: (n, 3) where the neck's end is, if that is known [m].
    """
    azimuth, elevation = np.zeros((2, len(rows.time)))
    told = np.array([c in looks for looks in rows.looks], dtype=bool)
    out = float(np.hypot(*head[1][[0, 2]]))
    for span in rows.spans:
        route = rows.routes[span.start][c]
        own = np.arange(span.start, span.stop)[~told[span]]
        if not route.goes_straight and len(own):
            targets = _ahead(herd, rows, c, route, own, out)
            aside = _seen(rows, c, own, targets, *head)[0]
            azimuth[own] = rows.bearing.head_turn[own, c] * aside
    if told.any():
        own = np.flatnonzero(told)
        targets = np.array([_place(rows, k, rows.looks[k][c]) for k in own.tolist()])
        if eyes is None:
            azimuth[own], up = _seen(rows, c, own, targets, *head)
        else:
            from_eyes = targets - rows.p_WB[own, c] - turn(rows.R_WB[own, c], eyes[own])
            azimuth[own], up = _angles(from_eyes, rows.turned[own, c])
        elevation[own] = within(up, MOST_UP)
    return within(azimuth, most), elevation


def within(angle: Array, most: float) -> Array:
    """Return angles as they are up to 0.7 of `most`, and then ever less, up to `most` [rad]."""
    width = max(0.15 * most, 1e-6)
    result: Array = angle - np.sign(angle) * hinge(np.abs(angle) - (most - width), width)
    return np.clip(result, -most, most)


def _ahead(
    herd: Herd, rows: BodyMotion, c: int, route: Route, own: NDArray[np.int64], out: float
) -> Array:
    """Return places (n, 3) to which who follows its way looks, its eyes `out` before it [m]."""
    speed = herd.stride[c] / herd.cycle[c] * np.maximum(rows.drive[own, c], LEAST)
    xz, turned = route.at(rows.way[own, c] + LEAD * speed)
    xz = xz + (out + BEYOND * herd.footprint[c, 0]) * heading_vector(turned)
    return np.stack([xz[:, 0], rows.p_WB[own, c, 1], xz[:, 1]], axis=-1)


def _place(rows: BodyMotion, k: int, look: LookTarget) -> Array:
    """Return the place (3,) of what is looked at in row `k` [m]."""
    return rows.p_WB[k, look] if isinstance(look, int) else look


def _seen(
    rows: BodyMotion, c: int, own: NDArray[np.int64], targets: Array, base: Array, eye: Array
) -> tuple[Array, Array]:
    """Return azimuths and elevations (n,) of places (n, 3) from the eyes that look at them."""
    R, p, turned = rows.R_WB[own, c], rows.p_WB[own, c], rows.turned[own, c]
    azimuth = elevation = np.zeros(len(own))
    for _ in range(EYE_ITERATIONS):
        out = turn(heading(azimuth), np.broadcast_to(eye - base, p.shape))
        azimuth, elevation = _angles(targets - p - turn(R, base + out), turned)
    return azimuth, elevation


def _angles(way: Array, turned: Array) -> tuple[Array, Array]:
    """Return azimuths from headings `turned` (n,), and elevations (n,), of ways (n, 3) [rad]."""
    x, y, z = way.T
    azimuth = np.remainder(np.arctan2(-z, x) - turned + np.pi, 2.0 * np.pi) - np.pi
    return azimuth, np.arctan2(y, np.hypot(x, z))
