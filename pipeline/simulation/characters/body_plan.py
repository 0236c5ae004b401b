"""Body plan."""

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
    Crowd,
    Numbers,
    Structures,
)
from pipeline.simulation.spatial import Array


class Link(NamedTuple):
    """A link of a plan.

    Attributes:
        ends: nodes.
        girth: its radius, 0 if nothing touches it [m].
        least: distance that its ends keep, None for that of the rest pose [m].
        most: likewise.
        damping: of one end against the other [1/s].
        arm: whether it is one of an arm.
    """

    ends: tuple[int, int]
    girth: float = 0.0
    least: float | None = None
    most: float | None = None
    damping: float = 0.0
    arm: bool = False


class Plan(NamedTuple):
    """What one character is made of; nodes and links count from its own first.

    Attributes:
        rest: (n, 3) its nodes, standing at the origin, X forward, Y up, Z to the right [m].
        mass: (n,) of them, infinite for those that stay [kg].
        radius: (n,) [m].
        links: its.
        middles: a node, and the two that it is held between.
        limbs: (k,) `LIMB`.
        pairs: its links that meet one another.
        air: damping against the world [1/s].
        ground: damping of what touches the ground [1/s].
        friction: Coulomb's coefficient.
        bounciness: speed after / before an impact.
        threshold: energy of a touch that hurts [J].
        grips: how many things it can hold.
        edge: radius of the edges of a box, whose nodes are its eight corners [m].
        gliding: nodes that run on a level bearing.
    """

    rest: Array
    mass: Array
    radius: Array
    links: tuple[Link, ...]
    middles: tuple[tuple[int, int, int], ...] = ()
    limbs: Structures = np.zeros(0, LIMB)
    pairs: tuple[tuple[int, int], ...] = ()
    air: float = 0.2
    ground: float = 6.0
    friction: float = 0.6
    bounciness: float = 0.0
    threshold: float = np.inf
    grips: int = 0
    edge: float = 0.0
    gliding: tuple[int, ...] = ()


def crowd_of(plans: Sequence[Plan], places: Sequence[Array]) -> Crowd:
    """Return the arrays of characters whose nodes (n, 3) are at `places`, at rest."""
    firsts = _firsts([len(plan.rest) for plan in plans])
    link_firsts = _firsts([len(plan.links) for plan in plans])
    links = _links(plans, firsts)
    limbs = [_moved(plan.limbs, a) for plan, a in zip(plans, firsts, strict=True)]
    return Crowd(
        nodes=_nodes(plans, places, links),
        links=links,
        middles=_numbered([plan.middles for plan in plans], firsts, 3),
        limbs=np.concatenate([np.zeros(0, LIMB), *limbs]).view(np.recarray),
        pairs=_numbered([plan.pairs for plan in plans], link_firsts, 2),
        grips=np.full((sum(plan.grips for plan in plans), 2), NOBODY),
        owners=_owners(plans, firsts, link_firsts),
    )


def _nodes(plans: Sequence[Plan], places: Sequence[Array], links: Structures) -> Structures:
    counts = [len(plan.rest) for plan in plans]
    nodes = np.zeros(sum(counts), NODE).view(np.recarray)
    for name in ("p", "before", "place", "anchor"):
        nodes[name] = np.concatenate([np.zeros((0, 3)), *places])
    mass = np.concatenate([np.zeros(0), *(plan.mass for plan in plans)])
    nodes["inverse_mass"] = nodes["give"] = 1.0 / mass
    nodes["radius"] = np.concatenate([np.zeros(0), *(plan.radius for plan in plans)])
    nodes["air"] = np.repeat([plan.air for plan in plans], counts)
    nodes["owner"] = np.repeat(np.arange(len(plans)), counts)
    nodes["holds"] = NOBODY
    for plan, first in zip(plans, _firsts(counts), strict=True):
        nodes["glides"][[first + k for k in plan.gliding]] = True
    nodes["link"] = _links_of(links["ends"], links["girth"], len(nodes))
    return nodes


def _links(plans: Sequence[Plan], firsts: Numbers) -> Structures:
    counts = [len(plan.links) for plan in plans]
    links = np.zeros(sum(counts), LINK).view(np.recarray)
    each = [(plan, link) for plan in plans for link in plan.links]
    links["ends"] = _numbered([[link.ends for link in plan.links] for plan in plans], firsts, 2)
    links["reach"] = np.array([_reach(plan, link) for plan, link in each]).reshape(-1, 2)
    links["girth"] = [link.girth for _, link in each]
    links["damping"] = [link.damping for _, link in each]
    links["arm"] = [link.arm for _, link in each]
    links["owner"] = np.repeat(np.arange(len(plans)), counts)
    links["touched"] = links["touched_owner"] = NOBODY
    links["age"] = np.inf
    return links


def _links_of(ends: Numbers, girths: Array, count: int) -> Numbers:
    """Return the link of each node: of those that are touched the last that ends there."""
    found = np.zeros(count, dtype=np.int64)
    for at in (0, 1):
        for n, girth in enumerate(girths):
            if girth > 0.0:
                found[ends[n, at]] = n
    return found


def _owners(plans: Sequence[Plan], firsts: Numbers, link_firsts: Numbers) -> Structures:
    owners = np.zeros(len(plans), OWNER).view(np.recarray)
    spans = {
        "nodes": (firsts, [len(plan.rest) for plan in plans]),
        "links": (link_firsts, [len(plan.links) for plan in plans]),
    }
    for name in ("middles", "limbs", "pairs"):
        counts = [len(getattr(plan, name)) for plan in plans]
        spans[name] = _firsts(counts), counts
    for name, (first, counts) in spans.items():
        owners[name] = np.stack([first, counts], axis=1)
    for name in ("friction", "bounciness", "ground", "threshold", "edge"):
        owners[name] = [getattr(plan, name) for plan in plans]
    owners["glides"] = [bool(plan.gliding) for plan in plans]
    owners["embraces"] = NOBODY
    owners["mass"] = [plan.mass[np.isfinite(plan.mass)].sum() for plan in plans]
    return owners


def _reach(plan: Plan, link: Link) -> tuple[float, float]:
    apart = plan.rest[link.ends[0]] - plan.rest[link.ends[1]]
    rest = float(np.sqrt((apart * apart).sum()))
    least = rest if link.least is None else link.least
    return least, rest if link.most is None else link.most


def _moved(limbs: Structures, first: int) -> Structures:
    moved = limbs.copy()
    for name in ("root", "joint", "tip", "left", "right", "low", "high"):
        moved[name] += first
    return moved


def _firsts(counts: Sequence[int]) -> Numbers:
    ends = np.cumsum([0, *counts])
    return ends[:-1]


def _numbered(rows: Sequence[Sequence[Sequence[int]]], firsts: Numbers, columns: int) -> Numbers:
    """Return numbers of each character, counted from its first, as numbers of all."""
    all_rows = [[k + a for k in row] for one, a in zip(rows, firsts, strict=True) for row in one]
    return np.array(all_rows, dtype=np.int64).reshape(-1, columns)
