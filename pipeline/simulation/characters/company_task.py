"""Company task: walking along with a companion.

The way is that of the companion; where in the row one walks is chosen by `walking_group`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import WALKING_FROUDE
from pipeline.simulation.characters.person_tasks import Approach, Task
from pipeline.simulation.characters.visibility_route import SHRINK_FACTOR, are_free
from pipeline.simulation.characters.walking_group import SPACING
from pipeline.simulation.dynamics.compiled import Record
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.spatial import Array

LEAST_WAY = 1.5  # that a companion has left to go, or it is not joined [m]
ENDING_TIME = 4.0  # to get to its own place after the companion has arrived [s]


def leads_somewhere(person: Record) -> bool:
    """Tell whether a person goes somewhere, by itself, where others may come along."""
    if not person.has_goal or person.comes_along or person.frozen or person.partner != NOBODY:
        return False
    return math.dist(person.at, person.goal) > LEAST_WAY


def usual_pace(person: Record) -> float:
    """Return the pace at which a person walks without another word [m/s]."""
    return float(WALKING_FROUDE * math.sqrt(GRAVITY * float(person.hip_height)))


@dataclass
class WalkAlong(Task):
    """Walk where a companion walks, and stop beside it.

    Attributes:
        leader: `PERSON` record of the companion.
        place: (2,) where it goes itself [m].
        approach: to that.
        time: since the companion has arrived [s].
        is_there: whether it has arrived, too.
    """

    leader: Record
    place: Array | None = None
    approach: Approach = field(default_factory=Approach)
    time: float = 0.0
    is_there: bool = False

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        leader, person = self.leader, controller.record
        if self.is_there:
            return True
        leads = bool(leader.has_goal) and not leader.comes_along
        self.time = 0.0 if leads else self.time + dt
        if leads:
            self.place = self._place(controller)
            haste = float(leader.pace) / usual_pace(leader)
            self.pace = usual_pace(person) * haste if haste > 1.0 else 0.0
        if self.place is None or self.time > ENDING_TIME or not (leads or person.has_goal):
            controller.stop()
            person.comes_along = False
            self.is_there = controller.is_standing
            return self.is_there
        x, z = (float(c) for c in self.place)
        controller.go(x, z, float(leader.stop_distance))
        person.comes_along = True
        # The others wait for a person that is held up, so it gives nothing up.
        self.approach.advance(controller, self.place, dt)
        return False

    def leave(self, controller: PersonController) -> None:
        """See `Task`."""
        controller.record.comes_along = False

    def _place(self, controller: PersonController) -> Array:
        """Return (2,) where to walk [m]: beside where the companion goes, or after it."""
        goal, at = np.array(self.leader.goal), np.array(controller.record.at)
        beside = goal + self._offset(controller.record)
        middles, radii = controller.obstacles()
        if not len(radii):
            return beside
        reaches = np.minimum(
            radii + controller.body_radius, SHRINK_FACTOR * np.hypot(*(middles - at).T)
        )
        is_free = are_free(at, np.stack([beside, goal]), middles, reaches)
        if is_free[0]:
            return beside
        return goal if is_free[1] else np.array(self.leader.at)

    def _offset(self, person: Record) -> Array:
        """Return where it goes to from where the companion goes (2,), across the way [m]."""
        leader = self.leader
        x, z = float(leader.goal[0] - leader.at[0]), float(leader.goal[1] - leader.at[1])
        far = math.hypot(x, z)
        if person.group_size > 1 and leader.group_size > 1:
            (x, z), far = person.group_ahead, 1.0
            places = float(person.group_rank - leader.group_rank)
        else:
            to_right = (person.at[1] - leader.at[1]) * x - (person.at[0] - leader.at[0]) * z
            places = math.copysign(1.0, float(to_right))
        size = SPACING * 0.5 * float(person.height + leader.height) * places / max(far, 1e-9)
        return np.array([-z * size, x * size])
