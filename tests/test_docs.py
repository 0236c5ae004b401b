"""Documented scenes are valid, and links of the pages lead to files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pipeline.spec import read_scene

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")])
BLOCK = re.compile(r"```yaml\n(.*?)```", re.DOTALL)
WALKER = "cast: [{name: mare, figure: horse, walk: {}}]\n"


def blocks() -> list[tuple[str, str]]:
    """Return (name, YAML text) of the scenes in README.md and docs/scenes.md."""
    found = []
    for page in (ROOT / "README.md", ROOT / "docs" / "scenes.md"):
        texts = BLOCK.findall(page.read_text(encoding="utf-8"))
        found += [(f"{page.name} {n}", text) for n, text in enumerate(texts, start=1)]
    return found


@pytest.mark.parametrize(("name", "text"), blocks(), ids=lambda value: value.split("\n")[0])
def test_documented_scenes_are_valid(name: str, text: str) -> None:
    # Excerpts omit keys that do not matter for their subject.
    header = "" if text.startswith("pronk:") else "pronk: 1\nduration: 40\n"
    scene = read_scene(header + text + ("" if "cast:" in text else WALKER), name)
    assert scene.cast


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
