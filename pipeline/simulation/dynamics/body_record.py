"""Body records: one row of numbers per body for compiled code, their shapes, and contact lists."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.hull import Hull
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.dynamics.rigid_body import Bodies, State
from pipeline.simulation.dynamics.vectors import (
    Quaternion,
    Vector,
    dot,
    minus,
    normal_quaternion,
    put,
    row,
    triple,
)
from pipeline.simulation.spatial import Array

MAX_CONTACTS = 48
"""Contacts of a body that are kept, the nearest: as many as corners of a prism's base. MuJoCo
takes no more than 50 of a pair."""

_VECTORS = (MAX_CONTACTS, 3)

BODY = np.dtype(
    [
        # Constants, see `Bodies`; first and number of its vertices, facets and edges.
        ("corners", "i8", 2),
        ("facets", "i8", 2),
        ("edges", "i8", 2),
        ("mass", "f8"),
        ("inertia", "f8", (3, 3)),
        ("inverse", "f8", (3, 3)),
        *((name, "f8") for name in ("radius", "reach", "size", "thin")),
        *((name, "f8") for name in ("bounciness", "friction", "rolling", "soft")),
        # State, see `State`.
        ("p", "f8", 3),
        ("q", "f8", 4),
        ("v", "f8", 3),
        ("w", "f8", 3),
        # Contacts with the ground, the nearest first: smallest gap of those that were dropped,
        # gaps along normals [m], normals from the ground, levers from the centre of mass in the
        # world [m].
        ("count", "i8"),
        ("dropped", "f8"),
        ("gap", "f8", MAX_CONTACTS),
        ("normal", "f8", _VECTORS),
        ("lever", "f8", _VECTORS),
        # Number of contacts that hold it, their forces [N] and levers [m].
        ("held", "i8"),
        ("force", "f8", _VECTORS),
        ("force_lever", "f8", _VECTORS),
        # Time it has been quiet, and remaining time of a soft impact [s]; accelerations of that
        # impact in the world [m/s²], [rad/s²]; depth in soft ground [m].
        ("quiet", "f8"),
        ("pushed", "f8"),
        ("push_v", "f8", 3),
        ("push_w", "f8", 3),
        ("sunk", "f8"),
        ("awake", "?"),
    ],
    align=True,
)
"""A body over a terrain."""


class Shapes(NamedTuple):
    """Polyhedra of all bodies, one after the other.

    Attributes:
        corners: (n, 3) vertices from the centre of mass [m].
        facets: (n, 4) outward normals, and distances from the centre of mass [m].
        edges: (n, 4) vertices and adjacent facets, numbered from the body's first.
    """

    corners: Array
    facets: Array
    edges: NDArray[np.int64]


class Workspace(NamedTuple):
    """Arrays for one body at a time.

    Attributes:
        world: (V, 3) its vertices in the world [m].
        edges: (E, 12) start and extent of edges [m], normals of the adjacent facets.
        series: power series of its rotation.
        parts: (MAX_CONTACTS,) its contacts in the solver.
    """

    world: Array
    edges: Array
    series: Array
    parts: Records


class Motion(NamedTuple):
    """Pose and velocity of one body; letters as in `rigid_body`."""

    p: Vector
    q: Quaternion
    v: Vector
    w: Vector


def records_of(bodies: Bodies, state: State) -> tuple[Records, Shapes]:
    """Returns records of bodies in a state, all awake, and their shapes."""
    records = zero_records(len(bodies.mass), BODY)
    for name in set(BODY.names or ()) & set(vars(bodies)):
        records[name] = getattr(bodies, name)
    records["p"], records["q"], records["v"], records["w"] = state.p, state.q, state.v, state.w
    records["awake"] = True
    # Bodies of one shape share it.
    hulls = list({id(hull): hull for hull in bodies.hulls if hull is not None}.values())
    spans = {id(hull): k for k, hull in enumerate(hulls)}
    shapes = Shapes(
        _stacked([hull.vertices for hull in hulls], 3),
        _stacked([np.column_stack([hull.normals, hull.offsets]) for hull in hulls], 4),
        _stacked([_edges_with_facets(hull) for hull in hulls], 4).astype(np.int64),
    )
    for name, counts in (
        ("corners", [len(hull.vertices) for hull in hulls]),
        ("facets", [len(hull.normals) for hull in hulls]),
        ("edges", [len(hull.edges) for hull in hulls]),
    ):
        first = np.cumsum(counts) - counts
        for i, hull in enumerate(bodies.hulls):
            if hull is not None:
                k = spans[id(hull)]
                records[name][i] = first[k], counts[k]
    return records, shapes


def _stacked(rows: Sequence[NDArray[Any]], columns: int) -> NDArray[Any]:
    return np.concatenate([np.zeros((0, columns)), *rows])


def _edges_with_facets(hull: Hull) -> NDArray[np.int64]:
    """Returns the edges (E, 4) of a hull: vertices and adjacent facets."""
    beside = {}
    for f, facet in enumerate(hull.facets):
        for edge in pairwise((*facet, facet[0])):
            beside[edge] = f
    return np.array([(a, b, beside[a, b], beside[b, a]) for a, b in hull.edges.tolist()])


@compiled
def motion_of(body: Record) -> Motion:
    """Returns pose and velocity of a body."""
    q = body.q
    attitude = normal_quaternion((q[0], q[1], q[2], q[3]))
    return Motion(triple(body.p), attitude, triple(body.v), triple(body.w))


@compiled
def set_motion(body: Record, motion: Motion) -> None:
    """Sets pose and velocity of a body."""
    for i in range(3):
        body.p[i], body.v[i], body.w[i] = motion.p[i], motion.v[i], motion.w[i]
    for i in range(4):
        body.q[i] = motion.q[i]


SAME_CONTACT_DISTANCE = 1e-4
"""Distance of contacts that count as one, in sizes of the body."""

SAME_NORMAL_TOLERANCE = 1e-14
"""Largest 1 - n · n' of normals that count as one."""

EQUAL_GAP = 1e-6
"""Difference of gaps that count as equal, in sizes of the body."""


@compiled
def smallest_gap(body: Record) -> float:
    """Returns the smallest gap of a body, infinite without contacts [m]."""
    return body.gap[0] if body.count > 0 else np.inf


@compiled
def insert_contact(body: Record, gap: float, normal: Vector, lever: Vector) -> None:
    """Inserts a contact in the order of gaps; the farthest is dropped if the list is full."""
    k = body.count
    if k == MAX_CONTACTS:
        body.dropped = min(body.dropped, max(gap, body.gap[k - 1]))
        if gap >= body.gap[k - 1]:
            return
        k -= 1
    else:
        body.count = k + 1
    while k > 0 and body.gap[k - 1] > gap:
        _copy_contact(body, k - 1, k)
        k -= 1
    body.gap[k] = gap
    put(body.normal, k, normal)
    put(body.lever, k, lever)


@compiled
def clear_contacts(body: Record) -> None:
    """Removes all contacts."""
    body.count, body.dropped = 0, np.inf


@compiled
def drop_equal_contacts(body: Record) -> None:
    """Drops the contacts with the same gap as one that was dropped, unless all have it.

    Otherwise their order would decide which of them act.
    """
    least = body.dropped - EQUAL_GAP * body.size
    if body.dropped < np.inf and body.gap[0] < least:
        while body.gap[body.count - 1] >= least:
            body.count -= 1


@compiled
def remove_contact(body: Record, k: int) -> None:
    """Removes contact k."""
    body.count -= 1
    for later in range(k, body.count):
        _copy_contact(body, later + 1, later)


@compiled
def insert_new_contact(body: Record, gap: float, normal: Vector, lever: Vector) -> None:
    """Inserts a contact unless an equal one exists; of two equal ones the nearer stays."""
    k, same = 0, SAME_CONTACT_DISTANCE * body.size
    while k < body.count:
        apart = minus(row(body.lever, k), lever)
        alike = dot(row(body.normal, k), normal) > 1.0 - SAME_NORMAL_TOLERANCE
        if alike and dot(apart, apart) < same * same:
            if body.gap[k] <= gap:
                return
            remove_contact(body, k)
        else:
            k += 1
    insert_contact(body, gap, normal, lever)


@compiled
def _copy_contact(body: Record, source: int, target: int) -> None:
    body.gap[target] = body.gap[source]
    put(body.normal, target, row(body.normal, source))
    put(body.lever, target, row(body.lever, source))
