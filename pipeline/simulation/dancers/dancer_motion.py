"""Dancer motion: one dancer, control by control, in the frame in which it stands."""

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
from pipeline.simulation.dancers.torso import HANDS, LINKS, with_gains
from pipeline.simulation.dancers.trunk_control import TRUNK_JOINTS, TrunkController
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.spatial import Array
from pipeline.spec.dance import Controller
from pipeline.spec.dancer import Arms, Dancer

CONTROL_RATE = 96
"""Least number of controls a second; damping acts in every step of the dynamics."""

AIM_AHEAD = 0.012
"""Time before its beat at which a touch is aimed [s]: a moment late would show a frame late."""

MATCH_WINDOW = 0.2
"""Largest error at which a touch counts as the one that was planned [s]."""

LEARNING_RATE = 0.9
"""Fraction of a timing error that the next attempt makes up for."""

LEAD_LIMIT = 0.25
"""Largest lead that is learnt [s]."""

TOUCH_TOLERANCE = 0.025
"""Error of a touch on the body that is not corrected after practice [s]: less than a frame."""

NO_POSES = Poses()

HEAD, CHEST = LINKS.index("head"), LINKS.index("chest")


class DancerMotion:
    """State of one dancer in motion.

    Args:
        config: the dancer in the scene.
        choreography: its subtasks on its torso.
        moves: moves of each hand, in order of time.
        beat: duration of a beat [s].
        dt: duration of a world step [s].
        late: known lateness of each touch [s].
        tolerance: error of a touch on the body that is not corrected [s].
        poses: poses that override the dance.
        hang: side -> number of the subtask that lets the arm hang.

    Attributes:
        late: lateness learnt so far [s].
        timing_errors: time of the last touch minus its target time, by position in the bar [s].
        gaze_site: number of the site that the head follows; None at the start.
        gaze_place: (3,) place that the head faces instead [m]; None for none.
    """

    def __init__(
        self,
        config: Dancer,
        choreography: Choreography,
        moves: Mapping[str, Sequence[Move]],
        beat: float,
        dt: float,
        late: Mapping[BarPosition, float] | None = None,
        tolerance: float = 0.0,
        poses: Poses = NO_POSES,
        hang: Mapping[str, int] | None = None,
    ) -> None:
        self.config, self.goals = config, choreography.goals
        self.torso = with_gains(choreography.torso, config.gains)
        self.controls_per_step = max(math.ceil(dt * CONTROL_RATE - 1e-9), 1)
        self.control_time = dt / self.controls_per_step
        self.substeps = max(math.ceil(self.control_time * config.steps_a_second - 1e-9), 1)
        self.moving = LinkageSimulation(self.torso.linkage, self.control_time / self.substeps)
        self.postures = key_postures(choreography) if self._needs_postures() else ()
        self._take_start_posture(ready_postures(choreography))
        rate = FIELD_RATE * config.gains.rate
        self.arms = [
            ArmController(side, self.torso, self.moving, rate, config.combine == "winner")
            for side in HANDS
        ]
        self.moves = [list(moves[side]) for side in HANDS]
        self._next = [0] * len(HANDS)
        self._hang = hang or {}
        self._pose_moves = [deque(poses.hands.get(side, ())) for side in HANDS]
        self._trunk_keys = deque(poses.trunk)
        self._trunk_pose: dict[str, float] = {}
        self._is_posed = [False] * len(HANDS)
        self.late, self.tolerance = dict(late or {}), tolerance
        self.timing_errors: dict[BarPosition, float] = {}
        self._current_moves: list[list[Move]] = [[] for _ in HANDS]
        self.trunk = TrunkController(math.radians(config.sway_deg), beat, config.start, config.gaze)
        self.contacts = HandContacts(self.moving)
        self.count = 0
        for arm in self.arms:
            arm.drive(self._controller(arm.side, None) == "force-field")
            if not arm.by_fields:
                self.moving.targets[arm.all] = self.moving.q[arm.all]
        self.gaze_site: int | None = None
        self.gaze_place: Array | None = None
        self._eyes, self._chest = self.moving.place_of(HEAD), self.moving.turned(CHEST)
        self._trunk_targets = self.moving.targets[: len(TRUNK_JOINTS)]

    @property
    def now(self) -> float:
        """Time since the start [s]."""
        return self.count * self.control_time

    @property
    def is_posed(self) -> bool:
        """Whether a pose or an order holds a hand."""
        return any(self._is_posed)

    def advance(self) -> list[HandStrike]:
        """Advances by one world step; returns the strikes of the hands."""
        strikes = list[HandStrike]()
        for _ in range(self.controls_per_step):
            now = self.count * self.control_time
            self._start_moves(now)
            self._control(now)
            strikes += self._integrate(now)
            self.count += 1
        return strikes

    def _integrate(self, now: float) -> list[HandStrike]:
        """Advances the dynamics by one control; returns the strikes of the hands."""
        found, done, step = list[HandStrike](), 0, self.control_time / self.substeps
        while done < self.substeps:
            before = now + done * step
            done += self.moving.advance(self.substeps - done)
            strikes = self.contacts.update(now + done * step, step, before)
            self._learn(strikes)
            found += strikes
        return found

    def _learn(self, strikes: Sequence[HandStrike]) -> None:
        """Updates the known lateness from the times of strikes."""
        for strike in strikes:
            clap = strike.other.startswith("hand")
            for solid in (strike.hand, strike.other) if clap else (strike.hand,):
                k = HANDS.index(solid[-1])
                # A late hand has already begun its next move.
                move = min(
                    self._current_moves[k], key=lambda m: abs(strike.time - m.land), default=None
                )
                # A hand on its way to a surface claps with no other.
                if move is None or clap == (self.goals[move.subtask].surface is not None):
                    continue
                late = strike.time - move.land + AIM_AHEAD
                if abs(late) < MATCH_WINDOW:
                    self._current_moves[k].remove(move)
                    self.timing_errors[move.place] = late
                # Strikes on beats of the bar are always corrected.
                on_beat = self.goals[move.subtask].subtask.on is not None
                tolerance = 0.0 if on_beat else self.tolerance
                if tolerance <= abs(late) < MATCH_WINDOW:
                    learnt = self.late.get(move.place, 0.0) + LEARNING_RATE * late
                    self.late[move.place] = min(max(learnt, -LEAD_LIMIT), LEAD_LIMIT)

    def target_distances(self) -> list[float]:
        """Returns the distance of each palm to the end of its move [m]; 0 without a place."""
        found, places = list[float](), self.moving.places
        for arm, k in zip(self.arms, self._next, strict=True):
            rows = self.moves[HANDS.index(arm.side)]
            sites = self.goals[rows[k - 1].subtask].sites if k else ()
            away = places[arm.palm] - places[sites[-1]] if sites else np.zeros(3)
            found.append(float(np.sqrt((away * away).sum())))
        return found

    def _control(self, now: float) -> None:
        for arm in self.arms:
            arm.control(now)
        target = self.gaze_place
        if target is None and self.gaze_site is not None:
            target = self.moving.places[self.gaze_site]
        self._trunk_targets[:] = self.trunk.control(
            now, self.control_time, self._eyes, self._chest, target
        )

    def _start_moves(self, now: float) -> None:
        """Starts the moves and poses that are due."""
        for k, arm in enumerate(self.arms):
            rows, i = self.moves[k], self._next[k]
            while i < len(rows) and rows[i].begin <= now + 1e-9:
                if not self._is_posed[k]:
                    self._start_move(arm, rows[i], now)
                i += 1
            self._next[k] = i
            poses = self._pose_moves[k]
            while poses and poses[0].begin <= now + 1e-9:
                pose = poses.popleft()
                if pose.subtask is None:
                    self.release(arm.side, pose.land)
                else:
                    self.hold_at(arm.side, pose.subtask, pose.land)
        while self._trunk_keys and self._trunk_keys[0][0] <= now + 1e-9:
            angles = self._trunk_keys.popleft()[1]
            if angles is None:
                self.trunk.base_angles.update(dict.fromkeys(self._trunk_pose, 0.0))
                self._trunk_pose.clear()
            else:
                self._trunk_pose.update(angles)
                self.trunk.base_angles.update(angles)

    def change(self, moves: Mapping[str, Sequence[Move]], beat: float, start: float) -> None:
        """Replaces the moves to come; without any the dancer stands still.

        Args:
            moves: moves of each hand, in order of time.
            beat: duration of a beat [s].
            start: time of the first beat [s].
        """
        for k, side in enumerate(HANDS):
            self.moves[k] = [*self.moves[k][: self._next[k]], *moves.get(side, ())]
        sway = math.radians(self.config.sway_deg) if any(moves.values()) else 0.0
        self.trunk.set_sway(sway, beat, start)

    def set_lateness(self, late: Mapping[BarPosition, float]) -> None:
        """Adds the lateness that practice measured [s]."""
        self.late.update(late)
        self.tolerance = TOUCH_TOLERANCE if self.late else 0.0

    def freeze(self) -> None:
        """Stops with the hands where they are."""
        self.change({}, self.trunk.beat, self.now)
        for arm in self.arms:
            arm.hold(self.now)

    def hang(self, land: float) -> None:
        """Lowers arms without a pose by `land` [s]; holds trunk and head upright."""
        self.change({}, self.trunk.beat, self.now)
        pose = self._trunk_pose
        self.trunk.base_angles.update({joint: pose.get(joint, 0.0) for joint in TRUNK_JOINTS})
        for k, arm in enumerate(self.arms):
            # A released hand must not resume a move that was cut off.
            self.moves[k], self._next[k] = [], 0
            if not self._is_posed[k]:
                self._lower(arm, land)

    def look(self, place: Array | None) -> None:
        """Faces a place (3,) [m] from now on; None to follow the hand if `gaze` is set."""
        self.gaze_place = place
        self.trunk.gaze = self.config.gaze or place is not None

    def hold_at(self, side: str, subtask: int, land: float) -> None:
        """Holds a hand by a subtask from `land` on [s], instead of dancing with it."""
        k = HANDS.index(side)
        self._is_posed[k] = True
        self._start_move(self.arms[k], Move(subtask, 0, self.now, land), self.now)

    def release(self, side: str, land: float) -> None:
        """Returns a held hand to its last move by `land` [s]."""
        k = HANDS.index(side)
        if not self._is_posed[k]:
            return
        self._is_posed[k] = False
        done = self.moves[k][: self._next[k]]
        if not done:
            self._lower(self.arms[k], land)
            return
        again = replace(done[-1], begin=self.now, land=max(done[-1].land, land))
        self._start_move(self.arms[k], again, self.now)

    def _lower(self, arm: ArmController, land: float) -> None:
        self._start_move(arm, Move(self._hang[arm.side], 0, self.now, land), self.now)

    def _start_move(self, arm: ArmController, move: Move, now: float) -> None:
        goal = self.goals[move.subtask]
        current = self._current_moves[HANDS.index(arm.side)]
        current[:] = [*current[-1:], move]
        land = move.land - self.late.get(move.place, 0.0)
        by_fields = self._controller(arm.side, goal.subtask.controller) == "force-field"
        arm.drive(by_fields)
        self.gaze_site = arm.palm
        self.trunk.base_angles.update(goal.trunk | self._trunk_pose)
        if by_fields:
            if goal.sites:
                arm.pull(goal, now, land)
            return
        if goal.subtask.is_of_joints:
            posture = np.where(goal.given, goal.held, arm.desired(now))
            arm.turn((posture,), now, land)
        else:
            rehearsed = self.postures[move.subtask]
            arm.turn(rehearsed.keys, now, land, rehearsed.meets)

    def _controller(self, side: str, own: Controller | None) -> Controller:
        """Returns the controller of an arm; a subtask's own one takes precedence."""
        default = self.config.controller
        if own is not None:
            return own
        if isinstance(default, Arms):
            return default.r if side == "r" else default.l
        return default

    def _needs_postures(self) -> bool:
        """Returns whether joint torques perform any subtask."""
        return any(
            self._controller(goal.subtask.hand, goal.subtask.controller) == "joint-torque"
            for goal in self.goals
        )

    def _take_start_posture(self, ready: Mapping[str, Array]) -> None:
        for side in HANDS:
            joints = slice(self.torso.arm(side).start, self.torso.wrist(side).stop)
            self.moving.q[joints] = ready.get(side, hanging_posture())
        self.moving.targets[:] = self.moving.q
        self.moving.settle()
