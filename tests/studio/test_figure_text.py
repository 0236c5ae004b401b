"""Figure files with the editor's changes in them, everything else byte for byte."""

from __future__ import annotations

import difflib
from dataclasses import replace

import pytest

from pipeline.errors import SceneError, UsageError
from pipeline.spec import library
from pipeline.studio.drawing import DrawnFigure, DrawnNode
from pipeline.studio.figure_text import NEW_FIGURE, figure_of_text, rounded, updated_text
from pipeline.studio.yaml_pieces import number_text

FIGURES = sorted((library() / "figures").glob("*.yaml"))
BEETLE = (library() / "figures" / "beetle.yaml").read_text(encoding="utf-8")


def changed_lines(before: str, after: str) -> list[str]:
    lines = difflib.ndiff(before.splitlines(), after.splitlines())
    return [line for line in lines if line[0] in "+-"]


def drawn(text: str) -> DrawnFigure:
    return DrawnFigure.of(figure_of_text(text))


@pytest.mark.sample(4)
@pytest.mark.parametrize("file", FIGURES, ids=lambda file: file.stem)
def test_a_figure_of_the_library_that_was_not_changed_is_the_same_text(file) -> None:
    text = file.read_bytes().decode()
    drawing = DrawnFigure.from_json(drawn(text).as_json())
    assert updated_text(text, drawing) == text


@pytest.mark.sample(4)
@pytest.mark.parametrize("file", FIGURES, ids=lambda file: file.stem)
def test_a_moved_node_changes_its_line_alone(file) -> None:
    text = file.read_bytes().decode()
    drawing = drawn(text)
    name, node = next(iter(drawing.nodes.items()))
    moved = DrawnNode((node.at[0], node.at[1] + 0.0123), node.radius)
    after = updated_text(text, replace(drawing, nodes={**drawing.nodes, name: moved}))
    lines = changed_lines(text, after)
    assert [line[0] for line in lines] == ["-", "+"]
    assert f"{name}:" in lines[1]
    assert drawn(after).nodes[name].at[1] == pytest.approx(node.at[1] + 0.0123)


@pytest.mark.sample(4)
@pytest.mark.parametrize("file", FIGURES, ids=lambda file: file.stem)
def test_a_new_limb_adds_lines_and_removing_it_gives_the_text_back(file) -> None:
    text = file.read_bytes().decode()
    drawing = drawn(text)
    first = next(iter(drawing.nodes))
    more = replace(
        drawing,
        nodes={**drawing.nodes, "stub": DrawnNode((0.71, 0.72), 0.05)},
        chains=(*drawing.chains, (first, "stub")),
    )
    after = updated_text(text, more)
    assert [line[0] for line in changed_lines(text, after)] == ["+", "+"]
    assert updated_text(after, drawing) == text


def test_comments_and_line_ends_stay() -> None:
    text = BEETLE.replace("\n", "\r\n")
    drawing = drawn(text)
    nodes = {**drawing.nodes, "knee1_l": DrawnNode((-0.7, -0.9), 0.1)}
    after = updated_text(text, replace(drawing, nodes=nodes))
    assert after.count("\r\n") == after.count("\n") == text.count("\n")
    assert "# Hips join in a ring" in after
    assert "knee1_l:   {at: [-0.70, -0.90], radius: 0.100, material: brown chitin}" in after


@pytest.mark.parametrize(
    ("before", "value", "after"),
    [
        *(("1.40", 1.5, "1.50"), ("-0.5", 0.0, "0.0"), ("2", 1.0, "1"), ("1e-1", 0.5, "0.5")),
        *(("0.10", 0.12345, "0.1235"), ("", 0.25, "0.25"), ("1.00000", 2.0, "2")),
    ],
)
def test_a_number_keeps_the_decimals_it_was_written_with(before, value, after) -> None:
    assert number_text(value, before) == after


def test_a_deleted_node_takes_its_line_and_its_place_in_chains() -> None:
    drawing = drawn(BEETLE)
    nodes = {name: node for name, node in drawing.nodes.items() if name != "rump"}
    chains = (drawing.chains[0][:-1], *drawing.chains[1:])
    after = updated_text(BEETLE, replace(drawing, nodes=nodes, chains=chains))
    assert [line[0] for line in changed_lines(BEETLE, after)] == ["-", "-", "+"]


def test_a_node_without_radius_gets_one() -> None:
    text = "pronk: 1\nfigure:\n  nodes:\n    a: [0, 0]  # front\n    b: {at: [0, 1]}\n    c:\n"
    text += "      at: [0, 2]\n      material: horn\n  chains: [[a, b, c]]\n"
    drawing = drawn(text)
    nodes = {name: DrawnNode(node.at, 0.2) for name, node in drawing.nodes.items()}
    after = updated_text(text, replace(drawing, nodes=nodes))
    assert "    a: {at: [0, 0], radius: 0.2}  # front\n    b: {at: [0, 1], radius: 0.2}\n" in after
    assert "      at: [0, 2]\n      radius: 0.2\n      material: horn\n" in after


def test_settings_parts_and_mirroring_are_set_and_taken_back() -> None:
    drawing = drawn(BEETLE)
    other = replace(
        drawing,
        is_mirrored=False,
        parts={"foot1_l": "arm"},
        settings={"style": "mammal", "feet": "paws"},
    )
    after = updated_text(BEETLE, other)
    assert rounded(drawn(after)) == rounded(other)
    assert "mirror" not in after.split("figure:")[1]
    again = updated_text(after, drawing)
    assert rounded(drawn(again)) == rounded(drawing)
    none = updated_text(after, replace(other, parts={}))
    assert "parts" not in none


def test_a_new_file_is_written_from_nothing() -> None:
    drawing = DrawnFigure(
        {
            "chest": DrawnNode((0.0, -0.5), 0.2),
            "rump": DrawnNode((0.0, 0.5), 0.2),
            "foot_l": DrawnNode((-0.8, -0.5), None),
        },
        (("chest", "rump"), ("chest", "foot_l")),
        True,
        {},
        {"style": "mammal"},
    )
    text = updated_text(NEW_FIGURE, drawing)
    assert drawn(text) == drawing
    assert text == (
        "# A figure, drawn from above: head up, tail down, legs to the sides [m].\n"
        "pronk: 1\nfigure:\n  style: mammal\n  nodes:\n    chest: {at: [0, -0.5], radius: 0.2}\n"
        "    rump: {at: [0, 0.5], radius: 0.2}\n    foot_l: [-0.8, -0.5]\n  chains:\n"
        "    - [chest, rump]\n    - [chest, foot_l]\n  then:\n    - mirror: x\n"
    )


HORSE = (library() / "figures" / "horse.yaml").read_text(encoding="utf-8")


def test_a_joint_that_is_changed_changes_its_value_alone() -> None:
    drawing = drawn(HORSE)
    head = {**drawing.joints["head"], "base_pitch": {"rest_deg": 40.0, "limits_deg": [-40, 75.5]}}
    joints = {**drawing.joints, "head": head, "l1": {"base_yaw": {"rest_deg": -3.0}}}
    changed = replace(drawing, joints=joints, masses={"l1": 31.5})
    after = updated_text(HORSE, changed)
    assert changed_lines(HORSE, after) == [
        "+   masses: {l1: 31.5}",
        "-       base_pitch: {rest_deg: 46, limits_deg: [-40, 70]}",
        "+       base_pitch: {rest_deg: 40, limits_deg: [-40, 75.5]}",
        "+     l1:",
        "+       base_yaw: {rest_deg: -3}",
    ]
    assert updated_text(after, drawing) == HORSE


def test_joints_are_written_from_nothing_and_taken_back() -> None:
    drawing = drawn(BEETLE)
    joints = {"l1": {"base_pitch": {"rest_deg": 3.5}}, "r1": {"base_pitch": {"rest_deg": 3.5}}}
    after = updated_text(BEETLE, replace(drawing, joints=joints))
    assert "  joints:\n    l1:\n      base_pitch: {rest_deg: 3.5}\n    r1:\n" in after
    assert updated_text(after, drawing) == BEETLE


def test_values_of_a_mapping_in_one_line_come_and_go() -> None:
    text = "pronk: 1\nfigure:\n  nodes:\n    a: [0, 0]\n    b: [0, 1]\n  chains: [[a, b]]\n"
    text += "  masses: {body: 3}  # heavy\n"
    drawing = drawn(text)
    more = updated_text(text, replace(drawing, masses={"body": 3.0, "tail": 0.25}))
    assert more == text.replace("3}", "3, tail: 0.25}")
    less = updated_text(more, replace(drawing, masses={"tail": 0.5}))
    assert less == text.replace("{body: 3}", "{tail: 0.5}")


def test_joints_that_share_values_are_refused_and_not_damaged() -> None:
    crab = (library() / "figures" / "crab.yaml").read_text(encoding="utf-8")
    drawing = drawn(crab)
    own = {**drawing.joints, "feeler_r1": {"base_pitch": {"rest_deg": 20.0}}}
    with pytest.raises(UsageError, match="aliases"):
        updated_text(crab, replace(drawing, joints=own))


def test_shared_values_are_refused_and_not_damaged() -> None:
    text = "pronk: 1\nfigure:\n  nodes:\n    a: {at: &p [0, 0], radius: 1}\n"
    text += "    b: {at: [0, 3]}\n    c: {at: *p}\n  chains: [[a, b]]\n"
    drawing = drawn(text)
    nodes = {**drawing.nodes, "c": DrawnNode((1.0, 1.0))}
    with pytest.raises(UsageError, match="aliases"):
        updated_text(text, replace(drawing, nodes=nodes))


def test_a_drawing_that_is_no_figure_is_refused_with_its_reason() -> None:
    drawing = drawn(BEETLE)
    with pytest.raises(SceneError, match="no node is called 'nobody'"):
        updated_text(BEETLE, replace(drawing, chains=(*drawing.chains, ("head", "nobody"))))


@pytest.mark.parametrize("message", [None, [], {}, {"nodes": {"a": {}}, "chains": []}])
def test_a_message_without_a_drawing_is_refused(message: object) -> None:
    with pytest.raises(UsageError, match="no drawing"):
        DrawnFigure.from_json(message)


def test_a_last_line_without_an_end_is_kept_apart() -> None:
    text = BEETLE.rstrip("\n")
    drawing = drawn(text)
    nodes = {**drawing.nodes, "tip": replace(drawing.nodes["head"], at=(0.0, -3.0))}
    after = updated_text(
        text, replace(drawing, nodes=nodes, chains=(*drawing.chains, ("head", "tip")))
    )
    assert after == updated_text(
        BEETLE, replace(drawing, nodes=nodes, chains=(*drawing.chains, ("head", "tip")))
    )
