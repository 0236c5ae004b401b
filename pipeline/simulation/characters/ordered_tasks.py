"""Ordered tasks: the task of a person for each order of the script."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.character_view import CharacterView
from pipeline.simulation.characters.contact_tasks import Grab, Reach
from pipeline.simulation.characters.dance_task import Dance
from pipeline.simulation.characters.grasp import hands_needed
from pipeline.simulation.characters.handling_tasks import CarryTo, GrabMember, ThrowAt
from pipeline.simulation.characters.hug_tasks import Hug
from pipeline.simulation.characters.kick_task import KickThing
from pipeline.simulation.characters.person_controller import (
    HANDS,
    PersonController,
)
from pipeline.simulation.characters.person_tasks import Task, Turn, Walk
from pipeline.simulation.characters.pursuit_tasks import (
    ChaseTarget,
    FleeTarget,
    FollowTarget,
    WalkUp,
)
from pipeline.simulation.characters.push_task import PushRound
from pipeline.simulation.characters.queue_task import QueueUp
from pipeline.simulation.characters.ride_task import RideCarousel, RideSolid
from pipeline.simulation.characters.seat_task import SitOn
from pipeline.simulation.characters.shove_task import Grapple
from pipeline.simulation.characters.soothe_task import Soothe
from pipeline.spec import script as spec
from pipeline.spec.script import Do
from pipeline.spec.verbs import VERBS, key_of_order

ORDERS_BY_NODES = (
    *(spec.Reach, spec.Hug, spec.Grapple, spec.SitOn, spec.LookAt),
    *(spec.Ride, spec.PushRound, spec.Soothe),
)
"""Orders that find characters of this room by their nodes, not by their states."""

DEFAULT_GAP = 0.02
"""Distance at which a person stops before the surface of a member, just clear of it [m]."""


def members_named(order: Do, view: CharacterView) -> set[str]:
    """Return the members that an order names and whose states it needs."""
    if isinstance(order, str):
        return set()
    by_nodes = isinstance(order, ORDERS_BY_NODES)
    names = (getattr(order, key) for key in VERBS[key_of_order(order) or ""].targets)
    return {
        name for name in names if isinstance(name, str) and not (by_nodes and view.owner(name) >= 0)
    }


def task_of_order(controller: PersonController, order: Do) -> Task | None:
    """Return the task for an order, None for one that needs none."""
    build = TASKS.get(type(order))
    return build(controller, order) if build is not None else None


def _walk(controller: PersonController, order: spec.GoTo) -> Task:
    goal = order.go_to
    if isinstance(goal, str):
        return WalkUp(goal, DEFAULT_GAP if order.gap is None else order.gap)
    controller.go(*goal)
    return Walk(np.array(goal, dtype=float))


def _turn(controller: PersonController, order: spec.TurnBy) -> Task:
    controller.turn_to(float(controller.record.heading) + math.radians(order.turn_deg))
    return Turn()


def _follow(controller: PersonController, order: spec.Follow) -> Task:
    return FollowTarget(order.follow, order.gap)


def _chase(controller: PersonController, order: spec.Chase) -> Task:
    return ChaseTarget(order.chase)


def _flee(controller: PersonController, order: spec.Flee) -> Task:
    return FleeTarget(controller.view.target_name(order.flee), order.distance)


def _reach(controller: PersonController, order: spec.Reach) -> Task:
    hands = HANDS[order.hand]
    if not isinstance(order.reach, str):
        return Reach(hands, np.array(order.reach))
    owner = controller.view.owner(order.reach)
    return Reach(hands, None, owner, order.reach if owner == NOBODY else "")


def _grab(controller: PersonController, order: spec.Grab) -> Task:
    return _taking(controller, order, order.grab, order.part)


def _taking(
    controller: PersonController,
    order: spec.Grab | spec.Carry,
    name: str,
    part: str | None = None,
) -> Grab | GrabMember:
    """Return the task to take something: with both hands if it is too much for one."""
    view = controller.view
    owner, hands = view.owner(name), HANDS[order.hand]
    if owner != NOBODY and not view.is_ball(owner):
        return Grab(hands, owner, part)
    if "hand" not in order.model_fields_set:
        hands = hands_needed(controller, name)
    return GrabMember(name, hands)


def _carry(controller: PersonController, order: spec.Carry) -> Task:
    walk = WalkUp(controller.view.target_name(order.to))
    return CarryTo(order.carry, _taking(controller, order, order.carry), walk)


def _throw(controller: PersonController, order: spec.Throw) -> Task:
    return ThrowAt(controller.view.target_name(order.to), order.throw)


def _kick(controller: PersonController, order: spec.Kick) -> Task:
    to = None if order.to is None else controller.view.target_name(order.to)
    return KickThing(order.kick, to, order.speed)


def _hug(controller: PersonController, order: spec.Hug) -> Task:
    partner = controller.view.number(order.hug)
    return Hug(partner, controller.view.size(partner))


def _grapple(controller: PersonController, order: spec.Grapple) -> Task:
    return Grapple(controller.view.number(order.grapple))


def _sit_on(controller: PersonController, order: spec.SitOn) -> Task:
    owner = controller.view.owner(order.sit)
    return SitOn(owner, order.sit if owner == NOBODY else "")


def _ride(controller: PersonController, order: spec.Ride) -> Task:
    owner = controller.view.owner(order.ride)
    return RideSolid(order.ride) if owner == NOBODY else RideCarousel(order.ride, owner)


def _push(controller: PersonController, order: spec.PushRound) -> Task:
    return PushRound(controller.view.number(order.push), order.turns)


def _queue(controller: PersonController, order: spec.QueueUp) -> Task:
    heading = None if order.from_deg is None else math.radians(order.from_deg)
    return QueueUp(controller.view.target_name(order.queue), order.lasts, heading)


def _soothe(controller: PersonController, order: spec.Soothe) -> Task:
    return Soothe(controller.view.number(order.soothe))


def _dance(controller: PersonController, order: spec.Perform) -> Task:
    return Dance(order, controller.view.dances[controller.name])


TASKS: Mapping[type, Callable[[PersonController, Any], Task]] = {
    spec.GoTo: _walk,
    spec.TurnBy: _turn,
    spec.Follow: _follow,
    spec.Chase: _chase,
    spec.Flee: _flee,
    spec.Reach: _reach,
    spec.Grab: _grab,
    spec.Carry: _carry,
    spec.Throw: _throw,
    spec.Kick: _kick,
    spec.Hug: _hug,
    spec.Grapple: _grapple,
    spec.SitOn: _sit_on,
    spec.Ride: _ride,
    spec.PushRound: _push,
    spec.Perform: _dance,
    spec.QueueUp: _queue,
    spec.Soothe: _soothe,
}
"""Builders of tasks by the kind of order."""
