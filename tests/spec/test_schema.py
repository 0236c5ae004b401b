"""The JSON Schema accepts valid scenes, short forms included, and refuses mistakes."""

from __future__ import annotations

import copy
from functools import cache

import jsonschema
import pytest
import yaml

from pipeline.spec import Scene, dump, library, sequence_schema, shipped_scenes
from pipeline.spec import figure_schema as written_figure_schema
from pipeline.spec import schema as written_schema

# Writing a schema takes most of a second.
schema, figure_schema = cache(written_schema), cache(written_figure_schema)

SMALLEST = {"pronk": 1, "duration": 6, "terrain": "hills", "cast": [{"figure": "bug", "walk": {}}]}
FULL = {
    "pronk": 1,
    "title": "Beetle over the rocks",
    "fps": "30000/1001",
    "frames": 144,
    "terrain": {"preset": "hills", "height": 2},
    "figures": {
        "ant": {
            "style": "insect",
            "nodes": {"head": [0, -1.1], "tail": {"at": [0, 1.0], "radius": 0.05}},
            "chains": [["head", "tail"]],
            "then": [{"mirror": "y", "nodes": ["head"]}],
            "parts": {"head": "head"},
        }
    },
    "cast": [
        {"figure": "ant", "at": [-4, 2], "walk": {"gait": "tripod", "cycle": 0.7}},
        {"figure": "ant", "walk": {"gait": {"up": {"l1": 0}, "down": {"l1": 0.5}}}},
    ],
    "materials": {"goo": "moss", "slime": {"preset": "moss", "color": "#102030"}},
    "camera": [{"follow": "ant"}, {"start": 1, "follow": ["ant", "ant_2"]}],
    "light": {"sun": {"hour": 16.5}},
    "film": {"size": [1280, 720]},
    "sound": {"voices": [{"when": {"cause": "footfall"}, "pitch": "by foot"}]},
}
FIGURE = {"pronk": 1, "figure": FULL["figures"]["ant"]}


def accepts(json_schema, value):
    return jsonschema.Draft7Validator(json_schema).is_valid(value)


def changed(scene, path, value):
    scene = copy.deepcopy(scene)
    below = scene
    for step in path[:-1]:
        below = below[step]
    below[path[-1]] = value
    return scene


SCHEMAS = {"scene": schema, "figure": figure_schema, "sequence": sequence_schema}


@pytest.mark.parametrize("json_schema", [write() for write in SCHEMAS.values()], ids=SCHEMAS)
def test_schemas_follow_draft_07(json_schema):
    jsonschema.Draft7Validator.check_schema(json_schema)
    assert json_schema["$schema"] == "http://json-schema.org/draft-07/schema#"
    for later in ("$defs", "prefixItems", "discriminator"):
        assert not list(occurrences(json_schema, later))


def test_the_schema_of_sequences_takes_names_and_clips():
    clips = ["dunes", {"scene": "hug", "start": 1, "dissolve": 0.5}]
    assert accepts(sequence_schema(), {"pronk": 1, "sequence": clips})
    assert not accepts(sequence_schema(), {"pronk": 1, "sequence": [{"scene": "hug", "begin": 1}]})


def occurrences(json_schema, key):
    below = json_schema.values() if isinstance(json_schema, dict) else json_schema
    if isinstance(json_schema, dict) and key in json_schema:
        yield json_schema
    if isinstance(json_schema, dict | list):
        for value in below:
            yield from occurrences(value, key)


def test_every_reference_has_a_definition_and_no_sibling_keys():
    json_schema = schema()
    references = list(occurrences(json_schema, "$ref"))
    assert references
    for one in references:
        assert list(one) == ["$ref"]
        assert one["$ref"].removeprefix("#/definitions/") in json_schema["definitions"]


def test_every_key_has_a_description():
    undescribed = [
        f"{block['title']}.{name}"
        for block in (schema(), *schema()["definitions"].values(), figure_schema())
        for form in (block, *block.get("anyOf", []))
        for name, word in form.get("properties", {}).items()
        if "description" not in word and name != "preset"
    ]
    assert undescribed == []


@pytest.mark.parametrize(
    "terrain",
    [
        "boulders",
        {"preset": "stones", "jitter": 0, "at": [3, 4], "heading_deg": 20},
        {"kind": "image", "file": "land.png", "cells": [40, 40]},
        {"kind": "mesh", "file": "land.obj", "up": "z"},
        {"kind": "sum", "of": ["stairs", {"preset": "rocks", "height": 0.1}]},
    ],
)
def test_terrains_are_accepted(terrain):
    assert accepts(schema(), {**SMALLEST, "terrain": terrain})


@pytest.mark.parametrize("scene", [SMALLEST, FULL], ids=["smallest", "full"])
def test_scenes_are_accepted(scene):
    assert accepts(schema(), scene)


def test_a_dumped_scene_is_accepted():
    assert accepts(schema(), yaml.safe_load(dump(Scene.model_validate(FULL))))


@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_scenes_are_accepted(name):
    assert accepts(schema(), yaml.safe_load((library() / f"{name}.yaml").read_text("utf-8")))


@pytest.mark.parametrize("path", sorted((library() / "figures").glob("*.yaml")), ids=str)
def test_figure_files_are_accepted_by_the_figure_schema_only(path):
    json_schema = yaml.safe_load(path.read_text("utf-8"))
    assert accepts(figure_schema(), json_schema)
    assert not accepts(schema(), json_schema)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "value"),
    [
        (["zzz"], 1),
        (["pronk"], 2),
        (["duration"], 3),
        (["frames"], 0),
        (["frames"], "144"),
        (["fps"], "30000 / 1001"),
        (["fps"], 29.97),
        (["terrain"], "hill"),
        (["terrain"], {"kind": "flat", "height": 3}),
        (["terrain"], {"preset": "hills", "size": [1, 2, 3]}),
        (["terrain"], {"preset": "hills", "size": [1]}),
        (["terrain"], {"kind": "image"}),
        (["terrain"], {"kind": "sum", "of": ["hill"]}),
        (["figures", "ant", "nodes", "head"], [0]),
        (["figures", "ant", "nodes", "head"], [0, 1, 2]),
        (["figures", "ant", "nodes", "a.b"], [0, 0]),
        (["figures", "ant", "style"], "reptile"),
        (["figures", "ant", "then", 0, "mirror"], "z"),
        (["cast"], []),
        (["cast", 0, "figure"], 3),
        (["cast", 0, "walk", "gait"], "trto"),
        (["cast", 0, "walk", "strde"], 1),
        (["cast", 1, "walk", "gait", "down", "l1"], 2),
        (["light"], "dai"),
        (["film", "size"], [1280, "720"]),
        (["materials", "goo"], "mosss"),
    ],
)
def test_mistakes_are_refused(path, value):
    assert accepts(schema(), FULL)
    assert not accepts(schema(), changed(FULL, path, value))


@pytest.mark.parametrize("path", [["figure", "nodes"], ["figure", "radius"], ["pronk"]])
def test_mistakes_in_figure_files_are_refused(path):
    assert accepts(figure_schema(), FIGURE)
    assert not accepts(figure_schema(), changed(FIGURE, path, "x"))
