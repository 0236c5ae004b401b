"""Ground mesh: the terrain, and a far field around it to the horizon.

The far field consists of widening rings that start at the vertices of the terrain's edge, so that
neither a seam nor the end of the world is visible. Forbidden zones can be hatched, cell by cell.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TerrainRecord
from pipeline.simulation.terrain.heightfield import surface_of_vertices
from render.footprints import FootprintRaster
from render.shot import Mesh

RINGS = 26
"""Number of rings between the terrain's edge and the horizon."""

GROWTH = 1.32
"""How much wider each ring is than the one before."""


def ground_meshes(
    terrain: TerrainRecord, show_forbidden: bool = False, footprints: FootprintRaster | None = None
) -> tuple[Mesh, ...]:
    """Return the terrain and its far field, with texture coordinates in metres.

    Args:
        terrain: near field.
        show_forbidden: whether its forbidden zones are hatched.
        footprints: in it, over the whole film.
    """
    near = Mesh(
        name="terrain",
        vertices=terrain.vertices.astype(np.float32),
        faces=terrain.faces,
        material=terrain.material,
        uv=terrain.vertices[:, [0, 2]].astype(np.float32),
        warned=_forbidden_faces(terrain) if show_forbidden else None,
        footprints=footprints,
    )
    vertices, faces = _far_field(terrain)
    far = Mesh(
        name="horizon",
        vertices=vertices.astype(np.float32),
        faces=faces,
        material=terrain.material,
        uv=vertices[:, [0, 2]].astype(np.float32),
    )
    return near, far


def _forbidden_faces(terrain: TerrainRecord) -> NDArray[np.bool_]:
    """Return which faces lie in forbidden zones; the faces of a cell are contiguous."""
    forbidden = terrain.forbidden.ravel()
    return np.repeat(forbidden, len(terrain.faces) // len(forbidden))


def _far_field(terrain: TerrainRecord) -> tuple[Array, NDArray[np.uint32]]:
    """Return rings of vertices around the terrain and the triangles between them.

    Hills continue beyond the edge: a vertex takes the height of the terrain mirrored at its edge,
    smoother and flatter with the distance.
    """
    n_x, n_z = terrain.cells
    field = surface_of_vertices(terrain.vertices, terrain.cells)
    grid = terrain.vertices[: field.heights.size].reshape(n_z + 1, n_x + 1, 3)
    loop = _border(n_x, n_z)
    edge = grid[loop[:, 1], loop[:, 0]]
    # Rings are centred on the grid, along its axes.
    rim = np.stack(field.to_grid(edge[:, 0], edge[:, 2]), axis=-1)
    half = np.array(field.size) / 2
    middle = float(grid[..., 1].mean())
    cell = float((half * 2).min() / max(n_x, n_z))
    rings, width, out = [edge], cell * 2.0, 0.0
    for _ in range(RINGS):
        out += width
        width *= GROWTH
        # Each ring is the scaled border of the grid.
        xz = rim * (1.0 + out / half)
        calm = float(np.exp(-out / (1.2 * half.min())))
        height = middle + calm * (_mirrored_height(grid, half, xz) - middle)
        height = _smoothed(height, out / cell)
        x, z = field.to_world(xz[:, 0], xz[:, 1])
        rings.append(np.stack([x, height, z], axis=-1))
    n = len(edge)
    a = np.arange(RINGS)[:, None] * n + np.arange(n)
    b = np.arange(RINGS)[:, None] * n + (np.arange(n) + 1) % n
    quads = np.stack([a, b, b + n, a, b + n, a + n], axis=-1)
    return np.concatenate(rings), quads.reshape(-1, 3).astype(np.uint32)


def _border(n_x: int, n_z: int) -> NDArray[np.int64]:
    """Return the grid's border as (i, j), in the order in which faces point upward."""
    i, j = np.arange(n_x + 1), np.arange(n_z + 1)
    sides = [
        np.stack([i[:-1], np.zeros_like(i[:-1])], axis=-1),
        np.stack([np.full_like(j[:-1], n_x), j[:-1]], axis=-1),
        np.stack([i[:0:-1], np.full_like(i[1:], n_z)], axis=-1),
        np.stack([np.zeros_like(j[1:]), j[:0:-1]], axis=-1),
    ]
    return np.concatenate(sides)


def _mirrored_height(grid: Array, half: Array, xz: Array) -> Array:
    """Return the heights at `xz` of the terrain mirrored repeatedly at its edges."""
    n_z, n_x = grid.shape[0] - 1, grid.shape[1] - 1
    cells = np.array([n_x, n_z])
    place = (xz / half + 1.0) * 0.5 * cells
    period = 2 * cells
    place = np.abs(np.mod(place + period, period))
    place = np.where(place > cells, period - place, place)
    index = np.rint(place).astype(np.int64)
    return grid[index[:, 1], index[:, 0], 1]


def _smoothed(values: Array, width: float) -> Array:
    """Return periodic `values` filtered by a gaussian of about `width` neighbours."""
    n = len(values)
    k = np.fft.rfftfreq(n)
    return np.fft.irfft(np.fft.rfft(values) * np.exp(-0.5 * (k * width) ** 2), n)
