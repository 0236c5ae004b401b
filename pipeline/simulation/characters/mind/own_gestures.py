"""Own gestures: what people with minds show their friends by themselves.

They greet a friend whom they meet, and point out to a friend near them what frightens them or what
they would like to have. `gesture_behaviours` has the comforting of a friend; consent has refusals.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from pipeline.simulation.characters.gestures import LEAVING_HANDS, Gestures
from pipeline.simulation.characters.mind.mind import Mind
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import TAKE_NAMES
from pipeline.spec.gesture import GREET, POINT

LOOKING_EVERY = 12  # steps in which a mind looks for what to show once
MEETING_RANGE = 1.0, 6.0  # of a friend who is greeted [m]
APART = 7.0  # from which two who come near one another meet anew [m]
FIRST_APART = 3.5  # the same, at the start of a film
GREETING_FEAR, GREETING_ANGER = 0.25, 0.4  # from which nobody is greeted
SHOWING_RANGE = 4.0  # of the friend to whom something is shown [m]
FRIGHTENING = 0.3  # fear of something, less for what is far, from which it is shown
WANTED_RANGE = 7.0  # of what one would like to have [m]
WANTING = {"play": "ball", "carry": "thing", "push": "thing", "ride": "thing"}
"""Behaviours towards what one would like to have, and their attributes of its number."""
BUSY = ("withdrawal", "flee", "fight", "attachment", "soothe")
"""Behaviours in which nothing is shown."""
SHOWING_PAUSE = 20.0  # before the same thing is shown again [s]


class OwnGestures:
    """The gestures of people with minds.

    Args:
        minds: of people, by the index of their controllers.
        friends: numbers of the friends of each, by the same.
        dispatcher: of tasks.
        values: (M, 5) channels of the take, of which the behaviour is the last; changed.
        felt: (P, 6) emotions of people.
    """

    def __init__(
        self,
        minds: Mapping[int, Mind],
        friends: Mapping[int, Collection[int]],
        dispatcher: TaskDispatcher,
        values: Array,
        felt: Array,
    ) -> None:
        self._minds, self._dispatcher = minds, dispatcher
        self._values, self._felt = values, felt
        self._rows = {k: n for n, k in enumerate(minds)}
        self._friends = {k: sorted(others) for k, others in friends.items() if others}
        self._apart = dict[tuple[int, int], bool]()
        self._shown = dict[tuple[int, int], float]()
        self._steps = 0

    def advance(self, gestures: Gestures, now: float) -> None:
        """Let people with friends begin gestures, and tell the take all gestures of minds.

        Args:
            gestures: of all people.
            now: the time [s].
        """
        for k, n in self._rows.items() if gestures.are_made else ():
            if kind := gestures.kind(k):
                self._values[n, 4] = TAKE_NAMES.index(kind)
        if not self._friends:
            return
        self._steps += 1
        if self._steps % LOOKING_EVERY == 1:
            self._show_sadness()
            for k in self._friends:
                if not gestures.kind(k) and (found := self._wish(k, now)) is not None:
                    kind, other = found
                    gestures.begin(k, kind, self._dispatcher.view.names[other])

    def _show_sadness(self) -> None:
        """Let all see the sadness that faces show."""
        view, told = self._dispatcher.view, self._dispatcher.expressions[:, 1]
        shown = np.where(np.isnan(told), self._felt[:, 1], told)
        for controller, sadness in zip(self._dispatcher.controllers, shown.tolist(), strict=True):
            view.sadness[controller.owner] = sadness

    def _wish(self, k: int, now: float) -> tuple[str, int] | None:
        """Return the gesture that a person wants to make, and the number of its target."""
        mind = self._minds[k]
        met = [other for other in self._friends[k] if self._meets(k, mind, other, now)]
        task = self._dispatcher.task(k)
        has_free_hands = task is None or isinstance(task, LEAVING_HANDS)
        if mind.doing.partition(" ")[0] in BUSY or not has_free_hands:
            return None
        if met:
            return GREET, met[0]
        near = [f for f in self._friends[k] if mind.distance_to(f) < SHOWING_RANGE]
        for thing in self._worth_showing(mind) if near else ():
            if thing not in near and now >= self._shown.get((k, thing), 0.0):
                self._shown[k, thing] = now + SHOWING_PAUSE
                return POINT, thing
        return None

    def _meets(self, k: int, mind: Mind, other: int, now: float) -> bool:
        """Tell whether a person meets a friend that it has been apart from."""
        nearest, farthest = MEETING_RANGE
        distance = mind.distance_to(other)
        limit = APART if now > 1.0 else FIRST_APART
        apart = self._apart.get((k, other), False) or distance > limit
        is_met = bool(mind.memory.in_view[other]) and distance < farthest and now > 0.0
        self._apart[k, other] = apart and not is_met
        is_friendly = float(mind.attention.fears[other]) < GREETING_FEAR
        is_friendly &= mind.anger < GREETING_ANGER
        return apart and is_met and distance > nearest and is_friendly

    def _worth_showing(self, mind: Mind) -> Iterator[int]:
        """Yield what frightens a person, the most frightening first, and what it would like."""
        attention, in_view = mind.attention, mind.memory.in_view
        frights = attention.fears * attention.nearness
        for c in np.argsort(-frights, kind="stable").tolist():
            if frights[c] > FRIGHTENING and in_view[c]:
                yield c
        for name, behaviour in mind.behaviours.items():
            if (key := WANTING.get(name.partition(" ")[0])) is not None:
                thing = int(getattr(behaviour, key))
                if in_view[thing] and mind.distance_to(thing) < WANTED_RANGE:
                    yield thing
