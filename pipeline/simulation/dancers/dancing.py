"""Dancing: one dancer in motion, sub-step by sub-step, in the frame that it stands in."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.dancers.arms import Arm
from pipeline.simulation.dancers.carriage import TRUNK, Carriage
from pipeline.simulation.dancers.fields import RATE
from pipeline.simulation.dancers.goals import Choreography, rest_posture
from pipeline.simulation.dancers.moves import Move, Occasion
from pipeline.simulation.dancers.rehearsal import postures_of, ready_postures
from pipeline.simulation.dancers.torso import HANDS, LINKS, Torso
from pipeline.simulation.dancers.touching import Strike, Touching
from pipeline.simulation.dynamics.mujoco_linkage import Moving
from pipeline.simulation.spatial import Array
from pipeline.spec.cast import Dancer
from pipeline.spec.dance import Controller
from pipeline.spec.dancer import Arms, Gains

TICKS = 96
"""How often a second controllers look at least; what depends on speeds alone acts at every step."""

EARLY = 0.012
"""How long before its beat a hand aims to touch [s]: a moment late is seen a frame late."""

EXPECTED, LEARNS, MOST_LATE = 0.2, 0.7, 0.25
"""How far from its time a touch is taken for the one that was meant [s]; how much of an error is
made up for the next time, and how much in all [s]."""

ROUNDS, GOOD, CALM = 4, 0.01, 0.025
"""How often a dance is practised at most; how near to its time every touch is good enough; how
far from it one of the body may be later on before more is made up for: less than a frame of a
film [s]."""

HEAD, CHEST = LINKS.index("head"), LINKS.index("chest")


class Dancing:
    """A dancer in motion.

    Args:
        words: of the dancer.
        choreography: its dance, on its torso.
        moves: of each hand, in the order of time.
        beat: duration of a beat [s].
        dt: that it is advanced by at once [s].
        late: how late its hands come to each place of the bar, as far as it knows [s].
        calm: how far from its time a touch may be before anything is made up for [s].

    Attributes:
        late: likewise, as it has learnt by now [s].
        missed_by: how far from the time it aims at it last touched, by place of the bar [s].
    """

    def __init__(
        self,
        words: Dancer,
        choreography: Choreography,
        moves: Mapping[str, Sequence[Move]],
        beat: float,
        dt: float,
        late: Mapping[Occasion, float] | None = None,
        calm: float = 0.0,
    ) -> None:
        self.words, self.goals = words, choreography.goals
        self.torso = tuned(choreography.torso, words.gains)
        self.ticks = max(math.ceil(dt * TICKS - 1e-9), 1)
        self.tick = dt / self.ticks
        self.substeps = max(math.ceil(self.tick * words.steps_a_second - 1e-9), 1)
        self.moving = Moving(self.torso.linkage, self.tick / self.substeps)
        self.postures = postures_of(choreography) if self._needs_postures() else ()
        self._stand(ready_postures(choreography))
        rate = RATE * words.gains.rate
        self.arms = [
            Arm(side, self.torso, self.moving, rate, words.combine == "winner") for side in HANDS
        ]
        self.moves = [list(moves[side]) for side in HANDS]
        self._next = [0] * len(HANDS)
        self.late, self.calm = dict(late or {}), calm
        self.missed_by: dict[Occasion, float] = {}
        self._meant: list[list[Move]] = [[] for _ in HANDS]
        self.carriage = Carriage(math.radians(words.sway_deg), beat, words.start, words.gaze)
        self.touching = Touching(self.moving)
        self.count = 0
        for arm in self.arms:
            arm.drive(self._controller(arm.side, None) == "force-field")
            if not arm.by_fields:
                self.moving.targets[arm.all] = self.moving.q[arm.all]
        self.looks_at: int | None = None
        self._eyes, self._chest = self.moving.place_of(HEAD), self.moving.turned(CHEST)
        self._trunk = self.moving.targets[: len(TRUNK)]

    @property
    def now(self) -> float:
        """The time since it began [s]."""
        return self.count * self.tick

    def advance(self) -> list[Strike]:
        """Go on by one step of the world; return what its hands have touched."""
        found = list[Strike]()
        for _ in range(self.ticks):
            now = self.count * self.tick
            self._set_out(now)
            self._control(now)
            found += self._go(now)
            self.count += 1
        return found

    def _go(self, now: float) -> list[Strike]:
        """Go on by one tick; return what hands have touched in it."""
        found, done, step = list[Strike](), 0, self.tick / self.substeps
        while done < self.substeps:
            before = now + done * step
            done += self.moving.advance(self.substeps - done)
            strikes = self.touching.look(now + done * step, step, before)
            self._learn(strikes)
            found += strikes
        return found

    def _learn(self, strikes: Sequence[Strike]) -> None:
        """Hear how late hands came, to set out for the same the earlier the next time."""
        for strike in strikes:
            clap = strike.other.startswith("hand")
            for solid in (strike.hand, strike.other) if clap else (strike.hand,):
                k = HANDS.index(solid[-1])
                # A hand that comes late has the next move to do already.
                move = min(self._meant[k], key=lambda m: abs(strike.time - m.land), default=None)
                if move is None or not (clap or self.goals[move.subtask].surface):
                    continue
                late = strike.time - move.land + EARLY
                if abs(late) < EXPECTED:
                    self._meant[k].remove(move)
                    self.missed_by[move.place] = late
                if self.calm <= abs(late) < EXPECTED:
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
        hand = None if self.looks_at is None else self.moving.places[self.looks_at]
        self._trunk[:] = self.carriage.control(now, self.tick, self._eyes, self._chest, hand)

    def _set_out(self, now: float) -> None:
        """Begin the moves whose time has come."""
        for k, arm in enumerate(self.arms):
            rows, i = self.moves[k], self._next[k]
            while i < len(rows) and rows[i].begin <= now + 1e-9:
                self._begin(arm, rows[i], now)
                i += 1
            self._next[k] = i

    def _begin(self, arm: Arm, move: Move, now: float) -> None:
        goal = self.goals[move.subtask]
        meant = self._meant[HANDS.index(arm.side)]
        meant[:] = [*meant[-1:], move]
        land = move.land - self.late.get(move.place, 0.0)
        by_fields = self._controller(arm.side, goal.words.controller) == "force-field"
        arm.drive(by_fields)
        self.looks_at = arm.palm
        self.carriage.given.update(goal.trunk)
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
            self.moving.q[own] = ready.get(side, rest_posture())
        self.moving.targets[:] = self.moving.q
        self.moving.settle()


def practised(
    words: Dancer,
    choreography: Choreography,
    moves: Mapping[str, Sequence[Move]],
    beat: float,
    dt: float,
) -> Dancing:
    """Return a dancer about to begin, who has practised what is to be on a certain beat.

    It goes through the first bar again and again, or through two where it strikes on beats of
    the bar, hears how late its hands come, and keeps what came nearest: a hand that grazes its
    place touches it early, or late, or not at all.
    """
    strikes = any(goal.words.on is not None for goal in choreography.goals)
    touches = any(goal.surface is not None for goal in choreography.goals)
    if not strikes and not (touches and _is_in_time(words)):
        return Dancing(words, choreography, moves, beat, dt)
    late, best = dict[Occasion, float](), dict[Occasion, tuple[float, float]]()
    for _ in range(ROUNDS):
        trial = Dancing(words, choreography, moves, beat, dt, late)
        _go_through(trial, 2 if strikes else 1)
        for place, error in trial.missed_by.items():
            found = abs(error), late.get(place, 0.0)
            best[place] = min(best.get(place, found), found)
        late = trial.late
        if max(map(abs, trial.missed_by.values()), default=0.0) < GOOD:
            break
    kept = {place: lead for place, (_, lead) in best.items()}
    # Later bars are begun with what the first has taught.
    kept = {(subtask, k, True): lead for (subtask, k, _), lead in kept.items()} | kept
    return Dancing(words, choreography, moves, beat, dt, kept, 0.0 if strikes else CALM)


def _go_through(trial: Dancing, bars: int) -> None:
    """Let a dancer dance some bars, and go on for a while after the last move of them."""
    lands = [m.land for rows in trial.moves for m in rows if m.bar < bars]
    until = max(lands, default=0.0) + EXPECTED
    while trial.now < until:
        trial.advance()


def _is_in_time(words: Dancer) -> bool:
    """Tell whether hands are to come on beats."""
    return words.durations is None or words.tempo_bpm is not None


def tuned(torso: Torso, gains: Gains) -> Torso:
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
