"""Dancing arms: joint values of a walking person's arms that follow a guided dance.

The guide is a torso of the same measures with a waist and wrists of three joints each. A walker's
trunk is one piece, which turns about the waist as the guide's chest does, so that shoulders, head
and hands are where the dance wants them. An arm of a figure has five joints: the palm comes first,
then wrist and elbow, then the orientation of the hand, so that a stretched arm turns its palm over
by its shoulder.

Source: Sims 1987, 6.2 and B.3, for goals of several priorities.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.ik_goals import LimbPoint, PointOrientation, PointPlacement
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.network import ARM
from pipeline.simulation.figures.posed_limb import MAX_JOINT_RATE
from pipeline.simulation.figures.skeleton import Limb
from pipeline.simulation.figures.task_priority import Task, bounded_least_squares_step
from pipeline.simulation.people.body_frames import FRAMES
from pipeline.simulation.people.dressed_figure import person_bones
from pipeline.simulation.people.guided_dance import GUIDED_FRAMES, GUIDED_JOINTS, GuidedPose
from pipeline.simulation.people.proportions import JOINTS, PALM_FRACTION
from pipeline.simulation.spatial import Array, cross, normalized

PALM_WEIGHT, WRIST_WEIGHT, ELBOW_WEIGHT, TURN_WEIGHT = 1.0, 0.3, 0.1, 0.03
"""Weights of the palm's place, those of wrist and elbow, and the orientation of the hand, in
lengths of the arm and radians."""

DAMPING = 0.1
"""λ of an iteration: a stretched arm has no defined swivel, and one that points aside turns about
the axes of two joints of its shoulder at once; less lets these flip over."""

FIRST_STEPS, STEPS = 40, 2
"""Iterations to the first pose of a dance, and to each one after it."""


class TrunkPose(NamedTuple):
    """How a trunk is turned (3, 3) and moved (3,), in the frame of a standing body [m]."""

    R: Array
    p: Array


@dataclass(frozen=True, eq=False)
class _Arm:
    """An arm of a figure.

    Attributes:
        side: l or r.
        limb: of the figure.
        batch: the arm alone.
        elbow, wrist, palm: its points.
        hand_turn: (3, 3) rotation of the hand from a person's rest to the figure's.
    """

    side: str
    limb: Limb
    batch: LimbBatch
    elbow: LimbPoint
    wrist: LimbPoint
    palm: LimbPoint
    hand_turn: Array


class DancingArms:
    """The arms of one figure that is drawn as a person.

    Args:
        figure: accepted by `check_person`.
        dt: time between poses [s].

    Attributes:
        hips: (3,) between the hips, in the frame of the body [m].
        head: (3,) middle of the head, likewise.
        joints: (m,) numbers of the joints of both arms in the figure's skeleton.
    """

    def __init__(self, figure: Figure, dt: float) -> None:
        bones = person_bones(figure)
        rest = dict(zip(JOINTS, bones.proportions.rest(), strict=True))
        self.hips: Array = bones.places[FRAMES.index("pelvis")]
        self.head: Array = self.hips + rest["head"] - rest["pelvis"]
        self._spine: Array = rest["spine"] - rest["pelvis"]
        self._arms = [
            _arm(figure, limb, bones.turns[FRAMES.index(f"hand_{limb.side}")])
            for limb in figure.skeleton.limbs
            if limb.kind == ARM
        ]
        self.joints: NDArray[np.int64] = np.array(
            [joint for arm in self._arms for joint in arm.limb.joints], dtype=np.int64
        )
        self._most = MAX_JOINT_RATE * dt
        self._preferred = figure.skeleton.preferred[self.joints]

    def follow(self, pose: GuidedPose, q: Array | None) -> tuple[Array, TrunkPose]:
        """Return the joint values (m,) of `joints` and the trunk for the pose of a guide.

        Args:
            pose: of the guide.
            q: (m,) values of the step before; None at the start of a dance [rad].
        """
        places = dict(zip(GUIDED_JOINTS, pose.joints, strict=True))
        hands = dict(zip(GUIDED_FRAMES, pose.arms, strict=True))
        R = _chest_frame(places)
        count = STEPS if q is not None else FIRST_STEPS
        values = self._preferred if q is None else q
        found, first = list[Array](), 0
        for arm in self._arms:
            last = first + len(arm.limb.joints)
            here = values[None, first:last]
            hand = R.T @ hands[f"hand_{arm.side}"]
            elbow, wrist = (
                self._in_body(places[f"{name}_{arm.side}"], R, places["spine"])
                for name in ("elbow", "hand")
            )
            along = -hand[:, 1] * float(np.linalg.norm(arm.limb.tip - arm.wrist.place))
            goals = (
                (PointPlacement(arm.palm, (wrist + PALM_FRACTION * along)[None]), PALM_WEIGHT),
                (PointPlacement(arm.wrist, wrist[None]), WRIST_WEIGHT),
                (PointPlacement(arm.elbow, elbow[None]), ELBOW_WEIGHT),
                (PointOrientation(arm.palm, (hand @ arm.hand_turn.T)[None]), TURN_WEIGHT),
            )
            for _ in range(count):
                posed = arm.batch.pose(here)
                tasks = [(goal.task(arm.batch, posed), weight) for goal, weight in goals]
                task = Task(
                    np.concatenate([weight * own.jacobian for own, weight in tasks], axis=1),
                    np.concatenate([weight * own.velocity for own, weight in tasks], axis=1),
                )
                here = bounded_least_squares_step(
                    arm.batch, here, task, np.zeros_like(here), np.array([DAMPING])
                )
            found.append(here[0])
            first = last
        result = np.concatenate(found)
        if q is not None:
            # No joint is faster than joints of posed limbs.
            fastest = float(np.abs(result - q).max())
            result = q + (result - q) * min(1.0, self._most / max(fastest, 1e-12))
        moved = places["spine"] - (R * self._spine).sum(axis=1)
        return result, TrunkPose(R, moved + self.hips - (R * self.hips).sum(axis=1))

    def _in_body(self, place: Array, R: Array, spine: Array) -> Array:
        """Return a place (3,) of the guide in the frame of the body, which goes with its chest."""
        result: Array = self.hips + self._spine + ((place - spine)[:, None] * R).sum(axis=0)
        return result


def _arm(figure: Figure, limb: Limb, hand_turn: Array) -> _Arm:
    skeleton = figure.skeleton
    points = list[LimbPoint]()
    for number in limb.links:
        link = skeleton.links[number]
        along = normalized(link.ends[1] - link.ends[0])
        points.append(LimbPoint(limb.joints.index(link.joint), link.ends[1], along))
    elbow, wrist, tip = points
    palm = LimbPoint(tip.column, wrist.place + PALM_FRACTION * (tip.place - wrist.place), tip.along)
    batch = LimbBatch.of([(skeleton, limb)])
    return _Arm(limb.side, limb, batch, elbow, wrist, palm, hand_turn)


def _chest_frame(places: dict[str, Array]) -> Array:
    """Return the frame (3, 3) of the guide's chest: Y up its back, Z to the right shoulder."""
    y = normalized(places["shoulders"] - places["spine"])
    x = normalized(cross(y, places["shoulder_r"] - places["shoulder_l"]))
    return np.stack([x, y, cross(x, y)], axis=-1)
