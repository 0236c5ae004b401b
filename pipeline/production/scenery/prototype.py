"""Prototype: the shape of one plant or stone, which is repeated over the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array

Color = tuple[float, float, float]

UP = np.array([0.0, 1.0, 0.0])

TAPER = 0.85
"""Power of the distance from the tip with which a blade gets wider."""


@dataclass(frozen=True, eq=False)
class Prototype:
    """A shape that stands at the origin, Y up.

    Attributes:
        vertices: (V, 3) float32 [m].
        normals: (V, 3) float32, unit vectors to shade with.
        colors: (V, 3) float32, linear.
        foliage: (F, 3) uint32 triangles of thin sheets that let light through.
        solid: (G, 3) uint32 triangles of all else.
    """

    vertices: NDArray[np.float32]
    normals: NDArray[np.float32]
    colors: NDArray[np.float32]
    foliage: NDArray[np.uint32]
    solid: NDArray[np.uint32]

    @property
    def triangles(self) -> int:
        """Number of its triangles."""
        return len(self.foliage) + len(self.solid)


class Shape:
    """Collects pieces of a prototype."""

    def __init__(self) -> None:
        self._pieces: list[tuple[Array, Array, Array]] = []
        self._faces: dict[bool, list[NDArray[np.int64]]] = {True: [], False: []}
        self._count = 0

    def add(
        self,
        vertices: Array,
        normals: Array,
        colors: Array,
        faces: NDArray[np.int64],
        *,
        thin: bool = True,
    ) -> None:
        """Add a piece.

        Args:
            vertices: (..., 3) [m].
            normals: of the same shape, of any length.
            colors: of a shape that broadcasts to it.
            faces: (..., 3) numbers of its vertices.
            thin: whether light shines through.
        """
        flat = vertices.reshape(-1, 3)
        colored = np.broadcast_to(colors, vertices.shape).reshape(-1, 3)
        self._pieces.append((flat, unit(normals.reshape(-1, 3)), colored))
        self._faces[thin].append(faces.reshape(-1, 3) + self._count)
        self._count += len(flat)

    def prototype(self) -> Prototype:
        """Return all pieces."""
        columns = [np.concatenate(column) for column in zip(*self._pieces, strict=True)]
        vertices, normals, colors = (column.astype(np.float32) for column in columns)
        foliage, solid = (
            np.concatenate([np.zeros((0, 3), np.int64), *self._faces[thin]]).astype(np.uint32)
            for thin in (True, False)
        )
        return Prototype(vertices, normals, np.clip(colors, 0.002, 0.9), foliage, solid)


def unit(vectors: Array) -> Array:
    """Return vectors (..., 3) at unit length."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-12))


def random_directions(rng: np.random.Generator, count: int) -> Array:
    """Return unit vectors (count, 3), evenly over the sphere."""
    return unit(rng.normal(size=(count, 3)))


def across(directions: Array) -> tuple[Array, Array]:
    """Return two unit vectors (..., 3) each, at right angles to directions and to each other."""
    aside = unit(np.cross(directions, np.array([0.31, 0.12, 0.94])))
    return aside, np.cross(directions, aside)


def outward(directions: Array, sides: int) -> Array:
    """Return unit vectors (..., sides, 3) around directions (..., 3)."""
    angle = 2.0 * np.pi * np.arange(sides)[:, None] / sides
    u, w = (part[..., None, :] for part in across(directions))
    return np.asarray(np.cos(angle) * u + np.sin(angle) * w)


def band_faces(sides: int) -> NDArray[np.int64]:
    """Return the triangles (2 * sides, 3) between a ring of vertices and the one after it."""
    j = np.arange(sides)
    q = (j + 1) % sides
    return np.stack([j, q, q + sides, j, q + sides, j + sides], axis=-1).reshape(-1, 3)


def mixed(first: Array | Color, second: Array | Color, share: Array) -> Array:
    """Return colours (..., 3) between two, by shares (...) of the second."""
    a, b = np.asarray(first, float), np.asarray(second, float)
    return np.asarray(a + (b - a) * np.asarray(share)[..., None])


def add_blades(
    shape: Shape,
    rng: np.random.Generator,
    roots: Array,
    heights: Array,
    leans: Array,
    widths: Array,
    colors: tuple[Color, Color],
    *,
    segments: int = 2,
    headings: Array | None = None,
    variation: float = 0.25,
    dry: tuple[float, Color] = (0.0, (0.3, 0.25, 0.1)),
    blunt: float = 0.0,
    wave: float = 0.0,
) -> Array:
    """Add N blades of grass that bend over, and return their tips (N, 3).

    Args:
        shape: to which they are added.
        rng: of their directions and colours.
        roots: (N, 3) [m].
        heights: (N,) [m].
        leans: (N,) by how much tips hang over [m].
        widths: (N,) at the root [m].
        colors: linear, of root and tip.
        segments: of each blade, of two triangles each, the last of one.
        headings: (N,) to which they bend [rad]; at random by default.
        variation: of their lightness.
        dry: share of dry blades, and the colour of their tips.
        blunt: width of the tip relative to that of the root.
        wave: by how much they wind sidewards, relative to their heights.
    """
    n = len(roots)
    heading = rng.uniform(0.0, 2.0 * np.pi, n) if headings is None else headings
    ahead = np.stack([np.cos(heading), np.zeros(n), np.sin(heading)], axis=-1)
    # Blades are twisted a little against the way that they bend.
    turn = heading + rng.normal(0.0, 0.5, n)
    side = np.stack([-np.sin(turn), np.zeros(n), np.cos(turn)], axis=-1)
    t = np.arange(segments + 1) / segments
    # The more a blade hangs over, the more its tip bows.
    bow = np.clip(0.1 + 0.3 * leans / np.maximum(heights, 1e-6), 0.1, 0.5)[:, None]
    rise = heights[:, None] * (t[None] - bow * t**2)
    middle = roots[:, None] + rise[..., None] * UP
    middle = middle + (leans[:, None] * t**2)[..., None] * ahead[:, None]
    if wave:
        phase = rng.uniform(0.0, 2.0 * np.pi, n)[:, None]
        aside = wave * heights[:, None] * t * np.sin(phase + 5.5 * t)
        middle = middle + aside[..., None] * side[:, None]
    half = 0.5 * widths[:, None] * ((1.0 - t) ** TAPER * (1.0 - blunt) + blunt)[None]
    left, right = (middle + sign * half[..., None] * side[:, None] for sign in (-1.0, 1.0))
    color = mixed(*colors, t[None].repeat(n, 0))
    is_dry = rng.uniform(size=n) < dry[0]
    dead = mixed(np.asarray(dry[1]) * 0.45, dry[1], t[None].repeat(n, 0))
    color = np.where(is_dry[:, None, None], dead, color)
    color = color * (1.0 + variation * rng.uniform(-1.0, 1.0, n))[:, None, None]
    normal = 0.6 * UP - 0.55 * ahead[:, None] * np.ones_like(t)[None, :, None]
    last = segments if blunt == 0.0 else segments + 1
    rows = np.stack([left[:, :last], right[:, :last]], axis=2).reshape(n, -1, 3)
    shades = np.repeat(color[:, :last], 2, axis=1)
    leaning = np.repeat(normal[:, :last], 2, axis=1) + np.tile(
        np.stack([-0.3 * side, 0.3 * side], axis=1), (1, last, 1)
    )
    if blunt == 0.0:
        rows = np.concatenate([rows, middle[:, -1:]], axis=1)
        shades = np.concatenate([shades, color[:, -1:]], axis=1)
        leaning = np.concatenate([leaning, normal[:, -1:]], axis=1)
    k = np.arange(last - 1)[:, None] * 2
    quads = np.concatenate([k + np.array([0, 1, 3]), k + np.array([0, 3, 2])])
    if blunt == 0.0:
        tip = 2 * (segments - 1)
        quads = np.concatenate([quads, [[tip, tip + 1, tip + 2]]])
    faces = quads[None] + (np.arange(n) * rows.shape[1])[:, None, None]
    shape.add(rows, leaning, shades, faces)
    return np.asarray(middle[:, -1])


EGG_LEAF = np.array(
    [
        (0.0, 0.0, -0.10), (0.34, -1.0, 0.07), (0.34, 1.0, 0.07),
        (0.74, -0.62, 0.02), (0.74, 0.62, 0.02), (1.0, 0.0, -0.24),
    ]
)  # fmt: skip
"""Corners of an egg-shaped leaf: along it in its length, aside in half its width, and up in its
length."""

HEART = 10
"""Triangles of a heart-shaped leaf."""

HEART_LEAF = np.array(
    [
        (0.0, 0.0, 0.0), (0.30, -0.62, 0.05), (0.32, 0.0, -0.05), (0.30, 0.62, 0.05),
        (0.68, -1.0, 0.03), (0.64, 0.0, -0.06), (0.68, 1.0, 0.03),
        (0.98, -0.56, -0.06), (0.90, 0.0, -0.08), (0.98, 0.56, -0.06),
    ]
)  # fmt: skip
"""The same of a leaflet of clover, which is notched at its tip."""

HEART_LIGHT = np.array([0.70, 0.95, 0.85, 0.95, 1.20, 1.75, 1.20, 0.85, 0.80, 0.85])
"""Brightness of its corners: a pale chevron crosses it."""

HEART_FACES = np.array(
    [
        [0, 2, 1], [0, 3, 2], [1, 2, 5], [1, 5, 4], [2, 3, 6],
        [2, 6, 5], [4, 5, 8], [4, 8, 7], [5, 6, 9], [5, 9, 8],
    ]
)  # fmt: skip


def _laid(
    outline: Array, bases: Array, axes: Array, face: Array, half: Array, lengths: Array
) -> Array:
    """Return the corners (N, K, 3) of leaves of an outline (K, 3); see `add_leaves`."""
    along, aside, up = (outline[:, k, None] for k in range(3))
    long = lengths[:, None, None]
    return np.asarray(
        bases[:, None]
        + along * long * axes[:, None]
        + aside * half[:, None]
        + up * long * face[:, None]
    )


def add_leaves(
    shape: Shape,
    bases: Array,
    axes: Array,
    faces_to: Array,
    lengths: Array,
    widths: Array,
    colors: Array,
    normals: Array | None = None,
    fold: float = 0.18,
    triangles: int = 2,
) -> None:
    """Add N leaves: hearts of ten triangles, bent ones of four, folded ones of two, or of one.

    Args:
        shape: to which they are added.
        bases: (N, 3) where they are attached [m].
        axes: (N, 3) from there to their tips.
        faces_to: (N, 3) about the direction of their upper sides.
        lengths: (N,) [m].
        widths: (N,) [m].
        colors: (N, 3) linear.
        normals: (N, 3) to shade with; across the leaf by default.
        fold: depth of the fold relative to the width.
        triangles: of each leaf, 10, 4, 2 or 1.
    """
    axes = unit(axes)
    side = unit(np.cross(axes, faces_to) + 1e-6)
    face = np.cross(side, axes)
    half = 0.5 * widths[:, None] * side
    shade = face if normals is None else normals
    if triangles == HEART:
        corners = _laid(HEART_LEAF, bases, axes, face, half, lengths)
        tilts, light, numbers = 0.35 * HEART_LEAF[:, 1], HEART_LIGHT, HEART_FACES
    elif triangles == 4:
        # Widest below the middle; the tip bends down.
        corners = _laid(EGG_LEAF, bases, axes, face, half, lengths)
        tilts, light = 0.3 * EGG_LEAF[:, 1], 0.88 + 0.2 * EGG_LEAF[:, 0]
        numbers = np.array([[0, 2, 1], [1, 2, 4], [1, 4, 3], [3, 4, 5]])
    else:
        middle = bases + 0.45 * lengths[:, None] * axes + fold * widths[:, None] * face
        tip = bases + lengths[:, None] * axes
        corners = np.stack([bases, middle - half, tip, middle + half], axis=1)
        tilts, light = np.array([0.0, -0.25, 0.0, 0.25]), np.array([0.9, 1.0, 1.08, 1.0])
        numbers = np.array([[0, 3, 2], [0, 2, 1]])
    bent = shade[:, None] + tilts[:, None] * side[:, None]
    shades = colors[:, None] * light[:, None]
    if triangles == 1:
        corners, bent, shades = corners[:, 1:], bent[:, 1:], shades[:, 1:]
        numbers = np.array([[0, 2, 1]])
    faces = numbers[None] + corners.shape[1] * np.arange(len(bases))[:, None, None]
    shape.add(corners, bent, shades, faces)


def add_tubes(
    shape: Shape,
    starts: Array,
    ends: Array,
    start_radii: Array,
    end_radii: Array,
    colors: Array,
    sides: int,
    ways: tuple[Array, Array] | None = None,
) -> None:
    """Add N tubes without ends.

    Args:
        shape: to which they are added.
        starts: (N, 3) [m].
        ends: (N, 3) [m].
        start_radii: (N,) [m].
        end_radii: (N,) [m].
        colors: (N, 3) linear, or (N, 2, 3) of both ends.
        sides: of each tube.
        ways: directions (N, 3) of the rings at both ends; along the tubes by default.
    """
    along = unit(ends - starts)
    first, second = ways or (along, along)
    rings, normals = [], []
    for at, radius, way in ((starts, start_radii, first), (ends, end_radii, second)):
        out = outward(way, sides)
        rings.append(at[:, None] + radius[:, None, None] * out)
        normals.append(out)
    faces = band_faces(sides)[None] + (2 * sides * np.arange(len(starts)))[:, None, None]
    shape.add(
        np.concatenate(rings, axis=1),
        np.concatenate(normals, axis=1),
        colors[:, None] if colors.ndim == 2 else np.repeat(colors, sides, axis=1),
        faces,
        thin=False,
    )


def turned_rings(radius: Array, height: Array, around: Array) -> Array:
    """Return rings (R, S, 3) about the vertical, of radii and heights (R, S or 1) [m].

    Args:
        radius: of the rings.
        height: of the rings.
        around: (S,) angles from X to Z [rad].
    """
    radius, height, around = np.broadcast_arrays(radius, height, around)
    return np.stack([radius * np.cos(around), height, radius * np.sin(around)], axis=-1)


def add_rings(
    shape: Shape, places: Array, colors: Array, *, upward: bool = False, thin: bool = False
) -> None:
    """Add rings as one smooth surface.

    Args:
        shape: to which it is added.
        places: (R, S, 3) of R rings that go around the vertical from X to Z [m].
        colors: linear, of a shape that broadcasts to it.
        upward: whether it faces up where radii increase, else outward where heights increase.
        thin: whether light shines through.
    """
    rings, sides, _ = places.shape
    along = np.gradient(places, axis=0)
    about = np.roll(places, -1, axis=1) - np.roll(places, 1, axis=1)
    normals = np.cross(about, along) if upward else np.cross(along, about)
    faces = band_faces(sides)[None] + sides * np.arange(rings - 1)[:, None, None]
    if not upward:
        faces = faces[..., ::-1]
    shape.add(places, normals, colors, faces, thin=thin)
