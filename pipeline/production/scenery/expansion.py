"""Expansion: placed things as meshes: one of foliage, one of stone and one of all else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.scenery.placement import WIDE_FROM, WIDEST, Placed
from pipeline.production.scenery.plant_bend import bent, wind_bends
from pipeline.production.scenery.prototype import Prototype
from pipeline.production.scenery.species import KINDS, prototype
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.spatial import Array
from render.config import Material
from render.shot import Mesh

FOLIAGE = Material(color=(1.0, 1.0, 1.0), roughness=1.0, translucency=0.5, sheen=0.7)
"""Of leaves and blades; their colours are those of the vertices."""

SOLID = Material(color=(1.0, 1.0, 1.0), roughness=0.95)
"""Of wood, mushrooms and the like."""

STONE = Material(
    color="#85796c",
    color2="#9c9184",
    roughness=0.9,
    texture="rock",
    texture_scale=0.8,
    bump=1.0,
    steep_deg=89.0,
)
"""Of stones; the colours of their vertices cover most of its own."""

STONE_COVER = 0.72
"""Share of the vertices' colours on stone."""

MATERIALS = {"scenery foliage": FOLIAGE, "scenery solid": SOLID, "scenery stone": STONE}

REFERENCE_GROUND = np.array([0.155, 0.150, 0.085])
"""Linear colour of ground on which species have their own colours."""

FRESH, DRY = np.array([0.86, 1.0, 0.78]), np.array([1.60, 1.25, 0.95])
"""Factors on the colours of grass in hollows that keep water, and where it has dried."""

STUNTED, LUSH = 0.65, 1.6
"""Factors on the sizes of grass where the soil is poor and where it is rich."""
RICH_WIDTH, RICH_EDGE = 2.4, (-0.55, 0.85)
"""Width of rich spots [m], and values of their noise between which they begin."""

TALLER = 0.4
"""Power of the width of far clumps by which low ones are taller."""
LOW = 0.3
"""Height of low species [m]."""

SMALL = 1.4
"""Power of the chance by which there are more small things than large ones."""

Arrays = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32], NDArray[np.uint32]]


@dataclass(frozen=True, eq=False)
class Copies:
    """N copies of one shape.

    Attributes:
        shape: that is copied.
        points: (N, 3) [m].
        turns: (N, 3, 3) rotations.
        scales: (N, 3) along the shape's own axes.
        tints: (N, 3) factors on its colours.
        bends: (N, 2) see `plant_bend` [rad].
    """

    shape: Prototype
    points: Array
    turns: Array
    scales: Array
    tints: Array
    bends: Array | None = None

    @property
    def tall(self) -> Array:
        """Heights (N,) [m]."""
        return np.asarray(self.shape.vertices[:, 1].max() * self.scales[:, 1])

    @property
    def radii(self) -> Array:
        """Radii (N,) [m]."""
        widest = np.hypot(self.shape.vertices[:, 0], self.shape.vertices[:, 2]).max()
        return np.asarray(widest * self.scales[:, 0])

    def arrays(self, *, thin: bool) -> Arrays | None:
        """Return vertices, normals, colours and faces of the foliage, or of all else."""
        faces = self.shape.foliage if thin else self.shape.solid
        if not len(faces):
            return None
        used, inverse = np.unique(faces, return_inverse=True)
        vertices = self.shape.vertices[used]
        turns = self.turns.astype(np.float32)
        moved = (vertices[None] * self.scales[:, None].astype(np.float32)) @ turns.transpose(
            0, 2, 1
        )
        if self.bends is not None:
            tall, bends = self.tall.astype(np.float32), self.bends.astype(np.float32)
            moved = bent(moved, tall[:, None], bends[:, None])
        moved += self.points[:, None].astype(np.float32)
        normals = self.shape.normals[used] @ turns.transpose(0, 2, 1)
        colors = self.shape.colors[used] * self.tints[:, None].astype(np.float32)
        numbers = inverse.reshape(1, -1, 3) + len(used) * np.arange(len(turns))[:, None, None]
        return (
            moved.reshape(-1, 3),
            normals.reshape(-1, 3).astype(np.float32),
            np.clip(colors, 0.002, 0.9).reshape(-1, 3).astype(np.float32),
            numbers.reshape(-1, 3).astype(np.uint32),
        )


def triangle_counts(placed: Placed, detail: float) -> NDArray[np.int64]:
    """Return the number of triangles of each thing (N,)."""
    levels = _levels(placed, detail)
    result = np.zeros(len(levels), np.int64)
    for level in np.unique(levels):
        result[levels == level] = prototype(placed.name, 0, int(level)).triangles
    return result


def _levels(placed: Placed, detail: float) -> NDArray[np.int64]:
    """Return the level of detail of each thing: larger ones are finer."""
    species = KINDS[placed.name]
    if species.layer != "cover":
        # What stands is fine enough in frames 1280 pixels wide: more would only take memory.
        detail = min(detail, 1.0)
    apparent = placed.distances / (detail * np.maximum(_sizes(placed), 0.3))
    if species.layer == "solid" and species.sizes[1] < 1.0:
        apparent = placed.distances / (detail * _sizes(placed) / species.sizes[1])
    return np.searchsorted(np.array(species.levels), apparent)


def size_chance(sizes: Array, span: tuple[float, float]) -> Array:
    """Return the chances (N,) of sizes (N,) of a species, inverse of `_sizes` of size 1."""
    low, high = span
    return np.asarray((np.log(sizes / low) / np.log(high / low)).clip(0.0) ** (1 / SMALL))


def _sizes(placed: Placed) -> Array:
    """Return the sizes (N,): many small, few large."""
    low, high = KINDS[placed.name].sizes
    part = placed.chance[:, 2]
    sizes = np.asarray(low * (high / low) ** (part**SMALL)) * placed.size
    # A crop stands even.
    if KINDS[placed.name].widens and KINDS[placed.name].habitat != "open":
        sizes = sizes * vigour(placed.points[:, [0, 2]])
    if KINDS[placed.name].layer == "tree":
        sizes = sizes * (1.0 - DWARFED * smoothstep(*DISTANT, placed.distances))
    return sizes


def copies(
    placed: Placed, detail: float, wind: tuple[float, float] = (0.0, 0.0)
) -> Iterator[Copies]:
    """Yield the copies of each shape of a species.

    Args:
        placed: things of the species.
        detail: 1 for frames 1280 pixels wide.
        wind: near the ground, along x and z, in which they lean [m/s].
    """
    species = KINDS[placed.name]
    sizes = _sizes(placed)
    scales = np.repeat(sizes[:, None], 3, axis=1)
    if species.widens:
        wide_from = WIDE_FROM * detail * max(1.0, placed.size)
        wide = np.clip((placed.distances / wide_from) ** 0.75, 1.0, WIDEST)
        scales[:, [0, 2]] *= wide[:, None]
        if species.height < LOW:
            # Flat ones would melt into a plain.
            scales[:, 1] *= wide**TALLER
    scales[:, 1] *= 0.85 + 0.3 * placed.chance[:, 3]
    turns = _turns(placed, species.upright)
    tints = _tints(placed, species.ground)
    bends = None
    if species.bends and any(wind):
        bends = wind_bends(placed.points[:, [0, 2]], wind)
    level = _levels(placed, detail)
    variant = (placed.chance[:, 0] * species.variants).astype(int)
    for k in range(len(species.levels) + 1):
        for v in range(species.variants):
            some = np.flatnonzero((level == k) & (variant == v))
            if len(some):
                shape = prototype(placed.name, v, k)
                yield Copies(
                    *(shape, placed.points[some], turns[some], scales[some], tints[some]),
                    None if bends is None else bends[some],
                )


DWARFED, DISTANT = 0.55, (90.0, 420.0)
"""By how much trees are smaller in the distance, and from where to where [m].

The land around a terrain is smaller than life: full-grown trees on its ridges would say so.
"""


def vigour(places: Array) -> Array:
    """Return factors (N,) on the sizes of grass at places (N, 2): tall in spots, short between."""
    rich = smoothstep(*RICH_EDGE, fractal(places / RICH_WIDTH, 8103, 3))
    return np.asarray(STUNTED + (LUSH - STUNTED) * rich)


def sward(places: Array) -> Array:
    """Return factors (N, 3) on the colours of grass at places (N, 2): fresh here, dry there."""
    value = fractal(places / 17.0, 8101, 3) + 0.55 * fractal(places / 3.1, 8102, 3)
    dry = smoothstep(-0.5, 0.75, value)[:, None]
    return np.asarray(FRESH + (DRY - FRESH) * dry)


def _turns(placed: Placed, upright: float) -> Array:
    """Return rotations (N, 3, 3) that turn things about the vertical and lay them on slopes."""
    up = placed.normals * (1.0 - upright) + np.array([0.0, upright, 0.0])
    up = up / np.linalg.norm(up, axis=-1, keepdims=True)
    angle = 2.0 * np.pi * placed.chance[:, 1]
    ahead = np.stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)], axis=-1)
    ahead = ahead - (ahead * up).sum(axis=-1, keepdims=True) * up
    ahead = ahead / np.linalg.norm(ahead, axis=-1, keepdims=True)
    return np.stack([ahead, up, np.cross(ahead, up)], axis=-1)


def _tints(placed: Placed, share: float) -> Array:
    """Return factors (N, 3) on colours: lightness at random, and a share of the ground's hue."""
    light = 0.82 + 0.36 * placed.chance[:, 3:]
    if KINDS[placed.name].widens:
        # Tufts that differ are seen as tufts; alike they melt into a plain.
        light = light * (0.7 + 0.6 * placed.chance[:, 1:2]) * sward(placed.points[:, [0, 2]])
    if not share:
        return np.broadcast_to(light, (len(light), 3))
    ratio = placed.color / REFERENCE_GROUND
    return np.asarray(light * np.clip(ratio, 0.2, 5.0) ** share)


def meshes(
    every: Sequence[Placed], detail: float, wind: tuple[float, float] = (0.0, 0.0)
) -> tuple[Mesh, ...]:
    """Return the meshes of all placed things; see `copies`."""
    pieces = [
        (copy, "scenery stone" if KINDS[placed.name].is_stone else "scenery solid")
        for placed in every
        for copy in copies(placed, detail, wind)
    ]
    return gathered_meshes(pieces)[0]


def gathered_meshes(
    every: Sequence[tuple[Copies, str]],
) -> tuple[tuple[Mesh, ...], list[NDArray[np.int64]]]:
    """Return one mesh for each material of copies, and the copies (V,) of their vertices.

    Args:
        every: copies, with the material of what is not foliage. The vertices of a mesh are
            numbered by copy, through all copies of all shapes.
    """
    pieces: dict[str, list[Arrays]] = {name: [] for name in MATERIALS}
    owners: dict[str, list[NDArray[np.int64]]] = {name: [] for name in MATERIALS}
    first = 0
    for copy, solid in every:
        count = len(copy.points)
        for name, thin in (("scenery foliage", True), (solid, False)):
            arrays = copy.arrays(thin=thin)
            if arrays is not None:
                pieces[name].append(arrays)
                each = len(arrays[0]) // count
                owners[name].append(first + np.repeat(np.arange(count), each))
        first += count
    found = [name for name, some in pieces.items() if some]
    return (
        tuple(_mesh(name, pieces[name]) for name in found),
        [np.concatenate(owners[name]) for name in found],
    )


def _mesh(name: str, pieces: list[Arrays]) -> Mesh:
    """Return the mesh of one material."""
    starts = np.cumsum([0, *(len(piece[0]) for piece in pieces)])
    numbers = [piece[3] + np.uint32(k) for piece, k in zip(pieces, starts, strict=False)]
    vertices, normals, colors = (np.concatenate([p[k] for p in pieces]) for k in range(3))
    faces = np.concatenate(numbers)
    if name != "scenery stone":
        return Mesh(name, vertices, faces, name, normals=normals, colors=colors)
    share = np.full((len(colors), 1), STONE_COVER, np.float32)
    cover = np.concatenate([colors, share], axis=1)
    flat = np.ascontiguousarray(vertices[:, [0, 2]])
    return Mesh(name, vertices, faces, name, uv=flat, normals=normals, cover=cover)
