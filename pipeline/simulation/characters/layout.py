"""Layout: all characters of a troupe as flat arrays, for compiled loops.

Nodes are point masses; links keep two of them apart and are what is touched. What a character
is, is its slices of both. Positions of two sub-steps are the whole state: the velocity of a
node is (p - before) / h.

Compiled functions take nodes, links and owners as arrays of records: a tuple of many arrays
costs more to hand on than most of them do.

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

FREE, LOCKED, LANDING, RESTING = 0, 1, 2, 3
"""What a node's lock is; RESTING is that of all nodes of a character that sleeps."""

NOBODY, TERRAIN, SOLID = -1, -2, -3
"""What is touched that is no link: nothing, the ground, the first solid of another room; further
solids are numbered downward."""

NODE = np.dtype(
    [
        # Where it is, where it was one sub-step ago, where it is locked, where it was when it was
        # last looked whether it rests [m]; what control adds to gravity in this sub-step [m/s²].
        *((name, "f8", 3) for name in ("p", "before", "place", "anchor", "acceleration")),
        # 0 stays where it is; and in this sub-step, also 0 if it is locked [1/kg].
        ("inverse_mass", "f8"),
        ("give", "f8"),
        # Radius of what is there [m].
        ("radius", "f8"),
        # Damping against the world; and the owner's where it touches the ground, else 0, and where
        # it touches others [1/s].
        ("air", "f8"),
        ("grounded", "f8"),
        ("rubbed", "f8"),
        # Of one that is locked: how far what is in its links would have it give way [m].
        ("pressed", "f8", 3),
        # FREE, LOCKED or LANDING; whose; the link with which it touches the ground.
        ("lock", "i8"),
        ("owner", "i8"),
        ("link", "i8"),
        # Whose the node is that it is held together with by a grip, or NOBODY.
        ("holds", "i8"),
        # How far from what it has closed around a hand is yet [m].
        ("gap", "f8"),
        # Whether it runs on a level bearing, at the height of its place.
        ("glides", "?"),
    ],
    align=True,
)
"""A point mass."""

LINK = np.dtype(
    [
        # Nodes, of a ball the same twice; least and most distance of these, equal if rigid [m].
        ("ends", "i8", 2),
        ("reach", "f8", 2),
        # Radius, 0 of one that cannot be touched [m]; damping of one end against the other [1/s].
        ("girth", "f8"),
        ("damping", "f8"),
        ("owner", "i8"),
        # Whether it is one of an arm, which passes through those of whom it embraces.
        ("arm", "?"),
        # The link that it touches, or NOBODY, TERRAIN, SOLID - k, and whose that is, or NOBODY.
        ("touched", "i8"),
        ("touched_owner", "i8"),
        # Kinetic energy of the hardest touch in this step [J]; since it last touched another
        # link, and the ground [s].
        ("energy", "f8"),
        ("age", "f8", 2),
    ],
    align=True,
)
"""What keeps two nodes apart."""

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
        # Radius of the edges of a box, whose nodes are its eight corners; 0 of what is none [m].
        ("edge", "f8"),
        # Whether some of its nodes glide.
        ("glides", "?"),
        # How deep something was found in it, or it in something, in this sub-step [m].
        ("deep", "f8"),
        # Whether its own links are deep in one another, and for how long [s].
        ("knotted", "?"),
        ("tangled", "f8"),
        # Whether it is gone through now.
        ("busy", "?"),
        # Whom its arms are put around, or NOBODY.
        ("embraces", "i8"),
        # Whether it acts, and never sleeps; whether it sleeps; how long it has been watched [s],
        # and how often it did not go far; how fast its fastest node is [m/s].
        ("acts", "?"),
        ("asleep", "?"),
        ("watched", "f8"),
        ("drowsy", "i8"),
        ("speed", "f8"),
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
    """All characters. The columns of nodes have names of their own in Python, as `crowd.p`.

    Attributes:
        nodes: (N,) `NODE`.
        links: (L,) `LINK`.
        middles: (M, 3) a node and the two that it is held between.
        limbs: (K,) `LIMB`.
        pairs: (S, 2) links of one character that meet one another.
        grips: (G, 2) nodes that are held together, -1 for none.
        owners: (C,) `OWNER`.
    """

    nodes: Structures
    links: Structures
    middles: Numbers
    limbs: Structures
    pairs: Numbers
    grips: Numbers
    owners: Structures

    @property
    def p(self) -> Array:
        """(N, 3) nodes [m]."""
        result: Array = self.nodes["p"]
        return result

    @property
    def before(self) -> Array:
        """(N, 3) nodes one sub-step ago [m]."""
        result: Array = self.nodes["before"]
        return result

    @property
    def ends(self) -> Numbers:
        """(L, 2) nodes of links."""
        result: Numbers = self.links["ends"]
        return result


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
