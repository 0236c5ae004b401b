"""Signals: what people go through that those who direct them hear of."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.simulation.characters.direction import Direction
from pipeline.simulation.characters.errands import CLOSES, Hug
from pipeline.simulation.happenings import Happening

HURTS = 0.2
"""Pain of a step that is told of, in what is just felt as pain."""


class Signals:
    """Pains and hugs of all people of a troupe, each told of when it begins."""

    def __init__(self, direction: Direction) -> None:
        self.direction = direction
        self._owners = [int(actor.me.owner) for actor in direction.actors]
        self._pain = np.zeros(len(self._owners))
        self._hugged: list[Hug | None] = [None for _ in self._owners]

    def of_step(self) -> tuple[Happening, ...]:
        """Return what has begun in the last step."""
        return (*self._pains(), *self._hugs())

    def _pains(self) -> Iterator[Happening]:
        stage = self.direction.stage
        owners, links = stage.crowd.owners, stage.crowd.links
        before, self._pain = self._pain, owners["pain"][self._owners]
        for k in np.flatnonzero(self._pain - before > HURTS).tolist():
            first, count = (int(n) for n in owners["links"][self._owners[k]])
            own = links[first : first + count]
            by = int(own["touched_owner"][int(np.argmax(own["energy"]))])
            whom = stage.names[by] if by >= 0 else ""
            yield Happening("pain", self.direction.actors[k].name, whom)

    def _hugs(self) -> Iterator[Happening]:
        for k, actor in enumerate(self.direction.actors):
            errand = self.direction.errand(k)
            hug = errand if isinstance(errand, Hug) and errand.touched > CLOSES else None
            if hug is not None and hug is not self._hugged[k]:
                yield Happening("hug", actor.name, self.direction.stage.names[hug.owner])
            self._hugged[k] = hug
