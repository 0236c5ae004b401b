"""Gaze targets: places of the characters that people look at, of all people at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.person_record import HEAD
from pipeline.simulation.dynamics.compiled import Records, entry

ELSEWHERE = -2
"""In place of the number of a character: the person looks at a place that is set already."""


@entry
def look_at_characters(
    persons: Records,
    nodes: Records,
    owners: Records,
    people: NDArray[np.bool_],
    looked_at: IntArray,
) -> None:
    """Let people look at the heads of people and the middles of things.

    Args:
        persons: (P,) `PERSON` records; changed.
        nodes: of all characters.
        owners: (C,) all characters.
        people: (C,) which have the joints of people.
        looked_at: (P,) numbers of characters, NOBODY to look ahead, or ELSEWHERE.
    """
    for k in range(len(persons)):
        owner = looked_at[k]
        if owner == ELSEWHERE:
            continue
        person = persons[k]
        person.has_look_target = owner >= 0
        if owner < 0:
            continue
        first, count = owners[owner].nodes[0], owners[owner].nodes[1]
        if people[owner]:
            first, count = first + HEAD, 1
        for i in range(3):
            total = 0.0
            for n in range(first, first + count):
                total += nodes[n].p[i]
            person.look_at[i] = total / count
