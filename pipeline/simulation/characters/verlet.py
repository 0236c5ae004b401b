"""Verlet: where nodes go in a sub-step by themselves.

Source: Horswill 2008, "Dynamics simulation" and "Friction, drag and damping".
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.layout import LOCKED, RESTING
from pipeline.simulation.dynamics.compiled import Record, Records, inlined


@inlined
def integrate(nodes: Records, gravity: float, h: float) -> None:
    """Move all nodes on by a sub-step.

    p(t + h) = (2 - d) p(t) - (1 - d) p(t - h) + a h², where d = 1 - exp(-c h): the paper's
    factor is one a sixtieth of a second, a rate c [1/s] holds for any step.

    Args:
        nodes: of all characters.
        gravity: [m/s²].
        h: the sub-step [s].
    """
    for i in range(len(nodes)):
        _move(nodes[i], gravity, h)


@inlined
def _move(node: Record, gravity: float, h: float) -> None:
    p, before, pull = node.p, node.before, node.acceleration
    for k in range(3):
        node.pressed[k] = 0.0
    if node.lock == LOCKED:
        for k in range(3):
            p[k] = before[k] = node.place[k]
            pull[k] = 0.0
        node.give = 0.0
        return
    if node.lock == RESTING or node.inverse_mass == 0.0:
        for k in range(3):
            before[k] = p[k]
            pull[k] = 0.0
        node.give = 0.0
        return
    node.give = node.inverse_mass
    keeps = math.exp(-(node.air + max(node.grounded, node.rubbed)) * h)
    for k in range(3):
        went = p[k] - before[k]
        before[k] = p[k]
        p[k] += keeps * went + pull[k] * h * h
        pull[k] = 0.0
    p[1] -= gravity * h * h
    node.grounded = node.rubbed = 0.0


@inlined
def damp(nodes: Records, links: Records, h: float) -> None:
    """Damp the ends of links against one another, a crude model of muscles and tendons.

    Both take on part of their difference, weighted so that no momentum is made.
    """
    for n in range(len(links)):
        link = links[n]
        if link.damping == 0.0:
            continue
        one, other = nodes[link.ends[0]], nodes[link.ends[1]]
        if one.give + other.give == 0.0:
            continue
        part = (1.0 - math.exp(-link.damping * h)) / (one.give + other.give)
        for k in range(3):
            slip = part * ((one.p[k] - one.before[k]) - (other.p[k] - other.before[k]))
            one.before[k] += one.give * slip
            other.before[k] -= other.give * slip
