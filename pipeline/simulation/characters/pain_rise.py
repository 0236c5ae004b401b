"""Pain rise: by how much the pain of acting people has risen in the last step.

Minds, reflexes and signals all read it, so it is computed once a step.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.dynamics.compiled import Records, bound, entry
from pipeline.simulation.spatial import Array


class PainRise:
    """The pain of acting people and its rise.

    Args:
        owners: (C,) `OWNER` records of all characters.
        persons: `PERSON` records.

    Attributes:
        pain: (P,) of the people now.
        added: (P,) since the step before.
        largest: the largest of these, 0 without people.
    """

    def __init__(self, owners: Records, persons: Records) -> None:
        self._owners, self._numbers = owners, persons["owner"].copy()
        self.pain: Array = np.zeros(len(persons))
        self.added: Array = np.zeros(len(persons))
        self.largest = 0.0

    @cached_property
    def _read(self) -> Callable[[], float]:
        return bound(_update, self._owners, self._numbers, self.pain, self.added)

    def update(self) -> None:
        """Read the pain after a step."""
        self.largest = self._read()


@entry
def _update(owners: Records, numbers: IntArray, pain: Array, added: Array) -> float:
    """Update pain and its rise (P,) of the characters with these numbers; return the largest."""
    largest = 0.0
    for k in range(len(numbers)):
        now = owners[numbers[k]].pain
        added[k] = now - pain[k]
        pain[k] = now
        largest = max(largest, added[k])
    return largest
