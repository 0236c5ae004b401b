"""Shapes of sounding bodies: box, cylinder, ellipsoid, open vessel and stretched membrane.

A shape is normalised to the cube from -1 to 1 of its bounding box; the longest axis is the first.
A vessel stands on the floor of its last axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log2, pi
from typing import Literal

import numpy as np

from audio.dsp import Signal

ShapeKind = Literal["box", "cylinder", "ellipsoid", "vessel", "membrane"]

FILLED_SHARES: dict[ShapeKind, float] = {
    "box": 1.0,
    "cylinder": pi / 4,
    "ellipsoid": pi / 6,
    "membrane": pi / 4,
}
"""Shares of their bounding boxes that solid bodies fill."""

STATIONS = 17
"""Points along the longest axis at which a body may be struck."""
SIDES = 4
"""Points around each of them."""

# Proportions are rounded to this many steps per doubling: within 2.2 %.
_STEPS = 16
# Thinner bodies are solved as if they were as thick: rounding would spoil their modes.
_FLATTEST = 1e-3
# Multiples of four and of two, so that no point lies in a plane of symmetry.
_ANGLES = 20
_GAUSS = 12


@dataclass(frozen=True, slots=True)
class BodyShape:
    """Dimensions of a body.

    Attributes:
        kind: of the body.
        length: greatest extent [m]; a vessel's diameter.
        width: middle extent [m]; a vessel's height.
        thickness: least extent [m]; of a vessel that of its wall, of a membrane that of its skin.
    """

    kind: ShapeKind
    length: float
    width: float
    thickness: float

    @property
    def volume(self) -> float:
        """Volume of the material [m³]."""
        product = self.length * self.width * self.thickness
        if self.kind == "vessel":
            floor = pi / 4 * self.length**2 * self.thickness
            return pi * (self.length - self.thickness) * product / self.length + floor
        return FILLED_SHARES[self.kind] * product

    @property
    def contact_radius(self) -> float:
        """Radius of curvature where another body touches [m].

        Edges of real boxes and plates are rounded; half the thickness stands for them.
        """
        if self.kind == "ellipsoid":
            return (self.length * self.width * self.thickness) ** (1 / 3) / 2
        if self.kind == "vessel":
            return self.length / 4
        return max(self.thickness / 2, 0.1 * self.width)

    @property
    def radiating_radius(self) -> float:
        """Radius of a sphere that radiates like the body [m]."""
        return (self.length * self.width) ** 0.5 / 2

    @property
    def proportions(self) -> tuple[float, float]:
        """Width and thickness relative to the length, rounded so that like shapes share modes."""
        return _rounded(self.width / self.length), _rounded(self.thickness / self.length)


def _rounded(proportion: float) -> float:
    return float(2.0 ** (round(log2(max(proportion, _FLATTEST)) * _STEPS) / _STEPS))


@dataclass(frozen=True, eq=False)
class Quadrature:
    """Points of a body of length 2 with the volume that each stands for.

    One part of a symmetric body stands for all: what is integrated must be even.

    Attributes:
        points: (M, 3).
        weights: (M,).
        half: (3,) half extents.
        is_symmetric: (3,) whether the body is its own mirror image along each axis.
    """

    points: Signal
    weights: Signal
    half: Signal
    is_symmetric: tuple[bool, bool, bool]


def quadrature(kind: ShapeKind, width: float, thickness: float) -> Quadrature:
    """Return the integration points of a body of length 2.

    Args:
        kind: any but a membrane.
        width: relative to the length.
        thickness: relative to the length.
    """
    if kind == "vessel":
        return _vessel(2 * width, 2 * thickness)
    half = np.array([1.0, width, thickness])
    x, w = np.polynomial.legendre.leggauss(_GAUSS)
    if kind == "box":
        points, weights = _product((x, x, x), (w, w, w))
    else:
        r, wr = (x + 1) / 2, w / 2
        angle = (np.arange(_ANGLES) + 0.5) * 2 * pi / _ANGLES
        turn = np.full(_ANGLES, 2 * pi / _ANGLES)
        grid, weights = _product((r, angle, x), (wr, turn, w))
        r, angle, z = grid.T
        if kind == "cylinder":
            # The axis is that whose extent differs most from the other two.
            points = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)
            weights = weights * r
            if width * width < thickness:
                points = points[:, [2, 0, 1]]
        else:
            flat = np.sqrt(1 - z * z)
            points = np.stack([r * flat * np.cos(angle), r * flat * np.sin(angle), r * z], axis=1)
            weights = weights * r * r
    return _one_part(points * half, weights * half.prod(), half, (True, True, True))


def _one_part(
    points: Signal, weights: Signal, half: Signal, is_symmetric: tuple[bool, bool, bool]
) -> Quadrature:
    """Return the points on the positive side of all mirrors, none of which holds a point."""
    kept = ((points > 0) | ~np.array(is_symmetric)).all(axis=1)
    share = 2 ** sum(is_symmetric)
    return Quadrature(points[kept], weights[kept] * share, half, is_symmetric)


def _product(
    nodes: tuple[Signal, Signal, Signal], weights: tuple[Signal, Signal, Signal]
) -> tuple[Signal, Signal]:
    """Return the points and weights of a product rule: (M, 3), (M,)."""
    points = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    a, b, c = weights
    return points, (a[:, None, None] * b[None, :, None] * c[None, None, :]).reshape(-1)


def _vessel(height: float, wall: float) -> Quadrature:
    """Return the points of a cylinder of radius 1 with a floor, open at the top."""
    few, w_few = np.polynomial.legendre.leggauss(4)
    many, w_many = np.polynomial.legendre.leggauss(12)
    angle = (np.arange(2 * _ANGLES) + 0.5) * pi / _ANGLES
    turn = np.full(2 * _ANGLES, pi / _ANGLES)
    rings = []
    # Radius and height of the wall, and of the floor within it.
    for r0, r1, z0, z1, radial, axial in (
        (1 - wall, 1.0, 0.0, height, (few, w_few), (many, w_many)),
        (0.0, 1 - wall, 0.0, wall, (many, w_many), (few, w_few)),
    ):
        r = r0 + (r1 - r0) * (radial[0] + 1) / 2
        z = z0 + (z1 - z0) * (axial[0] + 1) / 2
        w_r, w_z = radial[1] * (r1 - r0) / 2 * r, axial[1] * (z1 - z0) / 2
        grid, weights = _product((r, angle, z), (w_r, turn, w_z))
        r, a, z = grid.T
        rings.append((np.stack([r * np.cos(a), r * np.sin(a), z - height / 2], axis=1), weights))
    points = np.concatenate([ring[0] for ring in rings])
    weights = np.concatenate([ring[1] for ring in rings])
    return _one_part(points, weights, np.array([1.0, 1.0, height / 2]), (True, True, False))


def strike_points(kind: ShapeKind, width: float, thickness: float) -> tuple[Signal, Signal]:
    """Return points of the surface and their normals: (STATIONS, SIDES, 3) each.

    Stations run along the longest axis; of a vessel around the rim. The sides run from the broad
    face to the narrow one.
    """
    along = np.linspace(-1, 1, STATIONS)[:, None]
    turn = np.linspace(0.5, 0.12, SIDES)[None, :] * pi
    if kind == "vessel":
        # Where it is struck matters most by height: sides run from the rim down.
        around = 0.3 + 0 * turn + pi / 2 * (along + 1) / 2
        height = np.linspace(1, 0.3, SIDES)[None, :] * width * 2 - width + 0 * along
        radial = np.stack([np.cos(around), np.sin(around), 0 * around], axis=-1)
        return radial + np.array([0, 0, 1.0]) * height[..., None], radial
    c, s = np.cos(turn) + 0 * along, np.sin(turn) + 0 * along
    if kind == "box":
        # A blow from one side: faces meet at an edge, and the broad one is met first.
        points = np.stack([along + 0 * c, width * c, thickness + 0 * c], axis=-1)
        return points, np.broadcast_to(np.array([0, 0, 1.0]), points.shape)
    ring = np.sqrt(np.maximum(1 - along**2, 0)) if kind == "ellipsoid" else 1.0 + 0 * along
    disc = kind == "cylinder" and width * width >= thickness
    if disc:
        ring = np.sqrt(np.maximum(1 - along**2, 0))
        points = np.stack([along + 0 * c, width * c * ring, thickness + 0 * c], axis=-1)
        return points, np.broadcast_to(np.array([0, 0, 1.0]), points.shape)
    points = np.stack([along + 0 * c, width * c * ring, thickness * s * ring], axis=-1)
    gradient = np.array([1.0 if kind == "ellipsoid" else 0.0, 1 / width**2, 1 / thickness**2])
    normals = points * gradient
    return points, normals / np.linalg.norm(normals, axis=-1, keepdims=True)
