"""Dances of a walking herd: persons that come to stand and dance, by order.

The guide of the dance is a torso like a dancer's, in the measures of the figure. Legs stay those of
a walker: they carry a trunk that sways on planted feet. Another order ends a dance: the arms sink
while the walker sets out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.body_motion.gaze import LookTarget
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.dancing.dancing_arms import DancingArms, TrunkPose
from pipeline.simulation.locomotion.foot_state import FootState
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
from pipeline.simulation.locomotion.stepping.standing import is_standing, standing_pose
from pipeline.simulation.order_outcome import Outcome
from pipeline.simulation.people.dressed_figure import is_person, person_bones
from pipeline.simulation.people.guided_dance import (
    BodyStrike,
    DanceGuides,
    GuidedDance,
    GuideMaker,
    strike_contact,
)
from pipeline.simulation.spatial import Array, matrix, quaternion, turn
from pipeline.simulation.take import Contact
from pipeline.simulation.troupe import World
from pipeline.spec.creature import Creature
from pipeline.spec.script import Do, Instruction, Perform
from pipeline.spec.verbs import VERBS, key_of_order

TAKE_OVER_TIME = 0.35
"""In which a dance takes over trunk and arms, and gives them back [s]."""

PATIENCE = 8.0
"""In which a walker comes to stand, or gives the dance up [s]."""

GAZE_DISTANCE = 3.0
"""Of the place ahead of the head that a dancing person looks at [m]."""

STRAIGHT_GAZE = 0.999
"""Cosine of the turn of a head up to which it looks ahead, as one that does not dance."""


@dataclass(frozen=True, slots=True, eq=False)
class DancingBody:
    """One dancing creature at one moment.

    Attributes:
        blend: from its own motion (0) to the dance (1).
        trunk: in the frame of the standing body.
        joints: (m,) numbers of its arms' joints among the herd's free joints.
        q: (m,) their values in the dance [rad].
    """

    blend: float
    trunk: TrunkPose
    joints: NDArray[np.int64]
    q: Array


@dataclass(eq=False, slots=True)
class _Performance:
    """A dance under way.

    Attributes:
        order: that it carries out.
        guide: that moves trunk and arms.
        start: [s].
        trunk, q: present pose.
        ahead: (3,) direction in which the head faces, in the frame of the standing body.
        over: end of the guide's motion [s]; infinite before.
        is_ordered: whether it goes on until its bars end.
    """

    order: Perform
    guide: GuidedDance
    start: float
    trunk: TrunkPose
    q: Array
    ahead: Array
    over: float = math.inf
    is_ordered: bool = True


class WalkerDances:
    """The dances of a herd.

    Args:
        cast: place in the scene's cast, config and figure of each creature.
        world: constants of the scene.
        progress: of the herd on its routes.
        feet: of the herd.
        free_joints: of the herd.
        guide: makes the dances of a person; None if nobody can dance.

    Attributes:
        arrived: creatures whose bars ended in the last step.
        contacts: of hands with their own bodies in the last step.
        outcomes: orders that ended in the last step.

    Raises:
        SceneError: a creature cannot dance what the script tells it to.
    """

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        world: World,
        progress: RouteProgress,
        feet: FootState,
        free_joints: FreeJoints,
        guide: GuideMaker | None,
    ) -> None:
        self._world, self._progress, self._feet = world, progress, feet
        self._numbers = free_joints.numbers
        self._arms: dict[int, DancingArms] = {}
        self._coming: dict[int, tuple[Perform, float]] = {}
        self._under_way: dict[int, _Performance] = {}
        self.arrived: list[str] = []
        self.contacts: list[Contact] = []
        self.outcomes: list[Outcome] = []
        people = {
            member.name: person_bones(figure).proportions
            for _, member, figure in cast
            if is_person(figure)
        }
        self._guides = DanceGuides(people, guide)
        self._guides.prepare_all(world.instructions)

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Let a walker learn the dance of an instruction.

        Raises:
            SceneError: the walker cannot dance it.
        """
        self._guides.prepare(instruction, path)

    # --- orders -----------------------------------------------------------------

    def take(self, c: int, order: Do) -> Do:
        """Take an order; return what the feet are told: who dances stops.

        Every order that is more than an aside ends the dance before it.
        """
        if VERBS[key_of_order(order) or ""].is_aside:
            return order
        self._coming.pop(c, None)
        if c in self._under_way:
            self._under_way[c].guide.end()
            self._under_way[c].is_ordered = False
        if not isinstance(order, Perform):
            return order
        self._coming[c] = order, self._progress.time
        return "stop"

    def is_coming(self, name: str) -> bool:
        """Return whether a creature comes to rest only in order to dance."""
        c = self._progress.herd.names.index(name)
        return c in self._coming

    # --- a step -------------------------------------------------------------------

    def advance(self, step: int) -> None:
        """Advance to the end of a step, after all have walked."""
        self.arrived, self.contacts, self.outcomes = [], [], []
        for c, (order, since) in sorted(self._coming.items()):
            if c in self._under_way:
                continue
            if is_standing(self._progress, self._feet, c):
                del self._coming[c]
                self._begin(c, order)
            elif self._progress.time - since > PATIENCE:
                del self._coming[c]
                name = self._progress.herd.names[c]
                self.outcomes.append(Outcome(name, order, "cannot come to stand"))
        for c, dance in sorted(self._under_way.items()):
            self._advance_dance(step, c, dance)

    def _begin(self, c: int, order: Perform) -> None:
        herd = self._progress.herd
        if c not in self._arms:
            self._arms[c] = DancingArms(herd.figures[c], self._world.clock.dt)
        guide = self._guides.guides[herd.names[c]].begin(order)
        pose = guide.pose()
        q, trunk = self._arms[c].follow(pose, None)
        time = self._progress.time
        self._under_way[c] = _Performance(order, guide, time, trunk, q, pose.ahead)

    def _advance_dance(self, step: int, c: int, dance: _Performance) -> None:
        now = self._progress.time
        if dance.over < math.inf:
            if now - dance.over >= TAKE_OVER_TIME:
                del self._under_way[c]
            return
        strikes = dance.guide.advance()
        pose = dance.guide.pose()
        dance.q, dance.trunk = self._arms[c].follow(pose, dance.q)
        dance.ahead = pose.ahead
        self._report(step, c, strikes)
        if dance.guide.is_over:
            dance.over = now
            if dance.is_ordered:
                name = self._progress.herd.names[c]
                self.arrived.append(name)
                self.outcomes.append(Outcome(name, dance.order))

    def _report(self, step: int, c: int, strikes: Sequence[BodyStrike]) -> None:
        if not strikes:
            return
        name = self._progress.herd.names[c]
        R, p = standing_pose(self._progress, self._feet, c)
        pelvis = R, p + (R * self._arms[c].hips).sum(axis=1)
        proportions = person_bones(self._progress.herd.figures[c]).proportions
        clothes = self._world.clothes[name]
        self.contacts += [
            strike_contact(strike, name, proportions, clothes, step, pelvis) for strike in strikes
        ]

    # --- rows ---------------------------------------------------------------------

    def bodies(self, time: float) -> dict[int, DancingBody]:
        """Return the dancing creatures at a time."""
        return {
            c: DancingBody(
                self._blend(dance, time),
                dance.trunk,
                np.array([self._numbers[c, j] for j in self._arms[c].joints.tolist()]),
                dance.q,
            )
            for c, dance in self._under_way.items()
        }

    def gazes(self, looks: Mapping[int, LookTarget]) -> Mapping[int, LookTarget]:
        """Return what creatures look at: what they are told to, or where a dance turns the head."""
        turned = dict[int, LookTarget]()
        for c, dance in self._under_way.items():
            if c not in looks and dance.over == math.inf and dance.ahead[0] < STRAIGHT_GAZE:
                R, p = standing_pose(self._progress, self._feet, c)
                place = self._arms[c].head + GAZE_DISTANCE * dance.ahead
                turned[c] = p + (R * place).sum(axis=1)
        return {**looks, **turned} if turned else looks

    def _blend(self, dance: _Performance, time: float) -> float:
        begun = min(max((time - dance.start) / TAKE_OVER_TIME, 0.0), 1.0)
        left = 1.0 - min(max((time - dance.over) / TAKE_OVER_TIME, 0.0), 1.0)
        return float(ease(np.array(min(begun, left))))


def turn_trunks(rows: Sequence[Mapping[int, DancingBody]], R_WB: Array, p_WB: Array) -> None:
    """Turn and move bodies (n, C, 3, 3), (n, C, 3) in place as dances of n rows want [m]."""
    for k, row in enumerate(rows):
        for c, body in row.items():
            R, p = R_WB[k, c].copy(), body.blend * body.trunk.p
            p_WB[k, c] += turn(R, p)
            R_WB[k, c] = R @ _fraction(body.trunk.R, body.blend)


def move_arms(rows: Sequence[Mapping[int, DancingBody]], q: Array) -> None:
    """Lead values of free joints (n, M) in place to those of dances of n rows [rad]."""
    for k, row in enumerate(rows):
        for body in row.values():
            own = q[k, body.joints]
            q[k, body.joints] = own + body.blend * (body.q - own)


def _fraction(R: Array, part: float) -> Array:
    """Return a rotation (3, 3) by less than half a turn, by a fraction of its angle about."""
    q = quaternion(R[None])
    q = np.where(q[:, :1] < 0.0, -q, q)
    mean = np.array([1.0, 0.0, 0.0, 0.0]) * (1.0 - part) + part * q
    return matrix(mean / np.sqrt((mean * mean).sum()))[0]
