"""Contact sliding: how bodies move along what they touch.

Of each body the contact counts that slides most. Of two bodies in contact only the quicker one is
reported: the one that slides, not what it slides over.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.rigid_body import dot
from pipeline.simulation.spatial import Array, cross

Numbers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Contacts:
    """K contacts between T things.

    Attributes:
        things: (K, 2) numbers of the two things.
        place: (K, 3) [m].
        normal: (K, 3) from the first to the second.
        p, v, w: (T, 3) position, velocity and angular velocity of the things, in the world.
    """

    things: Numbers
    place: Array
    normal: Array
    p: Array
    v: Array
    w: Array


@dataclass(frozen=True, eq=False)
class SlidingMotion:
    """Motion of N things along what they touch.

    Attributes:
        touches: (N,) whether a thing touches anything.
        other: (N,) number of the other thing.
        place: (N, 3) [m].
        normal: (N, 3) from the other thing.
        along: (N,) speed of the centre along the other thing [m/s].
        slip: (N,) speed of the contact [m/s].
    """

    touches: NDArray[np.bool_]
    other: Numbers
    place: Array
    normal: Array
    along: Array
    slip: Array


def sliding_motion(contacts: Contacts, which: range) -> SlidingMotion:
    """Returns how the things of a range move along what they touch."""
    one, other = np.concatenate([contacts.things, contacts.things[:, ::-1]]).T
    place = np.concatenate([contacts.place, contacts.place])
    normal = np.concatenate([-contacts.normal, contacts.normal])
    speed = np.sqrt(dot(contacts.v, contacts.v))
    quicker = (speed[one] > speed[other]) | ((speed[one] == speed[other]) & (one < other))
    own = np.flatnonzero((one >= which.start) & (one < which.stop) & quicker)
    one, other, place, normal = one[own], other[own], place[own], normal[own]
    under = contacts.v[other] + cross(contacts.w[other], place - contacts.p[other])
    middle = contacts.v[one] - under
    touch = middle + cross(contacts.w[one], place - contacts.p[one])
    along, slip = (_tangential_speed(u, normal) for u in (middle, touch))
    # Sorted by slip: the last one written slides most.
    order = np.lexsort((other, slip))
    count, rows = len(which), one[order] - which.start
    found = SlidingMotion(
        np.zeros(count, dtype=bool),
        np.zeros(count, dtype=np.int64),
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        np.zeros(count),
        np.zeros(count),
    )
    found.touches[rows] = True
    for values, own_values in (
        (found.other, other),
        (found.place, place),
        (found.normal, normal),
        (found.along, along),
        (found.slip, slip),
    ):
        values[rows] = own_values[order]
    return found


def _tangential_speed(u: Array, normal: Array) -> Array:
    across = u - dot(u, normal)[:, None] * normal
    return np.sqrt(dot(across, across))
