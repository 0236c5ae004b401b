"""Companions: people who belong together set out together, find room, and look at one another.

`walking_group` has the places that they take as they walk.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.company_task import WalkAlong, leads_somewhere
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import STANDING
from pipeline.simulation.characters.person_tasks import StandUp, Turn, Walk
from pipeline.simulation.characters.pursuit_tasks import WalkUp
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher
from pipeline.simulation.characters.walking_group import SPACING
from pipeline.simulation.seeds import generator

SIGHT = 2.5  # ahead, in which things beside the way are noticed [m]
ROOM_RATE = 0.012  # change of the room that is taken up in a step
LOOKING_EVERY = 8  # steps in which the room is measured once
LOOKS, PAUSES = (0.7, 1.3), (2.0, 5.0)  # at one another, and between these [s]
LOOKING_RANGE = 3.0  # [m]

LEFT_OFF = Walk, WalkUp, Turn, StandUp, WalkAlong
"""Tasks of those without an order who may come along."""


class Companions:
    """All people of a troupe who belong together.

    Args:
        groups: names of the people of each group.
        dispatcher: of their tasks.
        seed: of the scene.
    """

    def __init__(self, groups: Sequence[Sequence[str]], dispatcher: TaskDispatcher, seed: int):
        self._dispatcher, self._steps = dispatcher, 0
        numbers = {one.name: k for k, one in enumerate(dispatcher.controllers)}
        self._groups = [[numbers[name] for name in group] for group in groups]
        for number, group in enumerate(self._groups):
            for k in group:
                dispatcher.controllers[k].record.group = number
        members = [k for group in self._groups for k in group]
        self._chances = {
            k: generator(seed, f"{dispatcher.controllers[k].name}.companions") for k in members
        }
        # When each looks at another next, until when, and at whom.
        self._looks = {k: [self._between(k, PAUSES), 0.0] for k in members}
        self._looked_at = dict.fromkeys(members, NOBODY)
        self._rooms = [1.0] * len(self._groups)

    def advance(self, time: float) -> None:
        """Let those come along who may, before the tasks of a step that starts at `time` [s]."""
        self._steps += 1
        for number, group in enumerate(self._groups):
            self._set_out(group)
            self._take_room(number, group)
            self._look(group, time)

    # --- setting out --------------------------------------------------------------------

    def _set_out(self, group: Sequence[int]) -> None:
        """Let idle people walk along with a companion that sets out."""
        controllers = self._dispatcher.controllers
        leaders = [k for k in group if leads_somewhere(controllers[k].record)]
        for k in group if leaders else ():
            if k not in leaders and self._is_free(k):
                self._dispatcher.begin(k, WalkAlong(controllers[leaders[0]].record))

    def _is_free(self, k: int) -> bool:
        """Tell whether a person may come along; a mind decides that itself."""
        dispatcher, record = self._dispatcher, self._dispatcher.controllers[k].record
        if dispatcher.is_ordered(k) or k in dispatcher.minded or record.frozen:
            return False
        if record.has_goal or record.posture != STANDING or record.sit_blend > 0.0:
            return False
        task = dispatcher.task(k)
        return task is None or isinstance(task, LEFT_OFF)

    # --- room ---------------------------------------------------------------------------

    def _take_room(self, number: int, group: Sequence[int]) -> None:
        """Walk side by side where there is room, and one behind the other where there is none."""
        controllers = [self._dispatcher.controllers[k] for k in group]
        walking = [one for one in controllers if one.record.group_size > 1]
        if walking and self._steps % LOOKING_EVERY == 0:
            self._rooms[number] = room_of(walking)
        for one in walking:
            change = self._rooms[number] - float(one.record.group_room)
            one.record.group_room += min(max(change, -ROOM_RATE), ROOM_RATE)

    # --- looks --------------------------------------------------------------------------

    def _between(self, k: int, times: tuple[float, float]) -> float:
        low, high = times
        return low + (high - low) * float(self._chances[k].random())

    def _look(self, group: Sequence[int], time: float) -> None:
        """Let those who walk together look at one another now and then."""
        dispatcher = self._dispatcher
        for k in group:
            begin, end = self._looks[k]
            if time < begin:
                continue
            record = dispatcher.controllers[k].record
            if end <= begin:
                near = self._near(k, group) if record.group_size > 1 else []
                if near:
                    self._looked_at[k] = near[int(self._chances[k].integers(len(near)))]
                end = time + self._between(k, LOOKS)
            if time < end:
                if self._looked_at[k] != NOBODY:
                    dispatcher.glance(k, self._looked_at[k])
                self._looks[k][1] = end
                continue
            if self._looked_at[k] != NOBODY:
                dispatcher.glance(k, NOBODY)
            self._looked_at[k] = NOBODY
            self._looks[k] = [time + self._between(k, PAUSES), 0.0]

    def _near(self, k: int, group: Sequence[int]) -> list[int]:
        """Return the numbers of the companions near a person."""
        controllers, at = self._dispatcher.controllers, self._dispatcher.controllers[k].record.at
        others = (controllers[n].record for n in group if n != k)
        return [int(o.owner) for o in others if math.dist(o.at, at) < LOOKING_RANGE]


def room_of(walking: Sequence[PersonController]) -> float:
    """Return the room that people who walk together have between things: 1 side by side, 0 none."""
    leaders = [one for one in walking if not one.record.comes_along]
    first = leaders[0] if leaders else walking[0]
    middles, radii = first.obstacles()
    if not len(radii):
        return 1.0
    # The row follows the one companion that has an order.
    line = leaders if len(leaders) == 1 else walking
    at = np.mean([one.record.at for one in line], axis=0)
    ahead = np.array(first.record.group_ahead)
    offset = middles - at
    along = offset @ ahead
    aside = ahead[0] * offset[:, 1] - ahead[1] * offset[:, 0]
    height = float(np.mean([one.record.height for one in walking]))
    body = first.body_radius
    needed = SPACING * height * (len(walking) - 1)
    half = 0.5 * needed + body
    is_near = (along > -0.5 - radii) & (along < SIGHT + radii)
    right, left = aside - radii, -aside - radii
    # What stands on the way itself is walked around, on either side.
    free = sum(
        min(half, float(side[is_near & (side > 0.0)].min(initial=half))) for side in (right, left)
    )
    return min(max((free - 2.0 * body) / needed, 0.0), 1.0)
