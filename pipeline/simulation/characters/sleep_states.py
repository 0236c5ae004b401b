"""Sleep states."""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import FREE, RESTING, Numbers
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined

WATCH = 0.25
"""Time after which it is looked whether somebody has moved [s]."""

MOVED, MORE, MOST = 0.006, 0.002, 0.05
"""How far what rests may have moved in that time; how much more for each time that it did not
go far, and how far that is [m]."""

TOUCHES = 0.1
"""How long ago it has to have touched something [s]."""

WAKES = 0.3
"""Speed of what wakes whom it comes to [m/s]."""

TIRED = 8
"""How often somebody has been watched and has not gone far when its tremor wakes nobody: in a pile
each would keep the others awake for ever."""

UNTANGLES = 2.0
"""Time for which links of one character that are in one another are parted [s]: where its joints
hold them there they are thrown back as fast as they part, and it would never lie still."""

DEEP, WEDGED = 0.004, 40
"""How deep somebody lies in another who is given time to come out [m], and how often it is watched
for that."""


@compiled
def look_who_rests(
    nodes: Records, links: Records, owners: Records, grips: Numbers, h: float, dt: float
) -> None:
    """Let those sleep who lie still, and wake whoever is held; once a step."""
    for c in range(len(owners)):
        owner = owners[c]
        if not owner.asleep:
            owner.speed = _speed(nodes, owner) / h
            # Those who act bring their arms out of themselves.
            longer = dt if owner.knotted and not owner.acts else -dt
            owner.tangled = min(max(owner.tangled + longer, 0.0), UNTANGLES)
            owner.knotted = False
            owner.watched += dt
            if owner.watched >= WATCH and not owner.acts:
                _watch(nodes, links, owner)
    for n in range(len(grips)):
        if grips[n, 0] >= 0 and grips[n, 1] >= 0:
            for k in range(2):
                wake(nodes, owners[nodes[grips[n, k]].owner])


@inlined
def strike(nodes: Records, one: Record, other: Record) -> None:
    """Wake who is struck by somebody, unless that one has only trembled for long.

    Who is pushed by somebody who acts does not fall asleep meanwhile.
    """
    if (one.asleep or other.acts) and other.drowsy < TIRED:
        wake(nodes, one)
    if (other.asleep or one.acts) and one.drowsy < TIRED:
        wake(nodes, other)


@inlined
def rouse(nodes: Records, one: Record, other: Record, depth: float, speed: float) -> None:
    """Wake those of two who touch whom that wakes: a blow at a speed [m/s], or a depth [m].

    Who has lain deep in somebody asleep for long wakes that one, for both to make room; who fell
    asleep in spite of it does not wake the other again.
    """
    if speed > WAKES:
        strike(nodes, one, other)
    if depth <= DEEP:
        return
    if one.asleep and one.drowsy < WEDGED and not other.asleep and other.drowsy >= TIRED:
        wake(nodes, one)
    elif other.asleep and other.drowsy < WEDGED and not one.asleep and one.drowsy >= TIRED:
        wake(nodes, other)


@inlined
def wake_near(nodes: Records, owners: Records, near: Numbers) -> None:
    """Wake those beside whom somebody moves."""
    for n in range(len(near)):
        one, other = owners[near[n, 0]], owners[near[n, 1]]
        if one.asleep and not other.asleep and other.speed > WAKES:
            strike(nodes, one, other)
        elif other.asleep and not one.asleep and one.speed > WAKES:
            strike(nodes, one, other)


@compiled
def wake(nodes: Records, owner: Record) -> None:
    """Wake somebody."""
    owner.watched, owner.drowsy = 0.0, 0
    if not owner.asleep:
        return
    owner.asleep = False
    for i in range(owner.nodes[0], owner.nodes[0] + owner.nodes[1]):
        node = nodes[i]
        if node.lock == RESTING:
            node.lock, node.give = FREE, node.inverse_mass
        for k in range(3):
            node.anchor[k] = node.p[k]


@inlined
def _speed(nodes: Records, owner: Record) -> float:
    """Return how far the fastest node went in the last sub-step [m]."""
    fastest = 0.0
    for i in range(owner.nodes[0], owner.nodes[0] + owner.nodes[1]):
        node, squared = nodes[i], 0.0
        for k in range(3):
            squared += (node.p[k] - node.before[k]) ** 2
        fastest = max(fastest, squared)
    return math.sqrt(fastest)


@inlined
def _watch(nodes: Records, links: Records, owner: Record) -> None:
    """Let somebody sleep who has not moved, or remember where it is."""
    owner.watched = 0.0
    first, end = owner.nodes[0], owner.nodes[0] + owner.nodes[1]
    farthest, held = 0.0, False
    for i in range(first, end):
        node, squared = nodes[i], 0.0
        held = held or node.inverse_mass == 0.0
        for k in range(3):
            squared += (node.p[k] - node.anchor[k]) ** 2
            node.anchor[k] = node.p[k]
        farthest = max(farthest, squared)
    for n in range(owner.links[0], owner.links[0] + owner.links[1]):
        held = held or min(links[n].age[0], links[n].age[1]) < TOUCHES
    far = math.sqrt(farthest)
    owner.drowsy = owner.drowsy + 1 if far < MOST else 0
    if not held or far > min(MOVED + MORE * owner.drowsy, MOST):
        return
    if owner.deep > DEEP and owner.drowsy < WEDGED:
        return
    owner.asleep, owner.speed = True, 0.0
    for i in range(first, end):
        if nodes[i].lock == FREE:
            nodes[i].lock = RESTING
