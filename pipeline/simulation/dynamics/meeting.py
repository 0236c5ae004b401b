"""Meeting: where bodies touch a terrain, or are about to.

Polyhedra touch it with their vertices, and with facets and edges where it stands out
(`ridges`); balls with what is nearest (`rounding`). A body whose centre of mass has left
the terrain is held by nothing any more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.ridges import Found, Ridges
from pipeline.simulation.dynamics.rigid import Bodies, turned
from pipeline.simulation.dynamics.rounding import Triangles
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.terrain import Ground
from pipeline.simulation.terrain.heightfield import HeightField

CORNERS, OTHERS = 12, 6
"""Most vertices of a body, and most other contacts, that are looked at together: the nearest."""

HOLLOW = 1e-3
"""How far around a vertex the ground's other planes are looked for, in sizes of the body."""


@dataclass(frozen=True, eq=False)
class Contacts:
    """Up to K contacts of each of B bodies, the nearest first.

    Attributes:
        gap: (B, K) along the normal, infinite where there is none [m].
        normal: (B, K, 3) from the ground.
        lever: (B, K, 3) from the centre of mass, in the world [m].
    """

    gap: Array
    normal: Array
    lever: Array

    @property
    def least(self) -> Array:
        """The smallest gap (B,) [m]."""
        result: Array = self.gap[:, 0]
        return result

    def put(self, which: NDArray[np.int64], other: Contacts) -> None:
        """Take over those of some bodies."""
        self.gap[which], self.normal[which] = other.gap, other.normal
        self.lever[which] = other.lever

    def some(self, which: NDArray[np.int64]) -> Contacts:
        """Return those of some bodies."""
        return Contacts(self.gap[which], self.normal[which], self.lever[which])


class Meeting:
    """A terrain, ready to be met.

    Attributes:
        ground: it.
        top: its greatest height [m].
        width: of contacts kept a body (K).
    """

    def __init__(self, ground: Ground, with_balls: bool, with_corners: bool) -> None:
        self.ground = ground
        self.field: HeightField = ground.field
        self.top = float(self.field.heights.max())
        self.ridges = Ridges.of(self.field) if with_corners else None
        self.triangles = Triangles.of(self.field) if with_balls else None
        self.width = CORNERS + OTHERS

    def contacts(self, bodies: Bodies, p: Array, q: Array, slack: float) -> Contacts:
        """Return the contacts of bodies at p (B, 3) [m], q (B, 4); see `Contacts`.

        Args:
            bodies: B of them.
            p: their places.
            q: their attitudes.
            slack: larger gaps need not be told [m].
        """
        found = none(len(p), self.width)
        held = self.field.inside(p[:, 0], p[:, 2])
        held &= p[:, 1] - bodies.reach <= self.top + slack
        for rows, meet in (
            (np.flatnonzero(held & (bodies.radius == 0.0)), self._polyhedra),
            (np.flatnonzero(held & (bodies.radius > 0.0)), self._balls),
        ):
            if len(rows):
                found.put(rows, meet(bodies.some(rows), p[rows], q[rows], slack))
        return found

    def _polyhedra(self, bodies: Bodies, p: Array, q: Array, slack: float) -> Contacts:
        assert self.ridges is not None
        R = matrix(q)
        levers = turned(R[:, None], bodies.vertices)
        world = p[:, None] + levers
        corners = self._corners(bodies, world, levers)
        others = _packed(self.ridges.meet(bodies, p, R, world, slack), p, OTHERS)
        return _sorted(_beside(corners, others))

    def _corners(self, bodies: Bodies, world: Array, levers: Array) -> Contacts:
        """Return the contacts of the lowest vertices, and of hollows that they lie in."""
        x, z = world[..., 0], world[..., 2]
        normal = self.field.normal(x, z)
        gap = (world[..., 1] - self.field.height(x, z)) * normal[..., 1]
        gap[~self.field.inside(x, z)] = np.inf
        # The last vertex stands for those that a body has fewer than others.
        again = (bodies.vertices[:, 1:] == bodies.vertices[:, :-1]).all(axis=-1)
        gap[:, 1:][again] = np.inf
        return _lowest(Contacts(gap, normal, levers), CORNERS)

    def _balls(self, bodies: Bodies, p: Array, q: Array, slack: float) -> Contacts:
        assert self.triangles is not None
        found = self.triangles.meet(p, bodies.radius, slack)
        return _sorted(_beside(none(len(p), CORNERS), _packed(found, p, OTHERS)))


def none(bodies: int, width: int) -> Contacts:
    """Return no contacts of so many bodies."""
    normal = np.zeros((bodies, width, 3))
    normal[..., 1] = 1.0
    return Contacts(np.full((bodies, width), np.inf), normal, np.zeros((bodies, width, 3)))


def _packed(found: Found, p: Array, most: int) -> Contacts:
    """Return the nearest contacts of each of the bodies at p (B, 3)."""
    result = none(len(p), most)
    order = np.lexsort((found.gap, found.body))
    body = found.body[order]
    counts = np.bincount(body, minlength=len(p))
    rank = np.arange(len(body)) - (np.cumsum(counts) - counts)[body]
    few = rank < most
    order, body, rank = order[few], body[few], rank[few]
    result.gap[body, rank] = found.gap[order]
    result.normal[body, rank] = found.normal[order]
    result.lever[body, rank] = found.place[order] - p[body]
    return result


def _beside(a: Contacts, b: Contacts) -> Contacts:
    return Contacts(
        np.concatenate([a.gap, b.gap], axis=1),
        np.concatenate([a.normal, b.normal], axis=1),
        np.concatenate([a.lever, b.lever], axis=1),
    )


def _lowest(contacts: Contacts, most: int) -> Contacts:
    """Return as many of the nearest contacts as there is room for."""
    short = most - contacts.gap.shape[1]
    if short > 0:
        return _sorted(_beside(contacts, none(len(contacts.gap), short)))
    whole = _sorted(contacts)
    return Contacts(whole.gap[:, :most], whole.normal[:, :most], whole.lever[:, :most])


def _sorted(contacts: Contacts) -> Contacts:
    order = np.argsort(contacts.gap, axis=1, kind="stable")
    rows = np.arange(len(order))[:, None]
    return Contacts(
        contacts.gap[rows, order], contacts.normal[rows, order], contacts.lever[rows, order]
    )
