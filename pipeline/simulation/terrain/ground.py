"""Ground: the terrain of a scene, ready to be stood on and drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import SceneError
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.forbidden import forbidden_cells
from pipeline.simulation.terrain.from_file import below
from pipeline.simulation.terrain.generators import GENERATORS
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.simulation.terrain.surfaces import surface_of
from pipeline.spec.terrain import Ground as Words
from pipeline.spec.values import FAR


@dataclass(frozen=True, eq=False)
class Ground:
    """A surface with its forbidden zones and its material.

    Attributes:
        field: the surface.
        forbidden: (n_z, n_x) cells that no foot may be put on.
        material: name of its material.
    """

    field: HeightField
    forbidden: NDArray[np.bool_]
    material: str

    def height(self, x: Array, z: Array) -> Array:
        """Return the height of the surface [m] at world (x, z)."""
        return self.field.height(x, z)

    def normal(self, x: Array, z: Array) -> Array:
        """Return the unit normals (..., 3) of the surface at (x, z)."""
        return self.field.normal(x, z)

    def surface(self, x: Array, z: Array) -> tuple[Array, Array]:
        """Return heights (...) [m] and unit normals (..., 3) at (x, z), found together."""
        return self.field.surface(x, z)

    def steppable(self, x: Array, z: Array) -> NDArray[np.bool_]:
        """Say where a foot may be put; outside the grid it may not."""
        forbidden = self.forbidden[self.field.cell_of(x, z)]
        result: NDArray[np.bool_] = self.field.inside(x, z) & ~forbidden
        return result


def level_ground(height: float, like: Ground) -> Ground:
    """Return level ground everywhere at `height` [m], of the material of another one."""
    field = HeightField(np.full((3, 3), height), (2.0 * FAR, 2.0 * FAR))
    return Ground(field, np.zeros((2, 2), dtype=bool), like.material)


def build_ground(words: Words, seed: int) -> Ground:
    """Build the ground that `words` describe.

    The terrain draws from the scene's seed under the name "terrain".

    Raises:
        SceneError: a file that the words name does not hold what it should.
    """
    try:
        field = GENERATORS[type(words)](words, generator(seed, "terrain"))
    except SceneError as error:
        raise below(error, "terrain") from None
    field = surface_of(field, words.polygons).placed(words.at, math.radians(words.heading_deg))
    zones = forbidden_cells(field, math.radians(words.unsteppable_slope_deg), words.foot_radius)
    return Ground(field, zones, words.material)
