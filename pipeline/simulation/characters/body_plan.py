"""Body plan: what one character is made of, and the arrays of several."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.body_arrays import (
    LIMB,
    LINK,
    NOBODY,
    NODE,
    OWNER,
    CharacterArrays,
    IntArray,
    RecordArray,
)
from pipeline.simulation.dynamics.record_array import records_of_array, zero_records
from pipeline.simulation.spatial import Array


class Link(NamedTuple):
    """A link of a plan.

    Attributes:
        ends: nodes.
        radius: 0 of a link that cannot be touched [m].
        shortest: least distance of the ends, None for that of the rest pose [m].
        longest: likewise the greatest.
        damping: of one end against the other [1/s].
        flatness: radius for arms that lie around its owner, in its own.
        is_arm: whether it belongs to an arm or its shoulder.
        is_deck: whether people who stand on the thing stand above it, and do not touch it.
        toughness: energy of a touch that hurts, relative to that of its character.
    """

    ends: tuple[int, int]
    radius: float = 0.0
    shortest: float | None = None
    longest: float | None = None
    damping: float = 0.0
    flatness: float = 1.0
    is_arm: bool = False
    is_deck: bool = False
    toughness: float = 1.0


class BodyPlan(NamedTuple):
    """The nodes and links of one character, numbered from its own first.

    Attributes:
        rest: (n, 3) nodes, standing at the origin, X forward, Y up, Z to the right [m].
        mass: (n,) of the nodes, infinite for those that stay in place [kg].
        radius: (n,) of the nodes [m].
        links: its links.
        middles: a node, and the two that it is held between.
        limbs: (k,) `LIMB`.
        pairs: its links that may touch one another.
        air_damping: against the world [1/s].
        ground_damping: of what touches the ground [1/s].
        friction: Coulomb's coefficient.
        bounciness: speed after / before an impact.
        pain_threshold: energy of a touch that hurts [J].
        grips: how many things it can hold.
        edge_radius: of a box, whose nodes are its eight corners [m].
        bearing_nodes: nodes that run on a level bearing.
    """

    rest: Array
    mass: Array
    radius: Array
    links: tuple[Link, ...]
    middles: tuple[tuple[int, int, int], ...] = ()
    limbs: RecordArray = np.zeros(0, LIMB)
    pairs: tuple[tuple[int, int], ...] = ()
    air_damping: float = 0.2
    ground_damping: float = 6.0
    friction: float = 0.6
    bounciness: float = 0.0
    pain_threshold: float = np.inf
    grips: int = 0
    edge_radius: float = 0.0
    bearing_nodes: tuple[int, ...] = ()


def character_arrays(plans: Sequence[BodyPlan], places: Sequence[Array]) -> CharacterArrays:
    """Return the arrays of characters whose nodes (n, 3) are at `places`, at rest."""
    node_starts = _starts([len(plan.rest) for plan in plans])
    link_starts = _starts([len(plan.links) for plan in plans])
    links = _links(plans, node_starts)
    limbs = [plan.limbs.copy() for plan in plans]
    for own, start in zip(limbs, node_starts, strict=True):
        for name in ("root", "joint", "tip", "left", "right", "low", "high"):
            own[name] += start
    return CharacterArrays(
        nodes=_nodes(plans, places, links),
        links=links,
        middles=_renumbered([plan.middles for plan in plans], node_starts, 3),
        limbs=records_of_array(np.concatenate([np.zeros(0, LIMB), *limbs])),
        pairs=_renumbered([plan.pairs for plan in plans], link_starts, 2),
        grips=np.full((sum(plan.grips for plan in plans), 2), NOBODY),
        owners=_owners(plans, node_starts, link_starts),
    )


def _nodes(plans: Sequence[BodyPlan], places: Sequence[Array], links: RecordArray) -> RecordArray:
    counts = [len(plan.rest) for plan in plans]
    nodes = zero_records(sum(counts), NODE)
    for name in ("p", "previous", "lock_place", "anchor"):
        nodes[name] = np.concatenate([np.zeros((0, 3)), *places])
    mass = np.concatenate([np.zeros(0), *(plan.mass for plan in plans)])
    nodes["inverse_mass"] = nodes["mobility"] = 1.0 / mass
    nodes["radius"] = np.concatenate([np.zeros(0), *(plan.radius for plan in plans)])
    nodes["air_damping"] = np.repeat([plan.air_damping for plan in plans], counts)
    nodes["owner"] = np.repeat(np.arange(len(plans)), counts)
    nodes["grip_partner"] = nodes["grip_bar"] = NOBODY
    for plan, start in zip(plans, _starts(counts), strict=True):
        nodes["on_bearing"][[start + k for k in plan.bearing_nodes]] = True
    # A node touches the ground as the last touchable link that ends there.
    for at in (0, 1):
        for n in np.flatnonzero(links["radius"] > 0.0):
            nodes["ground_link"][links["ends"][n, at]] = n
    return nodes


def _links(plans: Sequence[BodyPlan], node_starts: IntArray) -> RecordArray:
    counts = [len(plan.links) for plan in plans]
    links = zero_records(sum(counts), LINK)
    planned = [(plan, link) for plan in plans for link in plan.links]
    ends = [[link.ends for link in plan.links] for plan in plans]
    links["ends"] = _renumbered(ends, node_starts, 2)
    limits = [_length_limits(plan, link) for plan, link in planned]
    links["length_limits"] = np.array(limits).reshape(-1, 2)
    for name in ("radius", "damping", "is_arm", "is_deck", "toughness"):
        links[name] = [getattr(link, name) for _, link in planned]
    links["embraced_radius"] = [link.radius * link.flatness for _, link in planned]
    links["owner"] = np.repeat(np.arange(len(plans)), counts)
    links["touched"] = links["touched_owner"] = links["recent"] = NOBODY
    links["age"] = links["recent_age"] = np.inf
    return links


def _owners(plans: Sequence[BodyPlan], node_starts: IntArray, link_starts: IntArray) -> RecordArray:
    owners = zero_records(len(plans), OWNER)
    spans = {
        "nodes": (node_starts, [len(plan.rest) for plan in plans]),
        "links": (link_starts, [len(plan.links) for plan in plans]),
    }
    for name in ("middles", "limbs", "pairs"):
        counts = [len(getattr(plan, name)) for plan in plans]
        spans[name] = _starts(counts), counts
    for name, (starts, counts) in spans.items():
        owners[name] = np.stack([starts, counts], axis=1)
    for name in ("friction", "bounciness", "ground_damping", "pain_threshold", "edge_radius"):
        owners[name] = [getattr(plan, name) for plan in plans]
    owners["on_bearing"] = [bool(plan.bearing_nodes) for plan in plans]
    owners["embraces"] = owners["stands_on"] = NOBODY
    owners["mass"] = [plan.mass[np.isfinite(plan.mass)].sum() for plan in plans]
    return owners


def _length_limits(plan: BodyPlan, link: Link) -> tuple[float, float]:
    offset = plan.rest[link.ends[0]] - plan.rest[link.ends[1]]
    rest = float(np.sqrt((offset * offset).sum()))
    shortest = rest if link.shortest is None else link.shortest
    return shortest, rest if link.longest is None else link.longest


def _starts(counts: Sequence[int]) -> IntArray:
    return np.cumsum([0, *counts])[:-1]


def _renumbered(
    rows: Sequence[Sequence[Sequence[int]]], starts: IntArray, columns: int
) -> IntArray:
    """Return numbers counted from each character's first as numbers of all."""
    all_rows = [[k + a for k in row] for own, a in zip(rows, starts, strict=True) for row in own]
    return np.array(all_rows, dtype=np.int64).reshape(-1, columns)
