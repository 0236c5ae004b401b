"""Weathered pit: banks and beds are worn in the picture, and what carries feet stays."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pipeline.production.shots.weathered_pit import LOWEST, weathered
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import TerrainRecord
from pipeline.spec.scene import Scene

WATER = {"preset": "river", "level": -0.2}
STONES = {
    "preset": "stones",
    "size": [8, 6],
    "cells": [160, 120],
    "start": -1.6,
    "length": 3.2,
    "depth": 0.7,
    "gap": 0.4,
}

STILL = {"name": "ball", "prop": {"shape": "ball", "radius": 0.1}, "at": [-3, 0.1, 0]}


def terrains(**keys: Any) -> tuple[TerrainRecord, TerrainRecord]:
    """Return the ground of a take, and as it is drawn."""
    scene: Scene = Scene.model_validate(
        {
            "pronk": 1,
            "title": "Test",
            "duration": 0.1,
            "terrain": {**STONES, **keys},
            "cast": [STILL],
        }
    )
    simulated = simulate(scene).terrain
    return simulated, weathered(simulated, scene)


def test_tops_and_banks_stay_and_the_bed_is_raised() -> None:
    before, after = terrains(water=WATER)
    low = before.vertices[:, 1] < -0.69
    assert 0.1 < low.mean() < 0.5
    np.testing.assert_array_equal(after.vertices[~low], before.vertices[~low])
    np.testing.assert_array_equal(after.vertices[:, [0, 2]], before.vertices[:, [0, 2]])
    raised = (after.vertices - before.vertices)[low, 1]
    assert raised.min() >= 0.0
    # Water is left between the stones, and nothing in the pit is as high as the banks.
    assert (after.vertices[low, 1] < WATER["level"]).mean() > 0.3
    assert after.vertices[low, 1].max() <= -0.5 * LOWEST


def test_the_edge_of_a_bank_wanders_instead_of_being_straight() -> None:
    before, after = terrains(water=WATER)
    shape = before.cells[1] + 1, before.cells[0] + 1
    spreads = []
    for terrain in (before, after):
        grid = terrain.vertices.reshape(*shape, 3)
        wet = grid[..., 1] < WATER["level"]
        first = np.array([row.argmax() for row in wet])
        spreads.append(grid[0, first, 0].std())
    assert spreads[0] < 1e-9
    assert spreads[1] > 0.04


@pytest.mark.parametrize(
    "keys",
    [{}, {"water": WATER, "material": "grey plaster"}, {"water": WATER, "show_forbidden": True}],
    ids=["dry", "built", "hatched"],
)
def test_other_pits_stay(keys: dict[str, Any]) -> None:
    before, after = terrains(**keys)
    assert after is before
