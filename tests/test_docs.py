"""Documented scenes are valid, and links of the pages lead to files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pipeline.production.reports.figure_sheet import drawn_figures
from pipeline.production.reports.figure_size import size_table
from pipeline.simulation.figure_analysis import check_figure
from pipeline.spec import read_scene
from pipeline.spec.events import event_table
from pipeline.spec.key_table import order_key_table, terrain_tables
from pipeline.spec.terrain.base import TERRAIN_KINDS
from pipeline.spec.verbs import verb_table

ROOT = Path(__file__).parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
BLOCK = re.compile(r"```yaml\n(.*?)```", re.DOTALL)
WALKER = "cast: [{name: mare, figure: horse, walk: {}}]\n"


def blocks() -> list[tuple[str, str]]:
    """Return (name, YAML text) of the scenes in the README and the pages on the language."""
    found = []
    pages = ("README.md", "docs/scenes.md", "docs/scripts.md", "docs/stories.md")
    for page in map(ROOT.joinpath, pages):
        texts = BLOCK.findall(page.read_text(encoding="utf-8"))
        found += [(f"{page.name} {n}", text) for n, text in enumerate(texts, start=1)]
    return found


@pytest.mark.parametrize(("name", "text"), blocks(), ids=lambda value: value.split("\n")[0])
def test_documented_scenes_are_valid(name: str, text: str) -> None:
    # Excerpts omit keys that do not matter for their subject.
    header = "" if text.startswith("pronk:") else "pronk: 1\nduration: 40\n"
    scene = read_scene(header + text + ("" if "cast:" in text else WALKER), name)
    assert scene.cast


def test_the_documented_orders_are_those_of_the_language() -> None:
    text = (ROOT / "docs" / "scripts.md").read_text(encoding="utf-8")
    assert verb_table() in text
    assert order_key_table() in text


def test_the_documented_events_are_those_of_the_language() -> None:
    assert event_table() in (ROOT / "docs" / "scripts.md").read_text(encoding="utf-8")


def test_the_documented_keys_of_terrains_are_those_of_the_models() -> None:
    text = (ROOT / "docs" / "terrain.md").read_text(encoding="utf-8")
    assert text.endswith(f"{terrain_tables()}\n")
    assert all(f"### `{kind}`\n" in text for kind in TERRAIN_KINDS)
    examples = re.findall(r"^terrain: .+$", text, re.MULTILINE)
    assert len(examples) == 4
    for example in examples:
        read_scene(f"pronk: 1\nframes: 1\n{example}\ncast: [{{figure: beetle}}]\n")


def test_the_documented_sizes_are_those_of_the_library() -> None:
    assert size_table() in (ROOT / "docs" / "figures.md").read_text(encoding="utf-8")


def figure_blocks() -> list[str]:
    """Return the figures of docs/figures.md as YAML text, and check that no block is overlooked."""
    text = (ROOT / "docs" / "figures.md").read_text(encoding="utf-8")
    marked = re.findall(r"<!-- (?:figure|scene) -->\n```yaml\n", text)
    assert len(marked) == len(BLOCK.findall(text))
    return re.findall(r"<!-- figure -->\n```yaml\n(.*?)```", text, re.DOTALL)


@pytest.mark.parametrize("step", range(1, 11))
def test_a_documented_figure_stands_without_mistakes(step: int, tmp_path: Path) -> None:
    file = tmp_path / "giraffe.yaml"
    file.write_text(figure_blocks()[step - 1], encoding="utf-8")
    (drawn,) = drawn_figures(str(file))
    assert not [remark for remark in check_figure(drawn.figure) if remark.is_fault]
    assert len(drawn.figure.skeleton.legs) == (0 if step == 1 else 4)


def test_the_scene_of_the_documented_figures_is_accepted(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "figures.md").read_text(encoding="utf-8")
    (scene,) = re.findall(r"<!-- scene -->\n```yaml\n(.*?)```", text, re.DOTALL)
    (tmp_path / "giraffe.yaml").write_text(figure_blocks()[-1], encoding="utf-8")
    walking = ["cast[0].material=coat", "cast[0].walk={}"]
    assert read_scene(scene, "show.yaml", tmp_path, walking).cast


def test_pictures_of_the_documented_figures_are_small() -> None:
    pictures = sorted((ROOT / "docs" / "figures").glob("*.png"))
    assert len(pictures) == 10
    assert sum(picture.stat().st_size for picture in pictures) < 400_000


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_of_a_page_lead_to_files(page: Path) -> None:
    targets = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    local = [target for target in targets if not target.startswith("https:")]
    missing = [target for target in local if not (page.parent / target).exists()]
    assert not missing
    assert len(page.read_text(encoding="utf-8")) < 6_000 or page.name != "README.md"


def test_modules_named_in_contributing_exist() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    modules = re.findall(r"`((?:pipeline|render|audio|tests)/[\w/]+\.py)`", text)
    assert len(modules) > 8
    assert [module for module in modules if not (ROOT / module).is_file()] == []
