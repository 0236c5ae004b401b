"""Handling tasks: grabbing members of other rooms, carrying, putting down and throwing."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.contact_tasks import (
    GRAB_PATIENCE,
    PATIENCE,
    STANDING_RANGE,
    STOPPED_SLACK,
    STOPPING_SLACK,
    Grab,
)
from pipeline.simulation.characters.grasp import (
    grasp_failure,
    grasp_place,
    half_extent,
    hold_members,
    lift_over_knees,
    mass_of,
)
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import SWINGING
from pipeline.simulation.characters.person_tasks import Task, place_text, shoulder_height
from pipeline.simulation.characters.pursuit_tasks import CHASE_PATIENCE, TargetTask, WalkUp
from pipeline.simulation.characters.standoff import (
    BOWED_RANGE,
    BOWING_TOLERANCE,
    LEAST_RANGE,
    Standoff,
)
from pipeline.simulation.characters.task_progress import TaskProgress
from pipeline.simulation.characters.throw_flight import launch_velocity
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.members import MemberState
from pipeline.simulation.spatial import Array

CLOSING_DISTANCE, PATIENT_CLOSING_DISTANCE = 0.03, 0.09  # of a hand to its place, in heights
BOWING_TIME = 0.5  # by which a person looks ahead where a rolling thing will be [s]
ROLLING_SPEED = 0.3  # from which a thing is hurried after [m/s]
CATCH_UP_SPEED = 0.6  # beyond that of a thing that rolls away [m/s]
HAND_DELAY = 0.15  # by which hands are behind the place that they are sent to [s]

# Putting down.
TABLE_RANGE = 0.12, 0.75  # heights of surfaces that things are put down on, in heights
PUT_DOWN_GAP = 0.03  # above the surface at which hands open [m]
PUT_DOWN_TIME = 4.0  # after which they open anyway, if there is something below [s]
MOST_BOWED_RANGE = 1.0  # of hands that put down before the middle of a person, in arm lengths
PUTTING_LEAD = 0.3  # by which hands that put down are led at most [m]
INWARD = 2.0  # of a thing from the edge of a surface, in half its least width
OPENING_TIME = 0.4  # of hands that have put down or thrown [s]
AT_GOAL = 0.4  # of a thing from its goal, in which it is carried there [m]
ON_TABLE = 0.1  # below a surface, within which a thing still lies on it [m]
RESTING_SPEED, SETTLING_TIME = 0.1, 1.5  # of what is put down [m/s], and time left to it [s]

# Throwing.
WINDUP_TIME, SWING_TIME = 0.25, 0.15  # [s]
AIM_TOLERANCE, AIM_TIME = 0.12, 4.0  # of the turn to the target [rad]; to take it [s]
THROW_SPEED = 8.5  # of the fastest throw, by the height of the thrower [1/s]
RISING_TIME = 1.5  # after which even who stays bowed throws [s]
ARM_MASS = 0.06  # that is thrown along with a thing, in the person's mass


@dataclass
class GrabMember(TargetTask):
    """Go to a member of another room and take it, with one hand or both.

    Attributes:
        hands: numbers of the hands.
        time: since it is within reach [s].
        is_walking: whether the person goes up to it.
        progress: of the hands.
        pursuit: the distance to it, from the start.
        standoff: from low things.
    """

    hands: tuple[int, ...] = (1,)
    time: float = 0.0
    is_walking: bool = True
    progress: TaskProgress = field(default_factory=TaskProgress)
    pursuit: TaskProgress = field(default_factory=TaskProgress)
    standoff: Standoff = field(default_factory=Standoff)

    def asks_for(self, controller: PersonController) -> str:
        """See `Task`."""
        return self.target

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        held = controller.hands_holding(self.target)
        self.leads_hands = bool(held) and held != self.hands
        if held == self.hands:
            return True
        if reason := grasp_failure(controller, self.target, self.hands):
            self.failure = reason
            return False
        state, person = controller.view.state(self.target), controller.record
        if held:
            self._change_hands(controller, state, held, dt)
            return False
        place = state.nearest(controller.waist())
        is_high = place[1] - person.floor > 0.4 * person.height
        both = len(self.hands) == 2
        if both and not is_high:
            place = 0.5 * (
                grasp_place(controller, state, 0, both) + grasp_place(controller, state, 1, both)
            )
        soon = place + BOWING_TIME * state.v * np.array([1.0, 0.0, 1.0])
        near = (STANDING_RANGE if is_high else BOWED_RANGE) * controller.arm
        distance = controller.ground_distance(soon)
        is_stopped = not person.has_goal or self.standoff.is_stepping
        if self._rolls_away(controller, state, dt):
            return False
        if distance > near + (STOPPED_SLACK if is_stopped else STOPPING_SLACK) * controller.arm:
            self.standoff.is_stepping, self.is_walking = False, True
            self.stick(self.walk_to(controller, soon, near, dt), self.approach)
            return False
        if self.is_walking:
            self.is_walking, self.pace, self.progress = False, 0.0, TaskProgress()
            controller.stop()
        if self.asked > 0.0:
            controller.face_to(state.centre)
        else:
            self._take(controller, state, place, soon, dt)
        return False

    def _take(
        self,
        controller: PersonController,
        state: MemberState,
        place: Array,
        soon: Array,
        dt: float,
    ) -> None:
        """Turn to the thing, bow if it is low, and close the hands around it.

        Args:
            controller: of the person.
            state: of the thing.
            place: (3,) where it is taken [m].
            soon: (3,) where that will be once the person is down [m].
            dt: the step [s].
        """
        person = controller.record
        is_high = place[1] - person.floor > 0.4 * person.height
        stuck = self.progress.time
        if not is_high and not self.standoff.is_kept(controller, place, soon, dt, stuck):
            self.progress, self.time = TaskProgress(), 0.0
            return
        controller.face_to(state.centre)
        if not is_high and not controller.is_facing(BOWING_TOLERANCE):
            # One who bows first would stir the feet under bent knees.
            self._check_progress(controller, controller.turn_left, dt, "cannot turn to it")
            return
        self._close_hands(controller, state, len(self.hands) == 2, dt)

    def _rolls_away(self, controller: PersonController, state: MemberState, dt: float) -> bool:
        """Hurry after what rolls away; give up what comes no nearer, however far one gets."""
        speed = float(state.v @ controller.direction_to(state.centre))
        distance = controller.ground_distance(state.centre)
        self.pursuit.update(distance, dt)
        if speed < ROLLING_SPEED:
            self.pace = 0.0
            return False
        # Nobody catches up with it at a walk.
        self.pace = min(speed + CATCH_UP_SPEED, controller.best_pace)
        if self.pursuit.idle_time > CHASE_PATIENCE and not controller.record.frozen:
            self.failure = f"is not fast enough; still {distance:.2g} m off"
        return bool(self.failure)

    def _change_hands(
        self, controller: PersonController, state: MemberState, held: tuple[int, ...], dt: float
    ) -> None:
        """Take what is in a hand with other hands, before the waist."""
        controller.stop()
        right = np.array([-controller.ahead[2], 0.0, controller.ahead[0]])
        width, depth = (half_extent(state, axis) for axis in (right, controller.ahead))
        farthest = 0.0
        for k in {*held, *self.hands}:
            if k in held:
                controller.lead_hand(k, controller.place_before(k, width, depth))
            else:
                wrist = grasp_place(controller, state, k, both=True)
                controller.lead_hand(k, wrist)
                farthest = max(farthest, math.dist(controller.hand(k), wrist))
        if farthest < PATIENT_CLOSING_DISTANCE * controller.record.height:
            for k in held:
                if k not in self.hands:
                    controller.let_go(k)
            controller.take(self.target, self.hands)
            return
        self._check_progress(
            controller,
            farthest,
            dt,
            f"has it in one hand; the other stays {farthest:.2f} m off it,",
        )

    def _close_hands(
        self, controller: PersonController, state: MemberState, both: bool, dt: float
    ) -> None:
        """Send hands to the thing, and close them when all are there."""
        person = controller.record
        self.time += dt
        closing = CLOSING_DISTANCE if self.time < PATIENCE else PATIENT_CLOSING_DISTANCE
        farthest = 0.0
        for k in self.hands:
            wrist = grasp_place(controller, state, k, both)
            lift = lift_over_knees(controller, k, wrist)
            controller.put_hand(k, wrist + HAND_DELAY * state.v + lift)
            farthest = max(farthest, math.dist(controller.hand(k), wrist))
        if farthest < closing * person.height:
            controller.take(self.target, self.hands)
            person.has_facing = False
            return
        self._check_progress(controller, farthest, dt, f"stays {farthest:.2f} m out of reach")

    def _check_progress(
        self, controller: PersonController, distance: float, dt: float, reason: str
    ) -> None:
        """Give up what comes no nearer; what hangs too high, without a second try."""
        if self.progress.update(distance, dt) > GRAB_PATIENCE:
            lowest = float(controller.view.state(self.target).low[1])
            self.stick(f"{reason} at {place_text(controller)}")
            self.is_stuck = lowest - shoulder_height(controller) < controller.arm


@dataclass
class CarryTo(Task):
    """Take something, go somewhere with it, and put it down.

    Attributes:
        thing: name of what is carried.
        grab: that takes it.
        walk: to where it is put down.
        time: since it is being put down, and since the hands are open [s].
        is_down: whether the hands are open.
        is_there: whether the thing has come to rest at its goal, whatever becomes of it later.
    """

    thing: str
    grab: Grab | GrabMember
    walk: WalkUp
    time: float = 0.0
    is_down: bool = False
    is_there: bool = False

    @property
    def members(self) -> tuple[str, ...]:
        """See `Task`."""
        return (self.thing, self.walk.target)

    def asks_for(self, controller: PersonController) -> str:
        """See `Task`."""
        return "" if self.is_down else self.grab.asks_for(controller)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.is_down:
            self.is_there = self.is_there or self._has_come_to_rest(controller, dt)
            return self.is_there
        if len(controller.hands_holding(self.thing)) < len(self.grab.hands):
            self.grab.asked, self.grab.giver = self.asked, self.giver
            self.grab.advance(controller, dt)
            self.failure = self.grab.failure or self.failure
            self.is_stuck = self.grab.is_stuck
            self.pace = self.grab.pace
            self.leads_hands = self.grab.leads_hands
            return False
        self.leads_hands, self.pace = False, 0.0
        thing, goal = controller.view.state(self.thing), controller.view.state(self.walk.target)
        surface = _table_height(controller, goal)
        if surface is None and not goal.solids:
            # So that it hangs above the place.
            self.walk.gap = BOWED_RANGE * controller.arm
        if not self.walk.advance(controller, dt):
            if self.walk.failure:
                self.stick(f"{self.walk.failure}; still holds '{self.thing}'", self.walk.approach)
            return False
        self._put_down(controller, thing, goal, surface, dt)
        return False

    def _has_come_to_rest(self, controller: PersonController, dt: float) -> bool:
        """Tell whether the thing has come to rest at its goal; fail if it has elsewhere."""
        self.time += dt
        thing = controller.view.state(self.thing)
        is_at_rest = float(np.linalg.norm(thing.v)) < RESTING_SPEED
        if self.time <= OPENING_TIME or not (is_at_rest or self.time > SETTLING_TIME):
            return False
        self.stick(self._miss(controller, thing))
        return not self.failure

    def _miss(self, controller: PersonController, thing: MemberState) -> str:
        """Return how far from its goal the thing has come to rest, "" if it is there."""
        goal = controller.view.state(self.walk.target)
        offset = goal.nearest(thing.centre) - thing.centre
        distance = math.hypot(offset[0], offset[2])
        if distance > AT_GOAL:
            return f"'{self.thing}' lies {distance:.2g} m off '{self.walk.target}'"
        if (
            _table_height(controller, goal) is not None
            and thing.centre[1] < goal.high[1] - ON_TABLE
        ):
            return f"'{self.thing}' does not lie on '{self.walk.target}'"
        return ""

    def _aside(self, controller: PersonController) -> Array:
        """Return (3,) from the middle of a person to where it puts down what it holds [m].

        One hand puts down before its own shoulder: on the way to the middle the thigh would bar it.
        """
        hands = controller.hands_holding(self.thing)
        side = 0.0 if len(hands) == 2 else (-1.0, 1.0)[hands[0]]
        ahead, half = controller.ahead, 0.5 * float(controller.record.shoulders)
        return side * half * np.array([-ahead[2], 0.0, ahead[0]])

    def _put_down(
        self,
        controller: PersonController,
        thing: MemberState,
        goal: MemberState,
        surface: float | None,
        dt: float,
    ) -> None:
        """Lead the hands down to the surface, and open them there."""
        self.leads_hands = True
        self.time += dt
        # Clear of the feet, which would send it rolling.
        before = BOWED_RANGE * controller.arm
        if surface is None and not goal.solids:
            controller.face_to(goal.centre)
            least, most = LEAST_RANGE * controller.arm, MOST_BOWED_RANGE * controller.arm
            before = min(max(controller.ground_distance(goal.centre), least), most)
        place = np.array([controller.record.at[0], 0.0, controller.record.at[1]])
        place += before * controller.ahead + self._aside(controller)
        floor = controller.view.ground_height(place[0], place[2])
        height = floor if surface is None else surface
        rise = height + 0.5 * PUT_DOWN_GAP - float(thing.low[1])
        move = np.array([place[0] - thing.centre[0], rise, place[2] - thing.centre[2]])
        is_over = surface is None
        # First up, then over the surface, then down.
        if surface is not None and rise < 0.05:
            depth = 0.5 * float(np.ptp(np.concatenate(thing.solids)[:, [0, 2]], axis=0).min())
            edge = goal.nearest(thing.centre)
            inward = goal.centre - edge
            inward[1] = 0.0
            farther = min(INWARD * depth / max(float(np.linalg.norm(inward)), 1e-9), 1.0)
            over = edge + farther * inward - thing.centre
            move[[0, 2]] = over[[0, 2]]
            rim = edge - thing.centre
            is_over = math.hypot(rim[0], rim[2]) < 0.01
            left = math.hypot(move[0], move[2])
            is_over &= left < 0.5 * depth + 0.02 or self.time > 0.5 * PUT_DOWN_TIME
            if not is_over:
                move[1] = max(rise, 0.06 - (thing.low[1] - height))
        hands = controller.hands_holding(self.thing)
        # Hands on two places of a thing stay on them.
        both = len(hands) == 2 and controller.held_node(0) == controller.held_node(1)
        for k in hands:
            hand = grasp_place(controller, thing, k, both) if both else controller.hand(k)
            wrist = hand + move
            lift = lift_over_knees(controller, k, wrist) if surface is None else 0.0
            controller.lead_hand(k, wrist + lift, PUTTING_LEAD)
        if self.time > PUT_DOWN_TIME and not is_over:
            reason = f"does not reach the top of '{self.walk.target}'"
            self.stick(f"{reason} at {place_text(controller)}; still holds '{self.thing}'")
        elif (abs(rise) < PUT_DOWN_GAP and is_over) or self.time > PUT_DOWN_TIME:
            controller.release(self.thing, np.zeros(3))
            if (owner := controller.view.owner(self.thing)) >= 0:
                controller.embrace(owner)
            self.leads_hands, self.is_down, self.time = False, True, 0.0


def _table_height(controller: PersonController, goal: MemberState) -> float | None:
    """Return the height of a surface that something can be put down on, None without any [m]."""
    person = controller.record
    above = float(goal.high[1] - person.floor) / float(person.height)
    is_table = goal.solids and TABLE_RANGE[0] < above < TABLE_RANGE[1]
    return float(goal.high[1]) if is_table else None


@dataclass
class ThrowAt(TargetTask):
    """Turn to a target, swing the arm back and forward, and let go of what is in the hand.

    Attributes:
        thing: name of what is thrown.
        aimed: time since the start [s].
        time: since the arm swings, -1 before [s].
        shortfall: distance by which a throw at full strength falls short [m].
        is_thrown: whether the hand is open.
    """

    thing: str = ""
    aimed: float = 0.0
    time: float = -1.0
    shortfall: float = 0.0
    is_thrown: bool = False
    grip: tuple[int, ...] = field(default=())

    @property
    def members(self) -> tuple[str, ...]:
        """See `Task`."""
        return (self.thing, self.target)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.is_thrown:
            self.time += dt
            if self.time > OPENING_TIME:
                for k in self.grip:
                    controller.record.arm_mode[k] = SWINGING
                controller.record.has_facing = False
                self.failure = self._shortfall_text()
            return self.time > OPENING_TIME and not self.failure
        hands = controller.hands_holding(self.thing)
        if not hands:
            self.failure = f"does not hold '{self.thing}'"
            return False
        target = controller.view.state(self.target)
        self.aimed += dt
        if self.time < 0.0:
            controller.face_to(target.centre)
            is_risen = controller.is_upright or self.aimed > RISING_TIME
            is_ready = controller.is_standing and is_risen
            if not (is_ready and controller.is_facing(AIM_TOLERANCE)):
                if self.aimed > AIM_TIME:
                    self.failure = f"cannot turn to '{self.target}' at {place_text(controller)}"
                hold_members(controller)
                return False
            self.time, self.leads_hands, self.grip = 0.0, True, hands
            if len(hands) == 2 and self.thing in controller.held_members.values():
                # From before the chest into the hand that swings.
                controller.release(self.thing)
                controller.hold_member(self.thing, (1,))
        self.time += dt
        self._swing(controller, target)
        if self.time >= WINDUP_TIME + SWING_TIME:
            self._let_fly(controller, target)
        return False

    def _swing(self, controller: PersonController, target: MemberState) -> None:
        """Lead the hands back and up, and then forward."""
        ahead = controller.direction_to(target.centre)
        right = np.array([-ahead[2], 0.0, ahead[0]])
        up = np.array([0.0, 1.0, 0.0])
        arm = controller.arm
        for k in self.grip:
            shoulder, side = controller.shoulder(k), 1.0 if k == 1 else -1.0
            if self.time < WINDUP_TIME:
                place = arm * (-0.55 * ahead + 0.6 * up + 0.25 * side * right)
            else:
                # Beyond where it gets to, for the hand lags behind.
                place = arm * (1.5 * ahead + 0.4 * up - 0.1 * side * right)
            controller.put_hand(k, shoulder + place)

    def _let_fly(self, controller: PersonController, target: MemberState) -> None:
        view, person = controller.view, controller.record
        thing, owner = view.state(self.thing), view.owner(self.thing)
        offset = target.centre - thing.centre
        if target.radius == 0.0:
            # A thing hits a place with its surface.
            offset = offset + np.array([0.0, 0.5 * float(thing.high[1] - thing.low[1]), 0.0])
        damping = 0.0
        if owner >= 0:
            nodes = view.arrays.nodes
            damping = float(nodes["air_damping"][int(view.arrays.owners["nodes"][owner, 0])])
        limit = THROW_SPEED * float(person.height) * self._strength(controller)
        v, self.shortfall = launch_velocity(offset, target.v, limit, GRAVITY, damping)
        controller.release(self.thing, v)
        if owner >= 0:
            controller.embrace(owner)
        for k in self.grip:
            controller.put_hand(k, controller.hand(k))
        self.is_thrown, self.leads_hands, self.time = True, False, 0.0

    def _shortfall_text(self) -> str:
        """Return that a throw fell short, "" if it did not."""
        if self.shortfall == 0.0:
            return ""
        return f"threw it as hard as it can, which falls {self.shortfall:.1f} m short"

    def _strength(self, controller: PersonController) -> float:
        """Return the speed of a throw, as a fraction of that of a light thing."""
        arm = ARM_MASS * float(controller.view.arrays.owners["mass"][controller.record.owner])
        return math.sqrt(arm / (arm + mass_of(controller, self.thing)))
