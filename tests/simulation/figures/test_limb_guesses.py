"""Limb guesses: ten animals as newcomers draw them, and what their limbs are taken for."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.spec import Figure as FigureConfig
from pipeline.spec import load_figures
from pipeline.spec.scene_library import library

Nodes = dict[str, tuple[float, float]]


def animal(
    style: str, spine: Nodes, *limbs: tuple[str, Nodes], **keys: Any
) -> Mapping[str, object]:
    """Return a figure with a spine on the midline, and limbs, as base and nodes, on both sides."""
    nodes = {name: list(at) for name, at in spine.items()}
    chains = [list(spine)]
    for base, limb in limbs:
        nodes |= {name: list(at) for name, at in limb.items()}
        chains.append([base, *limb])
    return {"style": style, "nodes": nodes, "chains": chains, "then": [{"mirror": "x"}], **keys}


def leg(number: int, y: float, length: float = 0.9) -> Nodes:
    """Return a straight leg to the left."""
    return {f"knee{number}": (-length / 2, y), f"foot{number}": (-length, y)}


GOAT = animal(
    "mammal",
    {"nose": (0, -1.2), "head": (0, -0.9), "chest": (0, -0.4), "rump": (0, 0.4), "tail": (0, 0.6)},
    ("head", {"horn": (-0.1, -0.75)}),
    ("head", {"ear": (-0.2, -0.85)}),
    ("chest", leg(1, -0.4)),
    ("rump", leg(2, 0.4)),
)
DEER = animal(
    "mammal",
    {"nose": (0, -1.2), "head": (0, -0.9), "chest": (0, -0.4), "rump": (0, 0.5)},
    ("head", {"beam": (-0.15, -0.7), "tine1": (-0.3, -0.6)}),
    ("beam", {"tine2": (-0.05, -0.55)}),
    ("chest", leg(1, -0.4, 1.0)),
    ("rump", leg(2, 0.5, 1.0)),
)
UNICORN = animal(
    "mammal",
    {"nose": (0, -1.3), "head": (0, -0.95), "chest": (0, -0.4), "rump": (0, 0.4), "tail": (0, 0.9)},
    ("head", {"horn": (0, -1.15)}),
    ("chest", leg(1, -0.4)),
    ("rump", leg(2, 0.4)),
)
BIRD = animal(
    "mammal",
    {"beak": (0, -0.7), "head": (0, -0.55), "body": (0, 0), "rump": (0, 0.3), "tail": (0, 0.8)},
    ("body", {"wing1": (-0.4, -0.1), "wing2": (-0.9, 0.1)}),
    ("rump", {"knee": (-0.2, 0.15), "foot": (-0.5, 0.15), "toe1": (-0.58, 0.08)}),
    ("foot", {"toe2": (-0.57, 0.2)}),
)
DINOSAUR = animal(
    "mammal",
    {"jaw": (0, -1.6), "neck": (0, -1.1), "chest": (0, -0.6), "rump": (0, 0.2), "tail": (0, 1.6)},
    ("chest", {"elbow": (-0.2, -0.6), "hand": (-0.35, -0.7)}),
    ("rump", leg(1, 0.2, 1.1)),
)
ANT = animal(
    "insect",
    {"head": (0, -0.8), "neck": (0, -0.5), "chest": (0, 0), "waist": (0, 0.4), "rump": (0, 1.0)},
    ("head", {"feeler1": (-0.2, -1.1), "feeler2": (-0.35, -1.4)}),
    ("neck", {"knee1": (-0.5, -0.7), "foot1": (-0.9, -0.9)}),
    ("chest", {"knee2": (-0.5, 0.0), "foot2": (-1.0, 0.0)}),
    ("waist", {"knee3": (-0.5, 0.6), "foot3": (-0.9, 0.9)}),
)
LOBSTER = animal(
    "insect",
    {"head": (0, -0.8), "chest": (0, 0), "back": (0, 0.5), "tail1": (0, 0.9), "tail2": (0, 1.3)},
    ("head", {"antenna": (-0.2, -1.6)}),
    ("head", {"arm": (-0.5, -0.9), "claw": (-0.6, -1.5)}),
    ("chest", leg(1, -0.3, 0.8)),
    ("chest", leg(2, 0.0, 0.8)),
    ("back", leg(3, 0.6, 0.8)),
)
SPIDER = animal(
    "insect",
    {"front": (0, -0.3), "middle": (0, 0), "hind": (0, 0.3), "rear": (0, 0.9)},
    ("front", {"knee1": (-0.4, -0.8), "foot1": (-0.7, -1.2)}),
    ("middle", {"knee2": (-0.6, -0.3), "foot2": (-1.1, -0.4)}),
    ("middle", {"knee3": (-0.6, 0.2), "foot3": (-1.1, 0.4)}),
    ("hind", {"knee4": (-0.4, 0.8), "foot4": (-0.7, 1.3)}),
)
DRAGONFLY = animal(
    "insect",
    {"head": (0, -0.6), "chest": (0, -0.2), "back": (0, 0.1), "end": (0, 1.4)},
    ("chest", {"wing1": (-1.3, -0.4)}),
    ("back", {"wing2": (-1.3, 0.2)}),
    ("chest", leg(1, -0.35, 0.5)),
    ("chest", leg(2, -0.1, 0.5)),
    ("back", leg(3, 0.3, 0.5)),
)
SNAKE = animal(
    "insect",
    {"head": (0, -1.5), "neck": (0, -1.0), "middle": (0, 0), "back": (0, 1.0), "tail": (0, 1.5)},
    ("head", {"tongue": (-0.05, -1.65)}),
)

EXPECTED = {
    "goat": (GOAT, {"leg": 4, "head": 1, "tail": 1, "horn": 4}),
    "deer": (DEER, {"leg": 4, "head": 1, "horn": 4}),
    "unicorn": (UNICORN, {"leg": 4, "head": 1, "tail": 1, "horn": 1}),
    "bird": (BIRD, {"leg": 2, "head": 1, "tail": 1, "wing": 2}),
    "dinosaur": (DINOSAUR, {"leg": 2, "arm": 2, "head": 1, "tail": 1}),
    "ant": (ANT, {"leg": 6, "head": 1, "tail": 1, "feeler": 2}),
    "lobster": (LOBSTER, {"leg": 6, "arm": 2, "tail": 1, "feeler": 2}),
    "spider": (SPIDER, {"leg": 8, "tail": 1}),
    "dragonfly": (DRAGONFLY, {"leg": 6, "wing": 4, "head": 1, "tail": 1}),
    "snake": (SNAKE, {"head": 1, "tail": 1, "feeler": 2}),
}


def built(words: Mapping[str, object]) -> Figure:
    """Return a figure at the size it is drawn in."""
    return build_figure("it", FigureConfig.model_validate(words), 1.0)


def kinds_of(figure: Figure) -> dict[str, str]:
    """Return the kinds of limbs by their tips."""
    names = figure.drawing.names
    return {names[a.nodes[-1]]: a.kind for a in figure.anatomy.appendages}


@pytest.mark.parametrize("name", EXPECTED)
def test_limbs_are_what_their_drawer_meant(name: str) -> None:
    words, kinds = EXPECTED[name]
    figure = built(words)
    assert dict(Counter(kinds_of(figure).values())) == kinds
    assert all(appendage.reason for appendage in figure.anatomy.appendages)


def test_limbs_of_both_sides_are_of_one_kind() -> None:
    for name, (words, _) in EXPECTED.items():
        kinds = kinds_of(built(words))
        assert all(kinds[tip] == kinds[f"{tip}_m"] for tip in kinds if f"{tip}_m" in kinds), name


def test_horns_leave_the_neck_flexible() -> None:
    figure = built(GOAT)
    (head,) = [limb for limb in figure.skeleton.limbs if limb.kind == "head"]
    assert [figure.drawing.names[n] for n in figure.anatomy.of_kind("head")[0].nodes] == [
        "chest",
        "head",
        "nose",
    ]
    X = JointTree.of(figure.skeleton).pose(figure.skeleton.preferred)
    last = head.joints[-1]
    poll = X[last, :3, 3]
    assert poll[1] > 0.3, "a mammal's neck is held up"
    muzzle = poll + X[last, :3, :3] @ (head.tip - figure.skeleton.places[last])
    assert muzzle[1] < poll[1], "and its head nods"


def test_tines_hang_on_their_antler() -> None:
    figure = built(DEER)
    names = figure.drawing.names
    horns = {names[a.nodes[-1]]: names[a.nodes[0]] for a in figure.anatomy.of_kind("horn")}
    assert horns == {"tine1": "head", "tine1_m": "head", "tine2": "beam", "tine2_m": "beam_m"}


def test_toes_are_left_out_with_a_hint() -> None:
    figure = built(BIRD)
    left_out = [figure.drawing.names[n] for n in figure.anatomy.ignored]
    assert sorted(left_out) == ["toe2", "toe2_m"]
    assert any("'toe2' is a toe" in str(remark) for remark in figure.anatomy.warnings)
    assert kinds_of(figure)["toe1"] == "leg"


@pytest.mark.parametrize("kind", ["leg", "feeler", "wing", "arm"])
def test_parts_come_before_guesses(kind: str) -> None:
    figure = built({**GOAT, "parts": {"horn": kind, "horn_m": kind}})
    kinds = kinds_of(figure)
    assert kinds["horn"] == kinds["horn_m"] == kind
    assert kinds["ear"] == "horn"
    reasons = {a.reason for a in figure.anatomy.appendages if a.kind == kind}
    assert "parts says so" in reasons


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(ValueError, match="horn"):
        FigureConfig.model_validate({**GOAT, "parts": {"horn": "antler"}})


def test_feet_of_legs_on_the_midline_stand_apart() -> None:
    figure = built({**GOAT, "radius": 0.2})
    tree = JointTree.of(figure.skeleton)
    X = tree.pose(figure.skeleton.preferred)
    feet = {}
    for limb in figure.skeleton.legs:
        last = limb.joints[-1]
        feet[limb.name] = X[last, :3, 3] + X[last, :3, :3] @ (limb.tip - tree.places[last])
    assert feet["r1"][2] == pytest.approx(0.14, abs=0.02)
    assert feet["l1"][2] == pytest.approx(-feet["r1"][2])


def test_an_author_who_poses_a_neck_starts_from_a_level_one() -> None:
    posed = built({**GOAT, "joints": {"head": {"joint1_bend": {"rest_deg": -20}}}})
    number = posed.skeleton.joint_names.index("head.base_pitch")
    assert np.degrees(posed.skeleton.preferred[number]) == pytest.approx(-8.0)


def test_horns_stand_however_they_are_drawn() -> None:
    for tip in ((-0.02, -1.2), (-0.2, -0.9), (-0.05, -0.7)):
        nodes = {**GOAT["nodes"], "horn": list(tip)}  # type: ignore[dict-item]
        figure = built({**GOAT, "nodes": nodes})
        (horn, _) = [
            limb
            for limb, a in zip(figure.skeleton.limbs, figure.anatomy.appendages, strict=True)
            if figure.drawing.names[a.nodes[-1]].startswith("horn")
        ]
        X = JointTree.of(figure.skeleton).pose(figure.skeleton.preferred)
        last = horn.joints[-1]
        along = X[last, :3, :3] @ (horn.tip - figure.skeleton.places[last])
        assert along[1] > 0.5 * np.linalg.norm(along), tip


def test_shipped_figures_have_the_limbs_that_they_were_drawn_with() -> None:
    limbs = {}
    for path in sorted((library() / "figures").glob("*.yaml")):
        scene, (name,) = load_figures(str(path))
        figure = build_figure(name, scene.figures[name], 1.0)
        limbs[name] = dict(Counter(a.kind for a in figure.anatomy.appendages))
        assert not figure.anatomy.ignored
    four_legs = {"leg": 4, "head": 1, "tail": 1}
    assert limbs == {
        "ant": {"leg": 6, "head": 1, "tail": 1, "feeler": 2},
        "antelope": four_legs | {"feeler": 4},
        "beetle": {"leg": 6, "head": 1, "tail": 1, "feeler": 2},
        "camel": four_legs | {"feeler": 2},
        "cat": four_legs | {"feeler": 2},
        "centipede": {"leg": 20, "head": 1, "feeler": 2},
        "crab": {"leg": 8, "head": 1, "feeler": 2},
        "dog": four_legs | {"feeler": 2},
        "elephant": four_legs | {"feeler": 5},
        "frog": {"leg": 4, "head": 1},
        "giraffe": four_legs | {"feeler": 2, "horn": 2},
        "lizard": four_legs,
        "mouse": four_legs | {"feeler": 2},
        "hopper": {"leg": 1, "head": 1},
        "horse": four_legs | {"feeler": 2},
        "inchworm": {"head": 1, "tail": 1},
        "kangaroo": {"leg": 2, "arm": 2, "head": 1, "tail": 1, "feeler": 2},
        "ostrich": {"leg": 2, "head": 1, "tail": 1},
        "person": {"leg": 2, "arm": 2, "head": 1},
        "robot_arm": {"arm": 1},
        "scorpion": {"leg": 8, "tail": 1, "feeler": 2},
        "spider": {"leg": 8, "head": 1, "tail": 1},
        "tripod": {"leg": 3},
    }


def test_a_twig_that_is_named_body_stays_body() -> None:
    figure = built({**GOAT, "parts": {"horn": "body"}})
    assert "horn" in [figure.drawing.names[n] for n in figure.anatomy.body]
    with pytest.raises(SceneError, match="no tip"):
        built({**GOAT, "parts": {"chest": "horn"}})
