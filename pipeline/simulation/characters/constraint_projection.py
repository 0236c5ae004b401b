"""Constraint projection: links get their lengths and middle nodes their places.

Each end of a link moves by its share of the inverse masses: the halves of Horswill 2008
conserve momentum for equal masses alone. The offset printed there, p_i - p_i, is p_i - p_j.

Source: Horswill 2008, "Kinematic constraints"; Jakobsen 2001.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.limb_limits import limit_limbs, place_joints
from pipeline.simulation.dynamics.compiled import Record, Records, inlined
from pipeline.simulation.dynamics.vectors import Vector, length, minus, plus, times, triple

LENGTH_TOLERANCE = 2e-3  # relative error of a link at which iteration stops
SURE = 0.999  # part of a tolerance below which rounding cannot exceed it
LIMIT_WEIGHT = 0.2  # of errors of links that are not rigid: limits may be off more, unseen
MAX_ITERATIONS = 40
GUIDED_LIMBS = 2  # arms, the last limbs of a person
GRIP_CLOSING_SPEED = 1.0  # at which a hand and what it grips come together [m/s]
GRIP_TOLERANCE = 5e-4  # [m]


@inlined
def project_constraints(
    nodes: Records, links: Records, middles: IntArray, limbs: Records, owner: Record
) -> bool:
    """Project the links, middles and joint limits of one character once, and note if it is settled.

    Returns:
        Whether all lengths were right before.
    """
    first = owner.links[0]
    is_right = True
    for n in range(first, first + owner.links[1]):
        link = links[n]
        is_right = _project_link(nodes[link.ends[0]], nodes[link.ends[1]], link) and is_right
    first = owner.middles[0]
    for n in range(first, first + owner.middles[1]):
        m, i, j = middles[n, 0], middles[n, 1], middles[n, 2]
        offset = _project_middle(nodes[m], nodes[i], nodes[j])
        is_right = is_right and offset <= LENGTH_TOLERANCE
    is_limited = False
    if owner.limbs[1] > 0:
        is_limited = limit_limbs(nodes, limbs, owner.limbs[0], _limited_limbs(owner))
    owner.settled = is_right and not is_limited
    if owner.on_bearing:
        for i in range(owner.nodes[0], owner.nodes[0] + owner.nodes[1]):
            if nodes[i].on_bearing:
                nodes[i].p[1] = nodes[i].previous[1] = nodes[i].lock_place[1]
    return is_right


@inlined
def finish_constraints(
    nodes: Records, links: Records, middles: IntArray, limbs: Records, owner: Record
) -> None:
    """Iterate the constraints of one character to tolerance, unless settled, and set its joints."""
    if not owner.settled:
        for _ in range(MAX_ITERATIONS):
            if project_constraints(nodes, links, middles, limbs, owner):
                break
    _set_joints(nodes, limbs, owner)


@inlined
def close_grips(nodes: Records, grips: IntArray, h: float) -> None:
    """Let gripped nodes approach their hands gradually."""
    for n in range(len(grips)):
        if grips[n, 0] >= 0:
            node = nodes[grips[n, 0]]
            node.grip_gap = max(node.grip_gap - GRIP_CLOSING_SPEED * h, node.grip_length)


@inlined
def place_on_bar(one: Record, other: Record, t: float) -> Vector:
    """Return the place at a fraction of the way from one node to another [m]."""
    return plus(times(1.0 - t, triple(one.p)), times(t, triple(other.p)))


@inlined
def project_grips(nodes: Records, owners: Records, grips: IntArray) -> float:
    """Bring together nodes held by a grip: links of length zero.

    Characters that this moves are settled no longer.

    Returns:
        The largest excess distance before [m].
    """
    largest = 0.0
    for n in range(len(grips)):
        if grips[n, 0] < 0 or grips[n, 1] < 0:
            continue
        one, other = nodes[grips[n, 0]], nodes[grips[n, 1]]
        # A bar is held between its ends; a node is a bar of which only this end counts.
        far = nodes[one.grip_bar] if one.grip_bar >= 0 else other
        t = one.grip_share if one.grip_bar >= 0 else 0.0
        yields = 0.0 if one.grip_follows else 1.0
        held = yields * ((1.0 - t) ** 2 * other.mobility + t * t * far.mobility)
        mobility = one.mobility + held
        offset = minus(triple(one.p), place_on_bar(other, far, t))
        distance = length(offset)
        if distance <= one.grip_gap or mobility == 0.0:
            continue
        largest = max(largest, distance - one.grip_gap)
        if distance - one.grip_gap > GRIP_TOLERANCE:
            owners[one.owner].settled = False
            if held > 0.0:
                owners[other.owner].settled = False
        share = (distance - one.grip_gap) / (distance * mobility)
        for k in range(3):
            move = share * offset[k]
            one.p[k] -= one.mobility * move
            other.p[k] += yields * (1.0 - t) * other.mobility * move
            if t > 0.0:
                far.p[k] += yields * t * far.mobility * move
    return largest


@inlined
def finish_grips(
    nodes: Records,
    links: Records,
    middles: IntArray,
    limbs: Records,
    owners: Records,
    grips: IntArray,
) -> None:
    """Iterate all characters that hold or are held, with their grips, to tolerance.

    Those whose constraints hold, and which no grip moves, are left as they are.
    """
    if not _activate_gripping(nodes, owners, grips):
        return
    for _ in range(MAX_ITERATIONS):
        is_right = True
        for c in range(len(owners)):
            if owners[c].active and not owners[c].settled:
                is_right = project_constraints(nodes, links, middles, limbs, owners[c]) and is_right
        if project_grips(nodes, owners, grips) <= GRIP_TOLERANCE and is_right:
            break
    for c in range(len(owners)):
        if owners[c].active:
            _set_joints(nodes, limbs, owners[c])


@inlined
def _activate_gripping(nodes: Records, owners: Records, grips: IntArray) -> bool:
    """Mark characters that hold or are held active; tell whether there are any."""
    found = False
    for c in range(len(owners)):
        owners[c].active = False
    for n in range(len(grips)):
        if grips[n, 0] >= 0 and grips[n, 1] >= 0:
            found = True
            for k in range(2):
                owners[nodes[grips[n, k]].owner].active = True
    return found


@inlined
def _set_joints(nodes: Records, limbs: Records, owner: Record) -> None:
    if owner.limbs[1] > 0:
        place_joints(nodes, limbs, owner.limbs[0], _limited_limbs(owner))


@inlined
def _limited_limbs(owner: Record) -> int:
    """Return how many limbs of a character have limits here: without arms that a dance guides.

    Those have the limits of the guide's hinges, which reach farther than cones.
    """
    count: int = owner.limbs[1] - GUIDED_LIMBS if owner.is_guided else owner.limbs[1]
    return count


@inlined
def is_gripped(nodes: Records, one: Record, other: Record) -> bool:
    """Tell whether the character of one link grips an end of the other."""
    for k in range(2):
        if (
            nodes[one.ends[k]].grip_partner == other.owner
            or nodes[other.ends[k]].grip_partner == one.owner
        ):
            return True
    return False


@inlined
def _project_link(one: Record, other: Record, link: Record) -> bool:
    """Move the ends of a link; tell whether its length was right."""
    p, q = one.p, other.p
    x, y, z = p[0] - q[0], p[1] - q[1], p[2] - q[2]
    squared = x * x + y * y + z * z
    shortest, longest = link.length_limits[0], link.length_limits[1]
    mobility = one.mobility + other.mobility
    if shortest * shortest <= squared <= longest * longest or mobility == 0.0 or squared == 0.0:
        return True
    distance = math.sqrt(squared)
    wanted = shortest if distance < shortest else longest
    share = (distance - wanted) / (distance * mobility)
    a, b = share * one.mobility, share * other.mobility
    p[0] -= a * x
    p[1] -= a * y
    p[2] -= a * z
    q[0] += b * x
    q[1] += b * y
    q[2] += b * z
    error: float = abs(distance - wanted)
    if error < SURE * LENGTH_TOLERANCE * wanted:
        # Most are, and need no division.
        return True
    weight = 1.0 if shortest == longest else LIMIT_WEIGHT
    return weight * (error / wanted) <= LENGTH_TOLERANCE


@inlined
def _project_middle(middle: Record, one: Record, other: Record) -> float:
    """Move a node midway between two others; return its distance from there."""
    mobility = middle.mobility + 0.25 * (one.mobility + other.mobility)
    if mobility == 0.0:
        return 0.0
    squared = 0.0
    for k in range(3):
        offset = middle.p[k] - 0.5 * (one.p[k] + other.p[k])
        squared += offset * offset
        offset /= mobility
        middle.p[k] -= middle.mobility * offset
        one.p[k] += 0.5 * one.mobility * offset
        other.p[k] += 0.5 * other.mobility * offset
    return math.sqrt(squared)
