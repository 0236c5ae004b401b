"""Mass properties: mass, centre of mass and inertia of polyhedra and of point masses.

A closed surface is the signed sum of tetrahedra from one apex to its triangles. With the apex at
the origin, corners a, b, c and s = a + b + c, a tetrahedron has

    V = a · (b × c) / 6,   ∫ x dV = V s / 4,   ∫ x xᵀ dV = V / 20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ),

so the result is exact for the polyhedron but for rounding. A second moment C = ∫ x xᵀ dm gives the
inertia I = tr(C) 1 - C.

Source: Sims 1987, 7.1.1, whose three moments about the axes are no matrix: a turned figure needs
the products as well, I = Σ m (|L|² 1 - L Lᵀ). Mirtich 1996 for polyhedra.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import MassError
from pipeline.simulation.spatial import Array, cross

_CLOSED: WeakValueDictionary[tuple[int, int], NDArray[Any]] = WeakValueDictionary()
"""Immutable face arrays that were found closed, by address and number of vertices: the links of a
figure share theirs, and the check costs more than all else."""

FLAT = 1e-13
"""Volume that counts as rounding, relative to the cube around a surface."""


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass properties of a rigid body in some frame B.

    Attributes:
        mass: [kg].
        centre: (3,) centre of mass p_BC [m].
        inertia: (3, 3) about the centre of mass, along the axes of B [kg m²]; symmetric.
    """

    mass: float
    centre: Array
    inertia: Array

    def in_frame(self, X_AB: Array) -> MassProperties:
        """Returns the same in another frame.

        Args:
            X_AB: (4, 4) pose of the present frame B in the other one, A.
        """
        R = X_AB[:3, :3]
        return MassProperties(
            self.mass, R @ self.centre + X_AB[:3, 3], _symmetric(R @ self.inertia @ R.T)
        )

    def about(self, point: Array) -> Array:
        """Returns the inertia (3, 3) about a `point` (3,) of B, along its axes [kg m²].

        Source: parallel axis theorem, for tensors.
        """
        arm = self.centre - point
        return self.inertia + _inertia(self.mass * np.outer(arm, arm))

    def moment(self, axis: Array) -> float:
        """Returns the moment of inertia about an axis through the centre of mass [kg m²].

        Args:
            axis: (3,) of length one.

        Source: Sims 1987, 7.1.1, i = T̂ᵀ I T̂.
        """
        return float(axis @ self.inertia @ axis)


def mass_of_solid(
    vertices: Array, faces: NDArray[np.integer[Any]], density: float
) -> MassProperties:
    """Returns the mass properties of the volume that a closed surface encloses.

    The surface may have several pieces; one that faces inward is a hole in another.

    Args:
        vertices: (V, 3) [m].
        faces: (F, 3), counter-clockwise from outside.
        density: [kg/m³].

    Raises:
        MassError: if the surface is open, inside out, flat or not finite, or the density is not
            positive.
    """
    _refuse_open(vertices, faces)
    _refuse_weightless(density, "density")
    # An apex near by keeps the digits of a small solid far from the origin.
    apex = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    corners = (vertices - apex).take(faces.ravel(), axis=0)
    a, b, c = corners[0::3], corners[1::3], corners[2::3]
    s = a + b + c
    volumes = np.einsum("fi,fi->f", a, cross(b, c)) / 6.0
    volume = float(volumes.sum())
    _refuse_empty(volume, np.ptp(vertices, axis=0))
    first = volumes @ s / 4.0
    second = (corners * np.repeat(volumes, 3)[:, None]).T @ corners
    second = (second + (s * volumes[:, None]).T @ s) / 20.0 - np.outer(first, first) / volume
    return MassProperties(
        density * volume, apex + first / volume, _symmetric(_inertia(density * second))
    )


def volume_of_solid(vertices: Array, faces: NDArray[np.integer[Any]]) -> float:
    """Returns the volume [m³] that a closed surface encloses, without checks.

    Args:
        vertices: (V, 3) [m].
        faces: (F, 3), counter-clockwise from outside.
    """
    a, b, c = (vertices - vertices[0])[faces.T]
    return float(np.einsum("fi,fi->", a, cross(b, c))) / 6.0


def mass_of_points(masses: ArrayLike, places: ArrayLike) -> MassProperties:
    """Returns the mass properties of rigidly connected points.

    Args:
        masses: (n,) none of them negative [kg].
        places: (n, 3) [m].

    Raises:
        MassError: if a mass is negative, all are zero, or a value is not finite.

    Source: Sims 1987, 7.1.1; see the head of this module.
    """
    m, p = np.asarray(masses, dtype=float), np.asarray(places, dtype=float)
    total = float(m.sum())
    _refuse_weightless(total, "total mass")
    if not (np.isfinite(p).all() and (m >= 0.0).all()):
        raise MassError("point masses must be finite and none of them negative")
    centre = m @ p / total
    arms = p - centre
    return MassProperties(total, centre, _symmetric(_inertia((arms * m[:, None]).T @ arms)))


def joined(parts: Iterable[MassProperties]) -> MassProperties:
    """Returns the mass properties of rigidly connected bodies, all in one frame.

    Raises:
        MassError: if there are none.
    """
    bodies = list(parts)
    if not bodies:
        raise MassError("nothing was joined, which has no centre of mass")
    mass = sum(body.mass for body in bodies)
    centre = sum((body.mass * body.centre for body in bodies), np.zeros(3)) / mass
    inertia = sum((body.about(centre) for body in bodies), np.zeros((3, 3)))
    return MassProperties(mass, centre, inertia)


def _inertia(second: Array) -> Array:
    """Return the inertia (3, 3) of a second moment ∫ x xᵀ dm (3, 3) [kg m²]."""
    return np.trace(second) * np.eye(3) - second


def _symmetric(matrix: Array) -> Array:
    return 0.5 * (matrix + matrix.T)


def _refuse_open(vertices: Array, faces: NDArray[np.integer[Any]]) -> None:
    """Refuses a surface whose edges are not passed as often one way as the other."""
    if not len(faces) or not np.isfinite(vertices).all():
        raise MassError("the surface has no faces, or vertices that are not finite")
    known = id(faces), len(vertices)
    if _CLOSED.get(known) is faces:
        return
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise MassError(f"a face names a vertex that is none of the {len(vertices)} there are")
    start = faces.astype(np.int64).ravel()
    end = np.roll(faces.astype(np.int64), -1, axis=1).ravel()
    count = len(vertices)
    there, back = np.sort(start * count + end), np.sort(end * count + start)
    if np.array_equal(there, back):
        if not faces.flags.writeable:
            _CLOSED[known] = faces
        return
    edges, passed = np.unique(np.concatenate([there, back]), return_counts=True)
    forth = np.bincount(np.searchsorted(edges, there), minlength=len(edges))
    a, b = divmod(int(edges[np.argmax(2 * forth != passed)]), count)
    raise MassError(
        f"the surface is open or its faces do not agree on what is outside: the edge between "
        f"vertices {a} and {b} is not passed as often one way as the other"
    )


def _refuse_empty(volume: float, extent: Array) -> None:
    # A plate may be thin: rounding grows with the cube around it, not the box.
    if abs(volume) <= FLAT * float(extent.max()) ** 3:
        raise MassError("the surface encloses no volume")
    if volume < 0.0:
        raise MassError("the surface is inside out: its faces run clockwise seen from outside")


def _refuse_weightless(amount: float, what: str) -> None:
    if not (np.isfinite(amount) and amount > 0.0):
        raise MassError(f"a {what} must be finite and positive, is {amount:g}")
