"""Shapes of sounding bodies: box, cylinder, ellipsoid, open vessel and stretched membrane.

Boxes, cylinders and ellipsoids are solid, or hollow and closed.
A shape is normalised to the cube from -1 to 1 of its bounding box; the longest axis is the first.
A vessel stands on the floor of its last axis.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
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
# Points across the wall of a hollow body.
_ACROSS = 4


@dataclass(frozen=True, slots=True)
class BodyShape:
    """Dimensions of a body.

    Attributes:
        kind: of the body.
        length: greatest extent [m]; a vessel's diameter.
        width: middle extent [m]; a vessel's height.
        thickness: least extent [m]; of a vessel that of its wall, of a membrane that of its skin.
        wall: thickness of the wall of a hollow box, cylinder or ellipsoid [m]; 0 if it is solid.
            That of an ellipsoid is in proportion to its axes, and this its least.
    """

    kind: ShapeKind
    length: float
    width: float
    thickness: float
    wall: float = 0.0

    @property
    def volume(self) -> float:
        """Volume of the material [m³]."""
        product = self.length * self.width * self.thickness
        if self.kind == "vessel":
            floor = pi / 4 * self.length**2 * self.thickness
            return pi * (self.length - self.thickness) * product / self.length + floor
        return FILLED_SHARES[self.kind] * (product - self._cavity)

    @property
    def _cavity(self) -> float:
        """Volume of the box around the cavity [m³]."""
        if not self.wall:
            return 0.0
        axes = (self.length, self.width, self.thickness)
        if self.kind == "ellipsoid":
            return (1 - 2 * self.wall / self.thickness) ** 3 * axes[0] * axes[1] * axes[2]
        inner = [max(axis - 2 * self.wall, 0.0) for axis in axes]
        return inner[0] * inner[1] * inner[2]

    def hollow(self, wall: float) -> BodyShape:
        """Return the shape with a cavity inside a wall [m]; solid where the wall leaves none."""
        can_be = self.kind in ("box", "cylinder", "ellipsoid")
        return replace(self, wall=wall) if can_be and 0 < 2 * wall < self.thickness else self

    def scaled(self, factor: float) -> BodyShape:
        """Return a shape of the same proportions and of another size."""
        axes = (self.length, self.width, self.thickness, self.wall)
        return BodyShape(self.kind, *(factor * axis for axis in axes))

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
    def proportions(self) -> tuple[float, float, float]:
        """Width, thickness and wall relative to the length, so rounded that like ones are equal."""
        width, thickness = (
            _rounded(self.width / self.length),
            _rounded(self.thickness / self.length),
        )
        wall = _rounded(self.wall / self.length) if self.wall else 0.0
        # Rounding must leave a cavity.
        return width, thickness, min(wall, 0.45 * thickness)


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


def quadrature(kind: ShapeKind, width: float, thickness: float, wall: float = 0.0) -> Quadrature:
    """Return the integration points of a body of length 2.

    Args:
        kind: any but a membrane.
        width: relative to the length.
        thickness: relative to the length.
        wall: of a hollow body, relative to the length; 0 if it is solid.
    """
    if kind == "vessel":
        return _vessel(2 * width, 2 * thickness)
    if wall:
        return _hollow(kind, np.array([1.0, width, thickness]), 2 * wall)
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


def _hollow(kind: ShapeKind, half: Signal, wall: float) -> Quadrature:
    """Return the points of the wall of a hollow body, on the positive side of all mirrors.

    Args:
        kind: box, cylinder or ellipsoid.
        half: (3,) half extents.
        wall: thickness of the wall, where the half length is 1.
    """
    quarter = (np.arange(_ANGLES // 2) + 0.5) * pi / _ANGLES
    turn = np.full(quarter.size, pi / _ANGLES)
    if kind == "ellipsoid":
        r, w_r = _gauss(_ACROSS, 1 - wall / float(half.min()), 1.0)
        z, w_z = _gauss(_GAUSS, 0.0, 1.0)
        grid, weights = _product((r, quarter, z), (w_r * r * r, turn, w_z))
        r, angle, z = grid.T
        flat = r * np.sqrt(1 - z * z)
        points = np.stack([flat * np.cos(angle), flat * np.sin(angle), r * z], axis=1) * half
        return Quadrature(points, 8 * weights * half.prod(), half, (True, True, True))
    if kind == "box":
        points, weights = _around([_cells(extent, wall) for extent in half])
        return Quadrature(points, 8 * weights, half, (True, True, True))
    # The axis is that whose extent differs most from the other two.
    axis = 0 if half[1] * half[1] < half[2] else 2
    across = [i for i in range(3) if i != axis]
    radii = half[across]
    whole = (quarter, turn), (np.zeros(0), np.zeros(0))
    (r, angle, z), weights = _around_columns(
        [_cells(1.0, wall / float(radii.min())), whole, _cells(float(half[axis]), wall)]
    )
    points = np.empty((r.size, 3))
    points[:, across[0]] = radii[0] * r * np.cos(angle)
    points[:, across[1]] = radii[1] * r * np.sin(angle)
    points[:, axis] = z
    return Quadrature(points, 8 * weights * r * radii.prod(), half, (True, True, True))


_Rule = tuple[Signal, Signal]
"""Points and weights of a rule on a line."""


def _gauss(count: int, low: float, high: float) -> _Rule:
    """Return the points and weights of Gauss and Legendre between two places: (count,) each."""
    x, w = np.polynomial.legendre.leggauss(count)
    return low + (high - low) * (x + 1) / 2, w * (high - low) / 2


def _cells(extent: float, wall: float) -> tuple[_Rule, _Rule]:
    """Return rules for half of the inside of an axis and for its wall."""
    return _gauss(_GAUSS, 0.0, extent - wall), _gauss(_ACROSS, extent - wall, extent)


def _around_columns(axes: list[tuple[_Rule, _Rule]]) -> tuple[list[Signal], Signal]:
    """Return coordinates and weights of all cells but the innermost: 3 of (M,), (M,)."""
    found = []
    for choice in product((0, 1), repeat=3):
        rules = [axis[i] for axis, i in zip(axes, choice, strict=True)]
        if any(choice) and all(rule[0].size for rule in rules):
            (a, wa), (b, wb), (c, wc) = rules
            found.append(_product((a, b, c), (wa, wb, wc)))
    points = np.concatenate([part for part, _ in found])
    return list(points.T), np.concatenate([weights for _, weights in found])


def _around(axes: list[tuple[_Rule, _Rule]]) -> _Rule:
    """Return points and weights of all cells but the innermost: (M, 3), (M,)."""
    columns, weights = _around_columns(axes)
    return np.stack(columns, axis=1), weights


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
