"""Registries: every model of a union has an implementation and a shipped scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache

import pytest

from pipeline.simulation.terrain.ground import GENERATORS
from pipeline.spec import Scene, find_scene, load_scene, read_scene, shipped_scenes
from pipeline.spec.behaviour import FORMS as BEHAVIOURS
from pipeline.spec.cast import MEMBERS
from pipeline.spec.script import FORMS as ORDERS
from pipeline.spec.terrain.base import TERRAIN_KINDS, TERRAIN_PRESETS, TerrainConfig
from pipeline.spec.verbs import VERBS

MORE_TERRAINS = ("ditches", "{kind: sum, of: [stairs, {preset: rocks, height: 0.1}]}")
"""Terrains without a shipped scene."""

FROM_FILES = {"image", "mesh"}
"""Terrains of files, which the library does not ship."""


@cache
def scenes() -> tuple[Scene, ...]:
    return tuple(load_scene(find_scene(name)) for name in shipped_scenes())


def terrains() -> Iterator[TerrainConfig]:
    scene_text = "{{pronk: 1, frames: 1, terrain: {}, cast: [{{figure: beetle}}]}}"
    more = (read_scene(scene_text.format(terrain)) for terrain in MORE_TERRAINS)
    for scene in (*scenes(), *more):
        yield scene.terrain
        yield from getattr(scene.terrain, "of", ())


@pytest.mark.parametrize("kind", TERRAIN_KINDS)
def test_every_terrain_has_a_generator_and_a_scene(kind: str) -> None:
    model = TERRAIN_KINDS[kind]
    assert model in GENERATORS
    assert kind in FROM_FILES or any(type(terrain) is model for terrain in terrains())


@pytest.mark.parametrize("preset", TERRAIN_PRESETS)
def test_every_preset_is_a_terrain(preset: str) -> None:
    keys = TERRAIN_PRESETS[preset]
    assert TERRAIN_KINDS[keys["kind"]].model_validate(dict(keys))


@pytest.mark.parametrize("block", MEMBERS)
def test_every_kind_of_performer_has_a_scene(block: str) -> None:
    model = MEMBERS[block]
    assert block in model.model_fields
    assert any(type(member) is model for scene in scenes() for member in scene.cast)


@pytest.mark.parametrize("key", BEHAVIOURS)
def test_the_key_of_a_behaviour_is_unique(key: str) -> None:
    assert key in BEHAVIOURS[key].model_fields
    assert [k for k, form in BEHAVIOURS.items() if key in form.model_fields] == [key]


@pytest.mark.parametrize("key", ORDERS)
def test_the_key_of_an_order_is_required(key: str) -> None:
    assert ORDERS[key].model_fields[key].is_required()


@pytest.mark.parametrize("table", [ORDERS, VERBS], ids=["models", "verbs"])
@pytest.mark.parametrize("key", ORDERS)
def test_the_key_of_an_order_comes_before_those_of_its_settings(
    key: str, table: Mapping[str, object]
) -> None:
    keys = list(table)
    settings = [name for name in ORDERS[key].model_fields if name in table and name != key]
    assert all(keys.index(key) < keys.index(name) for name in settings)
