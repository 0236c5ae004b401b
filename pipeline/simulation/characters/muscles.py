"""Muscles: accelerations and locks that bring nodes where control wants them.

Feet that stand are locked on the ground, feet that swing are given the velocity that brings them
along their line. All other nodes are drawn by critically damped springs, relaxed by blows.
Gravity is taken off those who hold themselves: a spring alone would let them sag.

Source: Horswill 2008, "Node control": by velocity, by acceleration, and locked in place. Loops
there are proportional, and the damping of nodes keeps them from swinging; here they damp
themselves, so that they hold at any rate of sub-steps.
"""

from __future__ import annotations

from pipeline.simulation.characters.layout import FREE, LOCKED
from pipeline.simulation.characters.record import (
    COUNT,
    ELBOW,
    FOOT,
    HAND,
    HEAD,
    STANCE,
)
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY

TRUNK, LIMBS = 30.0, 24.0
"""How quickly muscles bring nodes where they should be [rad/s]."""

FARTHEST = 0.08
"""That a muscle pulls, however far it has to [m]: no stronger than at this distance."""

CATCHES_UP = 1.5
"""How fast a foot that was stopped on its way goes after where it should be [m/s]."""

LEAPS = 15.0
"""How fast no foot goes, so that what is asked of it is no motion but another place: who runs has
feet of ten [m/s]."""

STUCK = 0.04
"""How far from where it should stand a foot is that was, and does not yet stand [m]."""

WEAKEST = 0.12
"""What a blow leaves of the muscles' quickness."""


@compiled
def firm(k: int) -> float:
    """Return how quickly a node of a person is brought where it should be [rad/s]."""
    limb = k == ELBOW or k == ELBOW + 1 or k == HAND or k == HAND + 1 or k == HEAD
    return LIMBS if limb else TRUNK


@compiled
def pull(person: Record, nodes: Records, dt: float) -> None:
    """Act on all nodes of a person for a sub-step."""
    for k in range(COUNT):
        node = nodes[person.node + k]
        if k >= FOOT:
            _step(person, nodes, k - FOOT, dt)
        else:
            quick = firm(k) * (1.0 - (1.0 - WEAKEST) * person.dazed)
            for c in range(3):
                v = (node.p[c] - node.before[c]) / dt
                along = (person.wanted[k, c] - person.before[k, c]) / dt
                off = min(max(person.wanted[k, c] - node.p[c], -FARTHEST), FARTHEST)
                node.acceleration[c] += quick * (quick * off + 2.0 * (along - v))
            node.acceleration[1] += GRAVITY
        for c in range(3):
            person.before[k, c] = person.wanted[k, c]


@compiled
def _is_there(person: Record, node: Record, k: int) -> bool:
    """Tell whether a foot that came down is about where it should stand."""
    squared = 0.0
    for c in range(3):
        squared += (node.p[c] - person.ankles[k, c]) ** 2
    there: bool = squared < STUCK * STUCK
    return there


@compiled
def _step(person: Record, nodes: Records, k: int, dt: float) -> None:
    """Lock a foot that stands, and send one that swings along its line."""
    node = nodes[person.node + FOOT + k]
    if person.doing[k] == STANCE and (node.lock == LOCKED or _is_there(person, node, k)):
        node.lock = LOCKED
        for c in range(3):
            node.place[c] = person.ankles[k, c]
        return
    node.lock = FREE
    squared = 0.0
    for c in range(3):
        squared += (person.wanted[FOOT + k, c] - person.before[FOOT + k, c]) ** 2
    goes = 1.0 if squared < (LEAPS * dt) ** 2 else 0.0
    for c in range(3):
        along = goes * (person.wanted[FOOT + k, c] - person.before[FOOT + k, c])
        after = person.wanted[FOOT + k, c] - along - node.p[c]
        after = min(max(after, -CATCHES_UP * dt), CATCHES_UP * dt)
        node.before[c] = node.p[c] - along - after
    node.acceleration[1] += GRAVITY
