"""Costumes and hair: words for them, and what is wrong with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.casting import clothes_of
from pipeline.simulation.people.person_mesh import person_layers
from pipeline.simulation.people.proportions import ADULT
from pipeline.simulation.people.wardrobe import Clothes
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
        ("character: adult, hair: {style: bobb}", r"scene:5:.*cast\[0\].hair.style.*'bob'"),
        ("character: adult, hair: {material: red fir}", r"scene:5:.*hair.material.*'red fur'"),
        ("character: adult, hair: {length: 9}", r"scene:5:.*hair.length.*at most 2.5"),
        ("character: adult, hair: {colour: red}", r"scene:5:.*hair.colour: unknown key"),
        ("character: ball, hair: {style: bob}", r"scene:5:.*a ball has no hair"),
    ],
)
def test_wrong_costumes_are_refused_with_their_line(member: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        read_scene(SCENE.format(member=member))


@pytest.mark.parametrize(
    ("word", "message"),
    [("costume: suit", "wears nothing"), ("hair: {style: bob}", "has no such hair")],
)
def test_a_creature_that_is_no_person_wears_nothing(word: str, message: str) -> None:
    scene = read_scene(SCENE.format(member=f"figure: horse, {word}"))
    with pytest.raises(SceneError, match=rf"scene:5:.*{message}"):
        simulate(scene)


def test_hair_is_as_its_author_says_and_the_rest_as_dealt() -> None:
    dealt, told = (
        clothes_of(read_scene(SCENE.format(member=f"character: adult{hair}")), {})["it"]
        for hair in ("", ", hair: {style: bun, material: white fur, length: 1.5}")
    )
    assert told == replace(dealt, style="bun", hair="white fur", hair_length=1.5)


def test_long_hair_has_longer_strands() -> None:
    usual, longer = (
        next(x for x in person_layers(ADULT, Clothes(hair_length=n)) if x.name == "hair").mesh.hair
        for n in (1.0, 1.5)
    )
    lengths = np.linalg.norm(usual, axis=-1), np.linalg.norm(longer, axis=-1)
    np.testing.assert_allclose(lengths[1].max(), 1.5 * lengths[0].max(), rtol=1e-5)
    # Brows are none.
    np.testing.assert_allclose(lengths[1].min(), lengths[0].min(), rtol=1e-5)
