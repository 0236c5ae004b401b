"""Surfaces: what a grid of heights is made of, by its word."""

from __future__ import annotations

from collections.abc import Mapping

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.simulation.terrain.quadfield import QuadField
from pipeline.spec.terrain import Polygons

SURFACES: Mapping[Polygons, type[HeightField]] = {"triangles": HeightField, "quads": QuadField}


def surface_of(field: HeightField, polygons: Polygons) -> HeightField:
    """Return the same heights at the same place as a surface of `polygons`."""
    return SURFACES[polygons](field.heights, field.size, field.at, field.heading)


def surface_of_vertices(vertices: Array, cells: tuple[int, int]) -> HeightField:
    """Return the surface whose vertices (V, 3) these are: one that has middles has quads."""
    n_x, n_z = cells
    has_middles = len(vertices) > (n_x + 1) * (n_z + 1)
    return SURFACES["quads" if has_middles else "triangles"].of_vertices(vertices, cells)
