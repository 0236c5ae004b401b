"""Pelts: the hair or the feathers on one part of an animal.

Hair is drawn as ribbons that face the camera, each of which stands for a few hairs, and feathers as
folded vanes that lie on the skin. Roots are fixed to the part's mesh for the whole film, and tips
move as its vertices do, so that a coat neither swims nor flickers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, cross, normalized
from pipeline.simulation.take import Mesh as TakeMesh
from render.color import linear
from render.config import Material
from render.shot import Mesh
from render.vertex_normals import vertex_normals

COVER = 2.8
"""Hair over a point of the skin, one above the other."""

WIDTH = 0.021
"""Width of a ribbon of hair, in its length, where pixels are smaller."""

PIXELS = 0.85
"""Least width of a ribbon, in pixels: thinner ones would sparkle."""

LEAST_PIXELS = 1.5
"""Length of a coat in the frame, in pixels, below which its paint shows all there is."""

VANE_WIDTH = 0.24
"""Width of a feather, in its length."""

VANE_COVER = 5.0
"""Feathers over a point of the skin."""

CLUMP = 0.22
"""Distance of the tips that hairs draw together to, in the length of the coat."""

CLUMPING = 0.32
"""How much tips draw together."""

MERGING = 0.75
"""Power of the width of a ribbon, in its least one, by which it strays less."""

SPREAD, VANE_SPREAD = 0.12, 0.20
"""Deviation of hair and feathers from their lay to the side and from the skin, in their length."""

BOW = 0.13
"""Height of the bow of a hair over its chord, in its length."""

SUNK = 0.04
"""Depth of roots below the skin, in the length of the hair."""

LIFT, MERGED_LIFT = 1.5, 3.0
"""Height above the skin at which shadow rays of strands start, in that of their tips, and how much
higher it is where strands are not told apart: shade of one on another would be spots."""

UNDERCOAT = 0.8
"""Brightness of skin below a coat, in that of its colour: gaps between strands would be specks."""

SIDE_TURN = 0.45
"""How far normals turn to the side at the edges of a ribbon, which looks round by it."""

SHADES = (0.76, 1.13, 1.28)
"""Factors on the colour at root, middle and tip: little light reaches the roots."""

SCATTERED = 0.9
"""Power of the colour: light that goes from hair to hair, which is not traced, makes it paler."""

BLEACHED = (0.0, 0.0, 0.012)
"""Grey that is added at root, middle and tip: tips are sun-bleached."""

TINT, VANE_TINT = 0.10, 0.28
"""Deviation of the brightness of single hairs and feathers."""

LEAST_DENSE = 0.8
"""Density of the strands where hair is long, in the mean: fewer would show the skin."""

FEWEST_WIDTHS, FINE_WIDTHS = 3.0, 12.0
"""Length of hair in its least width below which single strands are not told apart, and from which
on they are: a coat of strands as long as a few pixels would look like a carpet."""

RESOLVED = 0.9, 2.6
"""Widths of a strand in pixels between which its roundness comes to be seen: samples of one that
is as narrow as a pixel are light or dark by chance."""

LEAST_SHOWN = 0.35
"""Share of the shades of a strand that is left where it is so narrow."""

LEAST_RELIEF = 0.2
"""Share of the shades of a strand that is left where it is not told apart."""

FLATTENED, WIDENED, LEAST_BOW = 0.95, 4.0, 0.2
"""How much flatter such strands lie, how much wider they are, and the share that is left of their
bow: shade between them, and the skin below, would be dots as wide as a pixel."""

TUFT, TUFT_TINT, TUFT_ASTRAY = 3.5, 0.07, 0.20
"""Size of tufts in the length of the hair there, deviation of their brightness, and of their lay to
the side."""

RIBBON = np.array([[0, 1, 3], [0, 3, 2], [2, 3, 4]])
"""Faces of a ribbon: two vertices at its root, two in its middle, one at its tip."""

VANE = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2], [2, 6, 3], [4, 5, 2], [2, 5, 6]])
"""Faces of a vane: the root, three across its middle, and two beside its tip."""


@dataclass(frozen=True, eq=False)
class Pelt:
    """The strands of one part: N hairs or feathers of M vertices each.

    Attributes:
        name: of its mesh.
        owner: name of the performer.
        material: of its strands.
        corners: (N, 3) vertices of the part around each root.
        shares: (N, 3) of these corners at the root.
        grown: (N,) factor on the length.
        astray: (N, 2) from the lay to the side and away from the skin, in the length.
        clumps: (N,) number of the clump of each.
        clumping: (N,) share of the way to the middle of the clump's tips.
        width: least width of a strand [m].
        vanes: whether they are feathers.
        relief: share of the roundness of a strand that shows, 0 to 1.
        colors: (N, M, 3) linear.
        faces: (F, 3) of all strands.
    """

    name: str
    owner: str
    material: str
    corners: NDArray[np.int64]
    shares: Array
    grown: Array
    astray: Array
    clumps: NDArray[np.int64]
    clumping: Array
    width: float
    vanes: bool
    relief: float
    colors: NDArray[np.float32]
    faces: NDArray[np.uint32]

    def at(
        self,
        skin: NDArray[np.float32],
        tips: NDArray[np.float32],
        faces: NDArray[np.uint32],
        eye: Array,
        pixel: float,
        alive: bool,
    ) -> Mesh:
        """Return the strands at a moment.

        Args:
            skin: (V, 3) vertices of the part [m].
            tips: (V, 3) of the hair that grows at them [m].
            faces: (F, 3) of the part.
            eye: (3,) where the camera is [m].
            pixel: size of a pixel a metre before the camera [m].
            alive: whether it is to be seen.
        """
        vertices, hair = skin.astype(float), (tips - skin).astype(float)
        normals = vertex_normals(skin, faces).astype(float)
        root, lie, n = (self._interpolated(values) for values in (vertices, hair, normals))
        n = normalized(n)
        flatter = 0.0 if self.vanes else FLATTENED * (1.0 - self.relief) ** 2
        lie -= flatter * (lie * n).sum(axis=-1, keepdims=True) * n
        length = np.linalg.norm(lie, axis=-1, keepdims=True)
        side = normalized(cross(lie, n))
        way = lie / np.maximum(length, 1e-9) + self.astray[:, :1] * side + self.astray[:, 1:] * n
        length = length * self.grown[:, None]
        tip = root + length * normalized(way)
        tip += self.clumping[:, None] * (self._clump_means(tip) - tip)
        root = root - SUNK * length * n
        away = np.linalg.norm(root - eye, axis=-1)
        if self.vanes:
            placed, bent = _vanes(root, tip, n, length)
        else:
            width = np.maximum(self.width, PIXELS * pixel * away)
            width *= 1.0 + WIDENED * (1.0 - self.relief)
            placed, bent = _ribbons(root, tip, n, length, eye, width, self.relief)
        # Single strands that the others leave in the light would be specks.
        above = np.maximum((lie * n).sum(axis=-1, keepdims=True), 0.0) + BOW * length
        far = LIFT + MERGED_LIFT * (1.0 - self.relief)
        lift = 0.0 if self.vanes else (far * above)[:, None]
        if not alive:
            # Hidden by collapsing, because the topology of a build is constant.
            placed = np.zeros_like(placed)
        return Mesh(
            *(self.name, placed.reshape(-1, 3).astype(np.float32), self.faces, self.material),
            colors=self.colors.reshape(-1, 3),
            normals=((1.0 + lift) * normalized(bent)).reshape(-1, 3).astype(np.float32),
            owner=self.owner,
        )

    def _interpolated(self, values: Array) -> Array:
        """Return values (N, 3) at the roots, of those at the vertices."""
        result: Array = (values[self.corners] * self.shares[..., None]).sum(axis=1)
        return result

    def _clump_means(self, tips: Array) -> Array:
        """Return the middle (N, 3) of the tips of the clump of each strand."""
        count = np.bincount(self.clumps)
        sums = np.stack([np.bincount(self.clumps, tips[:, k]) for k in range(3)], axis=-1)
        return (sums / np.maximum(count, 1)[:, None])[self.clumps]


def _ribbons(
    root: Array, tip: Array, n: Array, length: Array, eye: Array, width: Array, relief: float
) -> tuple[Array, Array]:
    """Return vertices and normals (N, 5, 3) of ribbons that face the camera."""
    side = normalized(cross(tip - root, eye - root))
    half = 0.5 * width[:, None] * side
    middle = 0.5 * (root + tip) + max(relief, LEAST_BOW) * BOW * length * n
    placed = np.stack([root - half, root + half, middle - 0.8 * half, middle + 0.8 * half, tip], 1)
    turn = relief * SIDE_TURN * side
    return placed, np.stack([n - turn, n + turn, n - turn, n + turn, n], 1)


def _vanes(root: Array, tip: Array, n: Array, length: Array) -> tuple[Array, Array]:
    """Return vertices and normals (N, 7, 3) of vanes that lie on the skin, folded at the shaft."""
    side = normalized(cross(tip - root, n))
    half = 0.5 * VANE_WIDTH * length * side
    shaft = root + 0.45 * (tip - root) + BOW * length * n
    drop = 0.25 * VANE_WIDTH * length * n
    end = root + 0.85 * (tip - root) + 0.6 * BOW * length * n
    placed = np.stack(
        [
            *(root, shaft - half - drop, shaft, shaft + half - drop),
            *(end - 0.8 * half - drop, tip, end + 0.8 * half - drop),
        ],
        axis=1,
    )
    turn = 0.6 * side
    bent = np.stack([n, n - turn, n, n + turn, n - turn, n, n + turn], axis=1)
    return placed, bent


def strand_count(mesh: TakeMesh, pixel: float, vanes: bool) -> tuple[int, float]:
    """Return how many strands cover a part of a take, and the least width of one [m].

    Args:
        mesh: with hair.
        pixel: least size of a pixel on it over the film [m].
        vanes: whether the strands are feathers.
    """
    area, length = _areas_and_lengths(mesh)
    total = float(area[length > 0.0].sum())
    mean = float((area * length).sum()) / max(total, 1e-12)
    if total == 0.0 or mean < LEAST_PIXELS * pixel:
        return 0, 0.0
    width = VANE_WIDTH * mean if vanes else max(WIDTH * mean, PIXELS * pixel)
    cover = VANE_COVER if vanes else COVER
    return int(cover * total / (0.75 * width * mean)) + 1, width


def _areas_and_lengths(mesh: TakeMesh) -> tuple[Array, Array]:
    """Return the area of each face [m²] and the length of the hair on it [m], (F,) each."""
    corners = mesh.vertices[mesh.faces.astype(int)].astype(float)
    area = 0.5 * np.linalg.norm(
        cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1
    )
    length = np.linalg.norm(mesh.hair.astype(float), axis=-1)
    return area, length[mesh.faces.astype(int)].mean(axis=1)


def grown_pelt(
    mesh: TakeMesh,
    material: Material,
    count: int,
    width: float,
    pixel: float,
    seed: tuple[int, ...],
    names: tuple[str, str, str],
) -> Pelt:
    """Return `count` strands on a part.

    Args:
        mesh: with hair.
        material: of the part.
        count: of the strands.
        width: least width of one [m].
        pixel: least size of a pixel on the part over the film [m].
        seed: of the part.
        names: of the strands' mesh, of the performer, and of the strands' material.
    """
    vanes = material.texture == "plumage"
    draw = np.random.default_rng(seed)
    area, length = _areas_and_lengths(mesh)
    # Where hair is short more of it covers the same skin.
    mean = float((area * length).sum()) / float(area[length > 0.0].sum())
    dense = np.clip(mean / np.maximum(length, 1e-9), LEAST_DENSE, 2.5)
    weight = area * np.where(length > 0.0, dense, 0.0)
    face = np.sort(draw.choice(len(area), count, p=weight / weight.sum()))
    u, v = np.sqrt(draw.random(count)), draw.random(count)
    shares = np.stack([1.0 - u, u * (1.0 - v), u * v], axis=-1)
    corners = mesh.faces[face].astype(np.int64)
    rest = (mesh.vertices[corners] * shares[..., None]).sum(axis=1)
    # Tips draw together within cells of a jittered lattice, wider where the hair is longer.
    own = np.linalg.norm((mesh.hair[corners] * shares[..., None]).sum(axis=1), axis=-1)
    scale = np.round(np.log2(np.clip(own / mean, 0.25, 8.0))).astype(np.int64)
    step = CLUMP * mean * 2.0 ** scale[:, None]
    clumps = _cells(rest / step, scale, draw)
    tufts = _cells(rest / (TUFT / CLUMP * step), scale, draw)
    each = draw.normal(size=(int(tufts.max()) + 1, 2)).clip(-2.0, 2.0)[tufts]
    astray = (VANE_SPREAD if vanes else SPREAD) * np.clip(draw.normal(size=(count, 2)), -2.0, 2.0)
    grown = draw.uniform(0.5 if vanes else 0.7, 1.2, count)
    # A ribbon stands for the more hairs the wider it is, and their mean strays less.
    merged = 1.0 if vanes else min(1.0, WIDTH * mean / width) ** MERGING
    astray *= merged
    clumping = CLUMPING * draw.uniform(0.1, 1.0, count) * (0.0 if vanes else 1.0)
    relief = 1.0 if vanes else min(_relief(mean / width), _shown(width / pixel))
    tint = (VANE_TINT if vanes else TINT * relief) * np.clip(draw.normal(size=count), -2.0, 2.0)
    if not vanes:
        # Tufts of a coat whose strands are not told apart would be flecks.
        tint += relief * TUFT_TINT * each[:, 0]
        astray[:, 0] += relief * TUFT_ASTRAY * each[:, 1]
        astray[:, 1] *= relief
    places = list((0, 1, 1, 1, 2, 2, 2) if vanes else (0, 0, 1, 1, 2))
    shades = np.mean(SHADES) + relief * (np.array(SHADES) - np.mean(SHADES))
    base = skin_colors(mesh, material, corners, shares)
    colors = base[:, None] ** SCATTERED * np.exp(tint)[:, None, None] * shades[places, None]
    colors = colors + np.array(BLEACHED)[places, None]
    pattern = VANE if vanes else RIBBON
    faces = pattern + (int(pattern.max()) + 1) * np.arange(count)[:, None, None]
    return Pelt(
        *names,
        corners,
        shares,
        grown,
        astray,
        clumps,
        clumping,
        width,
        vanes,
        relief,
        np.minimum(colors, 1.0).astype(np.float32),
        faces.reshape(-1, 3).astype(np.uint32),
    )


def _cells(places: Array, scale: NDArray[np.int64], draw: np.random.Generator) -> NDArray[np.int64]:
    """Return the number (N,) of the cell of a jittered lattice that holds each place (N, 3).

    Args:
        places: in the size of a cell.
        scale: (N,) of the cells; those of different scales are different.
        draw: of the jitter.
    """
    cell = np.floor(places + draw.normal(0.0, 0.22, places.shape)).astype(np.int64)
    keys = np.concatenate([cell, scale[:, None]], axis=1)
    return np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)


def _relief(slenderness: float) -> float:
    """Return the share of the shades of a strand that shows, by its length in its width."""
    share = (slenderness - FEWEST_WIDTHS) / (FINE_WIDTHS - FEWEST_WIDTHS)
    return LEAST_RELIEF + (1.0 - LEAST_RELIEF) * float(np.clip(share, 0.0, 1.0))


def _shown(pixels: float) -> float:
    """Return the share of the shades of a strand that shows, by its width in pixels."""
    share = (pixels - RESOLVED[0]) / (RESOLVED[1] - RESOLVED[0])
    return LEAST_SHOWN + (1.0 - LEAST_SHOWN) * float(np.clip(share, 0.0, 1.0))


def skin_colors(
    mesh: TakeMesh, material: Material, corners: NDArray[np.int64], shares: Array
) -> Array:
    """Return the linear colours (N, 3) of the skin at the roots."""
    result: Array = (_vertex_colors(mesh, material)[corners] * shares[..., None]).sum(axis=1)
    return result


def undercoat(mesh: TakeMesh, material: Material) -> NDArray[np.float32]:
    """Return the linear colour and its share (V, 4) of a skin, as dark as it is below a coat."""
    grows = (np.linalg.norm(mesh.hair, axis=-1) > 0.0)[:, None]
    dark = UNDERCOAT * _vertex_colors(mesh, material)
    bare = mesh.paint if len(mesh.paint) else np.zeros((len(dark), 4))
    below = np.concatenate([dark, np.ones((len(dark), 1))], axis=1)
    return np.where(grows, below, bare).astype(np.float32)


def _vertex_colors(mesh: TakeMesh, material: Material) -> Array:
    """Return the linear colours (V, 3) of a skin."""
    own = linear(material.color)
    if not len(mesh.paint):
        return np.tile(own, (len(mesh.vertices), 1))
    paint = mesh.paint.astype(float)
    result: Array = paint[:, 3:] * paint[:, :3] + (1.0 - paint[:, 3:]) * own
    return result
