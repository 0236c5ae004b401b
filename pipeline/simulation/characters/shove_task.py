"""Shove task: going up to somebody and pushing both palms against the chest.

The hands are drawn back before the own chest and strike out. Once a palm is at the chest, the
momentum of the body behind it passes over at a stroke: muscles would damp a slow push away before
it slackened them. It grows with the mass of the person, and it is taken from the person in turn,
save for what the feet bear.

Source: Horswill 2008, "Grappling", where arms are held out in walking on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.biped_gait import VELOCITY_GAIN
from pipeline.simulation.characters.encounter import Encounter, closing_pace
from pipeline.simulation.characters.grasp import lift_over_knees
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import HAND, PELVIS, SHOULDERS, SPINE, SWINGING
from pipeline.simulation.characters.person_tasks import (
    Approach,
    Task,
    place_text,
    shoulder_height,
)
from pipeline.simulation.characters.standoff import BOWED_RANGE
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.people.proportions import SEGMENT_MASSES
from pipeline.simulation.spatial import Array

SHOVING_RANGE = 0.95  # of palms before the own middle when they strike, in arm lengths
SHOVING_RATE = 1.5  # speed of the last steps to a shove, by the distance that is left [1/s]
FOLLOWING_TIME = 2.0 / VELOCITY_GAIN  # by which it walks ahead of one that walks on [s]
DRAWING_RANGE = 0.6  # beyond the former, within which hands are drawn back, in arm lengths
STRIKING_RANGE = 0.2  # beyond the former, within which they strike, in arm lengths
SHOVING_TOLERANCE = math.radians(30.0)  # of the turn to the partner
HIGHEST, LOWEST = 0.45, 0.75  # of the hands above and below the own shoulders, in arm lengths

DRAWING_TIME = 0.4  # for which hands are drawn back, as a rule [s]
STRIKING_TIME = 0.3  # in which they strike out and push [s]
LOWERING_TIME = 0.6  # in which they sink [s]
SHOVING_PATIENCE = 3.0  # of one that is near and does not get to strike [s]
OFF_BALANCE = 0.25  # slackness of the muscles of one that is pushed itself and cannot strike

LUNGE = 0.85  # of the distance to which the person steps in as it strikes
LUNGED_SPEED = 0.3  # of one that steps back, which the lunge makes up for while it lasts [m/s]
DRAWN = 0.22, -0.15, 0.05  # of a drawn hand from its shoulder, ahead, up and inward, in arm lengths
STRETCH = 1.7  # of the place to which a hand strikes, beyond its reach, for it lags behind
PALM_DEPTH = 0.11  # of a wrist from the middle of the chest that it pushes, in heights of both
PUSHING_FROUDE = 0.5  # momentum of a push, per mass of the person, in √(g l) of its legs
MOST_PUSHED_FROUDE = 0.54  # of whom it pushes, likewise; a stronger person holds back
SLACKENED = 0.4  # slackness of the muscles of one that is pushed, by its speed [s/m]
ARMS_MASS = 2.0 * sum(SEGMENT_MASSES[name] for name in ("upper_arm", "forearm", "hand"))
"""Mass that strikes with the palms, as a fraction of the body."""

STRIKING_SPEED = 2.5  # of palms at most that push and do not punch [m/s]
TRUNK_LENGTH = 0.29  # from the pelvis to the shoulders, in heights
UNBRACED = 0.25  # part of the momentum that the feet do not bear
BRACING_TIME = 0.35  # for which whoever sees the hands drawn back braces for the push [s]
YIELDING_TIME = 0.03  # by which the other strikes first, from which one braces instead [s]


@dataclass
class Grapple(Task):
    """Go to a character and shove it once.

    Attributes:
        owner: number of the character.
        drawing_time: for which it draws the hands back, at least [s].
        near: time for which the person is near [s].
        drawn: time since the hands are drawn back [s], 0 before.
        struck: time since they strike [s], 0 before.
        has_pushed: whether the momentum has passed over.
        palm_speed: of the faster palm against the chest in the step before, as they strike [m/s].
        encounter: with the character.
        approach: to it.
    """

    owner: int
    drawing_time: float = DRAWING_TIME
    near: float = 0.0
    drawn: float = 0.0
    struck: float = 0.0
    has_pushed: bool = False
    palm_speed: float = 0.0
    encounter: Encounter = field(default_factory=Encounter)
    approach: Approach = field(default_factory=Approach)

    @property
    def is_over(self) -> bool:
        """Whether the hands have struck and sunk again."""
        return self.struck > STRIKING_TIME + LOWERING_TIME

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.struck > STRIKING_TIME:
            if self.struck <= STRIKING_TIME + dt:
                controller.stop()
            self.struck += dt
            _lower_hands(controller)
            if self.is_over and not self.has_pushed:
                self.stick(f"misses at {place_text(controller)}")
            return self.is_over and not self.failure
        chest = self._chest(controller)
        is_low = self._is_low(controller, chest)
        partner = chest if is_low else controller.view.pelvis(self.owner)
        if self.struck > 0.0:
            self._strike(controller, chest, dt)
            return False
        stop = self._range(controller, chest)
        share = self.encounter.share_of_way(controller, partner, stop, dt)
        # Whoever slows down before the place of one that walks on never gets near.
        leaving = self.encounter.leaving
        short = max(stop + share - FOLLOWING_TIME * leaving, 0.0)
        reason = self.approach.walk_to(controller, partner, short, self.owner, dt)
        left = controller.ground_distance(partner) - stop
        self.most_pace = leaving + closing_pace(controller, left - share, SHOVING_RATE)
        if left > DRAWING_RANGE * controller.arm:
            self.near = self.drawn = 0.0
            _lower_hands(controller)
            self.stick(reason, self.approach)
            return False
        self.near += dt
        if is_low:
            self._reach_down(controller, chest, dt)
        else:
            self._draw_back(controller, left, dt)
        if self.struck == 0.0 and self.near > SHOVING_PATIENCE:
            self.stick(f"does not get to shove at {place_text(controller)}")
        return False

    def _range(self, controller: PersonController, chest: Array) -> float:
        """Return the distance from which the palms get to the chest [m]."""
        is_low = self._is_low(controller, chest)
        reach = (BOWED_RANGE if is_low else SHOVING_RANGE) * controller.arm
        return reach + 0.5 * PALM_DEPTH * self._size(controller)

    def _is_low(self, controller: PersonController, chest: Array) -> bool:
        """Tell whether a chest is too low to be pushed from standing upright."""
        return bool(chest[1] < shoulder_height(controller) - 1.01 * LOWEST * controller.arm)

    def _is_tall(self, controller: PersonController) -> bool:
        """Tell whether the character stands so tall that hands get no higher than its belly."""
        spine = float(controller.view.nodes(self.owner)[SPINE, 1])
        return spine > shoulder_height(controller) + HIGHEST * controller.arm

    def _size(self, controller: PersonController) -> float:
        """Return the height of the character [m]."""
        nodes = controller.view.nodes(self.owner)
        return math.dist(nodes[PELVIS], nodes[SHOULDERS]) / TRUNK_LENGTH

    def _chest(self, controller: PersonController) -> Array:
        """Return (3,) the place to push, as high as the person reaches [m]."""
        view = controller.view
        nodes, shoulder = view.nodes(self.owner), shoulder_height(controller)
        low, high = shoulder - LOWEST * controller.arm, shoulder + HIGHEST * controller.arm
        place: Array = 0.3 * nodes[SPINE] + 0.7 * nodes[SHOULDERS]
        if nodes[SHOULDERS, 1] - nodes[SPINE, 1] > 0.05:
            # A smaller or a taller one where it can be reached.
            place[1] = max(min(place[1], high), min(low, float(nodes[SHOULDERS, 1])))
        return place

    def _draw_back(self, controller: PersonController, left: float, dt: float) -> None:
        """Draw the hands back before the chest, and strike as soon as the chest is in reach."""
        left_to_draw = self.drawing_time - self.drawn - dt
        # Whom somebody else is about to push first yields.
        is_late = float(controller.record.seen_push_left) < left_to_draw - YIELDING_TIME
        if is_late or float(controller.record.stun) > OFF_BALANCE:
            self.drawn = 0.0
            _lower_hands(controller)
            return
        self.drawn += dt
        ahead = controller.ahead
        right = np.array([-ahead[2], 0.0, ahead[0]])
        forth, up, inward = (size * controller.arm for size in DRAWN)
        for k in range(2):
            if not controller.is_holding(k):
                side = inward if k == 0 else -inward
                place = controller.shoulder(k) + forth * ahead + side * right
                place[1] += up
                controller.put_hand(k, place)
        partner = controller.view.pelvis(self.owner)
        self._threaten(controller)
        turn = float(controller.direction_to(partner) @ ahead)
        is_facing = turn > math.cos(SHOVING_TOLERANCE)
        if is_facing and self.drawn > self.drawing_time and left < STRIKING_RANGE * controller.arm:
            self.struck = dt

    def _reach_down(self, controller: PersonController, chest: Array, dt: float) -> None:
        """Bow to one that lies, and strike as soon as a palm is at it."""
        for k in range(2):
            if not controller.is_holding(k):
                controller.put_hand(k, chest + lift_over_knees(controller, k, chest))
                if self._is_at_chest(controller, k):
                    self.struck = dt

    def _strike(self, controller: PersonController, chest: Array, dt: float) -> None:
        """Stretch the arms to the chest and beyond, and push while the palms are there."""
        self.struck += dt
        ahead = controller.direction_to(chest)
        self._threaten(controller)
        self.most_pace = math.inf
        ahead_by = FOLLOWING_TIME * max(self.encounter.leaving - LUNGED_SPEED, 0.0)
        short = max(LUNGE * self._range(controller, chest) - ahead_by, 0.0)
        controller.go(chest[0], chest[2], short, self.owner)
        right = np.array([-ahead[2], 0.0, ahead[0]])
        is_touching = False
        for k in range(2):
            if controller.is_holding(k):
                continue
            shoulder, side = controller.shoulder(k), 1.0 if k == 1 else -1.0
            aim = chest + 0.5 * side * float(controller.record.shoulders) * right
            way = aim - shoulder
            reach = STRETCH * controller.arm / max(float(np.linalg.norm(way)), 1e-6)
            controller.put_hand(k, shoulder + reach * way)
            is_touching |= self._is_at_chest(controller, k)
        if self.has_pushed:
            return
        if is_touching:
            self.has_pushed = True
            controller.touched.append(controller.view.names[self.owner])
            self._push(controller, ahead)
        # In the next step a chest may have stopped them already.
        self.palm_speed = self._palm_speed(controller)

    def _threaten(self, controller: PersonController) -> None:
        """Tell the person of the push: it turns a shoulder to it, and the face away."""
        person = controller.view.persons.get(self.owner)
        if person is None:
            return
        way = controller.direction_to(controller.view.pelvis(self.owner))
        left = 0.0 if self.struck > 0.0 else self.drawing_time - self.drawn
        told = float(person.push_left), float(person.push_way[0]), float(person.push_way[1])
        # Of several pushes in this step the soonest counts, whoever comes first in the cast.
        if person.push_warning < BRACING_TIME or (left, way[0], way[2]) < told:
            person.push_way[0], person.push_way[1] = way[0], way[2]
            person.push_left = left
        person.push_warning = BRACING_TIME

    def _is_at_chest(self, controller: PersonController, k: int) -> bool:
        """Tell whether a palm is at the trunk of the character."""
        view, hand = controller.view, controller.hand(k)
        nodes = view.nodes(self.owner)
        depth = PALM_DEPTH * 0.5 * float(controller.record.height)
        a, b = nodes[SPINE], nodes[SHOULDERS]
        if self._is_tall(controller):
            # A small child gets no higher than the belly of a tall adult.
            a, b = nodes[PELVIS], nodes[SPINE]
        share = float((hand - a) @ (b - a)) / max(float((b - a) @ (b - a)), 1e-9)
        near = a + min(max(share, 0.0), 1.0) * (b - a)
        return math.dist(hand, near) < depth + PALM_DEPTH * 0.5 * self._size(controller)

    def _push(self, controller: PersonController, ahead: Array) -> None:
        """Pass on the momentum of the body, ahead (3,), and the blow of the palms."""
        view, person = controller.view, controller.record
        own, other, masses = int(person.owner), self.owner, view.arrays.owners["mass"]
        ratio = float(masses[own] / masses[other])
        pushed = view.persons[other] if other in view.persons else person
        push = PUSHING_FROUDE * math.sqrt(GRAVITY * float(person.hip_height)) * ratio
        most = MOST_PUSHED_FROUDE * math.sqrt(GRAVITY * float(pushed.hip_height))
        restraint = min(most / push, 1.0)
        speed = push * restraint
        fastest = max(self.palm_speed, self._palm_speed(controller))
        struck = restraint * min(fastest, STRIKING_SPEED)
        view.push(other, speed * ahead, SLACKENED * speed)
        view.push(own, -UNBRACED * speed / ratio * ahead, 0.0)
        view.strike(other, "chest", own, 0.5 * ARMS_MASS * float(masses[own]) * struck * struck)

    def _palm_speed(self, controller: PersonController) -> float:
        """Return the speed of the faster palm against the chest [m/s]."""
        view, person = controller.view, controller.record
        chest = int(view.arrays.owners["nodes"][self.owner, 0]) + SHOULDERS
        hands = [int(person.node) + HAND + k for k in range(2)]
        return max(view.speed_between(hand, chest) for hand in hands)


def _lower_hands(controller: PersonController) -> None:
    """Let empty hands sink."""
    for k in range(2):
        if not controller.is_holding(k):
            controller.record.arm_mode[k] = SWINGING
