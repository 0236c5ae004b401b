"""Pain reflex: flinching and withdrawal of people who are told what to do.

An order and the withdrawal from pain compete by activation. The more obedient a person is, the
more pain it bears: from half of that on it flinches, shields its face and looks at the striker,
and goes on with what it does; beyond it steps back, a shoulder to the striker, and then goes on.
People with a mind that follow no order withdraw by their own behaviour.

Source: Horswill 2008, "High-level Control" (pain withdrawal, a fast, open-loop retreat from a
    source of pain; the highest activation is chosen) and "Tactile sensing" (pain decays).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.pain_rise import PainRise
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import PLACED, STANDING, SWINGING
from pipeline.simulation.characters.person_tasks import Task
from pipeline.simulation.characters.step_report import CRY, hardest_toucher
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher
from pipeline.simulation.characters.visibility_route import are_free
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.spatial import Array

BORNE_PAIN = 3.0  # by a person that is as obedient as not
FLINCH_PART = 0.5  # of the activation of withdrawal over that of the order

WITHDRAWAL_TIME = 0.8  # [s]
WITHDRAWAL_DISTANCE = 1.4  # [m]
WITHDRAWAL_FROUDE = 0.42  # pace, in √(g l)
WITHDRAWAL_FACING = math.radians(60.0)  # from the striker to where a person faces meanwhile
STRAIGHT_BACK = math.radians(155.0)  # from the striker to a way on which either shoulder serves
WITHDRAWAL_TURNS = tuple(math.radians(k) for k in (0.0, 35.0, -35.0, 70.0, -70.0))
"""Directions tried aside from straight away [rad]."""

LEAST_STEP_BACK = 0.1  # shorter than which there is no way back [m]
EDGE_MARGIN = 0.5  # of a withdrawal from the edge of the terrain [m]
WITHDRAWAL_PAUSE = 1.0  # after one before the next, or an order would never be done [s]
FLINCH_TIME = 0.5  # [s]
SHIELD = (0.13, -0.02, 0.07)  # of hands before the head, ahead, up and aside, in heights
WALKED_ROUND = 0.9  # of the distance to what a person stands in


def step_back_goal(
    at: Array, away: float, bounds: tuple[Array, Array], is_free: Callable[[Array], bool]
) -> Array:
    """Return the place (2,) to which a person steps back from pain [m].

    Args:
        at: (2,) where it is [m].
        away: direction from the source of the pain, counterclockwise from X in the XZ plane [rad].
        bounds: least and greatest x and z (2,) [m].
        is_free: tells whether the way to a place is free.
    """
    goals = [
        np.clip(
            at + WITHDRAWAL_DISTANCE * np.array([math.cos(away + turn), math.sin(away + turn)]),
            bounds[0] + EDGE_MARGIN,
            bounds[1] - EDGE_MARGIN,
        )
        for turn in WITHDRAWAL_TURNS
    ]
    return next((goal for goal in goals if is_free(goal)), goals[0])


def step_back_way(at: Array, goal: Array, away: float) -> float:
    """Return the heading of the way to where a person steps back [rad].

    Straight away from the striker where the edge of the ground leaves it no such way.

    Args:
        at: (2,) where it is [m].
        goal: (2,) where it steps to [m].
        away: as for `step_back_goal` [rad].
    """
    x, z = float(goal[0] - at[0]), float(goal[1] - at[1])
    way = math.atan2(-z, x)
    is_back = abs(math.remainder(way + away, 2.0 * math.pi)) < 0.5 * math.pi
    return way if is_back and math.hypot(x, z) > LEAST_STEP_BACK else -away


def withdrawal_facing(heading: float, to_striker: float, way: float) -> float:
    """Return where a person faces that steps back from pain [rad].

    It turns a shoulder to the striker, so that it sees where it steps: the one that turns it to its
    way, or the nearer one where it goes straight back.

    Args:
        heading: of the person [rad].
        to_striker: direction of the source of the pain [rad].
        way: direction in which it steps back [rad].
    """
    turned = math.remainder(way - to_striker, 2.0 * math.pi)
    if abs(turned) > STRAIGHT_BACK:
        turned = math.remainder(heading - to_striker, 2.0 * math.pi)
    return to_striker + math.copysign(WITHDRAWAL_FACING, turned)


@dataclass
class _Walk:
    """A walk that a withdrawal interrupts, and by which it goes on.

    Attributes:
        task: of the person.
        state: fields of its record.
    """

    task: Task | None
    state: Mapping[str, Array]


@dataclass
class _Reflex:
    """The reflex of one person.

    Attributes:
        striker: number of the character that struck it last, NOBODY for none.
        flinch_end: [s].
        withdrawal_end: [s].
        goal: (2,) of the withdrawal [m].
        way: heading of the way to it [rad].
        walk: that it interrupts, None while there is no withdrawal.
        shielded: places of hands that shield the face, by the number of the hand [m].
    """

    striker: int = NOBODY
    flinch_end: float = -math.inf
    withdrawal_end: float = -math.inf
    goal: Array = field(default_factory=lambda: np.zeros(2))
    way: float = 0.0
    walk: _Walk | None = None
    shielded: dict[int, Array] = field(default_factory=dict)


WALK_FIELDS = (
    *("has_goal", "goal", "stop_distance", "partner", "neighbour_distance"),
    *("has_facing", "facing", "pace", "posture"),
)
"""Fields of a record that a withdrawal changes."""


class PainReflexes:
    """The reflexes of all acting people of a troupe.

    Args:
        dispatcher: of their tasks.
        obediences: of the people, from 0 to 1, in the order of the controllers.
        pains: of the people.
    """

    def __init__(
        self, dispatcher: TaskDispatcher, obediences: Sequence[float], pains: PainRise
    ) -> None:
        self._dispatcher, self._pains = dispatcher, pains
        self._obediences = obediences
        self._reflexes = [_Reflex() for _ in obediences]
        self._owners = [int(one.record.owner) for one in dispatcher.controllers]
        self._active = set[int]()

    def react(self, now: float) -> None:
        """React to the blows of the last step, after tasks have commanded; `now` in [s]."""
        if self._pains.largest > CRY.pain:
            for k in np.flatnonzero(self._pains.added > CRY.pain).tolist():
                self._feel(k, now)
        for k in sorted(self._active):
            self._advance(k, now)

    def _feel(self, k: int, now: float) -> None:
        """Let a person feel a blow."""
        dispatcher, reflex = self._dispatcher, self._reflexes[k]
        controller = dispatcher.controllers[k]
        own_mind = k in dispatcher.minded and not dispatcher.is_ordered(k)
        striker = hardest_toucher(dispatcher.view.arrays, self._owners[k])
        if own_mind or striker < 0 or _is_held(controller, striker):
            return
        order, withdrawal = self._obediences[k], 1.0 - self._obediences[k]
        withdrawal *= float(self._pains.pain[k]) / BORNE_PAIN
        if withdrawal <= FLINCH_PART * order:
            return
        reflex.striker, reflex.flinch_end = striker, now + FLINCH_TIME
        self._active.add(k)
        is_rested = now > reflex.withdrawal_end + WITHDRAWAL_PAUSE
        if withdrawal > order and is_rested and _can_step(controller):
            self._withdraw(k, now)

    def _withdraw(self, k: int, now: float) -> None:
        dispatcher, reflex = self._dispatcher, self._reflexes[k]
        controller, record = dispatcher.controllers[k], dispatcher.controllers[k].record
        state = {name: np.copy(record[name]) for name in WALK_FIELDS}
        reflex.walk = _Walk(dispatcher.task(k), state)
        dispatcher.suspended.add(k)
        reflex.withdrawal_end = now + WITHDRAWAL_TIME
        at, source = np.array(record.at), controller.view.pelvis(reflex.striker)[[0, 2]]
        middles, radii = controller.obstacles()
        reaches = radii + controller.body_radius
        distances = np.sqrt(((middles - at) ** 2).sum(axis=1))
        reaches = np.minimum(reaches, WALKED_ROUND * distances)
        away = math.atan2(at[1] - source[1], at[0] - source[0])
        reflex.goal = step_back_goal(
            at,
            away,
            controller.view.edges,
            lambda goal: bool(are_free(at, goal[None], middles, reaches)[0]),
        )
        reflex.way = step_back_way(at, reflex.goal, away)

    def _advance(self, k: int, now: float) -> None:
        """Command a person in its reflex, or end it."""
        dispatcher, reflex = self._dispatcher, self._reflexes[k]
        controller, record = dispatcher.controllers[k], dispatcher.controllers[k].record
        controller.look_at(dispatcher.view.face(reflex.striker))
        if reflex.walk is not None:
            if dispatcher.task(k) is not reflex.walk.task:
                # A new order is obeyed at once.
                reflex.withdrawal_end = now
            if now < reflex.withdrawal_end:
                controller.go(float(reflex.goal[0]), float(reflex.goal[1]))
                record.startled = True
                record.pace = WITHDRAWAL_FROUDE * math.sqrt(GRAVITY * record.hip_height)
                place = dispatcher.view.pelvis(reflex.striker)
                x, z = place[0] - record.at[0], place[2] - record.at[1]
                heading, to_striker = float(record.heading), math.atan2(-z, x)
                record.has_facing = True
                record.facing = withdrawal_facing(heading, to_striker, reflex.way)
            else:
                self._resume(k)
        if now < reflex.flinch_end:
            _shield(controller, reflex)
        else:
            _lower(controller, reflex)
            if reflex.walk is None:
                self._active.discard(k)

    def _resume(self, k: int) -> None:
        """End a withdrawal; the person goes on with what it did."""
        dispatcher, reflex = self._dispatcher, self._reflexes[k]
        record, walk = dispatcher.controllers[k].record, reflex.walk
        dispatcher.suspended.discard(k)
        reflex.walk, record.startled = None, False
        if walk is None:
            return
        task = dispatcher.task(k)
        for name in WALK_FIELDS if task is walk.task else ("pace",):
            record[name] = walk.state[name]
        if task is None and walk.task is None and not record.has_goal and not record.has_facing:
            controller = dispatcher.controllers[k]
            controller.face_to(controller.view.pelvis(reflex.striker))


def _is_held(controller: PersonController, owner: int) -> bool:
    """Tell whether a person embraces, holds or is held by a character: that is no blow."""
    arrays, record = controller.view.arrays, controller.record
    if owner == record.owner or int(arrays.owners["embraces"][record.owner]) == owner:
        return True
    first, count = (int(n) for n in arrays.owners["nodes"][record.owner])
    partners = arrays.nodes["grip_partner"][first : first + count]
    return bool((partners == owner).any()) or int(arrays.owners["embraces"][owner]) == record.owner


def _can_step(controller: PersonController) -> bool:
    """Tell whether a person can step back: it neither sits nor is told to freeze."""
    record = controller.record
    is_up = float(record.sit_blend) == 0.0 and int(record.posture) == STANDING
    return is_up and not bool(record.frozen) and int(record.kick_foot) < 0


def _shield(controller: PersonController, reflex: _Reflex) -> None:
    """Hold free hands before the face."""
    record, ahead = controller.record, controller.ahead
    face = controller.view.face(int(record.owner))
    right = np.array([-ahead[2], 0.0, ahead[0]])
    for k in range(2):
        is_free = record.arm_mode[k] == SWINGING and not controller.is_holding(k)
        if is_free or (k in reflex.shielded and _is_shielding(controller, reflex, k)):
            out, up, aside = (size * float(record.height) for size in SHIELD)
            place = face + out * ahead + (aside if k == 1 else -aside) * right
            place[1] += up
            controller.put_hand(k, place)
            reflex.shielded[k] = place


def _is_shielding(controller: PersonController, reflex: _Reflex, k: int) -> bool:
    """Tell whether a hand is still where the reflex has sent it."""
    record = controller.record
    is_placed = record.arm_mode[k] == PLACED
    return bool(is_placed and (record.arm_target[k] == reflex.shielded[k]).all())


def _lower(controller: PersonController, reflex: _Reflex) -> None:
    """Let hands hang again that nothing else has been asked of."""
    for k in tuple(reflex.shielded):
        if _is_shielding(controller, reflex, k):
            controller.record.arm_mode[k] = SWINGING
        del reflex.shielded[k]
