"""Figure checks: each warning on a figure that deserves it, and none on the shipped figures."""

from __future__ import annotations

from typing import Any

import pytest

from pipeline.simulation.figures.figure import build_figure
from pipeline.simulation.figures.figure_checks import check_figure
from pipeline.simulation.figures.network import Remark
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Figure as FigureConfig
from pipeline.spec import Scene, load_figures
from pipeline.spec.scene_library import library


def dog(front: float = 0.8, hind: float = 0.8, **keys: Any) -> dict[str, Any]:
    """Return a four-legged figure with legs of these lengths [m]."""
    nodes = {
        "nose": [0, -0.9], "chest": [0, -0.4], "rump": [0, 0.4], "tail": [0, 0.8],
        "knee1": [-front / 2, -0.4], "foot1": [-front, -0.4],
        "knee2": [-hind / 2, 0.4], "foot2": [-hind, 0.4],
    }  # fmt: skip
    chains = [["nose", "chest", "rump", "tail"], ["chest", "knee1", "foot1"]]
    chains.append(["rump", "knee2", "foot2"])
    figure = {"style": "mammal", "nodes": nodes, "chains": chains, "then": [{"mirror": "x"}]}
    return {**figure, **keys}


def with_nodes(figure: dict[str, Any], nodes: dict[str, Any], *chains: list[str]) -> dict[str, Any]:
    """Return a figure with more nodes and chains."""
    return {
        **figure,
        "nodes": {**figure["nodes"], **nodes},
        "chains": [*figure["chains"], *chains],
    }


def remarks(words: dict[str, Any]) -> list[Remark]:
    """Return all remarks on a figure."""
    return list(check_figure(build_figure("it", FigureConfig.model_validate(words), 1.0)))


def only_fault(words: dict[str, Any]) -> Remark:
    """Return the one likely mistake of a figure."""
    (fault,) = [remark for remark in remarks(words) if remark.is_fault]
    return fault


def test_a_sound_figure_has_no_remarks() -> None:
    assert remarks(dog()) == []


def test_floating_feet_are_named_with_their_height() -> None:
    fault = only_fault(dog(hind=0.7))
    assert fault.node == "foot2"
    assert fault.text.startswith("'foot2', 'foot2_m' float 0.099 m above the ground where 'foot1'")


def test_legs_of_unequal_length() -> None:
    found = [r for r in remarks(dog(front=1.0, hind=0.75, parts={}) | {"parts": {}}) if r.is_fault]
    assert not any("unequal" in remark.text for remark in found), "a third more is no giant"
    told = {"foot1": "leg", "foot1_m": "leg"}
    faults = [r for r in remarks(dog(front=1.4, hind=0.8, parts=told)) if r.is_fault]
    (unequal,) = [fault for fault in faults if "unequal" in fault.text]
    assert "0.8 m to 'foot2', 1.4 m to 'foot1'" in unequal.text
    assert "parts: {foot2: arm}" in unequal.text


def test_a_body_on_the_ground() -> None:
    fat = dog()
    fat["nodes"] = {**fat["nodes"], "chest": {"at": [0, -0.4], "radius": 0.9}}
    (fault,) = [remark for remark in remarks(fat) if "lies on the ground" in remark.text]
    assert fault.is_fault
    assert "0.9 m thick" in fault.text


def test_a_figure_that_falls_over() -> None:
    biped = dog()
    biped["chains"] = [["nose", "chest", "rump", "tail"], ["rump", "knee2", "foot2"]]
    biped["nodes"] = {n: at for n, at in biped["nodes"].items() if not n.endswith("1")}
    fault = only_fault({**biped, "pitch_deg": 0})
    assert "would fall over" in fault.text
    assert "m ahead of its feet" in fault.text
    heavy = {**biped["nodes"], "tail": {"at": [0, 1.2], "radius": 0.2}}
    balanced = {**biped, "nodes": heavy}
    assert not [remark for remark in remarks(balanced) if "ahead of" in remark.text]


def test_loose_nodes() -> None:
    loose = with_nodes(dog(), {"bell": [0, -2.0]})
    assert only_fault(loose).text == "'bell' is not connected to the rest and ignored"


def test_a_loop_beside_the_midline() -> None:
    ring = {"ring1": [-0.2, -1.2], "ring2": [-0.3, -1.3], "ring3": [-0.1, -1.4]}
    fault = only_fault(with_nodes(dog(), ring, ["nose", "ring1", "ring2", "ring3", "ring1"]))
    assert fault.text.startswith("the loops of 'ring1', 'ring2', 'ring3' and of 'ring1_m', ")
    assert "beside the midline" in fault.text


def test_nodes_on_top_of_one_another() -> None:
    twice = with_nodes(dog(), {"chest2": [0, -0.4], "hump": [0, -0.1]}, ["rump", "hump", "chest2"])
    assert any(
        "'chest' and 'chest2' are at the same place and not connected" in remark.text
        for remark in remarks(twice)
        if remark.is_fault
    )
    close = with_nodes(dog(), {"tip": [0, 0.8005]}, ["tail", "tip"])
    assert "are joined and only 0.0005 m apart" in only_fault(close).text


@pytest.mark.parametrize(
    "path", sorted((library() / "figures").glob("*.yaml")), ids=lambda p: p.stem
)
def test_shipped_figures_have_no_faults(path: Any) -> None:
    scene, (name,) = load_figures(str(path))
    figure = build_figure(name, scene.figures[name], 1.0)
    assert [remark for remark in check_figure(figure) if remark.is_fault] == []


def filmed(figure: dict[str, Any], *members: dict[str, Any]) -> Take:
    """Return the take of two frames of creatures of one figure."""
    cast = [{"figure": "dog", **member} for member in members]
    words = {"pronk": 1, "frames": 2, "figures": {"dog": figure}, "cast": cast}
    return simulate(Scene.model_validate(words))


def test_a_take_notes_faults_once_for_each_figure() -> None:
    take = filmed(dog(hind=0.7), {"name": "rex"}, {"name": "bello", "at": [3, 0]})
    (note,) = [note for note in take.notes if note.kind == "drawn"]
    assert (note.step, note.part) == (0, "rex.foot2")
    assert "float" in note.text
    assert not [note for note in filmed(dog(), {"name": "rex"}).notes if note.kind == "drawn"]


def test_horns_hardly_move_while_walking() -> None:
    horned = with_nodes(dog(), {"horn": [-0.05, -0.85]}, ["nose", "horn"])
    horned = with_nodes(horned, {"snout": [0, -1.1]}, ["nose", "snout"])
    words = {"pronk": 1, "duration": 2, "figures": {"dog": horned}}
    words["cast"] = [{"name": "rex", "figure": "dog", "walk": {}}]
    take = simulate(Scene.model_validate(words))
    columns = [i for i, channel in enumerate(take.channels) if "rex.horn" in channel.name]
    assert len(columns) == 6
    assert (take.values[:, columns].max(axis=0) - take.values[:, columns].min(axis=0)).max() < 0.02
