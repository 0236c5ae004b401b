"""Figure sheets: the report on a figure and its picture."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pipeline.errors import SceneError, UsageError
from pipeline.production.reports.canvas import Panel
from pipeline.production.reports.figure_drawing import FRONT, SIDE, StandingFigure
from pipeline.production.reports.figure_report import report
from pipeline.production.reports.figure_sheet import (
    drawn_figures,
    figure_sheet,
    figure_svg,
    figures_of,
)
from pipeline.production.reports.plot_files import png_of
from pipeline.production.shots.solid_preview import PreviewSolid, render_preview
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.solids import ball_solid

SCENE = """\
pronk: 1
frames: 1
figures:
  worm: {nodes: {a: [0, 0], b: [0, 1], c: [0, 2], x: [4, 4]}, chains: [[a, b, c]]}
  dot: {nodes: {p: [0, 0], q: [1, 0]}, chains: [[p, q]]}
cast: [{name: eel, figure: worm}, {figure: beetle}]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, which holds a scene."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "play.yaml").write_text(SCENE)
    return tmp_path


@pytest.fixture(scope="module")
def beetle() -> Figure:
    """Return the shipped beetle."""
    return figures_of("beetle")[0]


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("beetle", ["beetle"]),
        ("play.yaml", ["worm", "dot", "beetle"]),
        ("play", ["worm", "dot", "beetle"]),
        ("play.yaml:worm", ["worm"]),
        ("play:eel", ["worm"]),
        ("play:dot", ["dot"]),
        ("first_steps", ["beetle"]),
    ],
)
def test_a_name_selects_figures(folder: Path, name: str, found: list[str]) -> None:
    assert [figure.name for figure in figures_of(name)] == found


def test_local_files_come_before_the_library(folder: Path) -> None:
    (folder / "figures").mkdir()
    own = "pronk: 1\nfigure: {nodes: {a: [0, 0], b: [0, 1]}, chains: [[a, b]]}\n"
    (folder / "figures" / "beetle.yaml").write_text(own)
    assert figures_of("beetle")[0].drawing.names == ("a", "b")
    assert figures_of("figures/beetle.yaml")[0].drawing.names == ("a", "b")


@pytest.mark.parametrize(
    ("name", "phrase"),
    [
        ("beatle", "did you mean 'beetle'?"),
        ("play:wurm", "no figure is called 'wurm', did you mean 'worm'?"),
        ("plya:worm", "no scene is called 'plya'"),
        ("a\0b", "no figure or scene is called 'a\\x00b'"),
    ],
)
def test_unknown_names_are_refused(folder: Path, name: str, phrase: str) -> None:
    with pytest.raises(UsageError, match="called") as caught:
        figures_of(name)
    assert phrase in str(caught.value)


def test_an_invalid_figure_is_refused_at_its_line(folder: Path) -> None:
    text = "pronk: 1\nfigure:\n  nodes: {a: [0, 0], b: [0, 1], c: [1, 0]}\n"
    text += "  chains: [[a, b, c, a]]\n  parts: {b: leg}\n"
    (folder / "ring.yaml").write_text(text)
    with pytest.raises(SceneError) as caught:
        figures_of("ring")
    (problem,) = caught.value.problems
    assert (problem.file, problem.line, problem.column) == ("ring.yaml", 5, 11)
    assert "'b' is on a loop" in problem.message


def test_the_report_has_all_parts(folder: Path, beetle: Figure) -> None:
    lines = report(beetle, FigureMass(beetle)).splitlines()
    assert lines[0].startswith("beetle: insect, 6 legs, 1 head, 1 tail, 2 feelers, 47 joints")
    for limb in beetle.skeleton.limbs:
        (line,) = [line for line in lines if line.split()[0] == limb.name and " link" in line]
        assert f"{limb.kind}, {len(limb.links)} link" in line
    assert any("hip1_l - knee1_l - ankle1_l - foot1_l" in line for line in lines)
    (table,) = [i for i, line in enumerate(lines) if line.split()[:2] == ["taken", "for"]]
    assert lines[table + 1].endswith("l1 (foot1_l), r1 (foot1_r)")
    assert any(line.split()[0] == "feeler" and "parts says so" in line for line in lines[table:])
    (worm,) = drawn_figures("play:worm")
    text = report(worm.figure, FigureMass(worm.figure), worm.remarks)
    assert "ignored     x" in text
    assert "warning     play.yaml:4: 'x' is not connected to the rest and ignored" in text


@pytest.mark.nightly
def test_the_svg_labels_all_parts(beetle: Figure) -> None:
    svg = figure_svg(beetle)
    texts = [element.text for element in ET.fromstring(svg).iter() if element.tag.endswith("text")]
    for limb in beetle.skeleton.limbs:
        # In the drawing, in the list of parts, and at least in one of the views.
        assert texts.count(limb.name) >= 3, limb.name
    assert set(beetle.drawing.names) & set(texts) >= {"thorax", "knee1_l", "foot3_r"}
    assert svg == figure_svg(beetle), "the same figure gives the same picture"


@pytest.mark.nightly
def test_the_png_shows_the_svg_with_its_texts(beetle: Figure) -> None:
    svg = figure_svg(beetle)
    picture = np.asarray(Image.open(io.BytesIO(png_of(svg))).convert("RGB")).astype(int)
    assert picture.shape[1] == 2400
    # The name of the figure stands in the upper left, dark on light.
    assert (picture[30:80, 50:180].sum(axis=-1) < 250).mean() > 0.05
    without = svg.replace(">beetle</text>", "></text>")
    bare = np.asarray(Image.open(io.BytesIO(png_of(without))).convert("RGB")).astype(int)
    assert (bare[30:80, 50:180].sum(axis=-1) < 250).mean() == 0


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["play:worm", "play:dot", "tripod", "hopper", "person"])
def test_figures_of_all_kinds_are_drawn(folder: Path, name: str) -> None:
    (drawn,) = drawn_figures(name)
    sheet = figure_sheet(drawn, folder / "sheets")
    assert [file.suffix for file in sheet.files] == [".svg", ".png"]
    assert all(file.stat().st_size > 5_000 for file in sheet.files)


def test_a_figure_stands_on_the_ground_and_is_seen_whole(beetle: Figure) -> None:
    standing = StandingFigure(beetle)
    assert standing.ground == pytest.approx(standing.bounds(SIDE)[0][1])
    low, high = standing.bounds(FRONT)
    assert low[0] == pytest.approx(-high[0], rel=1e-2), "a beetle has two equal sides"
    # From the side, the head is on the right.
    head = [limb.name for limb in beetle.skeleton.limbs].index("head")
    assert (standing.tips @ SIDE[0])[head] > 0


def test_a_ball_is_seen_as_a_disc_lit_from_above() -> None:
    solid = ball_solid(np.zeros(3), 40.0)
    vertices = solid.vertices * [1.0, -1.0, 1.0] + [50.0, 50.0, 0.0]
    faces = [PreviewSolid(vertices, solid.faces, np.array([0.2, 0.5, 0.8]), 0)]
    picture = render_preview(faces, (100, 100), np.ones(3))
    covered = (picture < 0.999).any(axis=-1)
    assert covered.sum() == pytest.approx(np.pi * 40**2, rel=0.06)
    assert covered[50, 15]
    assert not covered[5, 5]
    assert picture[25, 50].sum() > 1.2 * picture[75, 50].sum()


def test_the_nearer_ball_hides_the_other() -> None:
    solid = ball_solid(np.zeros(3), 20.0)
    upright = solid.vertices * [1.0, -1.0, 1.0]
    red, blue = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    near = PreviewSolid(upright + np.array([40.0, 40.0, 30.0]), solid.faces, red, 0)
    far = PreviewSolid(upright + np.array([50.0, 40.0, -30.0]), solid.faces, blue, 1)
    for order in ([near, far], [far, near]):
        picture = render_preview(order, (100, 80), np.ones(3))
        assert picture[40, 45, 0] > picture[40, 45, 2]
        assert picture[40, 66, 2] > picture[40, 66, 0]


def test_panels_contain_and_overlap_others() -> None:
    panel = Panel(0, 0, 10, 10)
    assert panel.contains(Panel(1, 1, 9, 9))
    assert not panel.contains(Panel(1, 1, 10, 9))
    assert panel.overlaps(Panel(9, 9, 5, 5))
    assert not panel.overlaps(Panel(10, 0, 5, 5))
