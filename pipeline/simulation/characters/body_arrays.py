"""Body arrays."""

from __future__ import annotations

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
