"""Registry of terrain generators: the model of a kind -> its surface about the origin.

A new kind is a model in `pipeline/spec/terrain` and a function with `@generates` in a module
that `ground` imports.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from pipeline.errors import SceneError
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.terrain.base import TerrainConfig
from pipeline.spec.terrain.kinds import SumTerrain

Generator = TypeVar("Generator", bound=Callable[[Any, np.random.Generator], HeightField])

GENERATORS: dict[type[TerrainConfig], Callable[..., HeightField]] = {}
"""Generators by the model of their kind."""


def generates(model: type[TerrainConfig]) -> Callable[[Generator], Generator]:
    """Register the generator of a kind of terrain."""

    def register(generator: Generator) -> Generator:
        GENERATORS[model] = generator
        return generator

    return register


@generates(SumTerrain)
def total(terrain: SumTerrain, rng: np.random.Generator) -> HeightField:
    """Return the sum of terrains; each draws from a seed of its own.

    Raises:
        SceneError: the file of a term does not hold what it should.
    """
    heights = np.zeros((terrain.cells[1] + 1, terrain.cells[0] + 1))
    for i, (term, own) in enumerate(zip(terrain.of, rng.spawn(len(terrain.of)), strict=True)):
        try:
            heights += GENERATORS[type(term)](term, own).heights
        except SceneError as error:
            raise below(error, f"of[{i}]") from None
    return HeightField(heights, terrain.size)


def below(error: SceneError, path: str) -> SceneError:
    """Return an error whose problems lie below `path` in the scene."""
    return SceneError([replace(p, path=f"{path}.{p.path}") for p in error.problems])
