"""Broad phase: pairs of characters and of links that may touch in a sub-step.

Bounding boxes of characters are swept along x; where two overlap, boxes of their links are
compared. Pairs come out in the order of the cast, whatever the order along x.

Two links of one character are measured again only when its nodes have moved so far, against one
another, that the links may have come near or apart: most keep apart, whatever the character does.

Source: Ericson 2005, 7.5 (sweep and prune); Verlet 1967 for lists of neighbours that hold until
    something has moved as far as their margin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.body_arrays import CharacterArrays, IntArray
from pipeline.simulation.characters.constraint_projection import is_gripped
from pipeline.simulation.characters.contact_response import link_overlaps
from pipeline.simulation.characters.link_contacts import closest_points
from pipeline.simulation.characters.solid_arrays import Solids, no_solids
from pipeline.simulation.dynamics.compiled import Record, Records, inlined
from pipeline.simulation.dynamics.vectors import dot, length, minus, plus, set_triple, times, triple
from pipeline.simulation.spatial import Array

MARGIN = 0.005  # gap that is still a pair: motion within the sub-step [m]
OWN_MARGIN = 0.01  # the same between links of one character, which joints move faster [m]
PAIRS_PER_CHARACTER, PAIRS_PER_LINK, SPARE_PAIRS = 20, 12, 64  # capacity of the buffers


class Workspace(NamedTuple):
    """Buffers of the compiled step.

    Attributes:
        order: (C,) characters in the order of their bounding boxes along x.
        near: (n, 2) characters with overlapping boxes.
        pairs: (m, 4) two links that may touch, and their owners.
        measured: (N, 3) places of the nodes when bounds were last updated [m].
        travel: (C,) how much nearer, at most, links of one character have come in all [m].
        due: (S,) travel from which the links of an own pair are measured again [m].
        is_near: (S,) whether they may touch.
        solids: of other rooms.
    """

    order: IntArray
    near: IntArray
    pairs: IntArray
    measured: Array
    travel: Array
    due: Array
    is_near: NDArray[np.bool_]
    solids: Solids


def workspace_for(arrays: CharacterArrays, solids: Solids | None = None) -> Workspace:
    """Return the buffers for characters, each with limited numbers of pairs."""
    count, links = len(arrays.owners), len(arrays.links)
    return Workspace(
        np.arange(count),
        np.zeros((PAIRS_PER_CHARACTER * count, 2), dtype=np.int64),
        np.zeros((SPARE_PAIRS + PAIRS_PER_LINK * links, 4), dtype=np.int64),
        np.zeros((len(arrays.nodes), 3)),
        np.zeros(count),
        np.zeros(len(arrays.pairs)),
        np.zeros(len(arrays.pairs), dtype=np.bool_),
        no_solids() if solids is None else solids,
    )


@inlined
def update_bounds(nodes: Records, owner: Record, measured: Array) -> float:
    """Update the bounding box of a character; return how much nearer two of its links may be [m].

    That is at most twice the longest way of a node, along with the first node of the character.

    Args:
        nodes: of all characters.
        owner: the character; changed.
        measured: (N, 3) places of the nodes at the update before [m]; changed.
    """
    first, farthest = owner.nodes[0], 0.0
    low = high = triple(nodes[first].p)
    shift = minus(low, triple(measured[first]))
    for i in range(first, first + owner.nodes[1]):
        p, r = triple(nodes[i].p), nodes[i].radius
        low = min(low[0], p[0] - r), min(low[1], p[1] - r), min(low[2], p[2] - r)
        high = max(high[0], p[0] + r), max(high[1], p[1] + r), max(high[2], p[2] + r)
        way = minus(minus(p, triple(measured[i])), shift)
        farthest = max(farthest, dot(way, way))
        set_triple(measured[i], p)
    set_triple(owner.low, low)
    set_triple(owner.high, high)
    return 2.0 * math.sqrt(farthest)


@inlined
def find_near_characters(owners: Records, order: IntArray, near: IntArray) -> int:
    """Find characters with overlapping boxes; return the number of pairs."""
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
            if bounds_overlap(one, other) and found < len(near):
                a, b = order[n], order[m]
                near[found, 0], near[found, 1] = min(a, b), max(a, b)
                found += 1
    _sort_pairs(near, found)
    return found


@inlined
def find_own_pairs(
    nodes: Records,
    links: Records,
    owners: Records,
    own: IntArray,
    travel: Array,
    due: Array,
    is_near: NDArray[np.bool_],
    pairs: IntArray,
) -> int:
    """Find links of one character that may touch.

    Args:
        nodes: of all characters.
        links: of all characters.
        owners: all characters.
        own: (S, 2) links of one character that may touch one another.
        travel: (C,) how much nearer, at most, links of one character have come in all [m].
        due: (S,) travel from which the links of a pair are measured again [m]; changed.
        is_near: (S,) whether they may touch; changed.
        pairs: buffer for the result.

    Returns:
        The number of pairs.
    """
    found = 0
    for c in range(len(owners)):
        owner = owners[c]
        if owner.asleep or owner.is_guided:
            continue
        for n in range(owner.pairs[0], owner.pairs[0] + owner.pairs[1]):
            if travel[c] >= due[n]:
                gap = _gap(nodes, links[own[n, 0]], links[own[n, 1]]) - OWN_MARGIN
                due[n], is_near[n] = travel[c] + abs(gap), gap <= 0.0
            if is_near[n] and found < len(pairs):
                if is_gripped(nodes, links[own[n, 0]], links[own[n, 1]]):
                    continue
                for k in range(2):
                    pairs[found, k], pairs[found, 2 + k] = own[n, k], c
                found += 1
    return found


@inlined
def _gap(nodes: Records, one: Record, other: Record) -> float:
    """Return the gap between two links, negative where they overlap [m]."""
    p, q = triple(nodes[one.ends[0]].p), triple(nodes[other.ends[0]].p)
    u = minus(triple(nodes[one.ends[1]].p), p)
    v = minus(triple(nodes[other.ends[1]].p), q)
    s, t = closest_points(p, u, q, v)
    offset = minus(plus(p, times(s, u)), plus(q, times(t, v)))
    return length(offset) - one.radius - other.radius


@inlined
def find_link_pairs(
    nodes: Records,
    links: Records,
    owners: Records,
    near: IntArray,
    pairs: IntArray,
    found: int,
) -> int:
    """Find links of two characters that may touch; boxes are met as wholes.

    Arms in an embrace pass through the arms of the embraced character, for two pairs of them have
    no room around two chests; and a gripped link does not push the hand off.

    Args:
        nodes: of all characters.
        links: of all characters.
        owners: all characters.
        near: (n, 2) characters with overlapping boxes.
        pairs: buffer for the result, which follows the pairs of one character.
        found: number of those.

    Returns:
        The number of all pairs.
    """
    for n in range(len(near)):
        one, other = owners[near[n, 0]], owners[near[n, 1]]
        if (one.asleep and other.asleep) or (one.edge_radius > 0.0) != (other.edge_radius > 0.0):
            continue
        hug = one.embraces == near[n, 1] or other.embraces == near[n, 0]
        # A ball that leaves the arms of its thrower has a single node.
        balls = one.nodes[1] == 1, other.nodes[1] == 1
        for a in range(one.links[0], one.links[0] + one.links[1]):
            if links[a].radius == 0.0 or not link_overlaps(
                nodes, links[a], links[a].radius + MARGIN, other
            ):
                continue
            in_arms = hug and (balls[0] or links[a].is_arm)
            for b in range(other.links[0], other.links[0] + other.links[1]):
                if links[b].radius == 0.0 or _stands_over(owners, links[a], links[b]):
                    continue
                if not (in_arms and (balls[1] or links[b].is_arm)):
                    found = _keep_pair(nodes, links, (a, b), pairs, found)
    return found


@inlined
def _stands_over(owners: Records, one: Record, other: Record) -> bool:
    """Tell whether the owner of one of two links stands on the other link, as on a deck."""
    return (one.is_deck and owners[other.owner].stands_on == one.owner) or (
        other.is_deck and owners[one.owner].stands_on == other.owner
    )


@inlined
def _keep_pair(
    nodes: Records, links: Records, pair: tuple[int, int], pairs: IntArray, found: int
) -> int:
    """Keep a pair of links if it may touch; return the number of pairs."""
    if found == len(pairs) or not _links_overlap(nodes, links[pair[0]], links[pair[1]]):
        return found
    if is_gripped(nodes, links[pair[0]], links[pair[1]]):
        return found
    for k in range(2):
        pairs[found, k], pairs[found, 2 + k] = pair[k], links[pair[k]].owner
    return found + 1


@inlined
def bounds_overlap(one: Record, other: Record) -> bool:
    """Tell whether the bounding boxes of two characters or solids overlap, with a margin."""
    for k in range(3):
        if one.low[k] > other.high[k] + MARGIN or other.low[k] > one.high[k] + MARGIN:
            return False
    return True


@inlined
def _links_overlap(nodes: Records, one: Record, other: Record) -> bool:
    p, q = nodes[one.ends[0]].p, nodes[one.ends[1]].p
    r, s = nodes[other.ends[0]].p, nodes[other.ends[1]].p
    radii = one.radius + other.radius + MARGIN
    for k in range(3):
        if min(p[k], q[k]) - radii > max(r[k], s[k]):
            return False
        if max(p[k], q[k]) + radii < min(r[k], s[k]):
            return False
    return True


@inlined
def _sort_pairs(near: IntArray, count: int) -> None:
    for n in range(1, count):
        a, b = near[n, 0], near[n, 1]
        m = n - 1
        while m >= 0 and (near[m, 0] > a or (near[m, 0] == a and near[m, 1] > b)):
            near[m + 1, 0], near[m + 1, 1] = near[m, 0], near[m, 1]
            m -= 1
        near[m + 1, 0], near[m + 1, 1] = a, b
