"""Land mesh: the land around a terrain, and the walls of a floor that stands on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.production.surroundings.land import Land
from pipeline.production.surroundings.land_cover import Color, Site, canopy, cover
from pipeline.production.surroundings.rings import (
    AROUND,
    LEAST_AROUND,
    border,
    distances,
    rim_places,
    ring_faces,
    turned,
    zipped,
)
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TerrainRecord
from render.shot import Mesh

WALL_FOOT = 0.3
"""Depth to which walls go below the level of the land [m]."""


def land_mesh(
    land: Land, terrain: TerrainRecord, material: str, color: Color, detail: float = 1.0
) -> Mesh:
    """Return the land from the vertices of the terrain's edge to the horizon.

    Args:
        land: its heights.
        terrain: where it begins.
        material: of the ground near the terrain.
        color: linear mean colour of that.
        detail: factor on the number of vertices along each direction.
    """
    around = vertices_around(detail)
    numbers = border(land.field)
    edge = np.array(terrain.vertices[numbers], dtype=float)
    inner = np.stack(land.field.to_grid(edge[:, 0], edge[:, 2]), axis=-1)
    rim = rim_places(land.half, around)
    way = rim / np.hypot(*rim.T)[:, None]
    first = 0.7 * min(min(land.field.cell), 0.4)
    out = distances(first, detail)
    places = (rim + out[:, None, None] * way).reshape(-1, 2)
    height = land.height_in_grid(places)
    sea = land.sea_level
    above = height - (land.level if sea is None else sea)
    spacing = _spacing(places, around)
    steep = _steepness(spacing, height, around)
    site = Site(places, land.beyond(places), spacing, above, steep, land.seed, color)
    # Steepness and cover are those of the ground below the trees.
    height = height + canopy(site, land.kind)
    x, z = land.field.to_world(*places.T)
    if land.is_platform:
        edge[:, 1] = land.level
    vertices = np.concatenate([edge, np.stack([x, height, z], axis=-1)]).astype(np.float32)
    faces = np.concatenate(
        [
            zipped(turned(inner, land.half), turned(rim, land.half)),
            ring_faces(len(out), around, len(edge)),
        ]
    ).astype(np.uint32)
    mesh = Mesh("horizon", vertices, faces, material, uv=vertices[:, [0, 2]])
    if land.kind == "none":
        return mesh
    # The edge shows the material alone, as the terrain does.
    bare = np.zeros((len(edge), 4))
    covered = np.concatenate([bare, cover(site, land.kind)]).astype(np.float32)
    return replace(mesh, cover=covered)


def vertices_around(detail: float) -> int:
    """Return the number of vertices of a ring at a detail."""
    return max(LEAST_AROUND, round(AROUND * detail))


def _spacing(places: Array, around: int) -> Array:
    """Return the distances (N, 2) to the next vertices of rings, outward and along a ring [m]."""
    at = places.reshape(-1, around, 2)
    ways = [np.roll(at, -1, axis) - np.roll(at, 1, axis) for axis in (0, 1)]
    # The first ring has none inside, the last one none outside.
    ways[0][0], ways[0][-1] = ways[0][1], ways[0][-2]
    return np.stack([np.hypot(*np.moveaxis(way, -1, 0)).ravel() / 2.0 for way in ways], axis=-1)


def _steepness(spacing: Array, height: Array, around: int) -> Array:
    """Return the rise per metre (N,) at the vertices of rings."""
    h = height.reshape(-1, around)
    rises = [(np.roll(h, -1, axis) - np.roll(h, 1, axis)) / 2.0 for axis in (0, 1)]
    rises[0][[0, -1]] = 0.0
    return np.hypot(*(np.stack(rises, -1).reshape(-1, 2) / np.maximum(spacing, 1e-6)).T)


def wall_mesh(land: Land, terrain: TerrainRecord) -> Mesh | None:
    """Return the walls from the edge of a floor down to the land, None without a platform."""
    if not land.is_platform:
        return None
    top = terrain.vertices[border(land.field)].astype(np.float32)
    foot = top.copy()
    foot[:, 1] = land.level - WALL_FOOT
    faces = ring_faces(2, len(top), 0).astype(np.uint32)
    vertices = np.concatenate([top, foot])
    return Mesh("edge", vertices, faces, terrain.material, uv=vertices[:, [0, 2]], smooth=False)
