"""Skinned surface: closed surfaces that follow one or two frames, from fields and from rings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.face_units import COLUMNS
from pipeline.simulation.figures.solids import loft, surface_nets
from pipeline.simulation.people.body_frames import FRAMES
from pipeline.simulation.people.signed_distance import Field
from pipeline.simulation.spatial import Array, cross, normalized

FILLED_DEPTH = 1e-9  # of a filled sample [m]

cached_part = lru_cache(maxsize=256)
"""Cache for parts that many persons share."""

MIRROR = np.array([1.0, 1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed surface.

    Attributes:
        vertices: (V, 3) at rest [m].
        faces: (F, 3), counter-clockwise from outside.
    """

    vertices: Array
    faces: NDArray[np.uint32]

    def mirrored(self) -> Surface:
        """Return the surface mirrored to the other side of the body."""
        return Surface(self.vertices * MIRROR, self.faces[:, ::-1])

    def follow(
        self, frame: str, other: str | None = None, share: Array | None = None
    ) -> SkinnedPatch:
        """Return the surface as a patch that follows one frame, or two.

        Args:
            frame: the first.
            other: the second.
            share: (V,) of the second, from 0 to 1.
        """
        count = len(self.vertices)
        part = np.zeros(count) if share is None else np.clip(share, 0.0, 1.0)
        first = np.full(count, FRAMES.index(frame))
        second = np.full(count, FRAMES.index(other or frame))
        return SkinnedPatch(self.vertices, self.faces, np.stack([first, second], axis=-1), part)


@dataclass(frozen=True, eq=False)
class SkinnedPatch:
    """A surface that follows one frame or two.

    Attributes:
        vertices: (V, 3) at rest [m].
        faces: (F, 3), counter-clockwise from outside.
        frames: (V, 2) numbers in `FRAMES`.
        share: (V,) of the second frame; the first has the rest.
        targets: (n, 2) vertex, and the unit of the face or of a hand that moves it.
        offsets: (n, 3) by which it moves at the unit's full action [m].
        tint: (V, 2) number of another colour than the material's, and its share; (0, 2) for none.
        shade: (V,) factor on the colour, less than 1 in folds and hollows; (0,) for none.
        crease: (V, 3) by which vertices move where their frames are bent by a right angle [m];
            (0, 3) for none.
        twist: (V, 3) middle direction of the limb, as long as the share of the second frame's twist
            that a vertex does not take; (0, 3) for none.
    """

    vertices: Array
    faces: NDArray[np.uint32]
    frames: NDArray[np.int64]
    share: Array
    targets: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    offsets: Array = field(default_factory=lambda: np.zeros((0, 3)))
    tint: Array = field(default_factory=lambda: np.zeros((0, 2)))
    shade: Array = field(default_factory=lambda: np.zeros(0))
    crease: Array = field(default_factory=lambda: np.zeros((0, 3)))
    twist: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def tints(self) -> Array:
        """Numbers and shares (V, 2) of other colours, with none written out."""
        return self.tint if len(self.tint) else np.zeros((len(self.vertices), 2))

    @property
    def shades(self) -> Array:
        """Factors on the colour (V,), with none written out."""
        return self.shade if len(self.shade) else np.ones(len(self.vertices))

    @property
    def creases(self) -> Array:
        """Moves of bent vertices (V, 3), with none written out [m]."""
        return self.crease if len(self.crease) else np.zeros_like(self.vertices)

    @property
    def twists(self) -> Array:
        """Middle directions (V, 3) times the shares of twist not taken, with none written out."""
        return self.twist if len(self.twist) else np.zeros_like(self.vertices)

    def mirrored(self) -> SkinnedPatch:
        """Return the patch mirrored to the other side of the body, with its frames."""
        return SkinnedPatch(
            self.vertices * MIRROR,
            self.faces[:, ::-1],
            MIRRORED_FRAMES[self.frames],
            self.share,
            np.stack([self.targets[:, 0], MIRRORED_UNITS[self.targets[:, 1]]], axis=-1),
            self.offsets * MIRROR,
            self.tint,
            self.shade,
            self.crease * MIRROR,
            self.twist * MIRROR,
        )


def _other_sides(names: Sequence[str]) -> NDArray[np.int64]:
    """Return for each name the number of the one on the other side of the body."""
    found = list[int]()
    for name in names:
        stem, _, side = name.rpartition("_")
        found.append(names.index(f"{stem}_{'lr'[side == 'l']}" if stem and side in "lr" else name))
    return np.array(found)


MIRRORED_FRAMES, MIRRORED_UNITS = _other_sides(FRAMES), _other_sides(COLUMNS)
"""For each frame, and for each unit, the one on the other side of the body."""


def merge_patches(patches: Sequence[SkinnedPatch]) -> SkinnedPatch:
    """Return several patches as one."""
    starts = np.cumsum([0, *(len(p.vertices) for p in patches)])
    faces = [p.faces + np.uint32(start) for p, start in zip(patches, starts, strict=False)]
    targets = [p.targets + np.array([start, 0]) for p, start in zip(patches, starts, strict=False)]
    return SkinnedPatch(
        np.concatenate([p.vertices for p in patches]),
        np.concatenate(faces),
        np.concatenate([p.frames for p in patches]),
        np.concatenate([p.share for p in patches]),
        np.concatenate(targets),
        np.concatenate([p.offsets for p in patches]),
        np.concatenate([p.tints for p in patches])
        if any(len(p.tint) for p in patches)
        else np.zeros((0, 2)),
        np.concatenate([p.shades for p in patches])
        if any(len(p.shade) for p in patches)
        else np.zeros(0),
        np.concatenate([p.creases for p in patches])
        if any(len(p.crease) for p in patches)
        else np.zeros((0, 3)),
        np.concatenate([p.twists for p in patches])
        if any(len(p.twist) for p in patches)
        else np.zeros((0, 3)),
    )


def with_mirror(patch: SkinnedPatch) -> SkinnedPatch:
    """Return a patch of the right side together with its mirror image."""
    return merge_patches([patch, patch.mirrored()])


def polygonise(
    field: Field,
    low: Sequence[float],
    high: Sequence[float],
    cell: float,
    stretch: float = 1.0,
    symmetric: bool = False,
    hem: float | None = None,
    fine: tuple[int, float, float] | None = None,
    seam: float | None = None,
) -> Surface:
    """Return the zero surface of a field.

    Args:
        field: positive on the border of the box.
        low: (3,) corner of the box [m].
        high: (3,) opposite corner [m].
        cell: distance of the samples [m].
        stretch: factor of the distance in height.
        symmetric: whether both sides of the body are alike, and sampled alike.
        hem: height at which the solid is cut off by an even edge, in place of the box's [m].
        fine: axis, and the place on it with the distance within which samples are twice as dense;
            on both sides of a symmetric solid [m].
        seam: height above the hem of its seam, where samples are dense [m].
    """
    if symmetric:
        field = symmetric_field(field)
    steps = cell * np.array([1.0, stretch, 1.0])
    axes = [
        _samples(*ends, symmetric and k == 2)
        for k, ends in enumerate(zip(low, high, steps, strict=True))
    ]
    if hem is not None:
        axes[1] = _hemmed_samples(hem, high[1], steps[1], seam)
    if fine is not None:
        axes[fine[0]] = _halved_steps(axes[fine[0]], *fine[1:])
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = field(grid.reshape(-1, 3)).reshape(grid.shape[:3])
    if hem is not None:
        # All below the edge is cut away.
        values[:, 0] = cell
    _fill_pinches(values)
    while symmetric and (values != values[..., ::-1]).any():
        # Of two samples in a pinch the one that is filled may differ between the sides.
        np.minimum(values, values[..., ::-1].copy(), out=values)
        _fill_pinches(values)
    vertices, faces = surface_nets(values, np.zeros(3), 1.0)
    places = np.stack(
        [np.interp(vertices[:, k], np.arange(len(axes[k])), axes[k]) for k in range(3)], axis=-1
    )
    if hem is None:
        return Surface(_project_to_surface(field, places, 0.25 * cell), faces)
    lowest = vertices[:, 1] < 1.0
    places[~lowest] = _project_to_surface(field, places[~lowest], 0.25 * cell)
    places[lowest] = _hem_edge(field, places[lowest], vertices[lowest], values, (hem, cell))
    return Surface(places, faces)


HEM_FOLD = 0.35
"""Height of the first row above an edge, in a cell: the light turns there and no higher."""


SEAM_ROWS = (0.70, 0.90, 1.10, 1.40)
"""Heights of samples about the seam of a hem, in its height: vertices lie half way between them."""


def _hemmed_samples(hem: float, top: float, step: float, seam: float | None) -> Array:
    """Return heights of samples of which the first two lie just below and above an edge [m]."""
    near = 0.01 * step
    rows = [HEM_FOLD * step + near] if seam is None else [seam * row for row in SEAM_ROWS]
    last = hem + rows[-1]
    rest = last + step * np.arange(1, int(np.ceil(max(top - last, 0.0) / step)) + 1)
    return np.array([hem - near, hem + near, *(hem + row for row in rows), *rest])


def _hem_edge(
    field: Field, places: Array, cells: Array, values: Array, edge: tuple[float, float]
) -> Array:
    """Return the lowest vertices (n, 3) of cut cloth: an even edge, hollow inside.

    Args:
        field: of the cloth, not cut.
        places: (n, 3) vertices in the lowest cells [m].
        cells: (n, 3) the same in cells.
        values: samples.
        edge: height of the edge, and size of a cell [m].
    """
    hem, cell = edge
    i, _, k = np.floor(cells).astype(int).T
    upper = np.stack([values[i + a, 1, k + b] for a in (0, 1) for b in (0, 1)])
    is_wall = (upper > 0.0).any(axis=0)
    level = np.array([1.0, 0.0, 1.0])
    found = places.copy()
    found[:, 1] = hem
    for _ in range(2):
        found[is_wall] = _project_to_surface(field, found[is_wall], 0.6 * cell, level)
    found[~is_wall, 1] += cell
    return found


def symmetric_field(field: Field) -> Field:
    """Return a field whose left equals its right to the last bit."""

    def distance(places: Array) -> Array:
        right = places.copy()
        right[:, 2] = np.abs(right[:, 2])
        return field(right)

    return distance


def angle_around(places: Array) -> Array:
    """Return the angles (n,) of places (n, 3) about the vertical from the front, 0 to pi [rad].

    They are alike on both sides.
    """
    return np.asarray(np.arctan2(np.abs(places[:, 2]), places[:, 0]))


def _fill_pinches(values: Array) -> None:
    """Fill samples where two parts of a solid would meet in an edge alone.

    Where the inside samples of a square lie diagonally, four faces would share an edge.
    """
    found = True
    while found:
        found = False
        for first, second in ((0, 1), (0, 2), (1, 2)):
            a, b, c, d = _squares(values, first, second)
            in_a, in_b, in_c, in_d = (corner < 0.0 for corner in (a, b, c, d))
            is_diagonal = (in_a == in_c) & (in_b == in_d) & (in_a != in_b)
            if not is_diagonal.any():
                continue
            # Samples are only ever filled, so the loop ends.
            found = True
            for one, other, outside in ((a, c, ~in_a), (b, d, ~in_b)):
                one[is_diagonal & outside & (one <= other)] = -FILLED_DEPTH
                other[is_diagonal & outside & (one > other)] = -FILLED_DEPTH


def _squares(values: Array, first: int, second: int) -> tuple[Array, Array, Array, Array]:
    """Return views of the four corners of all squares of a grid along two of its axes."""
    n = values.shape

    def corner(i: int, j: int) -> Array:
        take = [slice(None)] * 3
        take[first] = slice(i, n[first] - 1 + i)
        take[second] = slice(j, n[second] - 1 + j)
        return values[tuple(take)]

    return corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)


def _samples(low: float, high: float, step: float, symmetric: bool) -> Array:
    if symmetric:
        half = int(np.ceil(high / step + 0.5))
        return (np.arange(-half, half, dtype=float) + 0.5) * step
    return low + step * np.arange(int(np.ceil((high - low) / step)) + 1, dtype=float)


def _halved_steps(samples: Array, place: float, reach: float) -> Array:
    """Return samples (n,) with more half way between those that lie near a place on either side."""
    middles = 0.5 * (samples[1:] + samples[:-1])
    near = np.abs(np.abs(middles) - place) < reach
    return np.sort(np.concatenate([samples, middles[near]]))


def _project_to_surface(
    field: Field, places: Array, limit: float, ways: Array | None = None
) -> Array:
    """Return places drawn onto the zero surface of a field, by a limit at most [m].

    A net lies inside of round solids, by its cells' size; drawn out, few vertices are enough.
    `ways` (3,) is 0 along axes along which nothing moves.
    """
    step = 0.2 * limit
    for _ in range(2):
        slope = np.stack(
            [(field(places + d) - field(places - d)) / (2.0 * step) for d in step * np.eye(3)],
            axis=-1,
        )
        slope = slope if ways is None else ways * slope
        square = np.maximum((slope * slope).sum(axis=-1), 0.04)
        move = -(field(places) / square)[:, None] * slope
        length = np.sqrt((move * move).sum(axis=-1, keepdims=True))
        places = places + move * np.minimum(1.0, limit / np.maximum(length, 1e-12))
    return places


def ramp(values: Array, start: float | Array, end: float | Array) -> Array:
    """Return 0 up to `start`, 1 from `end` on, smooth between; `end` may be the lower."""
    s = np.clip((values - start) / (end - start), 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


CAP_LATITUDES = np.radians([25.0, 65.0])  # of the rings of a cap


def tube(points: Array, radii: Array, around: int) -> Surface:
    """Return the surface around a line, closed by caps.

    Args:
        points: (n, 3) of the line, not along X [m].
        radii: (n,) [m].
        around: vertices of a ring.
    """
    along = normalized(np.gradient(points, axis=0))
    x = np.array([1.0, 0.0, 0.0])
    places, sizes, directions = list(points), list(radii), list(along)
    for k, sign in ((0, -1.0), (-1, 1.0)):
        rings = [points[k] + sign * radii[k] * np.sin(a) * along[k] for a in CAP_LATITUDES]
        narrow = [radii[k] * np.cos(a) for a in CAP_LATITUDES]
        if k == 0:
            places, sizes = [*rings[::-1], *places], [*narrow[::-1], *sizes]
            directions = [along[0]] * len(CAP_LATITUDES) + directions
        else:
            places, sizes = [*places, *rings], [*sizes, *narrow]
            directions = directions + [along[-1]] * len(CAP_LATITUDES)
    y = normalized(cross(np.array(directions), np.broadcast_to(x, (len(directions), 3))))
    z = cross(np.array(directions), y)
    angle = np.arange(around) * (2.0 * np.pi / around)
    ring = np.cos(angle)[:, None] * y[:, None] + np.sin(angle)[:, None] * z[:, None]
    rings = np.array(places)[:, None] + np.array(sizes)[:, None, None] * ring
    ends = np.stack([points[0] - radii[0] * along[0], points[-1] + radii[-1] * along[-1]])
    solid = loft(rings, ends)
    return Surface(solid.vertices, solid.faces)


def ellipsoid_surface(centre: Array, radii: Array, rings: int, around: int) -> Surface:
    """Return an ellipsoid around `centre` (3,) of `radii` (3,), its poles above and below."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, rings + 2)[1:-1]
    turn = np.arange(around) * (2.0 * np.pi / around)
    ring = np.stack(
        [
            np.cos(angle)[:, None] * np.sin(turn),
            np.repeat(np.sin(angle)[:, None], around, axis=1),
            np.cos(angle)[:, None] * np.cos(turn),
        ],
        axis=-1,
    )
    poles = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    solid = loft(ring * radii + centre, poles * radii + centre)
    return Surface(solid.vertices, solid.faces)
