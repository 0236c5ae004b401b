"""Held bar: where a grip holds a node or a bar, which edge a hand takes, and a push of its ends.

Hands that hold a bar follow it from step to step, so that tasks need not command them in each.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.body_arrays import CharacterArrays, IntArray
from pipeline.simulation.characters.person_record import PLACED
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, entry
from pipeline.simulation.spatial import Array

UPRIGHT = 0.7  # cosine to the vertical from which an edge stands


class HeldBar(NamedTuple):
    """A place on a bar.

    Attributes:
        node: at one end.
        far: node at the other end.
        share: of the way from the one to the other.
    """

    node: int
    far: int
    share: float


def nearest_standing_edge(arrays: CharacterArrays, owner: int, place: Array) -> HeldBar:
    """Return the place nearest to a place (3,) [m] on the edges of a box that stand.

    Of a box that lies askew, on all of its edges. Corners would be no holds: half-way up a box one
    hand would take an upper one and the other hand a lower one, and the box would roll over.
    """
    first, count = arrays.owners[owner].links
    links, p = arrays.links[first : first + count], arrays.p
    ends = np.asarray(links["ends"])[links["radius"] > 0.0]
    start, way = p[ends[:, 0]], p[ends[:, 1]] - p[ends[:, 0]]
    squared = (way * way).sum(axis=1)
    shares = np.clip(((place - start) * way).sum(axis=1) / squared, 0.0, 1.0)
    offsets = np.linalg.norm(start + shares[:, None] * way - place, axis=1)
    stands = way[:, 1] ** 2 > UPRIGHT * UPRIGHT * squared
    if stands.any():
        offsets[~stands] = np.inf
    n = int(np.argmin(offsets))
    return HeldBar(int(ends[n, 0]), int(ends[n, 1]), float(shares[n]))


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


@compiled
def follow_bars(person: Record, nodes: Records, grips: IntArray) -> None:
    """Let hands that hold bars without moving them follow these, on the level of their tasks."""
    for k in range(2):
        number = person.grip + k
        if grips[number, 0] < 0 or grips[number, 1] < 0 or person.arm_mode[k] != PLACED:
            continue
        hand, node = nodes[grips[number, 0]], nodes[grips[number, 1]]
        if hand.grip_follows and hand.grip_bar >= 0:
            far, share = nodes[hand.grip_bar], hand.grip_share
            for c in (0, 2):
                person.arm_target[k, c] = (1.0 - share) * node.p[c] + share * far.p[c]


@entry
def push_node(nodes: Records, number: int, impulse: Array, h: float) -> None:
    """Push a node by an impulse (3,), for sub-steps of `h` [N s], [s]."""
    node = nodes[number]
    for k in range(3):
        node.previous[k] -= h * (impulse[k] * node.inverse_mass)
