"""Verlet: where nodes go in a sub-step by themselves.

Source: Horswill 2008, "Dynamics simulation" and "Friction, drag and damping".
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.layout import LOCKED, Crowd
from pipeline.simulation.dynamics.compiled import compiled


@compiled
def integrate(crowd: Crowd, gravity: float, h: float) -> None:
    """Move all nodes on by a sub-step.

    p(t + h) = (2 - d) p(t) - (1 - d) p(t - h) + a h², where d = 1 - exp(-c h): the paper's
    factor is one a sixtieth of a second, a rate c [1/s] holds for any step.

    Args:
        crowd: the characters.
        gravity: [m/s²].
        h: the sub-step [s].
    """
    p, before, pull = crowd.p, crowd.before, crowd.acceleration
    for i in range(len(p)):
        if crowd.lock[i] == LOCKED:
            for k in range(3):
                p[i, k] = before[i, k] = crowd.place[i, k]
                pull[i, k] = 0.0
            crowd.give[i] = 0.0
            continue
        crowd.give[i] = crowd.inverse_mass[i]
        if crowd.inverse_mass[i] == 0.0:
            continue
        keeps = math.exp(-(crowd.air[i] + crowd.grounded[i]) * h)
        for k in range(3):
            went = p[i, k] - before[i, k]
            before[i, k] = p[i, k]
            p[i, k] += keeps * went + pull[i, k] * h * h
            pull[i, k] = 0.0
        p[i, 1] -= gravity * h * h
        crowd.grounded[i] = 0.0


@compiled
def damp(crowd: Crowd, h: float) -> None:
    """Damp the ends of links against one another, a crude model of muscles and tendons.

    Both take on part of their difference, weighted so that no momentum is made.
    """
    before, p = crowd.before, crowd.p
    for n in range(len(crowd.ends)):
        if crowd.damping[n] == 0.0:
            continue
        i, j = crowd.ends[n, 0], crowd.ends[n, 1]
        w_i, w_j = crowd.give[i], crowd.give[j]
        if w_i + w_j == 0.0:
            continue
        part = (1.0 - math.exp(-crowd.damping[n] * h)) / (w_i + w_j)
        for k in range(3):
            slip = part * ((p[i, k] - before[i, k]) - (p[j, k] - before[j, k]))
            before[i, k] += w_i * slip
            before[j, k] -= w_j * slip
