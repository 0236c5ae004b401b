"""Constraint projection."""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import Numbers
from pipeline.simulation.characters.limb_limits import settle, straighten
from pipeline.simulation.dynamics.compiled import Record, Records, inlined
from pipeline.simulation.dynamics.vectors import length, minus, triple

ENOUGH = 2e-3
"""Part of its length that a link may be off when no more is done."""

MOST = 40
"""Times that all links of a character are gone through, at most."""

DRAWS = 1.0
"""How fast a hand and what it has closed around come together [m/s]."""

FAST = 5e-4
"""How far from one another they are when no more is done [m]."""


@inlined
def project(
    nodes: Records, links: Records, middles: Numbers, limbs: Records, owner: Record
) -> float:
    """Move the nodes of one character nearer to where its links have their lengths.

    Returns:
        How much the worst was off, as a part of its length.
    """
    first = owner.links[0]
    worst = 0.0
    for n in range(first, first + owner.links[1]):
        link = links[n]
        worst = max(worst, _link(nodes[link.ends[0]], nodes[link.ends[1]], link))
    first = owner.middles[0]
    for n in range(first, first + owner.middles[1]):
        m, i, j = middles[n, 0], middles[n, 1], middles[n, 2]
        worst = max(worst, _middle(nodes[m], nodes[i], nodes[j]))
    first = owner.limbs[0]
    for n in range(first, first + owner.limbs[1]):
        straighten(nodes, limbs[n])
    if owner.glides:
        for i in range(owner.nodes[0], owner.nodes[0] + owner.nodes[1]):
            if nodes[i].glides:
                nodes[i].p[1] = nodes[i].before[1] = nodes[i].place[1]
    return worst


@inlined
def finish(nodes: Records, links: Records, middles: Numbers, limbs: Records, owner: Record) -> None:
    """Go on with one character until nobody sees that its links are off; then set its joints."""
    for _ in range(MOST):
        if project(nodes, links, middles, limbs, owner) <= ENOUGH:
            break
    _set_joints(nodes, limbs, owner)


@inlined
def draw_in(nodes: Records, grips: Numbers, h: float) -> None:
    """Let hands and what they close around come nearer: it is drawn in, and not snatched."""
    for n in range(len(grips)):
        if grips[n, 0] >= 0:
            node = nodes[grips[n, 0]]
            node.gap = max(node.gap - DRAWS * h, 0.0)


@inlined
def hold(nodes: Records, grips: Numbers) -> float:
    """Bring together nodes that are held together: links of length zero.

    Returns:
        How far apart the worst were that should not be [m].
    """
    worst = 0.0
    for n in range(len(grips)):
        if grips[n, 0] < 0 or grips[n, 1] < 0:
            continue
        one, other = nodes[grips[n, 0]], nodes[grips[n, 1]]
        weight = one.give + other.give
        apart = length(minus(triple(one.p), triple(other.p)))
        if apart <= one.gap or weight == 0.0:
            continue
        worst = max(worst, apart - one.gap)
        share = (apart - one.gap) / (apart * weight)
        for k in range(3):
            move = share * (one.p[k] - other.p[k])
            one.p[k] -= one.give * move
            other.p[k] += other.give * move
    return worst


@inlined
def hold_fast(
    nodes: Records,
    links: Records,
    middles: Numbers,
    limbs: Records,
    owners: Records,
    grips: Numbers,
) -> None:
    """Go on with those who hold, and what they hold, until nobody sees a gap."""
    if not _find_who_hold(nodes, owners, grips):
        return
    for _ in range(MOST):
        worst = 0.0
        for c in range(len(owners)):
            if owners[c].busy:
                worst = max(worst, project(nodes, links, middles, limbs, owners[c]))
        if hold(nodes, grips) <= FAST and worst <= ENOUGH:
            break
    for c in range(len(owners)):
        if owners[c].busy:
            _set_joints(nodes, limbs, owners[c])


@inlined
def _find_who_hold(nodes: Records, owners: Records, grips: Numbers) -> bool:
    """Choose those who hold or are held to be gone through; tell whether there are any."""
    some = False
    for c in range(len(owners)):
        owners[c].busy = False
    for n in range(len(grips)):
        if grips[n, 0] >= 0 and grips[n, 1] >= 0:
            some = True
            for k in range(2):
                owners[nodes[grips[n, k]].owner].busy = True
    return some


@inlined
def _set_joints(nodes: Records, limbs: Records, owner: Record) -> None:
    """Put all joints of one character where they belong."""
    first = owner.limbs[0]
    for n in range(first, first + owner.limbs[1]):
        settle(nodes, limbs[n])


@inlined
def are_held(nodes: Records, one: Record, other: Record) -> bool:
    """Tell whether one of two links is held at one of its ends by whose the other is."""
    for k in range(2):
        if nodes[one.ends[k]].holds == other.owner or nodes[other.ends[k]].holds == one.owner:
            return True
    return False


@inlined
def _link(one: Record, other: Record, link: Record) -> float:
    """Move the ends of a link; return how much it was off, as a part of its length."""
    p, q = one.p, other.p
    x, y, z = p[0] - q[0], p[1] - q[1], p[2] - q[2]
    squared = x * x + y * y + z * z
    least, most = link.reach[0], link.reach[1]
    weight = one.give + other.give
    if least * least <= squared <= most * most or weight == 0.0 or squared == 0.0:
        return 0.0
    apart = math.sqrt(squared)
    wanted = least if apart < least else most
    share = (apart - wanted) / (apart * weight)
    a, b = share * one.give, share * other.give
    p[0] -= a * x
    p[1] -= a * y
    p[2] -= a * z
    q[0] += b * x
    q[1] += b * y
    q[2] += b * z
    # What only limits may be off a little more: nobody sees it.
    off: float = abs(apart - wanted) / wanted
    return off if least == most else 0.2 * off


@inlined
def _middle(middle: Record, one: Record, other: Record) -> float:
    """Move three nodes so that one is in the middle of two; return how far it was."""
    weight = middle.give + 0.25 * (one.give + other.give)
    if weight == 0.0:
        return 0.0
    squared = 0.0
    for k in range(3):
        apart = middle.p[k] - 0.5 * (one.p[k] + other.p[k])
        squared += apart * apart
        apart /= weight
        middle.p[k] -= middle.give * apart
        one.p[k] += 0.5 * one.give * apart
        other.p[k] += 0.5 * other.give * apart
    return math.sqrt(squared)
