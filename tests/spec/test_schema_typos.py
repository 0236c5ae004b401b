"""A validator of the JSON Schema names the wrong key or value of a typo, and its place.

Editors show what a validator reports; `best_match` of jsonschema chooses the error that says most.
"""

from __future__ import annotations

import copy
from typing import Any

import jsonschema
import pytest
from jsonschema.exceptions import best_match

from pipeline.spec import schema

SCENE: dict[str, Any] = {
    "pronk": 1,
    "duration": 6,
    "terrain": {"preset": "hills", "height": 2},
    "cast": [
        {"name": "bug", "figure": "beetle", "walk": {"gait": "tripod"}, "mood": "happy"},
        {"name": "ball", "body": {"shape": "cube", "size": 0.2}, "material": "oak"},
        {"name": "crate", "prop": {"shape": "box", "size": [1, 1, 1]}},
        {"name": "kim", "character": "child", "behaviours": [{"play": "ball", "within": 3}]},
        {"name": "wall", "many": {"layout": "pyramid", "rows": 3, "of": {"shape": "brick"}}},
        {"name": "birds", "group": {"rule": "flock", "count": 9}},
        {"name": "dancer", "dancer": "adult", "dance": "macarena"},
    ],
    "script": [
        {"at": 1, "who": "bug", "do": {"go_to": [1, 2]}},
        {"at": 2, "who": "bug", "do": "stop"},
        {"at": 3, "who": "bug", "do": {"mood": {"sad": 0.5}}},
        {"at": 4, "who": "bug", "do": {"gait": "wave", "speed": 0.3}},
        {"at": 5, "who": "kim", "do": {"urge": {"play": 0.3}}},
    ],
    "light": {"preset": "noon"},
    "sound": {"voices": [{"when": {"cause": "footfall"}, "instrument": "marimba"}]},
}

VALIDATOR = jsonschema.Draft7Validator(schema())

# The block that holds the typo, the right key or index in it, the wrong key or None, and the
# wrong value.
TYPOS: list[tuple[list[str | int], str | int, str | None, Any]] = [
    ([], "duration", "duraton", 6),
    ([], "terrain", None, "hils"),
    (["terrain"], "preset", None, "hils"),
    (["terrain"], "height", "hieght", 2),
    (["terrain"], "preset", "presset", "hills"),
    (["cast", 0], "walk", "wlak", {}),
    (["cast", 0], "figure", "figur", "beetle"),
    (["cast", 0], "mood", None, "hapy"),
    (["cast", 0, "walk"], "gait", None, "trpod"),
    (["cast", 0, "walk"], "gait", "gate", "tripod"),
    (["cast", 1], "material", None, "oack"),
    (["cast", 1, "body"], "shape", None, "sfere"),
    (["cast", 1, "body"], "size", "sise", 0.2),
    (["cast", 2, "prop"], "size", None, "big"),
    (["cast", 3], "character", None, "chlid"),
    (["cast", 3, "behaviours", 0], "play", "plya", "ball"),
    (["cast", 3, "behaviours", 0], "within", "witihn", 3),
    (["cast", 4, "many"], "layout", None, "piramid"),
    (["cast", 4, "many", "of"], "shape", None, "brik"),
    (["cast", 5, "group"], "rule", None, "flok"),
    (["cast", 6], "dancer", None, "adlut"),
    (["script", 0, "do"], "go_to", "go_too", [1, 2]),
    (["script", 0, "do"], "go_to", None, [1, "2"]),
    (["script", 1], "do", None, "stopp"),
    (["script", 2, "do", "mood"], "sad", "sda", 0.5),
    (["script", 3, "do"], "speed", "sped", 0.3),
    (["script", 3, "do"], "gait", None, "wavee"),
    (["script", 4, "do", "urge"], "play", "pley", 0.3),
    (["light"], "preset", None, "noone"),
    ([], "light", None, "dai"),
    (["sound", "voices", 0], "instrument", None, "marimbo"),
    (["sound", "voices", 0, "when"], "cause", None, "footfal"),
]


def with_typo(block: list[str | int], right: str | int, wrong: str | None, value: Any) -> Any:
    scene = copy.deepcopy(SCENE)
    below: Any = scene
    for step in block:
        below = below[step]
    if wrong is not None:
        del below[right]
    below[right if wrong is None else wrong] = value
    return scene


def test_the_scene_without_typos_is_accepted() -> None:
    assert best_match(VALIDATOR.iter_errors(SCENE)) is None


@pytest.mark.parametrize(("block", "right", "wrong", "value"), TYPOS, ids=str)
def test_the_best_error_names_the_typo_and_its_place(
    block: list[str | int], right: str | int, wrong: str | None, value: Any
) -> None:
    error = best_match(VALIDATOR.iter_errors(with_typo(block, right, wrong, value)))
    assert error is not None
    assert "given schemas" not in error.message
    place = list(error.absolute_path)
    if wrong is not None:
        assert place == block
        assert f"'{wrong}'" in error.message
        return
    path = [*block, right]
    assert place[: len(path)] == path
    named = value if len(place) == len(path) else value[place[-1]]
    assert repr(named) in error.message


@pytest.mark.parametrize(
    ("do", "names"),
    [
        ({"goto": "bug"}, "goto"),
        ({"jmp": {}}, "jmp"),
        ({"kick": "ball", "sped": 3}, "sped"),
        ({"jump": {"hieght": 1}}, "hieght"),
        ("walk_to", "walk_to"),
    ],
)
def test_all_errors_of_an_order_are_about_its_typo(do: Any, names: str) -> None:
    # Editors show the error of a union whose branch they take for the meant one: it has no union.
    (error,) = VALIDATOR.iter_errors(with_typo(["script", 0], "do", None, do))
    assert not error.context
    assert f"'{names}'" in error.message


def test_own_names_are_accepted_where_the_scene_has_a_block_for_them() -> None:
    scene = with_typo(["cast", 1], "material", None, "goo")
    assert not VALIDATOR.is_valid(scene)
    assert VALIDATOR.is_valid(scene | {"materials": {"goo": "moss"}})
    scene = with_typo(["cast", 0], "mood", None, "elated")
    assert not VALIDATOR.is_valid(scene)
    assert VALIDATOR.is_valid(scene | {"moods": {"elated": {"stride": 1.2}}})


@pytest.mark.parametrize("figure", ["g3", "my bug", "g3.yaml", "./g3.yaml", "../g3", "a\\b.yml"])
def test_any_name_and_path_of_a_figure_is_accepted(figure: str) -> None:
    assert VALIDATOR.is_valid(with_typo(["cast", 0], "figure", None, figure))


@pytest.mark.parametrize("name", ["Marimba", " marimba", "Honky-Tonk Piano", "honky_tonk  piano"])
def test_names_that_are_read_in_any_spelling_are_accepted_so(name: str) -> None:
    assert VALIDATOR.is_valid(with_typo(["sound", "voices", 0], "instrument", None, name))
