"""Body arrays: all characters of a troupe as flat arrays of records, for compiled loops.

Nodes are point masses; links keep two of them apart and are the solids that touch. A character,
the owner of both, is a slice of each. Positions of two sub-steps are the whole state: the
velocity of a node is (p - previous) / h.

Compiled functions take nodes, links and owners as arrays of records, for a tuple of many arrays
costs more to hand on than most of them do.

Before each sub-step control may write, for any node,

- a velocity: `previous = p - v h`;
- an acceleration, which is added to gravity and cleared after the sub-step;
- a lock: `lock = LOCKED` and `lock_place`, where the node then stays whatever pulls; `LANDING`
  becomes `LOCKED` where the node next touches the ground; `FREE` releases it.

Middle nodes are held between two others; what is written to one of the three moves all.

Source: Horswill 2008, "Geometric and kinematic modeling" and "Dynamics simulation".
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.record_array import cache_lines
from pipeline.simulation.people.proportions import JOINTS
from pipeline.simulation.spatial import Array

IntArray = NDArray[np.int64]
RecordArray = NDArray[np.void]

PERSON_NODES = {name: k for k, name in enumerate(JOINTS)}
"""Joint of a person -> its place behind the person's first node."""

FREE, LOCKED, LANDING, RESTING = 0, 1, 2, 3
"""Locks of a node; RESTING is that of all nodes of a sleeping character."""

NOBODY, TERRAIN, SOLID = -1, -2, -3
RECENT_TOUCHES = 4  # others that a link knows it is touching
"""What a link touches that is no link: nothing, the ground, the first solid of another room;
further solids are numbered downward."""

NODE = cache_lines(
    [
        # What constraints and contacts read and move: positions now and one sub-step ago [m];
        # inverse mass in this sub-step, 0 when locked [1/kg]; radius [m].
        ("p", "f8", 3),
        ("previous", "f8", 3),
        ("mobility", "f8"),
        ("radius", "f8"),
        # The acceleration that control adds to gravity in this sub-step [m/s²]; inverse mass, 0 of
        # what stays in place [1/kg].
        ("acceleration", "f8", 3),
        ("inverse_mass", "f8"),
        # Damping against the world; the owner's while touching the ground or others, else 0 [1/s].
        ("air_damping", "f8"),
        ("ground_damping", "f8"),
        ("contact_damping", "f8"),
        # FREE, LOCKED, LANDING or RESTING.
        ("lock", "i4"),
        # Whether the hand follows what it holds without moving it, as that of a rider, whose feet
        # push back as much as its hands push.
        ("grip_follows", "?"),
        # Whether it runs on a level bearing, at the height of its lock place.
        ("on_bearing", "?"),
        # Offset by which contacts of its links push a locked node [m].
        ("contact_push", "f8", 3),
        # Its character; the link that touches the ground here.
        ("owner", "i8"),
        ("ground_link", "i8"),
        # Owner of the node it is gripped together with, or NOBODY.
        ("grip_partner", "i8"),
        # Distance that a hand still has to close around what it grips [m].
        ("grip_gap", "f8"),
        # Distance at which it holds what it grips: the radius of a ball [m].
        ("grip_length", "f8"),
        # Positions where locked, and when rest was last measured [m].
        ("lock_place", "f8", 3),
        ("anchor", "f8", 3),
        # Node at the other end of a bar that it holds, or NOBODY; how far along the bar, 0 to 1.
        ("grip_bar", "i8"),
        ("grip_share", "f8"),
    ]
)
"""A point mass."""

LINK = cache_lines(
    [
        # End nodes, of a ball the same twice; shortest and longest distance, equal if rigid [m].
        ("ends", "i8", 2),
        ("length_limits", "f8", 2),
        # 0 of a link that cannot be touched [m]; damping of one end against the other [1/s].
        ("radius", "f8"),
        ("damping", "f8"),
        # Radius for arms that lie around its owner: backs are flat [m].
        ("embraced_radius", "f8"),
        ("owner", "i8"),
        # Whether it belongs to an arm or its shoulder, which passes through those of an embraced
        # character.
        ("is_arm", "?"),
        # Whether people who stand on its owner stand above it, and do not touch it.
        ("is_deck", "?"),
        # Energy of a touch that hurts, relative to that of its owner.
        ("toughness", "f8"),
        # The touched link, or NOBODY, TERRAIN, SOLID - k; and its owner, or NOBODY.
        ("touched", "i8"),
        ("touched_owner", "i8"),
        # Kinetic energy of the hardest touch in this step, and of a blow that strikes it with the
        # coming step [J]; time since it last touched another link, and the ground [s].
        ("energy", "f8"),
        ("blow", "f8"),
        ("age", "f8", 2),
        # What it has touched of late: owners, SOLID - thing, or NOBODY; time since it did [s].
        ("recent", "i8", RECENT_TOUCHES),
        ("recent_age", "f8", RECENT_TOUCHES),
    ]
)
"""A constraint between two nodes, and the capsule around them."""

OWNER = cache_lines(
    [
        # Bounding box of its balls [m].
        ("low", "f8", 3),
        ("high", "f8", 3),
        # Deepest contact in this sub-step [m].
        ("penetration", "f8"),
        # Whether contacts are solved for it now.
        ("active", "?"),
        # Whether its constraints held before they were last enforced, and nothing moved it since.
        ("settled", "?"),
        # Whether it acts, and never sleeps; whether it sleeps.
        ("acts", "?"),
        ("asleep", "?"),
        # Whether some of its nodes run on a bearing.
        ("on_bearing", "?"),
        # Whether a dance guides its arms, which keeps them out of its own body.
        ("is_guided", "?"),
        # Whether its own links are deep in one another.
        ("self_penetrating", "?"),
        # First and number of its nodes, links, middles, limbs and pairs of own links.
        ("nodes", "i8", 2),
        ("links", "i8", 2),
        ("middles", "i8", 2),
        ("limbs", "i8", 2),
        ("pairs", "i8", 2),
        # Radius of the edges of a box, whose nodes are its eight corners; 0 of other shapes [m].
        ("edge_radius", "f8"),
        # [kg]; Coulomb's coefficient; speed after / before an impact.
        ("mass", "f8"),
        ("friction", "f8"),
        ("bounciness", "f8"),
        # Damping of what touches the ground [1/s].
        ("ground_damping", "f8"),
        # Speed of its fastest node [m/s].
        ("speed", "f8"),
        # Kinetic energy above which a touch hurts, infinite for things [J]; present pain: 1 for a
        # touch of twice that, decaying.
        ("pain_threshold", "f8"),
        ("pain", "f8"),
        # For how long its own links are deep in one another [s].
        ("tangled_time", "f8"),
        # Owner around whom its arms are put, or NOBODY.
        ("embraces", "i8"),
        # Merry-go-round whose deck it may stand on, or NOBODY.
        ("stands_on", "i8"),
        # Time since rest was measured [s], and number of measurements without much movement.
        ("watch_time", "f8"),
        ("still_count", "i8"),
    ]
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
        # Axis of the cone from root to tip, in the frame of the trunk, X forward; cosine of its
        # half angle.
        ("middle", "f8", 3),
        ("cone", "f8"),
        # Direction of the joint for a limb along the axis; cosine and sine of its spread.
        ("bend", "f8", 3),
        ("spread", "f8", 2),
        # How far it may still come back from beyond its limits in this sub-step [m].
        ("slack", "f8"),
    ],
    align=True,
)
"""A limb of two links, whose joint bends one way."""


class CharacterArrays(NamedTuple):
    """All characters of a troupe.

    Attributes:
        nodes: (N,) `NODE`.
        links: (L,) `LINK`.
        middles: (M, 3) a node and the two that it is held between.
        limbs: (K,) `LIMB`.
        pairs: (S, 2) links of one character that may touch one another.
        grips: (G, 2) nodes that are held together, -1 for none.
        owners: (C,) `OWNER`.
    """

    nodes: RecordArray
    links: RecordArray
    middles: IntArray
    limbs: RecordArray
    pairs: IntArray
    grips: IntArray
    owners: RecordArray

    @property
    def p(self) -> Array:
        """(N, 3) positions of the nodes [m]."""
        return self.nodes["p"]

    @property
    def previous(self) -> Array:
        """(N, 3) positions of the nodes one sub-step ago [m]."""
        return self.nodes["previous"]
