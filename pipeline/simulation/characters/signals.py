"""Signals: what people go through that those who direct them hear of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.simulation.characters.direction import Direction
from pipeline.simulation.characters.errands import CLOSES, Hug
from pipeline.simulation.characters.record import HEAD, SHOULDERS
from pipeline.simulation.signals import Signal

HURTS = 0.2
"""Pain of a step that is told of, in what is just felt as pain."""

CRIES = 0.4
"""Pain of a step that is cried out for."""

WHIMPER, LOUDER, SCREAM = 1.0, 1.5, 5.0
"""Strength of the faintest cry, what pain adds, and of the loudest [m/s]."""

THROAT, BREAST = 0.1, 0.15
"""Sizes of what is heard in a cry and in a hug, in heights."""

CLOSING = 0.13 / CLOSES
"""How fast arms close, in heights of whom they close around [1/s]."""


def loudness(pain: float) -> float:
    """Return the strength of a cry for a blow that hurts so much [m/s]."""
    return min(WHIMPER + LOUDER * pain, SCREAM)


class Signals:
    """Pains, cries and hugs of all people of a troupe, each told of when it begins."""

    def __init__(self, direction: Direction) -> None:
        self.direction = direction
        self._owners = [int(actor.me.owner) for actor in direction.actors]
        self._pain = np.zeros(len(self._owners))
        self._pains_now = direction.stage.crowd.owners["pain"]
        self._hugged: list[Hug | None] = [None for _ in self._owners]

    def of_step(self, cries: Sequence[tuple[int, int, float]] = ()) -> tuple[Signal, ...]:
        """Return what has begun in the last step.

        Args:
            cries: of those who have a mind: numbers of the actor and of the character by whom,
                -1 for nobody; and strength [m/s].
        """
        return (*self._pains(), *(self._cry(*cry) for cry in cries), *self._hugs())

    def _pains(self) -> Iterator[Signal]:
        stage = self.direction.stage
        before, self._pain = self._pain, self._pains_now[self._owners]
        more = self._pain - before
        if not len(more) or float(more.max()) <= HURTS:
            return
        owners, links = stage.crowd.owners, stage.crowd.links
        for k in np.flatnonzero(more > HURTS).tolist():
            first, count = (int(n) for n in owners["links"][self._owners[k]])
            own = links[first : first + count]
            by = int(own["touched_owner"][int(np.argmax(own["energy"]))])
            whom = stage.names[by] if by >= 0 else ""
            much = float(self._pain[k] - before[k])
            yield Signal("pain", self.direction.actors[k].name, whom)
            if much > CRIES and k not in self.direction.minded:
                yield self._cry(k, by, loudness(much))

    def _cry(self, k: int, by: int, strength: float) -> Signal:
        size = THROAT * float(self.direction.actors[k].me.height)
        return self._voice("cry", k, by, "head", strength, size)

    def _voice(self, kind: str, k: int, by: int, part: str, strength: float, size: float) -> Signal:
        actor, stage = self.direction.actors[k], self.direction.stage
        joint = HEAD if part == "head" else SHOULDERS
        x, y, z = stage.nodes(int(actor.me.owner))[joint].tolist()
        whom = stage.names[by] if by >= 0 else ""
        return Signal(kind, actor.name, whom, f"{actor.name}.{part}", (x, y, z), strength, size)

    def _hugs(self) -> Iterator[Signal]:
        for k in range(len(self.direction.actors)):
            errand = self.direction.errand(k)
            hug = errand if isinstance(errand, Hug) and errand.touched > CLOSES else None
            if hug is not None and hug is not self._hugged[k]:
                size = BREAST * float(self.direction.actors[k].me.height)
                yield self._voice("hug", k, hug.owner, "chest", CLOSING * hug.size, size)
            self._hugged[k] = hug
