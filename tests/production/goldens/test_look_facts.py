"""Look facts: settings and shapes that differ are named, other wordings are not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from pipeline.production.goldens.look_facts import (
    Look,
    look_differences,
    look_of,
    shape_differences,
    shapes_of,
)
from pipeline.simulation.take import Take
from render.config import Film, light, material


def look(film: Mapping[str, Any] | None = None, lit: Any = "studio", clay: Any = "clay") -> Look:
    return look_of(Film.model_validate(film or {}).resolved(), light(lit), {"clay": material(clay)})


@pytest.mark.parametrize(
    ("film", "lit", "clay"),
    [
        ({"preset": "preview"}, "studio", "clay"),
        ({"exposure": 0, "depth": 4}, {"studio": {}}, {"preset": "clay"}),
        ({}, {"studio": {"fill": 0.3}}, {"preset": "clay", "metallic": 0}),
    ],
)
def test_another_wording_is_the_same_look(film: Any, lit: Any, clay: Any) -> None:
    assert list(look_differences(look(), look(film, lit, clay))) == []


@pytest.mark.parametrize(
    ("film", "lit", "clay", "says"),
    [
        (
            {"exposure": 0.001},
            "studio",
            "clay",
            "film: exposure is 0.001, the golden's 0",
        ),
        ({"samples": 3}, "studio", "clay", "film: samples is 3, the golden's 2"),
        ({}, {"studio": {"rim": 0.49}}, "clay", "light: studio.rim is 0.49, the golden's 0.5"),
        ({}, "day", "clay", "light: studio is None, the golden's given"),
        ({}, {"studio": {}, "lamps": [{}]}, "clay", "light: lamps is 1 given, the golden's []"),
        ({}, {"studio": {}, "lamps": [{}, {}]}, "clay", "light: lamps is 2 given"),
        ({}, "studio", {"preset": "clay", "roughness": 0.4}, "material clay: roughness is 0.4"),
    ],
)
def test_a_setting_that_differs_is_named(film: Any, lit: Any, clay: Any, says: str) -> None:
    found = list(look_differences(look(), look(film, lit, clay)))
    assert any(text.startswith(says) for text in found), found


def test_settings_that_another_version_does_not_know_say_nothing() -> None:
    then = look()
    del then["film"]["moments"], then["material clay"]["sheen"]
    assert list(look_differences(then, look())) == []
    assert list(look_differences(look(), then)) == []


def test_a_material_too_many_is_named() -> None:
    then, now = look(), look()
    now["material glass"] = now["material clay"]
    assert list(look_differences(then, now)) == ["material glass is new"]
    assert list(look_differences(now, then)) == ["material glass is gone"]


def test_another_shape_is_named(take: Take) -> None:
    then = shapes_of(take)
    assert list(shape_differences(then, then)) == []
    part = take.parts[0]
    mesh = take.meshes[part.seen]
    for factor, says in ((1.0001, []), (1.1, [part.name])):
        larger = replace(mesh, vertices=mesh.vertices * mesh.vertices.dtype.type(factor))
        meshes = (*take.meshes[: part.seen], larger, *take.meshes[part.seen + 1 :])
        found = list(shape_differences(then, shapes_of(replace(take, meshes=meshes))))
        assert [text.split()[1] for text in found if part.name in text] == says
    hidden = replace(take, parts=(replace(part, life=(0, 3)), *take.parts[1:]))
    (text,) = shape_differences(then, shapes_of(hidden))
    assert text.startswith(f"part {part.name} is visible in rows 0 to 3")
