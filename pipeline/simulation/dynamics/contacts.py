"""Contacts: the list that a body has of them, the nearest first."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.records import CONTACTS
from pipeline.simulation.dynamics.vectors import Vector, dot, minus, put, row

SAME_PLACE = 1e-4
"""Distance of contacts that are one, in sizes of the body."""

SAME_NORMAL = 1e-6
"""What 1 - n · n' of contacts with one normal may be."""


@compiled
def least(body: Record) -> float:
    """Return the smallest gap of a body, infinite where it has no contact [m]."""
    return body.gap[0] if body.count > 0 else np.inf


@compiled
def insert(body: Record, gap: float, normal: Vector, lever: Vector) -> None:
    """Add a contact in its order; the farthest is lost where there is no room."""
    k = body.count
    if k == CONTACTS:
        if gap >= body.gap[k - 1]:
            return
        k -= 1
    else:
        body.count = k + 1
    while k > 0 and body.gap[k - 1] > gap:
        _copy(body, k - 1, k)
        k -= 1
    body.gap[k] = gap
    put(body.normal, k, normal)
    put(body.lever, k, lever)


@compiled
def remove(body: Record, k: int) -> None:
    """Take away contact k."""
    body.count -= 1
    for later in range(k, body.count):
        _copy(body, later + 1, later)


@compiled
def insert_new(body: Record, gap: float, normal: Vector, lever: Vector) -> None:
    """Add a contact unless one says the same; of two that do, the nearer stays."""
    k, same = 0, SAME_PLACE * body.size
    while k < body.count:
        apart = minus(row(body.lever, k), lever)
        alike = dot(row(body.normal, k), normal) > 1.0 - SAME_NORMAL
        if alike and dot(apart, apart) < same * same:
            if body.gap[k] <= gap:
                return
            remove(body, k)
        else:
            k += 1
    insert(body, gap, normal, lever)


@compiled
def _copy(body: Record, source: int, target: int) -> None:
    body.gap[target] = body.gap[source]
    put(body.normal, target, row(body.normal, source))
    put(body.lever, target, row(body.lever, source))
