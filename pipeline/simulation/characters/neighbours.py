"""Neighbours: which links may touch in a sub-step; the others are not looked at.

Boxes around characters are swept along x; where two overlap, boxes around links are compared.
Pairs come out in the order of the cast, whatever the order along x.

Source: Ericson 2005, 7.5 (sweep and prune).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.layout import Crowd, Numbers
from pipeline.simulation.dynamics.compiled import Record, compiled

MARGIN = 0.005
"""Gap at which two are looked at: what comes on within the sub-step [m]."""


class Room(NamedTuple):
    """Room for what is found.

    Attributes:
        order: (C,) characters by where their boxes begin along x.
        near: (n, 2) characters whose boxes overlap.
        pairs: (m, 2) links that may touch.
    """

    order: Numbers
    near: Numbers
    pairs: Numbers


def room_for(crowd: Crowd) -> Room:
    """Return room: each character may be near twenty others, each link near twelve."""
    count, links = len(crowd.owners), len(crowd.ends)
    return Room(
        np.arange(count),
        np.zeros((20 * count, 2), dtype=np.int64),
        np.zeros((64 + 12 * links, 2), dtype=np.int64),
    )


@compiled
def enclose(crowd: Crowd) -> None:
    """Put boxes around characters."""
    for c in range(len(crowd.owners)):
        owner = crowd.owners[c]
        first = owner.nodes[0]
        for k in range(3):
            owner.low[k], owner.high[k] = np.inf, -np.inf
        for i in range(first, first + owner.nodes[1]):
            for k in range(3):
                owner.low[k] = min(owner.low[k], crowd.p[i, k] - crowd.radius[i])
                owner.high[k] = max(owner.high[k], crowd.p[i, k] + crowd.radius[i])


@compiled
def find_near(crowd: Crowd, room: Room) -> int:
    """Find characters whose boxes overlap; return how many pairs there are."""
    order, owners = room.order, crowd.owners
    for n in range(1, len(order)):
        c, x = order[n], owners[order[n]].low[0]
        m = n - 1
        while m >= 0 and owners[order[m]].low[0] > x:
            order[m + 1] = order[m]
            m -= 1
        order[m + 1] = c
    found = 0
    for n in range(len(order)):
        one = owners[order[n]]
        for m in range(n + 1, len(order)):
            other = owners[order[m]]
            if other.low[0] > one.high[0] + MARGIN:
                break
            if _overlap(one, other) and found < len(room.near):
                a, b = order[n], order[m]
                room.near[found, 0], room.near[found, 1] = min(a, b), max(a, b)
                found += 1
    _sort(room.near, found)
    return found


@compiled
def find_pairs(crowd: Crowd, room: Room, near: int) -> int:
    """Find links that may touch; return how many pairs there are."""
    found = 0
    for n in range(near):
        one, other = crowd.owners[room.near[n, 0]], crowd.owners[room.near[n, 1]]
        for a in range(one.links[0], one.links[0] + one.links[1]):
            if crowd.girth[a] == 0.0 or not _in_box(crowd, a, other):
                continue
            for b in range(other.links[0], other.links[0] + other.links[1]):
                if crowd.girth[b] > 0.0 and _side_by_side(crowd, a, b) and found < len(room.pairs):
                    room.pairs[found, 0], room.pairs[found, 1] = a, b
                    found += 1
    return found


@compiled
def _overlap(one: Record, other: Record) -> bool:
    for k in range(3):
        if one.low[k] > other.high[k] + MARGIN or other.low[k] > one.high[k] + MARGIN:
            return False
    return True


@compiled
def _in_box(crowd: Crowd, a: int, box: Record) -> bool:
    i, j, girth = crowd.ends[a, 0], crowd.ends[a, 1], crowd.girth[a] + MARGIN
    for k in range(3):
        x, y = crowd.p[i, k], crowd.p[j, k]
        if min(x, y) - girth > box.high[k] or max(x, y) + girth < box.low[k]:
            return False
    return True


@compiled
def _side_by_side(crowd: Crowd, a: int, b: int) -> bool:
    i, j, m, n = crowd.ends[a, 0], crowd.ends[a, 1], crowd.ends[b, 0], crowd.ends[b, 1]
    girth = crowd.girth[a] + crowd.girth[b] + MARGIN
    for k in range(3):
        if min(crowd.p[i, k], crowd.p[j, k]) - girth > max(crowd.p[m, k], crowd.p[n, k]):
            return False
        if max(crowd.p[i, k], crowd.p[j, k]) + girth < min(crowd.p[m, k], crowd.p[n, k]):
            return False
    return True


@compiled
def _sort(near: Numbers, count: int) -> None:
    """Sort pairs, of which most are in order already."""
    for n in range(1, count):
        a, b = near[n, 0], near[n, 1]
        m = n - 1
        while m >= 0 and (near[m, 0] > a or (near[m, 0] == a and near[m, 1] > b)):
            near[m + 1, 0], near[m + 1, 1] = near[m, 0], near[m, 1]
            m -= 1
        near[m + 1, 0], near[m + 1, 1] = a, b
