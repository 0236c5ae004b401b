"""Figures drawn as persons: clothed, joint on joint, and no solids beside their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from pipeline.errors import SceneError
from pipeline.simulation.casting import clothes_of, figures_of
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.people.dressed_figure import SOLE, check_person, figure_layers
from pipeline.simulation.people.wardrobe import Clothes
from pipeline.spec.figure import Figure as Drawing
from pipeline.spec.scene_loader import load_scene


def words_of(name: str) -> dict[str, object]:
    text = Path(f"scenes/figures/{name}.yaml").read_text(encoding="utf-8")
    words: dict[str, object] = yaml.safe_load(text)["figure"]
    return words


def built(words: dict[str, object], scale: float = 1.0) -> Figure:
    return build_figure("it", Drawing.model_validate(words), scale)


@pytest.mark.parametrize("scale", [1.0, 0.6])
def test_clothes_lie_around_the_links_that_they_follow(scale: float) -> None:
    figure = built(words_of("person"), scale)
    spans = np.array([link.ends for link in figure.skeleton.links])
    spans[0] = [[0.0, 0.0, 0.0], [0.0, 0.5 * scale, 0.0]]
    for layer in figure_layers(figure, Clothes(style="short", short_sleeves=False)):
        mesh = layer.mesh
        first = np.where(mesh.weights[:, 0] >= 0.5, mesh.nodes[:, 0], mesh.nodes[:, 1])
        a, b = spans[first, 0], spans[first, 1]
        along = ((mesh.vertices - a) * (b - a)).sum(axis=1) / ((b - a) ** 2).sum(axis=1)
        near = a + np.clip(along, 0.0, 1.0)[:, None] * (b - a)
        assert np.linalg.norm(mesh.vertices - near, axis=1).max() < 0.27 * scale, layer.name


def test_a_dressed_figure_stands_on_level_soles_as_tall_as_it_is_drawn() -> None:
    figure = built(words_of("person"))
    X = JointTree.of(figure.skeleton).pose(figure.skeleton.preferred)
    layers = {layer.name: layer.mesh for layer in figure_layers(figure, Clothes())}
    shoes = layers["shoes"]
    feet = figure.skeleton.links[6], figure.skeleton.links[3]
    for link, side in zip(feet, (1.0, -1.0), strict=True):
        own = shoes.vertices[shoes.vertices[:, 2] * side > 0.0]
        frame = X[link.joint]
        places = (own - figure.skeleton.places[link.joint]) @ frame[:3, :3].T + frame[:3, 3]
        tip = frame[:3, :3] @ (link.ends[1] - figure.skeleton.places[link.joint]) + frame[:3, 3]
        # Many vertices lie in the sole, as deep as the ball that touches the ground.
        low = places[:, 1].min()
        assert low == pytest.approx(tip[1] - link.radii[1], abs=SOLE + 0.001)
        assert (places[:, 1] < low + 0.004).sum() > 10
    top = max(float(mesh.vertices[:, 1].max()) for mesh in layers.values())
    crown = figure.skeleton.links[-1]
    assert top == pytest.approx(float(crown.ends[1, 1]) + crown.radii[1], abs=0.06)


def test_no_layer_is_rigid() -> None:
    for layer in figure_layers(built(words_of("person")), Clothes()):
        mesh = layer.mesh
        assert not (mesh.nodes == mesh.nodes[0, 0]).all(), layer.name
        np.testing.assert_allclose(mesh.weights.sum(axis=1), 1.0, atol=1e-6)


def test_the_skin_of_a_person_is_refused_on_a_horse() -> None:
    words = words_of("horse")
    check_person(built(words))
    with pytest.raises(SceneError, match=r"figures\.it\.skin\.form: a person has two legs"):
        check_person(built({**words, "skin": {"form": "person"}}))


SCENE = """
pronk: 1
duration: 1
seed: 4
cast:
  - {{name: ann, figure: person, costume: coat}}
  - {{name: ben, figure: person, at: [0, 1]}}
  - {{name: cas, character: adult, at: [0, 2]}}
  - {{name: dot, character: child, at: [0, 3], material: wood}}
  - {{name: eve, dancer: torso, at: [0, 4]}}
  - {{name: fay, dancer: torso, at: [0, 5]}}
  - {}
"""


def test_clothes_are_dealt_over_walkers_characters_and_dancers(tmp_path: Path) -> None:
    path = tmp_path / "people.yaml"
    path.write_text(SCENE.format("{figure: horse, at: [3, 3]}"), encoding="utf-8")
    scene = load_scene(path)
    worn = clothes_of(scene, figures_of(scene))
    assert sorted(worn) == ["ann", "ben", "cas", "dot", "eve", "fay"]
    assert worn["ann"].garments == ("coat",)
    assert worn["dot"].shirt == "wood"
    kinds = {(look.garments, look.short_sleeves, look.shorts) for look in worn.values()}
    assert len(kinds) == len(worn)


def test_a_costume_is_refused_for_a_horse(tmp_path: Path) -> None:
    path = tmp_path / "horse.yaml"
    path.write_text(SCENE.format("{figure: horse, costume: suit, at: [3, 3]}"), encoding="utf-8")
    scene = load_scene(path)
    with pytest.raises(SceneError, match=r"cast\[6\]\.costume: the figure 'horse' wears nothing"):
        clothes_of(scene, figures_of(scene))
