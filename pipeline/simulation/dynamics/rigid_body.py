"""Rigid bodies: constants and state, as arrays over all bodies.

Letters: p position of the centre of mass in the world, q attitude wxyz, v velocity in the world,
w angular velocity in the frame of the body, L levers from the centre of mass.

Source: Sims 1987, 7.1; 12.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.hull import Hull
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.spatial import Array, matrix

GRAVITY_VECTOR = np.array([0.0, -GRAVITY, 0.0])
"""Acceleration of free fall [m/s²]."""


@dataclass(frozen=True, eq=False)
class BodyModel:
    """One body in its own frame about its centre of mass.

    Attributes:
        mass: mass, and inertia about the centre of mass.
        hull: its surface, None for a ball.
        radius: of a ball [m], 0 for a polyhedron.
        bounciness: velocity ratio after / before an impact.
        friction: Coulomb's coefficient.
        rolling: lever of the rolling resistance, as a fraction of the size.
        soft: duration of the ground's force in a soft impact [s], 0 for an instantaneous one.
    """

    mass: MassProperties
    hull: Hull | None
    radius: float
    bounciness: float
    friction: float
    rolling: float = 0.0
    soft: float = 0.0


@dataclass(frozen=True, eq=False)
class Bodies:
    """Constants of N bodies.

    Attributes:
        hulls: (N,) of polyhedra, None for balls.
        mass: (N,) [kg].
        inertia: (N, 3, 3) along the axes of the body [kg m²].
        inverse: (N, 3, 3) inverse inertia.
        radius: (N,) of balls, 0 for polyhedra [m].
        reach: (N,) largest distance of a point from the centre of mass [m].
        size: (N,) characteristic length [m].
        thin: (N,) distance of the nearest facet from the centre of mass [m].
        bounciness: (N,).
        friction: (N,).
        rolling: (N,) lever of the rolling resistance [m].
        soft: (N,) [s].
    """

    hulls: NDArray[np.object_]
    mass: Array
    inertia: Array
    inverse: Array
    radius: Array
    reach: Array
    size: Array
    thin: Array
    bounciness: Array
    friction: Array
    rolling: Array
    soft: Array

    @staticmethod
    def of(builds: Sequence[BodyModel]) -> Bodies:
        """Returns the constants of bodies as arrays."""
        hulls = np.empty(len(builds), dtype=object)
        hulls[:] = [b.hull for b in builds]
        levers = [np.zeros((1, 3)) if h is None else h.vertices for h in hulls]
        radius = np.array([b.radius for b in builds])
        size = np.array([np.ptp(v, axis=0).max() for v in levers]) + 2.0 * radius
        inertia = np.array([b.mass.inertia for b in builds])
        return Bodies(
            hulls=hulls,
            mass=np.array([b.mass.mass for b in builds]),
            inertia=inertia,
            inverse=np.linalg.inv(inertia),
            radius=radius,
            reach=np.array([np.linalg.norm(v, axis=-1).max() for v in levers]) + radius,
            size=size,
            thin=np.array([b.radius if b.hull is None else b.hull.offsets.min() for b in builds]),
            bounciness=np.array([b.bounciness for b in builds]),
            friction=np.array([b.friction for b in builds]),
            rolling=np.array([b.rolling for b in builds]) * size,
            soft=np.array([b.soft for b in builds]),
        )

    def some(self, which: NDArray[np.int64]) -> Bodies:
        """Returns some of the bodies."""
        return replace(self, **{name: value[which] for name, value in vars(self).items()})


@dataclass(eq=False)
class State:
    """State of N bodies; see the letters above."""

    p: Array
    q: Array
    v: Array
    w: Array

    def some(self, which: NDArray[np.int64]) -> State:
        """Returns a copy of the state of some bodies."""
        return State(self.p[which], self.q[which], self.v[which], self.w[which])

    def put(self, which: NDArray[np.int64], other: State) -> None:
        """Sets the state of some bodies."""
        self.p[which], self.q[which] = other.p, other.q
        self.v[which], self.w[which] = other.v, other.w


def kinetic_energy(bodies: Bodies, v: Array, w: Array) -> Array:
    """Returns the kinetic energies (N,) [J]."""
    return 0.5 * (bodies.mass * dot(v, v) + dot(w, rotate(bodies.inertia, w)))


def total_energy(bodies: Bodies, state: State) -> Array:
    """Returns kinetic and potential energy (N,) over height 0 [J]."""
    return kinetic_energy(bodies, state.v, state.w) + bodies.mass * GRAVITY * state.p[:, 1]


def angular_momentum(bodies: Bodies, state: State) -> Array:
    """Returns the angular momenta (N, 3) about the centres of mass, in the world [kg m²/s]."""
    return rotate(matrix(state.q), rotate(bodies.inertia, state.w))


def dot(a: Array, b: Array) -> Array:
    """Returns a · b (...) of vectors (..., 3), summed in one order for any number of them."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def rotate(R: Array, v: Array) -> Array:
    """Returns R v (..., 3), summed in one order for any number of vectors."""
    return (R[..., :, 0] * v[..., None, 0] + R[..., :, 1] * v[..., None, 1]) + R[..., :, 2] * v[
        ..., None, 2
    ]


def rotate_inverse(R: Array, v: Array) -> Array:
    """Returns Rᵀ v (..., 3), summed like `rotate`."""
    return rotate(np.swapaxes(R, -1, -2), v)
