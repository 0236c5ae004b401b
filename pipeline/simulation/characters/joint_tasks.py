"""Joint tasks: what tasks of several people make of one another, whatever the order of the cast.

Places that are shared, loads that two carry, and things that one asks another for.
"""

from __future__ import annotations

from collections.abc import Mapping

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.crew import CarryEnd, crew_of
from pipeline.simulation.characters.hand_over import ASKING_TIME, HandOver, holder_of
from pipeline.simulation.characters.handling_tasks import CarryTo
from pipeline.simulation.characters.hug_tasks import Hug, LoosenHug
from pipeline.simulation.characters.person_tasks import SitDown, Task
from pipeline.simulation.characters.task_book import TaskBook
from pipeline.spec.gesture import REFUSE


def share_slots(people: TaskBook) -> None:
    """Let those who need slots take them, the nearest first."""
    waiting = [
        (task.slot_distance(controller), controller.name, task, controller)
        for k, task in people.busy(Task)
        if task.wants_slot and not task.failure and (controller := people.controllers[k])
    ]
    if not waiting:
        return
    for _, _, task, controller in sorted(waiting, key=lambda claim: claim[:2]):
        task.take_slot(controller)


def form_crews(people: TaskBook) -> None:
    """Let two who are told to carry the same thing to the same place do that together."""
    loads: dict[tuple[str, str], list[int]] = {}
    for k, task in people.busy(CarryTo):
        if people.is_ordered(k) and not task.is_down:
            if not people.controllers[k].hands_holding(task.thing):
                loads.setdefault((task.thing, task.walk.target), []).append(k)
    for (thing, target), carriers in loads.items():
        if len(carriers) < 2:
            continue
        pair = sorted(carriers, key=lambda k: people.controllers[k].name)[:2]
        crew = crew_of(thing, target, [people.controllers[k] for k in pair])
        for number, k in enumerate(pair):
            people.replace(k, CarryEnd(crew, number))


def advance_crews(people: TaskBook, dt: float) -> None:
    """Advance what pairs carry by a step of `dt` [s], once for the two."""
    for _, task in people.busy(CarryEnd):
        if task.number == 0:
            task.crew.advance(dt)


def ask_holders(people: TaskBook, asked: list[float], dt: float) -> dict[int, HandOver]:
    """Return what is handed over, by the giver; askers of a busy holder wait.

    Args:
        people: of the troupe.
        asked: time for which each has asked in vain [s]; changed.
        dt: the step [s].
    """
    givings: dict[int, HandOver] = {}
    for k, task in people.busy(Task):
        taker = people.controllers[k]
        if not people.is_ordered(k) or not (thing := task.asks_for(taker)):
            continue
        giver = None
        if not taker.hands_holding(thing):
            giver = holder_of(thing, taker, people.controllers)
        number = None if giver is None else people.index(giver.name)
        if giver is None or number is None:
            task.asked, task.giver = 0.0, NOBODY
            continue
        task.giver = int(giver.record.owner)
        is_busy, refusal = people.is_ordered(number) or number in givings, ""
        if number in people.minded:
            asker, owner = int(taker.record.owner), people.view.owner(thing)
            refusal = people.minded[number].refusal_to_give(asker, owner)
        if is_busy or refusal:
            task.asked = asked[k] = asked[k] + dt
            if task.asked > ASKING_TIME:
                task.failure = " and ".join(filter(None, [f"{giver.name} holds it", refusal]))
                people.gestures.append((number, REFUSE, taker.name))
        else:
            task.asked = 0.0
            givings[number] = HandOver(giver, taker, thing)
    return givings


def stand_to_give(people: TaskBook, givings: Mapping[int, HandOver]) -> set[int]:
    """Let people with a mind stand who hold out what another comes for; return their indices.

    They leave off what they do of their own will, but for sitting and for a hug.
    """
    if not givings:
        return set()
    keeps = Hug, LoosenHug, SitDown
    giving = {
        k
        for k, one in givings.items()
        if one.is_near and k in people.minded and not isinstance(people.task(k), keeps)
    }
    for k in sorted(giving - people.giving):
        people.end(k)
    return giving
