"""Costumes: words for clothes, and what is wrong with them."""

from __future__ import annotations

import pytest

from pipeline.errors import SceneError
from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene

SCENE = "pronk: 1\nduration: 1\nterrain: flat\ncast:\n  - {{name: it, {member}}}\n"


@pytest.mark.parametrize("member", ["character: adult", "character: child", "dancer: adult"])
def test_people_and_dancers_wear_costumes(member: str) -> None:
    (worn,) = read_scene(SCENE.format(member=f"{member}, costume: suit")).cast
    assert worn.costume == "suit"


@pytest.mark.parametrize(
    ("member", "message"),
    [
        ("character: adult, costume: suite", r"scene:5:.*cast\[0\].costume.*'suit'"),
        ("character: bench, costume: suit", r"scene:5:.*a bench wears nothing"),
    ],
)
def test_wrong_costumes_are_refused_with_their_line(member: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        read_scene(SCENE.format(member=member))


def test_a_creature_that_is_no_person_wears_nothing() -> None:
    scene = read_scene(SCENE.format(member="figure: horse, costume: suit"))
    with pytest.raises(SceneError, match=r"scene:5:.*wears nothing"):
        simulate(scene)
