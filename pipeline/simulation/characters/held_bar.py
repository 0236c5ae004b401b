"""Held bar: where a grip holds a node or a bar, and a push of its ends."""

from __future__ import annotations

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.dynamics.compiled import Records, entry
from pipeline.simulation.spatial import Array


@entry
def find_held_place(nodes: Records, grips: IntArray, number: int, place: Array) -> None:
    """Find the place on a node or a bar at which a grip holds it.

    Args:
        nodes: of all characters.
        grips: (G, 2) nodes that are held together.
        number: of the grip.
        place: (3,) set to the place [m].
    """
    hand, node = nodes[grips[number, 0]], nodes[grips[number, 1]]
    for k in range(3):
        place[k] = node.p[k]
        if hand.grip_bar >= 0:
            share = hand.grip_share
            place[k] = (1.0 - share) * node.p[k] + share * nodes[hand.grip_bar].p[k]


@entry
def push_node(nodes: Records, number: int, impulse: Array, h: float) -> None:
    """Push a node by an impulse (3,), for sub-steps of `h` [N s], [s]."""
    node = nodes[number]
    for k in range(3):
        node.previous[k] -= h * (impulse[k] * node.inverse_mass)
