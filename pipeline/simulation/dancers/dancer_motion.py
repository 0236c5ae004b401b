"""Dancing: one dancer in motion, sub-step by sub-step, in the frame that it stands in."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.dancers.arm_control import ArmController
from pipeline.simulation.dancers.dance_goals import Choreography, hanging_posture
from pipeline.simulation.dancers.dance_moves import BarPosition, Move
from pipeline.simulation.dancers.dancer_poses import Poses
from pipeline.simulation.dancers.force_fields import FIELD_RATE
from pipeline.simulation.dancers.hand_contacts import HandContacts, HandStrike
from pipeline.simulation.dancers.key_postures import key_postures, ready_postures
from pipeline.simulation.dancers.torso import HANDS, LINKS, Torso
from pipeline.simulation.dancers.trunk_control import TRUNK_JOINTS, TrunkController
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.spatial import Array
from pipeline.spec.dance import Controller
from pipeline.spec.dancer import Arms, Dancer, Gains

CONTROL_RATE = 96
"""How often a second controllers look at least; what depends on speeds alone acts at every step."""

AIM_AHEAD = 0.012
"""How long before its beat a hand aims to touch [s]: a moment late is seen a frame late."""

EXPECTED, LEARNS, MOST_LATE = 0.2, 0.9, 0.25
"""How far from its time a touch is taken for the one that was meant [s]; how much of an error is
made up for the next time, and how much in all [s]."""

ROUNDS, GOOD, CALM = 5, 0.012, 0.025
"""How often a dance is practised at most; how near to its time every touch is good enough; how
far from it one of the body may be later on before more is made up for: less than a frame of a
film [s]."""

PRACTICE_STEP_RATE = 1000
"""Steps a second with which it practises at most: who is simulated with finer steps has learnt
the same, and goes the same way."""

NO_POSES = Poses()

HEAD, CHEST = LINKS.index("head"), LINKS.index("chest")


class DancerMotion:
    """A dancer in motion.

    Args:
        words: of the dancer.
        choreography: its dance, on its torso.
        moves: of each hand, in the order of time.
        beat: duration of a beat [s].
        dt: that it is advanced by at once [s].
        late: how late its hands come to each place of the bar, as far as it knows [s].
        calm: how far from its time a touch of the body may be before it is made up for [s].
        poses: that it takes, whatever it dances.
        hang: side -> number of the subtask that lets the arm hang.

    Attributes:
        late: likewise, as it has learnt by now [s].
        looks_at: number of the spot that it looks at, None for none yet.
        looks_to: (3,) where it looks instead of at its hand, None for nowhere else [m].
        missed_by: how far from the time it aims at it last touched, by place of the bar [s].
    """

    def __init__(
        self,
        words: Dancer,
        choreography: Choreography,
        moves: Mapping[str, Sequence[Move]],
        beat: float,
        dt: float,
        late: Mapping[BarPosition, float] | None = None,
        calm: float = 0.0,
        poses: Poses = NO_POSES,
        hang: Mapping[str, int] | None = None,
    ) -> None:
        self.words, self.goals = words, choreography.goals
        self.torso = with_gains(choreography.torso, words.gains)
        self.ticks = max(math.ceil(dt * CONTROL_RATE - 1e-9), 1)
        self.tick = dt / self.ticks
        self.substeps = max(math.ceil(self.tick * words.steps_a_second - 1e-9), 1)
        self.moving = LinkageSimulation(self.torso.linkage, self.tick / self.substeps)
        self.postures = key_postures(choreography) if self._needs_postures() else ()
        self._stand(ready_postures(choreography))
        rate = FIELD_RATE * words.gains.rate
        self.arms = [
            ArmController(side, self.torso, self.moving, rate, words.combine == "winner")
            for side in HANDS
        ]
        self.moves = [list(moves[side]) for side in HANDS]
        self._next = [0] * len(HANDS)
        self._hang = hang or {}
        self._poses = [deque(poses.hands.get(side, ())) for side in HANDS]
        self._trunk_keys = deque(poses.trunk)
        self._trunk_posed: dict[str, float] = {}
        self._posed = [False] * len(HANDS)
        self.late, self.calm = dict(late or {}), calm
        self.missed_by: dict[BarPosition, float] = {}
        self._meant: list[list[Move]] = [[] for _ in HANDS]
        self.carriage = TrunkController(math.radians(words.sway_deg), beat, words.start, words.gaze)
        self.touching = HandContacts(self.moving)
        self.count = 0
        for arm in self.arms:
            arm.drive(self._controller(arm.side, None) == "force-field")
            if not arm.by_fields:
                self.moving.targets[arm.all] = self.moving.q[arm.all]
        self.looks_at: int | None = None
        self.looks_to: Array | None = None
        self._eyes, self._chest = self.moving.place_of(HEAD), self.moving.turned(CHEST)
        self._trunk = self.moving.targets[: len(TRUNK_JOINTS)]

    @property
    def now(self) -> float:
        """The time since it began [s]."""
        return self.count * self.tick

    def advance(self) -> list[HandStrike]:
        """Go on by one step of the world; return what its hands have touched."""
        found = list[HandStrike]()
        for _ in range(self.ticks):
            now = self.count * self.tick
            self._set_out(now)
            self._control(now)
            found += self._go(now)
            self.count += 1
        return found

    def _go(self, now: float) -> list[HandStrike]:
        """Go on by one tick; return what hands have touched in it."""
        found, done, step = list[HandStrike](), 0, self.tick / self.substeps
        while done < self.substeps:
            before = now + done * step
            done += self.moving.advance(self.substeps - done)
            strikes = self.touching.look(now + done * step, step, before)
            self._learn(strikes)
            found += strikes
        return found

    def _learn(self, strikes: Sequence[HandStrike]) -> None:
        """Hear how late hands came, to set out for the same the earlier the next time."""
        for strike in strikes:
            clap = strike.other.startswith("hand")
            for solid in (strike.hand, strike.other) if clap else (strike.hand,):
                k = HANDS.index(solid[-1])
                # A hand that comes late has the next move to do already.
                move = min(self._meant[k], key=lambda m: abs(strike.time - m.land), default=None)
                if move is None or not (clap or self.goals[move.subtask].surface):
                    continue
                late = strike.time - move.land + AIM_AHEAD
                if abs(late) < EXPECTED:
                    self._meant[k].remove(move)
                    self.missed_by[move.place] = late
                # Blows on beats of the bar are made better all the time.
                calm = self.calm if self.goals[move.subtask].words.on is None else 0.0
                if calm <= abs(late) < EXPECTED:
                    learnt = self.late.get(move.place, 0.0) + LEARNS * late
                    self.late[move.place] = min(max(learnt, -MOST_LATE), MOST_LATE)

    def missed(self) -> list[float]:
        """Return how far each palm is from where its move goes, 0 where that is no place [m]."""
        found, places = list[float](), self.moving.places
        for arm, k in zip(self.arms, self._next, strict=True):
            rows = self.moves[HANDS.index(arm.side)]
            spots = self.goals[rows[k - 1].subtask].spots if k else ()
            away = places[arm.palm] - places[spots[-1]] if spots else np.zeros(3)
            found.append(float(np.sqrt((away * away).sum())))
        return found

    def _control(self, now: float) -> None:
        for arm in self.arms:
            arm.control(now)
        hand = self.looks_to
        if hand is None and self.looks_at is not None:
            hand = self.moving.places[self.looks_at]
        self._trunk[:] = self.carriage.control(now, self.tick, self._eyes, self._chest, hand)

    def _set_out(self, now: float) -> None:
        """Begin the moves whose time has come."""
        for k, arm in enumerate(self.arms):
            rows, i = self.moves[k], self._next[k]
            while i < len(rows) and rows[i].begin <= now + 1e-9:
                if not self._posed[k]:
                    self._begin(arm, rows[i], now)
                i += 1
            self._next[k] = i
            poses = self._poses[k]
            while poses and poses[0].begin <= now + 1e-9:
                one = poses.popleft()
                if one.subtask is None:
                    self.release(arm.side, one.land)
                else:
                    self.hold_at(arm.side, one.subtask, one.land)
        while self._trunk_keys and self._trunk_keys[0][0] <= now + 1e-9:
            angles = self._trunk_keys.popleft()[1]
            if angles is None:
                self.carriage.given.update(dict.fromkeys(self._trunk_posed, 0.0))
                self._trunk_posed.clear()
            else:
                self._trunk_posed.update(angles)
                self.carriage.given.update(angles)

    def change(self, moves: Mapping[str, Sequence[Move]], beat: float, start: float) -> None:
        """Dance something else from now on; no moves at all to stand still.

        Args:
            moves: of each hand, in the order of time.
            beat: duration of a beat [s].
            start: of the first [s].
        """
        for k, side in enumerate(HANDS):
            self.moves[k] = [*self.moves[k][: self._next[k]], *moves.get(side, ())]
        sways = any(moves.values())
        self.carriage.sways(math.radians(self.words.sway_deg) if sways else 0.0, beat, start)

    def hears(self, late: Mapping[BarPosition, float]) -> None:
        """Take in what practice has taught: how late hands come [s]."""
        self.late.update(late)
        self.calm = CALM if self.late else 0.0

    def freeze(self) -> None:
        """Keep still, hands where they are."""
        self.change({}, self.carriage.beat, self.now)
        for arm in self.arms:
            arm.hold(self.now)

    def hang(self, land: float) -> None:
        """Let the arms hang that are not posed, by `land` [s]; hold trunk and head upright."""
        self.change({}, self.carriage.beat, self.now)
        posed = self._trunk_posed
        self.carriage.given.update({joint: posed.get(joint, 0.0) for joint in TRUNK_JOINTS})
        for k, arm in enumerate(self.arms):
            # What is not over is not gone back to either.
            self.moves[k], self._next[k] = [], 0
            if not self._posed[k]:
                self._lower(arm, land)

    def look(self, place: Array | None) -> None:
        """Look at a place (3,) from now on [m]; None for where its hand goes, if it does so."""
        self.looks_to = place
        self.carriage.gaze = self.words.gaze or place is not None

    def hold_at(self, side: str, subtask: int, land: float) -> None:
        """Hold a hand as a subtask says, from `land` on [s], instead of dancing with it."""
        k = HANDS.index(side)
        self._posed[k] = True
        self._begin(self.arms[k], Move(subtask, 0, self.now, land), self.now)

    def release(self, side: str, land: float) -> None:
        """Let a hand go back to what it did, to be there by `land` [s]."""
        k = HANDS.index(side)
        if not self._posed[k]:
            return
        self._posed[k] = False
        done = self.moves[k][: self._next[k]]
        if not done:
            self._lower(self.arms[k], land)
            return
        again = replace(done[-1], begin=self.now, land=max(done[-1].land, land))
        self._begin(self.arms[k], again, self.now)

    def _lower(self, arm: ArmController, land: float) -> None:
        self._begin(arm, Move(self._hang[arm.side], 0, self.now, land), self.now)

    def _begin(self, arm: ArmController, move: Move, now: float) -> None:
        goal = self.goals[move.subtask]
        meant = self._meant[HANDS.index(arm.side)]
        meant[:] = [*meant[-1:], move]
        land = move.land - self.late.get(move.place, 0.0)
        by_fields = self._controller(arm.side, goal.words.controller) == "force-field"
        arm.drive(by_fields)
        self.looks_at = arm.palm
        self.carriage.given.update(goal.trunk | self._trunk_posed)
        if by_fields:
            if goal.is_for_fields:
                arm.pull(goal, now, land)
            return
        if goal.words.is_of_joints:
            posture = np.where(goal.given, goal.held, arm.desired(now))
            arm.turn((posture,), now, land)
        else:
            rehearsed = self.postures[move.subtask]
            arm.turn(rehearsed.keys, now, land, rehearsed.meets)

    def _controller(self, side: str, own: Controller | None) -> Controller:
        given = self.words.controller
        if own is not None:
            return own
        if isinstance(given, Arms):
            return given.r if side == "r" else given.l
        return given

    def _needs_postures(self) -> bool:
        """Tell whether any subtask is done by torques."""
        return any(
            self._controller(goal.words.hand, goal.words.controller) == "joint-torque"
            for goal in self.goals
        )

    def _stand(self, ready: Mapping[str, Array]) -> None:
        for side in HANDS:
            own = slice(self.torso.arm(side).start, self.torso.wrist(side).stop)
            self.moving.q[own] = ready.get(side, hanging_posture())
        self.moving.targets[:] = self.moving.q
        self.moving.settle()


def rehearsed_motion(
    words: Dancer,
    choreography: Choreography,
    moves: Mapping[str, Sequence[Move]],
    beat: float,
    dt: float,
) -> DancerMotion:
    """Return a dancer about to begin, who has practised what is to be on a certain beat."""
    late = measure_lateness(words, choreography, moves, beat, dt)
    return DancerMotion(words, choreography, moves, beat, dt, late, CALM if late else 0.0)


def measure_lateness(
    words: Dancer,
    choreography: Choreography,
    moves: Mapping[str, Sequence[Move]],
    beat: float,
    dt: float,
) -> dict[BarPosition, float]:
    """Return how late the hands of a dancer come, as it finds by practice [s].

    It goes through the first bar again and again, or through two where it strikes on beats of
    the bar, hears how late its hands come, and keeps what came nearest: a hand that grazes its
    place touches it early or late and hardly ever in between.
    """
    numbers = {move.subtask for rows in moves.values() for move in rows}
    goals = [choreography.goals[number] for number in sorted(numbers)]
    strikes = any(goal.words.on is not None for goal in goals)
    touches = any(goal.surface is not None for goal in goals)
    if not strikes and not (touches and _is_in_time(words)):
        return {}
    steps = min(words.steps_a_second, PRACTICE_STEP_RATE)
    words = words.model_copy(update={"steps_a_second": steps})
    late, tried = dict[BarPosition, float](), dict[BarPosition, list[tuple[float, float]]]()
    for _ in range(ROUNDS):
        trial = DancerMotion(words, choreography, moves, beat, dt, late)
        _go_through(trial, 2 if strikes else 1)
        for place, error in trial.missed_by.items():
            tried.setdefault(place, []).append((late.get(place, 0.0), error))
        if max(map(abs, trial.missed_by.values()), default=0.0) < GOOD:
            break
        late = {place: _next(tried.get(place, ()), learnt) for place, learnt in trial.late.items()}
    kept = {
        place: min(rows, key=lambda row: (abs(row[1]), row))[0] for place, rows in tried.items()
    }
    # Later bars are begun with what the first has taught.
    return {(subtask, k, True): lead for (subtask, k, _), lead in kept.items()} | kept


def _next(tried: Sequence[tuple[float, float]], learnt: float) -> float:
    """Return how much earlier to aim next: between what was too little and what too much.

    Args:
        tried: how much earlier it was aimed, and how late the hand came then [s].
        learnt: what follows from the last time alone [s].
    """
    late = max((row for row in tried if row[1] >= 0.0), default=None)
    early = min((row for row in tried if row[1] < 0.0), default=None)
    if late is None or early is None or late[0] >= early[0]:
        return learnt
    (low, over), (high, under) = late, early
    return low + (high - low) * over / (over - under)


def _go_through(trial: DancerMotion, bars: int) -> None:
    """Let a dancer dance some bars, and go on for a while after the last move of them."""
    lands = [m.land for rows in trial.moves for m in rows if m.bar < bars]
    until = max(lands, default=0.0) + EXPECTED
    while trial.now < until:
        trial.advance()


def _is_in_time(words: Dancer) -> bool:
    """Tell whether hands are to come on beats."""
    return words.durations is None or words.tempo_bpm is not None


def with_gains(torso: Torso, gains: Gains) -> Torso:
    """Return a torso whose servos and fields work as hard as the author says."""
    if gains == Gains():
        return torso
    links = tuple(
        replace(
            link,
            hinges=tuple(
                replace(
                    hinge,
                    stiffness=hinge.stiffness * gains.stiffness,
                    damping=hinge.damping * gains.damping,
                )
                for hinge in link.hinges
            ),
        )
        for link in torso.linkage.links
    )
    linkage = replace(torso.linkage, links=links, drag=torso.linkage.drag * gains.drag)
    return replace(torso, linkage=linkage)
