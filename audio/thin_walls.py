"""Modes of closed thin-walled boxes and cylinders, as plates and shells that meet at edges.

Edges stay where they are, for walls are far stiffer along themselves than across, and their angles
stay right. A box is six plates whose slopes agree at the edges. A cylinder is a shell held round
by its ends, and two discs that the shell keeps from turning at their rims.

Source: Leissa 1969, for plates; Arnold and Warburton 1949, for the shell; Timoshenko and
Woinowsky-Krieger 1959, ch. 15, for the stiffness of a shell's rim.
"""

from __future__ import annotations

from itertools import combinations, product
from math import pi

import numpy as np
from scipy.optimize import brentq
from scipy.special import iv, ivp, jv, jvp

from audio.body_shape import SIDES, STATIONS, ShapeKind
from audio.dsp import Signal
from audio.symmetric_eigen import lowest_eigenpairs

# Functions of each parity along each side of a plate.
_FUNCTIONS = 5
_GAUSS = 16
# Stiffness of an edge's right angle, in that of a plate.
_CORNER = 1e4
# A blow at an edge moves the wall beside it [share of the half length].
_BESIDE_EDGE = 0.85
# What a blow on the shell moves of the ends, and one on an end of the shell; by ear.
_THROUGH_RIM = 0.2
# Greatest wave numbers of the shell, around and along; of the discs, diameters and circles.
_AROUND, _ALONG, _DIAMETERS, _CIRCLES = 9, 6, 4, 3

THIN = 0.08
"""Greatest thickness of a thin wall, as a share of the least extent."""


def thin_walled_modes(
    kind: ShapeKind, width: float, thickness: float, wall: float, poisson: float
) -> tuple[Signal, Signal]:
    """Return the modes of a hollow box or cylinder of length 2, in any order.

    Args:
        kind: box or cylinder.
        width: relative to the length.
        thickness: relative to the length.
        wall: relative to the length.
        poisson: Poisson's ratio.

    Returns:
        (M,) angular frequencies for unit density and Young's modulus, and (M, STATIONS * SIDES)
        displacements along the normal at the points of impact, of mean square 1 over the wall.
    """
    if kind == "box":
        return _box(np.array([1.0, width, thickness]) - wall, 2 * wall, poisson)
    # The axis is that whose extent differs most from the other two.
    is_long = width * width < thickness
    across = (width * thickness) ** 0.5 if is_long else width**0.5
    along = 1.0 if is_long else thickness
    return _cylinder(across - wall, along - wall, 2 * wall, poisson, is_long)


def _box(half: Signal, wall: float, poisson: float) -> tuple[Signal, Signal]:
    """Return the modes of six plates of half extents (3,); see `thin_walled_modes`."""
    s, w = np.polynomial.legendre.leggauss(_GAUSS)
    bending = wall**3 / (12 * (1 - poisson**2))
    x = np.linspace(-_BESIDE_EDGE, _BESIDE_EDGE, STATIONS)
    y = _BESIDE_EDGE * np.cos(np.linspace(0.5, 0.12, SIDES) * pi)
    omegas, shapes = [], []
    volume = sum(8 * wall * half[i] * half[j] for i, j in combinations(range(3), 2))
    for parity in product((0, 1), repeat=3):
        f, curved = zip(*(_supported(s, p) for p in parity), strict=True)
        # Products of the functions of each axis, and of their curvatures, over its length.
        own = [half[i] * (f[i] * w) @ f[i].T for i in range(3)]
        mixed = [(f[i] * w) @ curved[i].T / half[i] for i in range(3)]
        twice = [(curved[i] * w) @ curved[i].T / half[i] ** 3 for i in range(3)]
        size = _FUNCTIONS**2
        K, M = np.zeros((3 * size, 3 * size)), np.zeros((3 * size, 3 * size))
        for normal in range(3):
            i, j = (axis for axis in range(3) if axis != normal)
            face = slice(normal * size, (normal + 1) * size)
            cross = np.kron(mixed[i], mixed[j].T)
            laplacian = np.kron(twice[i], own[j]) + np.kron(own[i], twice[j]) + cross + cross.T
            # Both faces of a pair.
            K[face, face] = 2 * bending * laplacian
            M[face, face] = 2 * wall * np.kron(own[i], own[j])
        for one, other in combinations(range(3), 2):
            along = 3 - one - other
            turn = np.zeros((_FUNCTIONS, 3 * size))
            for normal, axis in ((one, other), (other, one)):
                slope = np.full((1, _FUNCTIONS), -2.0 / half[axis])
                eye = np.eye(_FUNCTIONS)
                parts = (slope, eye) if axis < along else (eye, slope)
                turn[:, normal * size : (normal + 1) * size] = np.kron(*parts)
            K += 4 * _CORNER * bending / half.min() * turn.T @ own[along] @ turn
        squared, vectors = lowest_eigenpairs(K, M, 2 * size)
        seen = np.einsum("mx,ny->mnxy", _supported(x, parity[0])[0], _supported(y, parity[1])[0])
        omegas.append(np.sqrt(np.maximum(squared, 0.0)))
        shapes.append(vectors[2 * size :].T @ seen.reshape(size, -1) * np.sqrt(volume))
    return np.concatenate(omegas), np.concatenate(shapes)


def _supported(s: Signal, parity: int) -> tuple[Signal, Signal]:
    """Return functions that are 0 at both ends of -1 to 1, 1 in slope there, and curvatures.

    Args:
        s: (N,) places.
        parity: 0 for even functions, 1 for odd ones.

    Returns:
        (_FUNCTIONS, N) values of (1 - s²) P_m, whose slope at 1 is -2, and second derivatives.
    """
    edge = np.polynomial.Polynomial([1.0, 0.0, -1.0])
    values, curvatures = [], []
    for k in range(_FUNCTIONS):
        legendre = np.polynomial.Legendre.basis(2 * k + parity)
        function = edge * legendre.convert(kind=np.polynomial.Polynomial)
        values.append(function(s))
        curvatures.append(function.deriv(2)(s))
    return np.array(values), np.array(curvatures)


def _cylinder(
    radius: float, half: float, wall: float, poisson: float, is_long: bool
) -> tuple[Signal, Signal]:
    """Return the modes of shell and ends; see `thin_walled_modes`.

    Args:
        radius: of the shell.
        half: of its length.
        wall: thickness.
        poisson: Poisson's ratio.
        is_long: whether it is struck on the shell, not on an end.
    """
    shell, end = 4 * pi * radius * half * wall, pi * radius**2 * wall
    volume = shell + 2 * end
    across = np.linspace(-_BESIDE_EDGE, _BESIDE_EDGE, STATIONS)
    omegas, shapes = [], []
    for m, n in product(range(1, _ALONG + 1), range(_AROUND + 1)):
        # With one wave around, the whole bends as a bar, of which no end is held.
        waves = m + 0.5 if n == 1 else m
        omega, outward = _shell_mode(waves * pi * radius / (2 * half), n, wall / radius, poisson)
        # Modes of one n stand in two directions; together they are the same all around.
        seen = outward * (2.0 if n else np.sqrt(2.0)) * np.abs(np.sin(0.5 * m * pi * (across + 1)))
        omegas.append(omega / radius)
        shapes.append(np.sqrt(volume / shell) * seen * (1.0 if is_long else _THROUGH_RIM))
    bending = np.sqrt(wall**2 / (12 * (1 - poisson**2)))
    rim = 2 * (3 * (1 - poisson**2)) ** 0.25 * np.sqrt(radius / wall)
    for n in range(_DIAMETERS + 1):
        for root in _disc_roots(n, rim, poisson):
            r = np.linspace(0.0, 1.0, 200)
            mean = np.mean(2 * r * _disc_shape(n, root, r) ** 2) * (0.5 if n else 1.0)
            seen = np.abs(_disc_shape(n, root, np.abs(across))) / np.sqrt(mean)
            omegas.append(bending * (root / radius) ** 2)
            shapes.append(np.sqrt(volume / end) * seen * (_THROUGH_RIM if is_long else 1.0))
    return np.array(omegas), np.repeat(np.array(shapes), SIDES, axis=1)


def _shell_mode(axial: float, n: int, wall: float, poisson: float) -> tuple[float, float]:
    """Return the lowest frequency of a shell of radius 1 held round, and how much is outward.

    Args:
        axial: wave number along the axis.
        n: waves around.
        wall: thickness.
        poisson: Poisson's ratio.
    """
    k, shear = wall**2 / 12, (1 - poisson) / 2
    uv, uw = -(1 + poisson) / 2 * axial * n, -poisson * axial
    vw = n + k * (n**3 + (2 - poisson) * axial**2 * n)
    energy = np.array(
        [
            [axial**2 + shear * n**2, uv, uw],
            [uv, n**2 + shear * axial**2 + k * (n**2 + 4 * shear * axial**2), vw],
            [uw, vw, 1 + k * (axial**2 + n**2) ** 2],
        ]
    )
    squared, vectors = np.linalg.eigh(energy)
    return float(np.sqrt(squared[0] / (1 - poisson**2))), float(abs(vectors[2, 0]))


def _disc_shape(n: int, root: float, r: Signal) -> Signal:
    """Return the shape of a disc of radius 1 that does not move at its rim, at radii (N,)."""
    return np.asarray(jv(n, root * r) / jv(n, root) - iv(n, root * r) / iv(n, root))


def _disc_roots(n: int, rim: float, poisson: float) -> list[float]:
    """Return the lowest frequencies of a disc of radius 1, as roots of those in its stiffness.

    Args:
        n: number of nodal diameters.
        rim: stiffness of the rim against turning, in that of the disc.
        poisson: Poisson's ratio.
    """

    def moment(x: float) -> float:
        # Bending moment and that of the rim; multiplied so that it has no poles.
        bessel, growing = jv(n, x), iv(n, x)
        slope = x * (jvp(n, x) * growing - ivp(n, x) * bessel)
        curved = x * x * (jvp(n, x, 2) * growing - ivp(n, x, 2) * bessel)
        return float((curved + (poisson + rim) * slope) / growing)

    grid = np.linspace(1.0, 20.0, 400)
    values = np.array([moment(x) for x in grid])
    signs = np.flatnonzero(values[:-1] * values[1:] < 0)
    return [brentq(moment, grid[i], grid[i + 1]) for i in signs[:_CIRCLES]]
