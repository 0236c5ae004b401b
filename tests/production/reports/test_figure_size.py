"""Sizes of figures, as `pronk list figures` and `pronk check` tell them."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.production.reports.figure_sheet import figures_of
from pipeline.production.reports.figure_size import FigureSize, listed_names
from pipeline.production.run.scene_check import check_scene
from pipeline.simulation.figure_analysis import build_figure
from pipeline.spec import library, read_scene
from pipeline.spec.name_catalogue import OWN_GROUP

CUBE = "pronk: 1\nfigure: {nodes: {a: [0, -1], b: [0, 1]}, chains: [[a, b]], radius: 0.25}\n"


def test_size_is_that_of_the_standing_solids_and_goes_with_the_scale() -> None:
    beetle = figures_of("beetle")[0]
    scene = read_scene("pronk: 1\nframes: 1\ncast: [{figure: beetle}]\n")
    half = FigureSize.of(build_figure("beetle", scene.figures["beetle"], 0.5))
    size = FigureSize.of(beetle)
    assert (size.length, size.width, size.height) == pytest.approx((2.896, 2.464, 1.023), abs=1e-3)
    assert (half.length, half.height) == pytest.approx((size.length / 2, size.height / 2), rel=1e-3)
    assert half.mass == pytest.approx(size.mass / 8, rel=1e-2)
    assert size.text == "2.90 m long, 2.46 m wide, 1.02 m high, 6 legs, 1389 kg"


def test_own_figures_are_listed_with_their_size_and_wrong_ones_with_what_to_do(
    tmp_path: Path,
) -> None:
    (tmp_path / "figures").mkdir()
    (tmp_path / "stick.yaml").write_text(CUBE)
    (tmp_path / "figures" / "beetle.yaml").write_text("# Own.\n" + CUBE)
    (tmp_path / "wrong.yaml").write_text(
        "pronk: 1\nfigure: {nodes: {a: [0, 0]}, chains: [[b, c]]}\n"
    )
    own = {
        listed.entry.name: listed
        for listed in listed_names("figures", tmp_path)
        if listed.entry.group == OWN_GROUP
    }
    for name in ("stick", "beetle"):
        assert own[name].size is not None
        assert own[name].facts["length"] == pytest.approx(2.5, abs=0.1)
        assert own[name].facts["legs"] == 0
    assert own["wrong"].size is None
    assert "`pronk figure wrong` says why" in own["wrong"].text


def test_check_tells_the_size_of_creatures_at_their_scale() -> None:
    scene = read_scene("pronk: 1\nframes: 1\ncast: [{name: bug, figure: beetle, scale: 0.1}]\n")
    assert "bug (beetle, 0.29 m long, 0.1 m high)" in check_scene(scene)


def test_every_figure_of_the_library_is_listed_with_a_size() -> None:
    listed = list(listed_names("figures", library()))
    assert all(one.size is not None and one.size.height > 0.05 for one in listed)


def test_check_names_walkers_whose_poses_need_simulation() -> None:
    pose = "pose: [{at: 0.2, limb: l1, frame: body, reach: [1, 0, -1]}]"
    texts = [
        check_scene(
            read_scene(f"pronk: 1\nduration: 0.3\ncast: [{{name: bug, figure: beetle, {keys}}}]\n")
        )
        for keys in (f"{pose}, walk: {{}}", pose, "walk: {}")
    ]
    told = "--simulate also checks the pose keys of 'bug'"
    assert [told in text for text in texts] == [True, False, False]
