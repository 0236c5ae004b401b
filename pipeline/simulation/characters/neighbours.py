"""Neighbours: the people within reach of each other, found by their order along x."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Records, allocating, compiled
from pipeline.simulation.spatial import Array

Numbers = NDArray[np.int64]


@allocating
def order_along_x(persons: Records) -> Numbers:
    """Return the numbers of all people in order along x."""
    order, xs = np.zeros(len(persons), dtype=np.int64), np.zeros(len(persons))
    for i in range(len(persons)):
        n, x = i, persons[i].at[0]
        while n > 0 and xs[n - 1] > x:
            order[n], xs[n] = order[n - 1], xs[n - 1]
            n -= 1
        order[n], xs[n] = i, x
    return order


@allocating
def places_in_order(persons: Records, order: Numbers) -> Array:
    """Return (n, 2) x and z of people in an order [m], side by side in memory."""
    places = np.empty((len(order), 2))
    for n in range(len(order)):
        at = persons[order[n]].at
        places[n, 0], places[n, 1] = at[0], at[1]
    return places


@compiled
def find_neighbours(places: Array, order: Numbers, n: int, reach: float, found: Numbers) -> int:
    """Write the numbers of all people about a person; return how many.

    They are at most `reach` from it along x, those on either side from near to far.

    Args:
        places: (P, 2) x and z of all people in their order along x [m].
        order: their numbers along x.
        n: the person's place in the order.
        reach: along x [m].
        found: written; room for all people.
    """
    x, count = places[n, 0], 0
    for direction in (-1, 1):
        m = n + direction
        while 0 <= m < len(order) and abs(places[m, 0] - x) <= reach:
            found[count] = order[m]
            count += 1
            m += direction
    return count


@compiled
def find_within(places: Array, order: Numbers, n: int, reach: float, found: Numbers) -> int:
    """Write the numbers of all people less than `reach` from a person; return how many.

    Arguments and order are those of `find_neighbours`.
    """
    x, z, count = places[n, 0], places[n, 1], 0
    for direction in (-1, 1):
        m = n + direction
        while 0 <= m < len(order) and abs(places[m, 0] - x) <= reach:
            off_x, off_z = places[m, 0] - x, places[m, 1] - z
            if off_x * off_x + off_z * off_z < reach * reach:
                found[count] = order[m]
                count += 1
            m += direction
    return count


@compiled
def insert_nearest(squares: Array, nearest: Numbers, count: int, square: float, number: int) -> int:
    """Insert a person among the nearest, in order of distance; return how many there are.

    Args:
        squares: of the distances of the nearest [m²]; written.
        nearest: numbers of these people; written.
        count: how many there are.
        square: of the distance of the person [m²].
        number: of the person.
    """
    most = len(nearest)
    k = min(count, most - 1)
    if count == most and square >= squares[k]:
        return count
    while k > 0 and squares[k - 1] > square:
        squares[k], nearest[k] = squares[k - 1], nearest[k - 1]
        k -= 1
    squares[k], nearest[k] = square, number
    return min(count + 1, most)
