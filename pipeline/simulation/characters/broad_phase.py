"""Broad phase."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.body_arrays import CharacterArrays, IntArray
from pipeline.simulation.characters.constraint_projection import is_gripped
from pipeline.simulation.characters.solid_arrays import Solids, no_solids
from pipeline.simulation.dynamics.compiled import Record, Records, inlined

MARGIN = 0.005
"""Gap at which two are looked at: what comes on within the sub-step [m]."""


class Workspace(NamedTuple):
    """Room for what is found.

    Attributes:
        order: (C,) characters by where their boxes begin along x.
        near: (n, 2) characters whose boxes overlap.
        pairs: (m, 2) links that may touch.
        solids: of other rooms, and room for those who are near them.
    """

    order: IntArray
    near: IntArray
    pairs: IntArray
    solids: Solids


def workspace_for(arrays: CharacterArrays, solids: Solids | None = None) -> Workspace:
    """Return room: each character may be near twenty others, each link near twelve."""
    count, links = len(arrays.owners), len(arrays.links)
    return Workspace(
        np.arange(count),
        np.zeros((20 * count, 2), dtype=np.int64),
        np.zeros((64 + 12 * links, 2), dtype=np.int64),
        no_solids() if solids is None else solids,
    )


@inlined
def enclose(nodes: Records, owners: Records) -> None:
    """Put boxes around characters."""
    for c in range(len(owners)):
        owner = owners[c]
        first = owner.nodes[0]
        for k in range(3):
            owner.low[k], owner.high[k] = np.inf, -np.inf
        for i in range(first, first + owner.nodes[1]):
            node = nodes[i]
            for k in range(3):
                owner.low[k] = min(owner.low[k], node.p[k] - node.radius)
                owner.high[k] = max(owner.high[k], node.p[k] + node.radius)


@inlined
def find_near(owners: Records, order: IntArray, near: IntArray) -> int:
    """Find characters whose boxes overlap; return how many pairs there are."""
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
            if _overlap(one, other) and found < len(near):
                a, b = order[n], order[m]
                near[found, 0], near[found, 1] = min(a, b), max(a, b)
                found += 1
    _sort(near, found)
    return found


@inlined
def find_pairs(
    nodes: Records, links: Records, owners: Records, own: IntArray, near: IntArray, pairs: IntArray
) -> int:
    """Find links that may touch, those of one character first; boxes are met as wholes.

    Arms of who embraces somebody pass through that one's arms, for two pairs of them have no
    room around two chests; and what a hand holds does not push it off.

    Args:
        nodes: of all characters.
        links: of all characters.
        owners: all characters.
        own: (S, 2) links of one character that meet one another.
        near: (n, 2) characters whose boxes overlap.
        pairs: room for what is found.

    Returns:
        How many pairs there are.
    """
    found = 0
    for n in range(len(own)):
        a, b = own[n, 0], own[n, 1]
        if not owners[links[a].owner].asleep:
            found = _keep_if_near(nodes, links, (a, b), pairs, found)
    for n in range(len(near)):
        one, other = owners[near[n, 0]], owners[near[n, 1]]
        if (one.asleep and other.asleep) or (one.edge_radius > 0.0) != (other.edge_radius > 0.0):
            continue
        hug = one.embraces == near[n, 1] or other.embraces == near[n, 0]
        for a in range(one.links[0], one.links[0] + one.links[1]):
            if links[a].radius == 0.0 or not _in_box(nodes, links[a], other):
                continue
            for b in range(other.links[0], other.links[0] + other.links[1]):
                if links[b].radius > 0.0 and not (hug and links[a].is_arm and links[b].is_arm):
                    found = _keep_if_near(nodes, links, (a, b), pairs, found)
    return found


@inlined
def _keep_if_near(
    nodes: Records, links: Records, pair: tuple[int, int], pairs: IntArray, found: int
) -> int:
    """Keep a pair of links if it may touch; return how many are kept now."""
    if found == len(pairs) or not _side_by_side(nodes, links[pair[0]], links[pair[1]]):
        return found
    if is_gripped(nodes, links[pair[0]], links[pair[1]]):
        return found
    pairs[found, 0], pairs[found, 1] = pair[0], pair[1]
    return found + 1


@inlined
def _overlap(one: Record, other: Record) -> bool:
    for k in range(3):
        if one.low[k] > other.high[k] + MARGIN or other.low[k] > one.high[k] + MARGIN:
            return False
    return True


@inlined
def _in_box(nodes: Records, link: Record, box: Record) -> bool:
    p, q, girth = nodes[link.ends[0]].p, nodes[link.ends[1]].p, link.radius + MARGIN
    for k in range(3):
        if min(p[k], q[k]) - girth > box.high[k] or max(p[k], q[k]) + girth < box.low[k]:
            return False
    return True


@inlined
def _side_by_side(nodes: Records, one: Record, other: Record) -> bool:
    p, q = nodes[one.ends[0]].p, nodes[one.ends[1]].p
    r, s = nodes[other.ends[0]].p, nodes[other.ends[1]].p
    girth = one.radius + other.radius + MARGIN
    for k in range(3):
        if min(p[k], q[k]) - girth > max(r[k], s[k]):
            return False
        if max(p[k], q[k]) + girth < min(r[k], s[k]):
            return False
    return True


@inlined
def _sort(near: IntArray, count: int) -> None:
    """Sort pairs, of which most are in order already."""
    for n in range(1, count):
        a, b = near[n, 0], near[n, 1]
        m = n - 1
        while m >= 0 and (near[m, 0] > a or (near[m, 0] == a and near[m, 1] > b)):
            near[m + 1, 0], near[m + 1, 1] = near[m, 0], near[m, 1]
            m -= 1
        near[m + 1, 0], near[m + 1, 1] = a, b
