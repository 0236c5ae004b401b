"""Generators: the words of a terrain -> its surface about the origin, one function a kind.

A new kind is a model in `pipeline/spec/terrain/`, a function in a file of this room and a
line in `GENERATORS`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipeline.errors import SceneError
from pipeline.simulation.terrain.boulders import boulders
from pipeline.simulation.terrain.built import ditches, ramp, stairs
from pipeline.simulation.terrain.from_file import below
from pipeline.simulation.terrain.grid_mesh import mesh
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.simulation.terrain.image import image
from pipeline.simulation.terrain.stones import stones
from pipeline.simulation.terrain.wild import flat, fractal, hills
from pipeline.spec.terrain import (
    BouldersTerrain,
    DitchesTerrain,
    FlatTerrain,
    FractalTerrain,
    HillsTerrain,
    ImageTerrain,
    MeshTerrain,
    RampTerrain,
    StairsTerrain,
    StonesTerrain,
    SumTerrain,
)
from pipeline.spec.terrain import Ground as Words


def total(words: SumTerrain, chance: np.random.Generator) -> HeightField:
    """Return the sum of terrains; each draws from a seed of its own.

    Raises:
        SceneError: a file that a term names does not hold what it should.
    """
    heights = np.zeros((words.cells[1] + 1, words.cells[0] + 1))
    for i, (term, own) in enumerate(zip(words.of, chance.spawn(len(words.of)), strict=True)):
        try:
            heights += GENERATORS[type(term)](term, own).heights
        except SceneError as error:
            raise below(error, f"of[{i}]") from None
    return HeightField(heights, words.size)


GENERATORS: dict[type[Words], Callable[..., HeightField]] = {
    FlatTerrain: flat,
    FractalTerrain: fractal,
    HillsTerrain: hills,
    BouldersTerrain: boulders,
    StairsTerrain: stairs,
    RampTerrain: ramp,
    DitchesTerrain: ditches,
    StonesTerrain: stones,
    ImageTerrain: image,
    MeshTerrain: mesh,
    SumTerrain: total,
}
