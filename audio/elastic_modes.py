"""Free vibrations of elastic bodies by the Ritz method.

The displacement is a polynomial in the three coordinates, and the modes are the stationary points
of the elastic over the kinetic energy. One basis serves bars, plates, balls and vessels: bending
with shear and rotary inertia, torsion and Lamb's modes of a sphere are all in it. Symmetry splits
the equations by the parity of each displacement, which keeps matrices small.

Source: Visscher, Migliori, Bell and Reinert 1991; Love 1927 for the energies; Rayleigh 1877 for
the membrane's.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product

import numpy as np
from scipy.special import jn_zeros, jv

from audio.body_shape import SIDES, STATIONS, ShapeKind, quadrature, strike_points
from audio.dsp import SINGLE_THREAD_SIZE, Signal
from audio.mode_store import stored
from audio.symmetric_eigen import lowest_eigenpairs
from audio.thin_walls import THIN, thin_walled_modes

MODES = 24
"""Number of the lowest modes that are kept."""

# Thin walls need more: their displacement is a polynomial across the whole body.
_DEGREE, _WALLED_DEGREE = 9, 11
# Across a thin body the displacement is at most cubic.
_THIN, _THIN_DEGREE = 0.25, 3
_RIGID_MODES = 6
# Modes closer than this are one, as seen from any point: only their sum does not depend on how
# the solver turns them.
_SAME = 2e-3


@dataclass(frozen=True, eq=False)
class BodyModes:
    """Modes of a body of unit length, density and Young's modulus.

    Attributes:
        omega: (M,) angular frequencies; those of a body are sqrt(E / ρ) / length times as high.
        displacement: (M, STATIONS, SIDES) along the surface's normal at the points of impact;
            its mean square over the volume is 1.
    """

    omega: Signal
    displacement: Signal

    @cached_property
    def mean_square(self) -> Signal:
        """Mean squares of the displacements over the surface: (M,)."""
        return np.asarray((self.displacement**2).mean(axis=(1, 2)))


@lru_cache(maxsize=512)
def body_modes(
    kind: ShapeKind, width: float, thickness: float, wall: float, poisson: float
) -> BodyModes:
    """Return the lowest modes of a body that is free everywhere.

    Args:
        kind: of the body; not a membrane.
        width: relative to the length.
        thickness: relative to the length.
        wall: of a hollow body, relative to the length; 0 if it is solid.
        poisson: Poisson's ratio.
    """
    body = kind, width, thickness, wall, poisson
    table = stored(body, (1 + STATIONS * SIDES,), lambda: _solved(*body))
    return BodyModes(table[:, 0], table[:, 1:].reshape(-1, STATIONS, SIDES))


def _solved(kind: ShapeKind, width: float, thickness: float, wall: float, poisson: float) -> Signal:
    """Return frequencies and displacements of the lowest modes: (M, 1 + STATIONS * SIDES)."""
    if kind != "ellipsoid" and 0 < wall <= THIN * thickness:
        found, displaced = thin_walled_modes(kind, width, thickness, wall, poisson)
        lowest = np.argsort(found, kind="stable")[:MODES]
        return _merged(2 * found[lowest], displaced[lowest])
    body = quadrature(kind, width, thickness, wall)
    x = body.points / body.half
    is_walled = kind == "vessel" or wall > 0
    degree = _WALLED_DEGREE if is_walled else _DEGREE
    exponents = _exponents(width, thickness, degree, is_walled)
    values = [_legendre(x[:, i], degree) for i in range(3)]
    slopes = [_slopes(values[i]) / body.half[i] for i in range(3)]
    at, normals = strike_points(kind, width, thickness)
    seen = [_legendre(at[..., i].reshape(-1) / body.half[i], degree) for i in range(3)]
    omegas, shapes = [], []
    for parity in product(*((0, 1) if symmetric else (None,) for symmetric in body.is_symmetric)):
        blocks = [_of_parity(exponents, parity, axis) for axis in range(3)]
        K, M = _energies(blocks, values, slopes, body.weights, poisson)
        squared, vectors = lowest_eigenpairs(K, M, MODES + _RIGID_MODES)
        normal = np.concatenate(
            [
                _basis(block, seen) * normals[..., axis].reshape(-1, 1)
                for axis, block in enumerate(blocks)
            ],
            axis=1,
        )
        omegas.append(squared)
        shapes.append((normal @ vectors).T * np.sqrt(body.weights.sum()))
    squared = np.concatenate(omegas)
    order = np.argsort(squared, kind="stable")[_RIGID_MODES : _RIGID_MODES + MODES]
    # The body of the equations has a length of 2.
    omega = 2 * np.sqrt(np.maximum(squared[order], 0))
    return _merged(omega, np.concatenate(shapes)[order])


def _exponents(
    width: float, thickness: float, degree: int, is_walled: bool
) -> list[tuple[int, int, int]]:
    most = [degree if is_walled or x > _THIN else _THIN_DEGREE for x in (width, thickness)]
    return [
        (i, j, k)
        for i, j, k in product(range(degree + 1), range(most[0] + 1), range(most[1] + 1))
        if i + j + k <= degree
    ]


def _of_parity(
    exponents: list[tuple[int, int, int]], parity: tuple[int | None, ...], axis: int
) -> Signal:
    """Return the exponents of one displacement component: (N, 3).

    A mode even in x has a displacement along x that is odd in x.
    """
    return np.array(
        [
            e
            for e in exponents
            if all(p is None or (e[i] + p + (i == axis)) % 2 == 0 for i, p in enumerate(parity))
        ]
    )


def _legendre(x: Signal, degree: int) -> Signal:
    """Return Legendre polynomials at points (N,): (N, degree + 1)."""
    return np.asarray(np.polynomial.legendre.legvander(x, degree), dtype=float)


def _slopes(values: Signal) -> Signal:
    """Return the derivatives of Legendre polynomials: P'_n = P'_(n-2) + (2n - 1) P_(n-1)."""
    slopes = np.zeros_like(values)
    for n in range(1, values.shape[1]):
        slopes[:, n] = (2 * n - 1) * values[:, n - 1] + (slopes[:, n - 2] if n > 1 else 0)
    return slopes


def _basis(block: Signal, tables: list[Signal]) -> Signal:
    i, j, k = block.T
    return np.asarray(tables[0][:, i] * tables[1][:, j] * tables[2][:, k])


def _energies(
    blocks: list[Signal], values: list[Signal], slopes: list[Signal], weights: Signal, nu: float
) -> tuple[Signal, Signal]:
    """Return the stiffness and the mass matrix for unit density and Young's modulus."""
    lame, shear = nu / ((1 + nu) * (1 - 2 * nu)), 1 / (2 * (1 + nu))
    root = np.sqrt(weights)[:, None]
    functions = [root * _basis(block, values) for block in blocks]
    slope = [
        [
            root * _basis(block, [slopes[i] if i == axis else values[i] for i in range(3)])
            for axis in range(3)
        ]
        for block in blocks
    ]
    ends = np.cumsum([0, *(len(block) for block in blocks)])
    K, M = np.zeros((ends[-1], ends[-1])), np.zeros((ends[-1], ends[-1]))
    for a in range(3):
        rows = slice(ends[a], ends[a + 1])
        M[rows, rows] = _products(functions[a], functions[a])
        for b in range(a, 3):
            columns = slice(ends[b], ends[b + 1])
            part = lame * _products(slope[a][a], slope[b][b])
            part += shear * _products(slope[a][b], slope[b][a])
            if a == b:
                part += shear * sum(_products(s, s) for s in slope[a])
            K[rows, columns] = part
            K[columns, rows] = part.T
    return K, M


def _products(left: Signal, right: Signal) -> Signal:
    """Return left.T @ right, summed over products small enough to stay on one thread."""
    rows = max(SINGLE_THREAD_SIZE // (left.shape[1] * right.shape[1]), 1)
    whole = len(left) // rows * rows
    stack = np.matmul(
        left[:whole].reshape(-1, rows, left.shape[1]).transpose(0, 2, 1),
        right[:whole].reshape(-1, rows, right.shape[1]),
    ).sum(axis=0)
    return np.asarray(stack + left[whole:].T @ right[whole:])


def _merged(omega: Signal, shapes: Signal) -> Signal:
    """Return modes with those of equal frequency as one, of the root of their summed squares."""
    kept = []
    first = 0
    for last in range(1, omega.size + 1):
        if last < omega.size and omega[last] < omega[first] * (1 + _SAME):
            continue
        group = shapes[first:last]
        frequency = float(f"{omega[first:last].mean():.6g}")
        size = np.sqrt((group**2).sum(axis=0))
        # Of a single mode the sign is kept, up to that of the solver.
        kept.append(np.append(frequency, np.round(size, 6)))
        first = last
    return np.array(kept)


@lru_cache(maxsize=1)
def membrane_modes() -> BodyModes:
    """Return the modes of a round membrane of unit diameter, density and tension per thickness.

    Its wave speed is 1: ω = 2 j_mn / diameter, with the zeros j_mn of the Bessel functions.
    """
    found = [(2 * z, n, z) for n in range(8) for z in jn_zeros(n, 5)]
    found = sorted(found)[:MODES]
    x = np.linspace(-1, 1, STATIONS)
    turn = np.linspace(0, 0.5, SIDES) * np.pi
    shapes = [
        np.outer(jv(n, z * np.abs(x)), np.cos(n * turn))
        / (abs(jv(n + 1, z)) * (1 if n == 0 else np.sqrt(0.5)))
        for _, n, z in found
    ]
    return BodyModes(np.array([f[0] for f in found]), np.abs(np.array(shapes)))
