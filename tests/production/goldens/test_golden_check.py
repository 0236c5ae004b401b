"""Golden checks by the command line."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from html.parser import HTMLParser
from importlib.resources import files
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from pipeline.production.goldens.golden_card import file_digest, read_card
from pipeline.production.goldens.golden_case import GoldenFolder

Pronk = Callable[..., tuple[int, str, str]]

SCENE = """\
pronk: 1
frames: 8
seed: 3
terrain: {kind: flat, size: [8, 8], cells: [8, 8]}
cast:
  - {name: bug, figure: beetle, scale: 0.6, walk: {gait: tripod, cycle: 0.3, speed: 0.6}}
camera: {follow: bug}
light: studio
film: {size: [64, 36], depth: 2}
golden: {frames: [1, 6], size: [64, 36], samples: 8}
"""
CHEAP = ("--layers", "motion,film")

pytestmark = pytest.mark.nightly


@pytest.fixture(autouse=True)
def _by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    # Goldens are not recorded in CI; these tests act as an author at home.
    monkeypatch.delenv("CI", raising=False)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a scene and its golden, shared by tests that do not write."""
    from pipeline.production.goldens.golden_case import GoldenRenderer, cases_of
    from pipeline.production.goldens.golden_record import record
    from pipeline.production.run.progress import Reporter

    folder = tmp_path_factory.mktemp("recorded")
    scene = folder / "tiny.yaml"
    scene.write_text(SCENE, encoding="utf-8")
    (case,) = cases_of([str(scene)], None, folder / "out")
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("CI", raising=False)
        record(case, GoldenRenderer(), Reporter(), seeds=3)
    return folder


@pytest.fixture
def home(recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of that folder, as the current one."""
    shutil.copytree(recorded, tmp_path / "home")
    monkeypatch.chdir(tmp_path / "home")
    return tmp_path / "home"


def state(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted((folder / "goldens/tiny").iterdir())}


def facts(folder: Path) -> Any:
    return json.loads((folder / "out/golden/report.json").read_text(encoding="utf-8"))


def test_a_recorded_golden_holds(pronk: Pronk, home: Path) -> None:
    before = state(home)
    assert set(before) == {
        "0001.png",
        "0006.png",
        "cues.json",
        "film.json",
        "golden.yaml",
        "motion.json",
        "spreads.json",
    }
    code, out, err = pronk("golden", "check", "tiny")
    assert code == 0, err
    assert out.count("identical") >= 4
    assert facts(home)["exit_code"] == 0
    assert state(home) == before
    # Without a name, all that have a golden.
    assert pronk("golden", "check", *CHEAP)[0] == 0
    code, _, err = pronk("golden", "record", "tiny", *CHEAP)
    assert code == 2
    assert "there is a golden already" in err
    code, _, err = pronk("golden", "approve", "tiny")
    assert code == 2
    assert "no check has found a difference" in err
    assert state(home) == before


def test_a_missing_golden_exits_with_code_5(pronk: Pronk, home: Path) -> None:
    shutil.rmtree(home / "goldens")
    code, out, _ = pronk("golden", "check", "tiny")
    assert code == 5
    assert "pronk golden record" in out
    assert not (home / "goldens").exists()
    code, _, err = pronk("golden", "check")
    assert code == 2
    assert "there are no goldens here" in err


@pytest.mark.parametrize(
    "arguments",
    [("record", "tiny", "--again"), ("approve", "tiny"), ("calibrate", "tiny", "--write")],
    ids=lambda arguments: arguments[0],
)
def test_goldens_are_not_written_in_continuous_integration(
    pronk: Pronk, home: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...]
) -> None:
    assert pronk("golden", "check", "tiny", "--set", "camera.fov_deg=40", *CHEAP)[0] == 1
    before = state(home)
    monkeypatch.setenv("CI", "true")
    code, _, err = pronk("golden", *arguments)
    assert code == 2
    assert "CI is set" in err
    assert pronk("golden", "check", "tiny", *CHEAP)[0] == 0
    assert state(home) == before


def test_a_change_is_reported_and_can_be_approved(pronk: Pronk, home: Path) -> None:
    before = state(home)
    scene = home / "tiny.yaml"
    scene.write_text(SCENE.replace("light: studio", "light: overcast"), encoding="utf-8")
    code, out, _ = pronk("golden", "check", "tiny")
    assert code == 1
    assert "frames changed: 2 of 2 frames" in out
    assert state(home) == before
    scenes = facts(home)["scenes"]
    assert [layer["outcome"] for layer in scenes[0]["layers"]] == [
        "changed",
        "changed",
        "identical",
    ]
    assert scenes[0]["approve"] == "pronk golden approve tiny"
    suite = ElementTree.parse(home / "out/golden/junit.xml").getroot()[0]
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("3", "2", "0")
    assert [case.get("name") for case in suite if len(case)] == ["motion", "frames"]

    made = (home / "out/golden/tiny/0006.png").read_bytes()
    code, out, err = pronk("golden", "approve", "tiny")
    assert code == 0, err
    assert "approved motion, frames" in out
    assert "calibrate --write" in out
    assert (home / "goldens/tiny/0006.png").read_bytes() == made
    assert (home / "goldens/tiny/motion.json").read_bytes() == before["motion.json"]
    assert read_card(home / "goldens/tiny/golden.yaml").limits == read_card_of(before, home)
    assert pronk("golden", "check", "tiny")[0] == 0
    assert pronk("golden", "approve", "tiny")[0] == 2
    code, out, _ = pronk("golden", "calibrate", "tiny", "--seeds", "2", "--write")
    assert code == 0
    assert "(written)" in out
    assert "spreads.json" in state(home)


def read_card_of(files_before: dict[str, bytes], home: Path) -> Any:
    earlier = home / "earlier.yaml"
    earlier.write_bytes(files_before["golden.yaml"])
    return read_card(earlier).limits


def test_a_check_against_another_golden_is_not_approved(pronk: Pronk, home: Path) -> None:
    assert pronk("golden", "check", "tiny", "--set", "camera.fov_deg=40", *CHEAP)[0] == 1
    assert pronk("golden", "record", "tiny", "--again", "--seeds", "0", *CHEAP)[0] == 0
    before = state(home)
    code, _, err = pronk("golden", "approve", "tiny")
    assert code == 2
    assert "check again" in err
    assert state(home) == before


def test_layers_that_a_golden_lacks_are_missing(pronk: Pronk, home: Path) -> None:
    assert pronk("golden", "record", "tiny", "--again", "--layers", "motion")[0] == 0
    assert pronk("golden", "check", "tiny")[0] == 0
    assert pronk("golden", "check", "tiny", "--layers", "film")[0] == 5
    code, _, err = pronk("golden", "check", "tiny", "--layers", "flim")
    assert code == 2
    assert "did you mean 'film'" in err


def _cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _edit(old: str, new: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")

    return change


DAMAGE: list[tuple[str, Callable[[Path], None], str]] = [
    ("golden.yaml", _cut, ""),
    ("golden.yaml", lambda path: path.write_bytes(b"\xff\xfe\0"), "is no YAML"),
    ("golden.yaml", lambda path: path.write_text("[1, 2]"), "golden"),
    ("golden.yaml", _edit("samples: 8", "samples: 9"), "changed by hand"),
    ("golden.yaml", _edit("scene: tiny", "scene: other"), "changed by hand"),
    ("golden.yaml", _edit("mean:", "maen:"), "limits.maen"),
    ("golden.yaml", _edit("golden: 1", "golden: 2"), "golden: Input should be 1"),
    ("motion.json", _cut, "is not the file"),
    ("motion.json", _edit("bug.body", "bag.body"), "is not the file"),
    ("cues.json", _edit('"ticks": "', '"ticks": "1'), "is not the file"),
    ("film.json", _edit("0.", "1."), "is not the file"),
    ("film.json", lambda path: path.unlink(), "is missing from the golden"),
    ("0006.png", _cut, "is no picture"),
    ("0006.png", lambda path: path.unlink(), "is missing from the golden"),
    ("0006.png", lambda path: shutil.copy(path.with_name("0001.png"), path), "is not the file"),
    (
        "0006.png",
        lambda path: path.write_text("version https://git-lfs.github.com/spec/v1\n"),
        "git lfs pull",
    ),
    ("spreads.json", _cut, "is not the file"),
]


@pytest.mark.parametrize(("name", "damage", "message"), DAMAGE)
def test_a_damaged_golden_is_reported_in_one_line_and_kept(
    pronk: Pronk, home: Path, name: str, damage: Callable[[Path], None], message: str
) -> None:
    damage(home / "goldens/tiny" / name)
    before = state(home)
    code, out, err = pronk("golden", "check", "tiny")
    assert code == 4
    assert "golden damaged" in out
    (line,) = [line for line in out.splitlines() if ": " in line and str(name) in line]
    assert message in line
    assert "Traceback" not in out + err
    assert state(home) == before


def test_the_golden_of_another_scene_is_refused(pronk: Pronk, home: Path) -> None:
    shutil.copytree(home / "goldens/tiny", home / "goldens/other")
    shutil.copy(home / "tiny.yaml", home / "other.yaml")
    code, out, _ = pronk("golden", "check", "other")
    assert code == 4
    assert "is of 'tiny', not of 'other'" in out


def _somewhere_else(home: Path) -> None:
    """Set another environment in the golden's card."""
    path = home / "goldens/tiny/golden.yaml"
    card = read_card(path)
    path.write_text(card.model_copy(update={"environment": "abacus"}).sealed().encoded())


def test_in_another_environment_only_variances_decide(pronk: Pronk, home: Path) -> None:
    _somewhere_else(home)
    # Equal pixels need no judge.
    assert pronk("golden", "check", "tiny", "--layers", "frames")[0] == 0
    dark = ("--set", "film.exposure=-0.5")
    assert pronk("golden", "check", "tiny", "--layers", "frames", *dark)[0] == 1
    code, _, err = pronk("golden", "calibrate", "tiny")
    assert code == 6
    assert "another environment (abacus)" in err
    assert (
        pronk("golden", "record", "tiny", "--again", "--seeds", "0", "--layers", "frames")[0] == 0
    )
    _somewhere_else(home)
    code, out, _ = pronk("golden", "check", "tiny", *dark)
    assert code == 6
    assert "cannot judge here" in out
    assert facts(home)["scenes"][0]["layers"][0]["outcome"] == "cannot judge here"
    suite = ElementTree.parse(home / "out/golden/junit.xml").getroot()[0]
    assert suite.get("skipped") == "1"


def _as_recorded_earlier(home: Path) -> None:
    """Take from a golden what earlier versions did not record."""
    place = GoldenFolder(home / "goldens/tiny")
    film, cues = (json.loads(path.read_text()) for path in (place.film, place.cues))
    del film["sound"], cues["look"], cues["shapes"]
    film["onsets"] = [onset[:2] for onset in film["onsets"]]
    cues["notes"] = [note[:5] for note in cues["notes"]]
    cues["camera"] = {frame: pose[:10] for frame, pose in cues["camera"].items()}
    place.film.write_text(json.dumps(film))
    place.cues.write_text(json.dumps(cues))
    card = read_card(place.card)
    digests = {name: file_digest(place.path / name) for name in card.files}
    text = card.model_copy(update={"files": digests}).sealed().encoded()
    place.card.write_text(re.sub(", exposure: [0-9.]+", "", text))


def test_a_golden_of_an_earlier_version_is_checked_for_what_it_has(
    pronk: Pronk, home: Path
) -> None:
    _as_recorded_earlier(home)
    code, out, _ = pronk("golden", "check", "tiny")
    assert code == 0
    assert "recorded by an earlier version, without loudness and exact onsets" in out
    assert "recorded by an earlier version, without settings, shapes and lens" in out
    assert pronk("golden", "check", "tiny", "--set", "camera.fov_deg=40", *CHEAP)[0] == 1
    assert pronk("golden", "check", "tiny", *CHEAP)[0] == 0
    code, out, err = pronk("golden", "approve", "tiny")
    assert code == 0, err
    assert "approved motion, film" in out
    code, out, _ = pronk("golden", "check", "tiny")
    assert code == 0
    assert "earlier version" not in out
    assert out.count("identical") >= 4


def test_limits_may_be_edited(pronk: Pronk, home: Path) -> None:
    path = home / "goldens/tiny/golden.yaml"
    text = path.read_text(encoding="utf-8")
    wide = re.sub(
        r"limits: \{.*\}", "limits: {mean: 1.0, tile: 1.0, z: 1000.0, exposure: 20}", text
    )
    path.write_text(wide, encoding="utf-8")
    dark = ("--layers", "frames", "--set", "film.exposure=-0.5")
    assert pronk("golden", "check", "tiny", *dark)[0] == 0


def test_other_line_ends_and_repacked_pictures_change_nothing(pronk: Pronk, home: Path) -> None:
    for path in (home / "goldens/tiny").glob("*.json"):
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert pronk("golden", "check", "tiny", "--layers", "motion,film")[0] == 0


def test_goldens_are_listed(pronk: Pronk, home: Path) -> None:
    code, out, _ = pronk("golden", "list")
    assert code == 0
    assert "motion, frames, film; frames 1, 6 of 64x36, 8 samples" in out
    assert "from 3 seeds" in out
    code, out, _ = pronk("golden", "list", "--json")
    (one,) = json.loads(out)["goldens"]
    assert (one["scene"], one["calibrated"], one["frames"]["numbers"]) == ("tiny", 3, [1, 6])


def test_jobs_change_no_verdict(pronk: Pronk, home: Path) -> None:
    shutil.copy(home / "tiny.yaml", home / "newer.yaml")
    changed = ("tiny", "newer", "--layers", "motion", "--set", "camera.fov_deg=40")

    def summary() -> Any:
        scenes = facts(home)["scenes"]
        for layer in (layer for scene in scenes for layer in scene["layers"]):
            del layer["seconds"]
        return scenes

    assert pronk("golden", "check", *changed)[0] == 1
    one = summary()
    assert pronk("golden", "check", *changed, "--jobs", "2")[0] == 1
    assert summary() == one


def test_the_most_severe_outcome_decides_the_exit_code(pronk: Pronk, home: Path) -> None:
    shutil.copy(home / "tiny.yaml", home / "newer.yaml")
    changed = ("--set", "camera.fov_deg=40")
    assert pronk("golden", "check", "tiny", "newer", *CHEAP, *changed)[0] == 1
    code, out, err = pronk("golden", "check", "tiny", "newer", *CHEAP, "--quiet")
    assert (code, out) == (5, "")
    # Those that hold are left out.
    assert err.startswith("newer: golden missing\n")
    assert pronk("golden", "check", "newer", *CHEAP, "--quiet", "--json")[2] == ""
    assert facts(home)["exit_code"] == 5


class Page(HTMLParser):
    """The tags of a report page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Record a tag; push it if it has an end tag."""
        self.tags.append((tag, {name: value or "" for name, value in attrs}))
        if tag not in ("meta", "img", "input"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        """Pop the open tag, which must match."""
        assert self.open.pop() == tag


def test_the_report_is_one_page_that_needs_no_network(pronk: Pronk, home: Path) -> None:
    shutil.copytree(home / "goldens/tiny", home / "goldens/aaa")
    (home / "aaa.yaml").write_text(SCENE, encoding="utf-8")
    path = home / "goldens/aaa/golden.yaml"
    card = read_card(path).model_copy(update={"scene": "aaa"})
    path.write_text(card.sealed().encoded(), encoding="utf-8")
    scene = SCENE.replace("light: studio", "light: overcast")
    (home / "tiny.yaml").write_text(scene, encoding="utf-8")
    assert pronk("golden", "check", "aaa", "tiny")[0] == 1
    text = (home / "out/golden/report.html").read_text(encoding="utf-8")
    page = Page(text)
    assert not page.open
    assert text.index("<b>tiny</b>") < text.index("<b>aaa</b>")
    sources = [
        attributes[name]
        for _, attributes in page.tags
        for name in ("src", "href")
        if name in attributes
    ]
    assert len(sources) == 6
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert not re.search(r"url\(|https?://|@import", text)
    assert "default-src 'none'" in text
    assert "pronk golden approve tiny" in text
    views = [attributes for _, attributes in page.tags if attributes.get("class") == "view"]
    assert [view["id"] for view in views] == ["tiny-1", "tiny-6"]
    # Every element that the script looks up exists.
    script = files("pipeline.production.goldens").joinpath("report.js").read_text(encoding="utf-8")
    ids = {attributes["id"] for _, attributes in page.tags if "id" in attributes}
    assert set(re.findall(r'getElementById\("([^"]+)"\)', script)) <= ids
    classes = {name for _, attributes in page.tags for name in attributes.get("class", "").split()}
    assert set(re.findall(r'querySelector(?:All)?\("\.([a-z-]+)"\)', script)) <= classes
