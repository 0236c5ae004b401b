"""Layout: all characters of a troupe as flat arrays, for compiled loops.

Nodes are point masses; links keep two of them apart and are what is touched. What a character
is, is its slices of both. Positions of two sub-steps are the whole state: the velocity of a
node is (p - before) / h.

Before each sub-step control may write, for any node,

- a velocity: `before = p - v h`;
- an acceleration, which is added to gravity and forgotten after the sub-step;
- a lock: `lock = LOCKED` and `place`, where it then stays whatever pulls; `LANDING` becomes
  `LOCKED` where the node next touches the ground; `FREE` lets it go.

Nodes at the middle of two others (`middles`) are held there; what is written to one of the
three moves all.

Source: Horswill 2008, "Geometric and kinematic modeling" and "Dynamics simulation".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.people.proportions import JOINTS
from pipeline.simulation.spatial import Array

Numbers = NDArray[np.int64]
Structures = NDArray[np.void]

PERSON_NODES = {name: k for k, name in enumerate(JOINTS)}
"""Where each joint of a person stands behind its first node."""

FREE, LOCKED, LANDING = 0, 1, 2
"""What a node's lock is."""

NOBODY, TERRAIN, SOLID = -1, -2, -3
"""What is touched that is no link: nothing, the ground, a solid of another room."""

OWNER = np.dtype(
    [
        # First and number of its nodes, links, middles, limbs and pairs of own links.
        ("nodes", "i8", 2),
        ("links", "i8", 2),
        ("middles", "i8", 2),
        ("limbs", "i8", 2),
        ("pairs", "i8", 2),
        # Its mass [kg]; Coulomb's coefficient; speed after / before an impact.
        ("mass", "f8"),
        ("friction", "f8"),
        ("bounciness", "f8"),
        # How fast what touches the ground is damped [1/s].
        ("ground", "f8"),
        # The kinetic energy of a touch above which it hurts, infinite for things [J]; how much
        # it hurts now: 1 for a touch of twice that, and less from then on.
        ("threshold", "f8"),
        ("pain", "f8"),
        # The box around it, with its girth [m].
        ("low", "f8", 3),
        ("high", "f8", 3),
    ],
    align=True,
)
"""A character."""

LIMB = np.dtype(
    [
        # Hip, knee, foot; or shoulder, elbow, hand.
        ("root", "i8"),
        ("joint", "i8"),
        ("tip", "i8"),
        # The nodes of the trunk that it moves against: to the left and right, below and above.
        ("left", "i8"),
        ("right", "i8"),
        ("low", "i8"),
        ("high", "i8"),
        # Lengths of its two links [m].
        ("upper", "f8"),
        ("lower", "f8"),
        # Middle of the cone in which root to tip may lie, in the frame of the trunk, X forward;
        # cosine of its half angle.
        ("middle", "f8", 3),
        ("cone", "f8"),
        # Where the joint points when root to tip lies in the middle; how far aside it may, as a
        # cosine and a sine.
        ("bend", "f8", 3),
        ("spread", "f8", 2),
    ],
    align=True,
)
"""A limb of two links, whose joint bends one way."""


class Crowd(NamedTuple):
    """All characters.

    Attributes:
        p: (N, 3) nodes [m].
        before: (N, 3) one sub-step ago [m].
        acceleration: (N, 3) what control adds to gravity in this sub-step [m/s²].
        inverse_mass: (N,) [1/kg]; 0 stays where it is.
        radius: (N,) of what is there [m].
        air: (N,) damping against the world [1/s].
        owner: (N,) whose.
        lock: (N,) FREE, LOCKED or LANDING.
        place: (N, 3) where a locked node is [m].
        grounded: (N,) the owner's damping where it touches the ground, 0 elsewhere [1/s].
        give: (N,) inverse mass in this sub-step, 0 if locked [1/kg].
        ends: (L, 2) nodes of links; a ball's are one node twice.
        reach: (L, 2) least and most distance of the ends; equal if rigid [m].
        girth: (L,) radius of a link that can be touched, 0 of one that cannot [m].
        link_owner: (L,) whose.
        damping: (L,) of one end against the other [1/s].
        touched: (L,) link that it touches, or NOBODY, TERRAIN, SOLID.
        touched_owner: (L,) whose that is, or NOBODY.
        energy: (L,) kinetic energy of the hardest touch in this step [J].
        age: (L, 2) since it last touched another link, and the ground [s].
        link_of: (N,) the link that a node touches the ground with.
        middles: (M, 3) a node and the two that it is held between.
        limbs: (K,) `LIMB`.
        pairs: (S, 2) links of one character that meet one another.
        grips: (G, 2) nodes that are held together, -1 for none.
        owners: (C,) `OWNER`.
    """

    p: Array
    before: Array
    acceleration: Array
    inverse_mass: Array
    radius: Array
    air: Array
    owner: Numbers
    lock: Numbers
    place: Array
    grounded: Array
    give: Array
    ends: Numbers
    reach: Array
    girth: Array
    link_owner: Numbers
    damping: Array
    touched: Numbers
    touched_owner: Numbers
    energy: Array
    age: Array
    link_of: Numbers
    middles: Numbers
    limbs: Structures
    pairs: Numbers
    grips: Numbers
    owners: Structures


class Link(NamedTuple):
    """A link of a plan.

    Attributes:
        ends: nodes.
        girth: its radius, 0 if nothing touches it [m].
        least: distance that its ends keep, None for that of the rest pose [m].
        most: likewise.
        damping: of one end against the other [1/s].
    """

    ends: tuple[int, int]
    girth: float = 0.0
    least: float | None = None
    most: float | None = None
    damping: float = 0.0


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


def crowd_of(plans: Sequence[Plan], places: Sequence[Array]) -> Crowd:
    """Return the arrays of characters whose nodes (n, 3) are at `places`, at rest."""
    p = np.concatenate([np.zeros((0, 3)), *places])
    count = len(p)
    firsts = _firsts([len(plan.rest) for plan in plans])
    link_firsts = _firsts([len(plan.links) for plan in plans])
    links = [(plan, link, a) for plan, a in zip(plans, firsts, strict=True) for link in plan.links]
    ends = _table([[link.ends[0] + a, link.ends[1] + a] for _, link, a in links], 2)
    limbs = [_moved(plan.limbs, a) for plan, a in zip(plans, firsts, strict=True)]
    owners = _owners(plans, firsts, link_firsts)
    grips = sum(plan.grips for plan in plans)
    mass = np.concatenate([np.zeros(0), *(plan.mass for plan in plans)])
    return Crowd(
        p=p,
        before=p.copy(),
        acceleration=np.zeros((count, 3)),
        inverse_mass=1.0 / mass,
        radius=np.concatenate([np.zeros(0), *(plan.radius for plan in plans)]),
        air=_repeated([plan.air for plan in plans], plans),
        owner=np.repeat(np.arange(len(plans)), [len(plan.rest) for plan in plans]),
        lock=np.zeros(count, dtype=np.int64),
        place=p.copy(),
        grounded=np.zeros(count),
        give=1.0 / mass,
        ends=ends,
        reach=np.array([_reach(plan, link) for plan, link, _ in links]).reshape(-1, 2),
        girth=np.array([link.girth for _, link, _ in links]),
        link_owner=np.repeat(np.arange(len(plans)), [len(plan.links) for plan in plans]),
        damping=np.array([link.damping for _, link, _ in links]),
        touched=np.full(len(links), NOBODY),
        touched_owner=np.full(len(links), NOBODY),
        energy=np.zeros(len(links)),
        age=np.full((len(links), 2), np.inf),
        link_of=_links_of(ends, [link.girth for _, link, _ in links], count),
        middles=_table(
            [
                [k + a for k in m]
                for plan, a in zip(plans, firsts, strict=True)
                for m in plan.middles
            ],
            3,
        ),
        limbs=np.concatenate([np.zeros(0, LIMB), *limbs]).view(np.recarray),
        pairs=_table(
            [
                [k + a for k in pair]
                for plan, a in zip(plans, link_firsts, strict=True)
                for pair in plan.pairs
            ],
            2,
        ),
        grips=np.full((grips, 2), NOBODY),
        owners=owners,
    )


def _links_of(ends: Numbers, girths: Sequence[float], count: int) -> Numbers:
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
    for name in ("friction", "bounciness", "ground", "threshold"):
        owners[name] = [getattr(plan, name) for plan in plans]
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


def _repeated(values: Sequence[float], plans: Sequence[Plan]) -> Array:
    return np.repeat(np.array(values, dtype=float), [len(plan.rest) for plan in plans])


def _table(rows: Sequence[Sequence[int]], columns: int) -> Numbers:
    return np.array(rows, dtype=np.int64).reshape(-1, columns)
