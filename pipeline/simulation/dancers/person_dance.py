"""Person dance: the dances of a person of another room, on a torso like a dancer's.

Each order dances from hanging arms, after practice as a dancer's, so that an order gives the same
motion whenever it is given.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.clock import Clock
from pipeline.simulation.dancers.dance_moves import BarPosition, beat_duration, plan_moves
from pipeline.simulation.dancers.dance_schedule import lead_beats
from pipeline.simulation.dancers.dancer_motion import TOUCH_TOLERANCE, DancerMotion
from pipeline.simulation.dancers.dancer_script import LOWER_TIME
from pipeline.simulation.dancers.hand_contacts import HandStrike
from pipeline.simulation.dancers.practice import measure_lateness
from pipeline.simulation.dancers.repertoire import Repertoire, build_repertoire
from pipeline.simulation.dancers.torso import LINKS
from pipeline.simulation.people.guided_dance import GUIDED_FRAMES, BodyStrike, GuidedPose
from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.simulation.spatial import Array
from pipeline.spec.dance import Dance
from pipeline.spec.dancer import Dancer
from pipeline.spec.script import Perform

JOINT_LINKS = [
    LINKS.index(name)
    for name in (
        *("chest", "head", "head", "upper_arm_l", "upper_arm_r", "forearm_l", "forearm_r"),
        *("hand_l", "hand_r"),
    )
]
"""The link that starts at each guided joint; the joint "head" lies on the link of that name."""

FRAME_LINKS = [LINKS.index(name) for name in GUIDED_FRAMES]
HEAD, HEAD_ROW = LINKS.index("head"), 2


class PersonDances:
    """The dances that one person knows; see `DanceGuide`.

    Args:
        name: of the person.
        proportions: of the person.
        dances: dances of the scene by name.
        clock: of the scene.
    """

    def __init__(
        self, name: str, proportions: Proportions, dances: Mapping[str, Dance], clock: Clock
    ) -> None:
        self._name, self._proportions, self._dances = name, proportions, dances
        self._clock = clock
        self._known: dict[str, Repertoire] = {}
        self._late: dict[tuple[str, float], Mapping[BarPosition, float]] = {}

    def prepare(self, dance: str, path: str) -> None:
        """See `DanceGuide`."""
        if dance in self._known:
            return
        config = self._dances[dance]
        if config.drums:
            message = (
                f"'{dance}' has drums, which only a `dancer` has before it; name a dance without"
            )
            raise SceneError([Problem(path, message)])
        # Hands start from where they hang, whatever the dance begins with.
        config = config.model_copy(update={"ready": {}})
        self._known[dance] = build_repertoire(
            self._dancer(Perform(dance=dance)),
            *(self._proportions, {dance: config}, (), True, {}, lambda place: place, path),
        )

    def begin(self, order: Perform) -> PersonDance:
        """See `DanceGuide`."""
        repertoire, member = self._known[order.dance], self._dancer(order)
        dance = repertoire.dances[order.dance]
        beat, until = beat_duration(member, dance), self._clock.frames / float(self._clock.rate)
        member = member.model_copy(update={"start": lead_beats(dance) * beat})
        moves = plan_moves(member, dance, until, "")
        choreography, dt = repertoire.choreography, self._clock.dt
        if (order.dance, beat) not in self._late:
            # Practice repeats the dance, however often it is then danced.
            endless = plan_moves(member.model_copy(update={"bars": None}), dance, until, "")
            self._late[order.dance, beat] = measure_lateness(
                member, choreography, endless, beat, dt
            )
        late = self._late[order.dance, beat]
        tolerance = TOUCH_TOLERANCE if late else 0.0
        motion = DancerMotion(
            *(member, choreography, moves, beat, dt, late, tolerance), hang=repertoire.hang
        )
        ends = math.inf
        if order.bars is not None:
            lands = [move.land for rows in moves.values() for move in rows]
            ends = max(*lands, member.start + order.bars * dance.length * beat)
        return PersonDance(motion, self._proportions, dt, ends)

    def _dancer(self, order: Perform) -> Dancer:
        """Return the dancer that a person is while it carries out an order."""
        return Dancer(
            name=self._name,
            dancer="adult",
            dance=order.dance,
            tempo_bpm=order.tempo_bpm,
            bars=order.bars,
        )


class PersonDance:
    """One dance of a person; see `GuidedDance`.

    Args:
        motion: of a torso with the person's proportions.
        proportions: of the person.
        dt: a world step [s].
        ends: end of its bars [s].
    """

    def __init__(
        self, motion: DancerMotion, proportions: Proportions, dt: float, ends: float
    ) -> None:
        self.motion, self.is_over = motion, False
        self._dt, self._ends, self._hangs = dt, ends, math.inf
        rest = dict(zip(JOINTS, proportions.rest(), strict=True))
        self._pelvis, self._neck = rest["pelvis"], rest["head"] - rest["shoulders"]

    def pose(self) -> GuidedPose:
        """See `GuidedDance`."""
        R, p = self.motion.moving.poses()
        joints: Array = p[JOINT_LINKS] - self._pelvis
        joints[HEAD_ROW] += (R[HEAD] * self._neck).sum(axis=1)
        return GuidedPose(joints, R[FRAME_LINKS], R[HEAD][:, 0])

    def advance(self) -> Sequence[BodyStrike]:
        """See `GuidedDance`."""
        start = self.motion.now
        strikes = self.motion.advance()
        now = self.motion.now
        if now >= self._ends:
            self.end()
        self.is_over = now >= self._hangs
        return [self._strike(strike, start) for strike in strikes]

    def end(self) -> None:
        """See `GuidedDance`."""
        self._ends = math.inf
        if self._hangs == math.inf:
            self._hangs = self.motion.now + LOWER_TIME
            self.motion.hang(self._hangs)

    def _strike(self, strike: HandStrike, start: float) -> BodyStrike:
        fraction = min(max((strike.time - start) / self._dt, 0.0), math.nextafter(1.0, 0.0))
        place = np.asarray(strike.place) - self._pelvis
        return BodyStrike(
            fraction, strike.hand, strike.other, place, np.asarray(strike.normal), strike.speed
        )
