"""Second try: a person whose order is stuck steps aside once, and tries again from there.

A person that is stuck twice, or whose act cannot be done from anywhere, gives up visibly: its arms
sink, and it looks at the thing or person, and then down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_tasks import Task
from pipeline.simulation.characters.visibility_route import are_free
from pipeline.simulation.spatial import Array

LONGEST_WAY = 1.0  # to where the second try starts [m]
LEAST_DISTANCE = 0.8  # of that place from what the act is about [m]
TURNS = tuple(math.radians(turn) for turn in (70.0, -70.0, 35.0, -35.0, 110.0, -110.0))
"""Angles around what the act is about at which a second try starts, the best first."""

LONGEST_STEP_ASIDE = 1.2  # after which a person tries from where it has got to [s]
REGRET_TIME, LOOKING_TIME = 2.2, 0.9  # of giving up, and of the look at the thing in it [s]
DOWN = 0.8, 0.9  # where it looks then, ahead and below the head, in heights


@dataclass
class StepAside(Task):
    """Go to a place from which the same order is tried once more.

    Attributes:
        place: (2,) [m].
        time: since the start [s].
    """

    place: Array
    time: float = 0.0

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.time == 0.0:
            controller.go(self.place[0], self.place[1])
        self.time += dt
        if self.time > LONGEST_STEP_ASIDE:
            controller.stop()
        return not controller.record.has_goal


def place_aside(controller: PersonController, subject: Array | None) -> Array:
    """Return (2,) a place within a few steps from which to try once more [m].

    It is beside the present one as seen from what the act is about (3,), on the first side that
    nothing stands on; without any, a step back.
    """
    at, record = np.array(controller.record.at), controller.record
    ahead = np.array([math.cos(record.heading), -math.sin(record.heading)])
    middle = at + LEAST_DISTANCE * ahead if subject is None else subject[[0, 2]]
    offset = at - middle
    distance = math.hypot(offset[0], offset[1])
    away = -ahead if distance < 1e-6 else offset / distance
    middles, radii = controller.obstacles()
    reaches = np.minimum(
        radii + controller.body_radius, 0.98 * np.sqrt(((middles - at) ** 2).sum(axis=1))
    )
    low, high = controller.view.edges
    for turn in TURNS:
        c, s = math.cos(turn), math.sin(turn)
        turned = np.array([c * away[0] - s * away[1], s * away[0] + c * away[1]])
        way = middle + max(distance, LEAST_DISTANCE) * turned - at
        place: Array = at + way * min(LONGEST_WAY / max(math.hypot(way[0], way[1]), 1e-6), 1.0)
        is_inside = bool((place > low).all() and (place < high).all())
        if is_inside and are_free(at, place[None], middles, reaches)[0]:
            return place
    back: Array = at + 0.4 * LONGEST_WAY * away
    return back


@dataclass(frozen=True, eq=False)
class Regret:
    """The look of a person that has given up.

    Attributes:
        subject: (3,) what it could not do [m]; None for nowhere.
        start: when it gave up [s].
    """

    subject: Array | None
    start: float

    def look(self, controller: PersonController, time: float) -> bool:
        """Look at the subject, and then down; tell whether that goes on."""
        since = time - self.start
        if since > REGRET_TIME:
            return False
        if self.subject is not None and since < LOOKING_TIME:
            controller.look_at(self.subject)
            return True
        person = controller.record
        place = controller.view.face(int(person.owner)) + DOWN[0] * person.height * controller.ahead
        place[1] -= DOWN[1] * person.height
        controller.look_at(place)
        return True
