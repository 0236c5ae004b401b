"""Neighbours: the people within reach of each other, found by their order along x."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Records, compiled

Numbers = NDArray[np.int64]


@compiled
def order_along_x(persons: Records) -> Numbers:
    """Return the numbers of all people in order along x."""
    order = np.zeros(len(persons), dtype=np.int64)
    for i in range(len(persons)):
        n = i
        while n > 0 and persons[order[n - 1]].at[0] > persons[i].at[0]:
            order[n] = order[n - 1]
            n -= 1
        order[n] = i
    return order


@compiled
def find_neighbours(persons: Records, order: Numbers, n: int, reach: float, found: Numbers) -> int:
    """Write the numbers of all people about a person; return how many.

    They are at most `reach` from it along x, those on either side from near to far.

    Args:
        persons: `PERSON` records.
        order: their numbers along x.
        n: the person's place in the order.
        reach: along x [m].
        found: written; room for all people.
    """
    x, count = persons[order[n]].at[0], 0
    for direction in (-1, 1):
        m = n + direction
        while 0 <= m < len(order) and abs(persons[order[m]].at[0] - x) <= reach:
            found[count] = order[m]
            count += 1
            m += direction
    return count
