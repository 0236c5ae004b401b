"""Ground mesh: the terrain, and the land around it to the horizon.

Forbidden zones can be hatched, cell by cell.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.wall_rims import rounded_walls, wall_faces
from pipeline.production.surroundings.choice import Choice
from pipeline.production.surroundings.land import Land
from pipeline.production.surroundings.land_cover import Color
from pipeline.production.surroundings.land_mesh import land_mesh, wall_mesh
from pipeline.simulation.take import TerrainRecord
from render.color import linear
from render.config import Material
from render.footprints import FootprintRaster
from render.shot import Mesh

FULL_DETAIL = 1280
"""Width of the frame for which the land has all its vertices [pixels]."""

LEAST_DETAIL, MAX_DETAIL = 0.2, 1.5
"""Bounds of the detail of the land."""


def terrain_mesh(
    terrain: TerrainRecord,
    show_forbidden: bool = False,
    footprints: FootprintRaster | None = None,
    smooth: bool = True,
) -> Mesh:
    """Return the terrain, with texture coordinates in metres.

    Args:
        terrain: of the take.
        show_forbidden: whether its forbidden zones are hatched.
        footprints: in it, over the whole film.
        smooth: whether it is shaded as a round surface, without edges.
    """
    return Mesh(
        name="terrain",
        vertices=rounded_walls(terrain.vertices, terrain.cells).astype(np.float32),
        faces=wall_faces(terrain.vertices, terrain.faces, terrain.cells),
        material=terrain.material,
        uv=terrain.vertices[:, [0, 2]].astype(np.float32),
        smooth=smooth,
        warned=_forbidden_faces(terrain) if show_forbidden else None,
        footprints=footprints,
    )


def surrounding_meshes(
    terrain: TerrainRecord, around: Choice, materials: Mapping[str, Material], width: int
) -> tuple[Mesh, ...]:
    """Return the land around the terrain, and the walls of a floor.

    Args:
        terrain: of the take.
        around: what surrounds it.
        materials: by name.
        width: of the frame [pixels].
    """
    color = mean_color(materials[around.material])
    return _surrounding_meshes(terrain, around, color, land_detail(width))


def land_detail(width: int) -> float:
    """Return the detail of the land in frames of a width [pixels]."""
    return min(max(width / FULL_DETAIL, LEAST_DETAIL), MAX_DETAIL)


def mean_color(material: Material) -> Color:
    """Return the mean linear colour of a ground material."""
    second = material.color if material.color2 is None else material.color2
    r, g, b = (0.5 * (linear(material.color) + linear(second))).tolist()
    return r, g, b


@lru_cache(maxsize=2)
def _surrounding_meshes(
    terrain: TerrainRecord, around: Choice, color: Color, detail: float
) -> tuple[Mesh, ...]:
    # Kept, because a take is often shot again with other cameras or lights.
    land = Land.of(terrain, around)
    made = (
        land_mesh(land, terrain, around.material, color, detail),
        wall_mesh(land, terrain),
    )
    return tuple(mesh for mesh in made if mesh is not None)


def _forbidden_faces(terrain: TerrainRecord) -> NDArray[np.bool_]:
    """Return which faces lie in forbidden zones; the faces of a cell are contiguous."""
    forbidden = terrain.forbidden.ravel()
    return np.repeat(forbidden, len(terrain.faces) // len(forbidden))
