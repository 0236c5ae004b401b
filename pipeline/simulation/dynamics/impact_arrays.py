"""Impact arrays: what the impact law reads and writes, as records for compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Record, Records
from pipeline.simulation.spatial import Array

THING = np.dtype(
    [
        # The lower one of a pair counts.
        ("bounciness", "f8"),
        # 0 for what does not give way [1/kg]; in its own frame [1/(kg m²)].
        ("inverse_mass", "f8"),
        ("inverse_inertia", "f8", (3, 3)),
        # Largest speed that a unit impulse gives any point of it [1/kg].
        ("gives", "f8"),
        # Present motion while in contact: angular and linear velocity in the world at its centre
        # [rad/s, m/s], centre [m], rotation matrix.
        ("velocity", "f8", 6),
        ("centre", "f8", 3),
        ("attitude", "f8", 9),
    ],
    align=True,
)
"""A thing: the terrain, a body, or a kinematic body, in this order."""


PAIR = np.dtype([("key", "i8"), ("onset", "f8")])
"""Two things in contact, by number, and the start of their last bounce [s]."""


STRIKE = np.dtype(
    [
        # Numbers of a body and of the other thing; time in the world [s]; see `Strike`.
        ("one", "i8"),
        ("other", "i8"),
        ("time", "f8"),
        ("place", "f8", 3),
        ("normal", "f8", 3),
        ("speed", "f8"),
        ("energy", "f8"),
    ],
    align=True,
)
"""The start of an impact."""


LAW_STATE = np.dtype(
    [
        # Length of the step [s]; number of bodies.
        ("h", "f8"),
        ("bodies", "i8"),
        # Half of `pairs` of the step before, its length, and number of strikes recorded.
        ("half", "i8"),
        ("known", "i8"),
        ("told", "i8"),
    ],
    align=True,
)
"""State of the law in one world."""


class ContactSet(NamedTuple):
    """All n contacts at one moment, those of one pair in a row.

    Attributes:
        contacts: (n,) of MuJoCo: position, `dist` negative at overlap [m]; the first three of
            `frame` are the normal from the first to the second; `dim` rows from `efc_address`,
            negative for none: normal, two of sliding, spin and rolling.
        things: (g,) the thing that each geom belongs to.
        springs: (k, 4) of rows; the first two become stiffness [1/s²] and damping [1/s].
        velocity: (m, 6) angular and linear velocities of all things in the world, at their centres
            [rad/s, m/s].
        centre: (m, 3) of all things [m].
        attitude: (m, 9) rotation matrices of all things.
    """

    contacts: Records
    things: NDArray[np.int32]
    springs: Array
    velocity: Array
    centre: Array
    attitude: Array


class ImpactLaw(NamedTuple):
    """Bounces in progress, and constants of things.

    Attributes:
        now: a `LAW_STATE`.
        things: (m,) `THING`.
        pairs: (2, room) `PAIR` of this step and of the one before, sorted.
        speeds: (room,) separation speeds of contacts [m/s].
        strikes: room for `STRIKE` records.
    """

    now: Record
    things: Records
    pairs: Records
    speeds: Array
    strikes: Records
