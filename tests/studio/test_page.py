"""The page in a real browser: a figure drawn by mouse from nothing walks, a scene is edited.

With `PRONK_STUDIO_PICTURES=docs/studio` the pictures of docs/studio.md are made on the way.
"""

from __future__ import annotations

import itertools
import os
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from PIL import Image

from pipeline.simulation.figure_analysis import build_figure
from pipeline.spec import library, load_figure, load_scene
from pipeline.studio.app import Studio
from tests.studio.conftest import SCENE, Served

BROWSER = "PRONK_BROWSER"
"""Environment variable: the browser to use, which then has to be there."""

PICTURES = "PRONK_STUDIO_PICTURES"
"""Environment variable: folder in which the pictures of the documentation are kept."""

SHOWN = re.findall(
    r"\(studio/(\w+)\.png\)",
    (Path(__file__).parents[2] / "docs" / "studio.md").read_text(encoding="utf-8"),
)
"""Names of those pictures."""

STUCK, REFUSED = 540.0, 60.0
"""Times after which what is waited for will not come [s], far longer than a busy machine takes: at
all, and where the page tells a mistake."""

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

pytestmark = [pytest.mark.nightly, pytest.mark.filterwarnings("default")]


class Page:
    """The page with what a user does on it.

    Args:
        page: of the browser.
        served: the studio.
        scratch: folder of screenshots.
    """

    def __init__(self, page: Any, served: Served, scratch: Path) -> None:
        self.page = page
        self.served = served
        self.scratch = scratch

    def open(self, first: str | None) -> None:
        """Load the page with a document."""
        self.served.studio.first = first
        self.page.goto(self.served.address)
        self.wait("Boolean(window.studio?.isReady)")

    def value(self, expression: str) -> Any:
        """Return a value of the page."""
        return self.page.evaluate(expression)

    def wait(self, expression: str) -> None:
        """Wait until an expression holds; a busy machine is given time, a stuck page is not."""
        good = start = time.monotonic()
        while not self.value(expression):
            now, status = time.monotonic(), self.page.inner_text("#status")
            if not self.page.locator("#status.bad").count():
                good = now
            assert now - start < STUCK, f"{expression}; {status}"
            assert now - good < REFUSED, f"{expression}; {status}"
            time.sleep(0.05)

    def wait_for_film(self) -> None:
        """Wait until the newest film of the render queue has ended, and check that it is done."""
        state = "document.querySelector('#renders strong')?.textContent.split(': ')[1]"
        self.wait(f"!['waiting', 'rendering', undefined].includes({state})")
        assert self.value(state) == "done", self.page.inner_text("#renders")

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Return where a place of the drawing is on the screen."""
        expression = (
            "([x, y]) => { const e = studio.editor; const b = e.canvas.getBoundingClientRect();"
            " const [sx, sy] = e.toScreen([x, y]); return [sx + b.left, sy + b.top]; }"
        )
        a, b = self.page.evaluate(expression, [x, y])
        return a, b

    def click(self, *places: tuple[float, float]) -> None:
        """Click places of the drawing, one after the other."""
        for place in places:
            self.page.mouse.click(*self.place(*place))

    def drag(self, start: tuple[float, float], end: tuple[float, float], steps: int = 12) -> None:
        """Drag from one place of the drawing to another."""
        self.page.mouse.move(*self.place(*start))
        self.page.mouse.down()
        self.page.mouse.move(*self.place(*end), steps=steps)
        self.page.mouse.up()

    def picture(self, name: str) -> Path:
        """Keep a screenshot, one that the documentation shows where it is wanted."""
        folder = Path(os.environ.get(PICTURES, self.scratch)) if name in SHOWN else self.scratch
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.png"
        self.page.screenshot(path=path)
        return path


@pytest.fixture
def page(served: Served, tmp_path: Path) -> Iterator[Page]:
    """The page in a browser, of which every error fails the test."""
    wanted = os.environ.get(BROWSER)
    found = next(filter(None, map(shutil.which, [wanted] if wanted else NAMES)), None)
    if found is None and wanted:
        pytest.fail(f"{BROWSER}={wanted} is no program")
    if found is None:
        pytest.skip(f"no Chromium here ({', '.join(NAMES)}); {BROWSER} names another")
    if wanted:
        import playwright.sync_api as driver
    else:
        driver = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    errors: list[str] = []
    with driver.sync_playwright() as started:
        flags = ["--no-sandbox", "--enable-unsafe-swiftshader"]
        browser = started.chromium.launch(executable_path=found, args=flags)
        opened = browser.new_page(viewport={"width": 1280, "height": 760})
        opened.on("pageerror", lambda error: errors.append(str(error)))
        opened.on("request", lambda asked: _refuse_foreign(asked.url, served, errors))
        yield Page(opened, served, tmp_path / "pictures")
        browser.close()
    assert errors == []


def _refuse_foreign(url: str, served: Served, errors: list[str]) -> None:
    """Note a request that goes elsewhere than to the studio."""
    if not url.startswith((f"http://127.0.0.1:{served.port}/", "blob:", "data:")):
        errors.append(f"fetched {url}")


def test_a_six_legged_figure_is_drawn_from_nothing_and_walks(page: Page) -> None:
    page.open(None)
    page.page.click("#mirrored")
    page.page.keyboard.press("d")
    page.click((0.0, -1.0), (0.0, -0.5), (0.0, 0.0), (0.0, 0.5), (0.0, 1.0))
    page.page.keyboard.press("Escape")
    for y, spread in ((-0.5, -0.35), (0.0, 0.0), (0.5, 0.35)):
        page.click((0.0, y), (-0.5, y + spread / 2), (-1.0, y + spread))
        page.page.keyboard.press("Escape")
    page.page.keyboard.press("v")
    page.drag((-0.3, -1.2), (0.3, 1.2))
    assert len(page.value("[...studio.editor.selected]")) == 5
    page.page.fill("#node-radius", "0.2")
    page.page.press("#node-radius", "Enter")
    page.wait("studio.editor.walks > 0 && studio.editor.isIdle")
    analysis = page.value("studio.editor.analysis")
    assert [limb["kind"] for limb in analysis["limbs"]].count("leg") == 6
    page.page.keyboard.press("Escape")
    _save_as(page, "sixlegs")
    figure = load_figure(page.served.folder / "figures" / "sixlegs.yaml")
    assert len(build_figure("it", figure, 1.0).skeleton.legs) == 6
    page.picture("new_figure")
    scene = page.served.folder / "walk.yaml"
    film = "film: {size: [64, 36], samples: 1}\n"
    scene.write_text(SCENE.replace("beetle", "sixlegs").replace("frames: 8", "frames: 2") + film)
    assert load_scene(scene).cast[0].figure == "sixlegs"
    page.open("walk.yaml")
    page.wait("studio.player.takes > 0")
    page.page.click("#render-film")
    page.wait_for_film()
    assert (page.served.folder / "out" / "walk" / "walk.mp4").stat().st_size > 0


def _save_as(page: Page, name: str) -> None:
    page.page.once("dialog", lambda dialog: dialog.accept(name))
    _save(page)


def _save(page: Page) -> None:
    page.page.click("#save")
    page.wait("document.getElementById('status').textContent.startsWith('saved')")


def test_a_dragged_node_is_drawn_and_analysed_and_undone(page: Page) -> None:
    page.open("library:figures/beetle.yaml")
    page.wait("studio.editor.walks > 0")
    page.picture("figure")
    before = page.value("JSON.stringify(studio.editor.drawing)")
    page.page.keyboard.press("s")
    for k in range(55):
        way = 0.05 if k % 2 == 0 else -0.03
        x, y = page.value("studio.editor.drawing.nodes.knee3_l.at")
        page.drag((x, y), (x - way, y), steps=1)
    assert page.value("studio.editor.undos.length") == 55
    assert page.value("studio.editor.drawing.nodes.knee3_l.at[0]") < -1.2
    after = page.value("JSON.stringify(studio.editor.drawing)")
    page.drag((-1.66, -0.06), (-1.5, -0.4), steps=60)
    metrics = page.value("studio.editor.metrics")
    # Judged on a machine at rest, by hand; here only that both kinds were measured.
    assert len(metrics["drawing"]) > 30
    assert len(metrics["analysis"]) > 0
    for _ in range(56):
        page.page.keyboard.press("Control+z")
    assert page.value("JSON.stringify(studio.editor.drawing)") == before
    for _ in range(55):
        page.page.keyboard.press("Control+Shift+Z")
    assert page.value("JSON.stringify(studio.editor.drawing)") == after


def _place_of_part(page: Page, part: str) -> tuple[float, float]:
    """Return a place of the screen at which a part of the creature is seen, well inside of it."""
    return _place_in(page, "creature", "partAt", part)


def _place_in(page: Page, view: str, at: str, name: str) -> tuple[float, float]:
    """Return a place of the screen at which a view shows what has a name, well inside of it."""
    box = page.page.locator(f"#{view}").bounding_box()
    viewer = {"creature": "studio.editor.viewer", "world": "studio.player.viewer"}[view]
    expression = (
        "([box, name]) => { const seen = []; for (let y = 4; y < box.height; y += 9)"
        " for (let x = 4; x < box.width; x += 9) {"
        " const at = {clientX: box.x + x, clientY: box.y + y};"
        f" if ({viewer}.{at}(at) === name) seen.push([at.clientX, at.clientY]); }}"
        " return seen[Math.floor(seen.length / 2)]; }"
    )
    found = page.page.evaluate(expression, [box, name])
    assert found, f"{name} is not seen"
    return found[0], found[1]


def test_a_part_is_clicked_and_posed_in_three_dimensions(page: Page) -> None:
    page.open("library:figures/beetle.yaml")
    page.wait("studio.editor.walks > 0 && Boolean(studio.editor.analysis.links)")
    page.page.focus("#canvas")
    page.page.keyboard.press("Space")
    page.page.mouse.click(*_place_of_part(page, "r2.2"))
    assert page.value("studio.editor.posing.link") == "r2.2"
    assert page.page.locator("#part").is_visible()
    before = page.value("studio.editor.analysis.links.find(l => l.name === 'r2.2').joints[0]")
    x, y = _place_of_part(page, "r2.2")
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(x + 6, y + 22, steps=8)
    page.picture("part")
    page.page.mouse.up()
    joints = page.value("studio.editor.drawing.joints")
    rest = joints["r2"]["joint1_bend"]["rest_deg"]
    assert before["lower"] <= rest <= before["upper"]
    assert abs(rest - before["preferred"]) > 3
    assert joints["l2"] == joints["r2"]
    assert page.value("studio.editor.undos.length") == 1
    page.wait("studio.editor.walks > 1")
    page.page.fill("[aria-label='mass']", "9.5")
    page.page.press("[aria-label='mass']", "Enter")
    page.wait("Math.abs(studio.editor.analysis.masses.l2 - 9.5) < 1e-6")
    page.page.fill("[aria-label='joint1_bend rest']", "179")
    page.page.press("[aria-label='joint1_bend rest']", "Enter")
    page.wait("document.querySelector('#part .bad') !== null")
    assert "rests outside its limits" in page.page.inner_text("#warnings")
    page.picture("refused")
    page.page.click("#undo")
    page.wait("document.querySelector('#part .bad') === null")
    most = page.value("studio.editor.posing.arcs[0].handles.most.toArray()")
    x, y = page.page.evaluate(
        "(p) => studio.editor.viewer.onScreen("
        "studio.editor.posing.arcs[0].handles.most.clone().fromArray(p))",
        most,
    )
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(x + 14, y + 14, steps=6)
    page.page.mouse.up()
    limits = page.value("studio.editor.drawing.joints.r2.joint1_bend.limits_deg")
    assert limits[0] == pytest.approx(before["lower"])
    assert limits[1] != pytest.approx(before["upper"])
    _save(page)
    text = (page.served.folder / "figures" / "beetle.yaml").read_text()
    original = (library() / "figures" / "beetle.yaml").read_text()
    assert all(line in text.splitlines() for line in original.splitlines())
    figure = load_figure(page.served.folder / "figures" / "beetle.yaml")
    assert figure.masses == {"r2": 9.5, "l2": 9.5}
    assert figure.joints["r2"]["joint1_bend"].rest_deg == rest
    for _ in range(3):
        page.page.click("#undo")
    assert page.value("studio.editor.drawing.joints") == {}
    page.page.focus("#canvas")
    page.page.keyboard.press("Escape")
    assert page.value("studio.editor.posing.link") is None


def test_a_part_of_one_skin_is_found(page: Page) -> None:
    page.open("library:figures/horse.yaml")
    page.wait("studio.editor.walks > 0 && Boolean(studio.editor.analysis.links)")
    page.page.focus("#canvas")
    page.page.keyboard.press("Space")
    page.page.mouse.click(*_place_of_part(page, "head.1"))
    assert page.value("studio.editor.posing.link") == "head.1"
    page.page.mouse.move(10, 10)
    page.picture("neck")
    x, y = _place_of_part(page, "head.1")
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(x + 30, y + 25, steps=8)
    page.page.mouse.up()
    page.picture("neck_lowered")
    assert page.value("studio.editor.drawing.joints.head.base_pitch.rest_deg") != 46


def test_operations_of_the_selected_set(page: Page) -> None:
    page.open("library:figures/tripod.yaml")
    count = "Object.keys(studio.editor.drawing.nodes).length"
    nodes = page.value(count)
    page.value("studio.editor.select(['hip2_l', 'knee2_l', 'foot2_l'])")
    at = "studio.editor.drawing.nodes.foot2_l.at"
    start = page.value(at)
    page.page.focus("#canvas")
    page.page.keyboard.press("ArrowRight")
    assert page.value(at) == pytest.approx([start[0] + 0.01, start[1]])
    for _ in range(24):
        page.page.keyboard.press("]")
    assert page.value(at) == pytest.approx([start[0] + 0.01, start[1]], abs=1e-6)
    page.page.keyboard.press("Control+d")
    assert page.value(count) == nodes + 3
    page.page.keyboard.press("Delete")
    assert page.value(count) == nodes
    page.page.keyboard.press("p")
    assert page.value("studio.editor.selected.size") == 3
    page.value("studio.editor.select([])")
    page.page.keyboard.press("l")
    box = page.page.locator("#canvas").bounding_box()
    left, top, right, bottom = (box["x"] + 5, box["y"] + 5, *(box[k] for k in ("width", "height")))
    page.page.mouse.move(left, top)
    page.page.mouse.down()
    for x, y in ((left + right - 10, top), (left + right - 10, top + bottom - 10)):
        page.page.mouse.move(x, y, steps=4)
    page.page.mouse.move(left, top + bottom - 10, steps=4)
    page.page.mouse.up()
    assert page.value("studio.editor.selected.size") == nodes


def test_sets_are_mirrored_scaled_turned_grouped_and_connected(page: Page) -> None:
    page.open(None)
    for place in ((0.0, -0.5), (0.0, 0.5)):
        page.page.mouse.click(*page.place(*place), button="middle")
    page.page.keyboard.press("d")
    page.click((0.0, -0.5), (-0.4, -0.5), (-0.4, 0.1))
    page.page.keyboard.press("Escape")
    page.page.keyboard.press("v")
    at = "Object.values(studio.editor.drawing.nodes).map((node) => node.at)"
    assert page.value(at) == [[0, -0.5], [0, 0.5], [-0.4, -0.5], [-0.4, 0.1]]
    # A leg is copied to the other side, and stays connected where it was.
    page.drag((-0.6, -0.7), (-0.2, 0.3))
    page.page.keyboard.press("t")
    page.page.keyboard.press("m")
    assert page.value(at)[4:] == [[0.4, -0.5], [0.4, 0.1]]
    leg, copy = {("n1", "n3"), ("n3", "n4")}, {("n1", "n3_m"), ("n3_m", "n4_m")}
    assert _connections(page) == leg | copy
    # The copy is selected: scaled about its middle, turned about the origin, moved by fields.
    page.page.keyboard.press("t")
    page.page.click("#scale")
    assert page.value(at)[4:] == [pytest.approx([0.4, -0.53]), pytest.approx([0.4, 0.13])]
    page.page.keyboard.press("Control+z")
    page.page.select_option("#about-point", "origin")
    page.page.fill("#angle", "90")
    page.page.click("#rotate")
    assert page.value(at)[4:] == [pytest.approx([0.5, 0.4]), pytest.approx([-0.1, 0.4])]
    page.page.fill("#by-y", "0.3")
    page.page.click("#translate")
    assert page.value(at)[4:] == [pytest.approx([0.5, 0.7]), pytest.approx([-0.1, 0.7])]
    page.page.keyboard.press("Shift+M")
    assert page.value(at)[4:] == [pytest.approx([0.5, -0.7]), pytest.approx([-0.1, -0.7])]
    page.page.keyboard.press("x")
    assert _connections(page) == leg | {("n1", "n3_m")}
    page.page.keyboard.press("c")
    assert _connections(page) == leg | copy
    # A group is selected by one of it, until it is none.
    page.page.keyboard.press("g")
    page.page.keyboard.press("Escape")
    page.click((0.5, -0.7))
    assert page.value("[...studio.editor.selected].sort()") == ["n3_m", "n4_m"]
    page.page.keyboard.press("Shift+G")
    page.page.keyboard.press("Escape")
    page.click((0.5, -0.7))
    assert page.value("[...studio.editor.selected]") == ["n3_m"]
    page.page.keyboard.press("Control+a")
    assert page.value("studio.editor.selected.size") == 6
    # A connection that is clicked is cut; a radius is dragged by its handle.
    page.click((-0.4, -0.2))
    page.page.keyboard.press("Delete")
    assert _connections(page) == {("n1", "n3")} | copy
    page.click((-0.4, 0.1))
    page.drag((-0.32, 0.1), (-0.25, 0.1))
    radius = page.value("studio.editor.drawing.nodes.n4.radius")
    assert radius == pytest.approx(0.15, abs=0.01)


def _connections(page: Page) -> set[tuple[str, str]]:
    """Return the connections of the drawing, the names of each in order."""
    chains = page.value("studio.editor.drawing.chains")
    pairs = (sorted(pair) for chain in chains for pair in itertools.pairwise(chain))
    return {(a, b) for a, b in pairs}


def test_a_scene_is_played_edited_and_marked(page: Page) -> None:
    page.open("walk.yaml")
    page.wait("studio.player.takes > 0")
    page.wait("Boolean(studio.player.film)")
    first = page.value("studio.player.facts.seconds")
    page.page.click("#on")
    assert page.value("studio.player.frame") == 2
    moved = page.picture("played")
    _replace(page, "frames: 8", "frames: 12")
    page.wait("studio.player.takes > 1")
    assert page.value("studio.player.facts.seconds") > first
    _replace(page, "walk: {}", "walk: {sped: 1}")
    page.wait("document.querySelectorAll('.cm-lintRange-error').length > 0")
    assert page.page.inner_text(".cm-lintRange-error") == "sped"
    assert "did you mean 'speed'" in page.page.inner_text("#status")
    page.picture("mistake")
    travelled = (
        "(studio.player.seek(studio.player.facts.seconds),"
        " studio.player.viewer.poseOf([...studio.player.viewer.nodes.keys()][0]).elements[12])"
    )
    ways = [page.value(travelled)]
    for takes, before, after in ((2, "sped: 1", "speed: 0.5"), (3, "speed: 0.5", "speed: 1")):
        _replace(page, before, after)
        page.wait(f"studio.player.takes > {takes}")
        ways.append(page.value(travelled))
    assert ways[2] - ways[1] == pytest.approx(0.5 * page.value("studio.player.facts.seconds"), 0.1)
    colors = np.asarray(Image.open(moved).convert("RGB"))[100:500, 700:1200].reshape(-1, 3)
    # A creature on ground below a sky, not a canvas of one colour.
    assert len(np.unique(colors // 16, axis=0)) > 12


MAPPED = """\
pronk: 1
frames: 8
terrain: {kind: ditches, size: [12, 12], cells: [60, 60], width: 1, spacing: 3, material: turf}
materials:
  turf: {preset: grass, color: "#668844"}
places: {tree: [2, 1]}
cast:
  - name: bug
    figure: beetle
    at: [0, 1]
    walk: {path: [[3, 0], [4, 2]], speed: 0.5}
  - {name: crate, prop: {shape: box, size: [0.2, 0.2, 0.2]}, parent: bug, at: [-0.4, 0.6, 0.3]}
"""


def test_keys_and_values_are_completed_at_their_place(page: Page) -> None:
    page.open("walk.yaml")
    text = page.value("studio.player.editor.text")

    def offered(added: str, at: str) -> list[str]:
        place = text.index(at) + len(at)
        page.page.evaluate(
            "([at, added]) => studio.player.editor.view.dispatch("
            "{changes: {from: at, insert: added}})",
            [place, added],
        )
        found = page.value(f"studio.player.editor.completions({place + len(added)})")
        page.page.evaluate("(text) => { studio.player.editor.text = text; }", text)
        return list(found)

    inside = offered("", "walk: {")
    assert {"gait", "speed", "path"} <= set(inside)
    assert "terrain" not in inside
    member = offered(", ", "figure: beetle")
    assert {"at", "heading_deg", "pose"} <= set(member)
    # Keys that are there already, and those of other performers, are left out.
    assert not {"name", "figure", "walk", "character", "traits"} & set(member)
    assert "tripod" in offered("gait: ", "walk: {")
    start = text.index("beetle")
    figures = page.value(f"studio.player.editor.completions({start}, {start + 6})")
    assert {"beetle", "spider", "horse"} <= set(figures)


def test_numbers_colours_and_positions_are_dragged(page: Page) -> None:
    (page.served.folder / "walk.yaml").write_text(MAPPED)
    page.open("walk.yaml")
    page.wait("studio.player.takes > 0")
    box = page.page.locator(".cm-dragged-number", has_text="0.5").bounding_box()
    y = box["y"] + box["height"] / 2
    page.page.mouse.move(box["x"] + 4, y)
    page.page.mouse.down()
    page.page.mouse.move(box["x"] + 17, y, steps=5)
    page.page.mouse.up()
    assert page.value("studio.player.editor.text") == MAPPED.replace("0.5", "0.8")
    page.page.keyboard.press("Control+z")
    assert page.value("studio.player.editor.text") == MAPPED
    page.page.locator(".swatch").evaluate(
        "(e) => { e.value = '#88aa66'; e.dispatchEvent(new Event('input'));"
        " e.dispatchEvent(new Event('change')); }"
    )
    assert page.value("studio.player.editor.text") == MAPPED.replace("#668844", "#88aa66")
    page.page.click("#see-map")
    labels = page.value("studio.player.map.points.map((point) => point.label)")
    assert labels == ["tree", "bug at", "bug path", "bug path", "crate at"]
    _drag_on_the_map(page, 4, 0.3, 0.2)
    text = page.value("studio.player.editor.text")
    before, own = ([-0.4, 0.3], yaml.safe_load(text)["cast"][1]["at"])
    assert own[1] == 0.6
    # As far as it was dragged, in the directions of what carries it.
    assert np.hypot(own[0] - before[0], own[2] - before[1]) == pytest.approx(0.36, abs=0.03)
    moved = page.value("studio.player.map.points[4]")
    assert (moved["own"]["x"], moved["own"]["z"]) == (own[0], own[2])
    page.value("studio.player.editor.view.focus()")
    page.page.keyboard.press("Control+z")
    _drag_on_the_map(page, 0, 0.5, -1.0)
    moved = page.value("studio.player.map.points[0]")
    assert (moved["x"], moved["z"]) == pytest.approx((2.5, 0.0), abs=0.03)
    page.wait("studio.player.takes > 1 && studio.player.request === null")
    page.picture("map")


def _drag_on_the_map(page: Page, number: int, dx: float, dz: float) -> None:
    """Drag a position of the text by some metres."""
    x, y = page.value(
        f"(p => studio.player.map.toScreen(p.x, p.z))(studio.player.map.points[{number}])"
    )
    scale = page.value("studio.player.map.toScreen(1, 0)[0] - studio.player.map.toScreen(0, 0)[0]")
    box = page.page.locator("#map").bounding_box()
    x, y = x + box["x"], y + box["y"]
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(x + dx * scale, y + dz * scale, steps=6)
    page.page.mouse.up()


def test_a_performer_that_is_clicked_shows_its_channels(page: Page) -> None:
    page.open("walk.yaml")
    page.wait("studio.player.takes > 0")
    page.page.mouse.click(*_place_in(page, "world", "performerAt", "bug"))
    page.wait("studio.player.bars.curves.length > 0")
    assert "gait_phase" in page.value("studio.player.bars.curves.map((curve) => curve.name)")
    # However many they are, the buttons stay in view.
    box = page.page.locator("#transport").bounding_box()
    assert box["y"] + box["height"] < 600
    page.picture("channels")


def _replace(page: Page, before: str, after: str, editor: str = "player") -> None:
    page.page.evaluate(
        f"([a, b]) => {{ const v = studio.{editor}.editor.view;"
        " const from = v.state.doc.toString().indexOf(a);"
        " v.dispatch({changes: {from, to: from + a.length, insert: b}}); }",
        [before, after],
    )


def test_a_new_scene_is_rendered(page: Page) -> None:
    page.open("walk.yaml")
    page.wait("studio.player.takes > 0")
    film = "film: {size: [64, 36], samples: 1}\n"
    _replace(page, "terrain:", f"{film}terrain:")
    _replace(page, "frames: 8", "frames: 2")
    page.wait("studio.player.facts?.frames === 2")
    page.page.click("#render-film")
    page.wait_for_film()
    assert film in (page.served.folder / "walk.yaml").read_text()
    page.wait("document.querySelector('#renders img').naturalWidth > 0")
    page.page.once("dialog", lambda dialog: dialog.accept("hello"))
    page.page.click("#tab-library")
    page.page.click("[data-name='+scene']")
    page.wait("document.getElementById('name').textContent.startsWith('hello.yaml')")


def test_a_scene_that_was_not_changed_is_saved_as_the_same_file(page: Page) -> None:
    file = page.served.folder / "walk.yaml"
    file.write_bytes(SCENE.replace("\n", "\r\n").encode())
    before = file.read_bytes()
    page.open("walk.yaml")
    # There is nothing to undo yet.
    page.value("studio.player.editor.view.focus()")
    page.page.keyboard.press("Control+z")
    assert not page.value("studio.player.isDirty")
    page.page.click("#save")
    page.wait("document.getElementById('status').textContent.startsWith('saved')")
    assert file.read_bytes() == before


def test_the_library_opens_documents(page: Page) -> None:
    page.open(None)
    page.page.click("#tab-library")
    page.wait("document.querySelectorAll('#library article').length > 200")
    # All that are in view, where the picture is kept: they are rendered one by one.
    seen = "[...document.querySelectorAll('#library article img')].filter((one) => one.src"
    if PICTURES in os.environ:
        seen += " || one.getBoundingClientRect().top > innerHeight"
        page.wait(f"{seen}).length === document.querySelectorAll('#library article img').length")
    page.wait(f"{seen}).length > 2")
    page.picture("library")
    page.page.fill("#find", "marimba")
    assert page.page.locator("#library article:visible").count() == 1
    page.page.click("#library article:visible .name")
    page.wait("studio.library.audio.duration > 3")
    page.page.fill("#find", "oak")
    page.page.once("dialog", lambda dialog: dialog.accept("log"))
    page.page.click("[data-from='material oak']")
    page.wait("document.getElementById('name').textContent.startsWith('log.yaml')")
    assert load_scene(page.served.folder / "log.yaml").cast[0].material == "oak"
    page.page.click("#tab-library")
    page.wait("document.querySelectorAll('#library article').length > 200")
    page.page.click("[data-name='library:figures/horse.yaml']")
    page.wait("studio.editor.analysis?.headline.startsWith('mammal, 4 legs')")


def test_studio_is_reached_by_its_address_alone(page: Page, served: Served) -> None:
    assert isinstance(served.studio, Studio)
    page.page.goto(f"http://127.0.0.1:{served.port}/")
    assert page.page.inner_text("body").startswith("refused: no token")


def test_a_page_that_is_loaded_again_shows_the_document_it_had(page: Page, served: Served) -> None:
    page.open("walk.yaml")
    assert page.page.url == f"http://127.0.0.1:{served.port}/"
    page.page.click("#tab-library")
    page.page.click("[data-name='library:figures/tripod.yaml']")
    page.wait("document.getElementById('name').textContent.startsWith('library:figures/tripod')")
    page.page.reload()
    page.page.wait_for_selector("#figure:not([hidden])")
    page.wait("Boolean(window.studio?.isReady)")
    assert page.page.inner_text("#name") == "library:figures/tripod.yaml"
    # Another studio at this address has another token.
    page.value("sessionStorage.studioToken = 'of another'")
    page.page.reload()
    page.page.wait_for_url("**/?again&token=of%20another")
    assert page.page.inner_text("body").startswith("refused: no token")


def test_first_frames_grow_while_the_simulation_goes_on(page: Page) -> None:
    file = page.served.folder / "walk.yaml"
    file.write_text(SCENE.replace("frames: 8", "duration: 60"))
    page.open("walk.yaml")
    page.wait("studio.player.beginnings?.length > 1")
    whole, known = page.value("[studio.player.bars.seconds, studio.player.bars.known]")
    assert whole == 60
    assert 0 < known < whole
    page.value("studio.player.seek(studio.player.bars.known / 2)")
    page.picture("growing")
    time_, frame = page.value("[studio.player.time, studio.player.frame]")
    assert 0 < time_ < whole
    assert frame > 1
    page.wait("studio.player.takes > 0")
    frames = page.value("studio.player.beginnings")
    assert frames == sorted(set(frames))
    assert page.value("studio.player.bars.known") == whole
    # The moment that was looked at stays.
    assert page.value("studio.player.time") == pytest.approx(time_)


def test_a_moving_view_has_fewer_triangles_and_one_at_rest_all(page: Page) -> None:
    cast = "".join(f"  - {{name: b{i}, figure: horse, at: [{3 * i}, 0]}}\n" for i in range(4))
    text = SCENE[: SCENE.index("cast:")].replace("[8, 8]", "[40, 40]") + f"cast:\n{cast}"
    (page.served.folder / "walk.yaml").write_text(text)
    page.open("walk.yaml")
    page.wait("studio.player.takes > 0")
    draw = "(studio.player.viewer.draw({}), studio.player.viewer.triangles)"
    whole = page.value(draw.format("false"))
    pictures = [page.picture("whole")]
    budget = page.value("studio.player.viewer.detail.budget = 18000")
    moving = page.value(draw.format("true"))
    pictures.append(page.picture("coarse"))
    assert whole > 2 * budget
    assert moving < 1.25 * budget
    seen = [np.asarray(Image.open(path).convert("L"), dtype=float) for path in pictures]
    # The same animals at the same places: few pixels are clearly another colour.
    assert (np.abs(seen[0] - seen[1])[50:540, 540:] > 60).mean() < 0.01
    page.wait(f"studio.player.viewer.triangles === {whole}")


def test_a_slow_renderer_is_known_by_its_frames(page: Page) -> None:
    """A renderer whose name is masked draws less after some frames that took long."""
    page.page.add_init_script(
        "WebGL2RenderingContext.prototype.getExtension = new Proxy("
        "WebGL2RenderingContext.prototype.getExtension, {apply: (work, self, [name]) =>"
        " name === 'WEBGL_debug_renderer_info' ? null : Reflect.apply(work, self, [name])});"
    )
    cast = "".join(f"  - {{name: b{i}, figure: horse, at: [{3 * i - 9}, 0]}}\n" for i in range(6))
    text = SCENE[: SCENE.index("cast:")].replace("[8, 8]", "[40, 40]") + f"cast:\n{cast}"
    (page.served.folder / "walk.yaml").write_text(text)
    page.open("walk.yaml")
    page.wait("studio.player.takes > 0")
    budget = page.value("studio.player.viewer.pace.budget")
    assert budget > 100_000
    # Frames as a slow renderer takes them, whatever this machine does.
    page.value("[1, 2, 3, 4, 5].forEach(() => studio.player.viewer.tookFrame(400))")
    assert page.value("studio.player.viewer.pace.budget") == 20_000
    moving = "(studio.player.viewer.draw(true), studio.player.viewer.triangles)"
    assert page.value(moving) <= 20_000
    assert not page.value("studio.player.viewer.pace.isLight")
    page.value("Array(20).fill().forEach(() => studio.player.viewer.tookFrame(400))")
    assert page.value("studio.player.viewer.pace.isLight")
    # Quick again, it draws more, but not as much as was too slow.
    page.value(f"{moving}, Array(15).fill().forEach(() => studio.player.viewer.tookFrame(16))")
    assert 20_000 < page.value("studio.player.viewer.pace.budget") < budget


def test_nodes_are_made_by_the_middle_button_and_by_the_keyboard(page: Page) -> None:
    page.open(None)
    page.page.mouse.click(*page.place(0.0, -0.4), button="middle")
    assert page.value("studio.editor.drawing.nodes.n1.at") == [0, -0.4]
    assert page.value("studio.editor.drawing.chains") == []
    page.page.keyboard.press("n")
    page.page.keyboard.press("n")
    assert page.value("studio.editor.drawing.chains") == [["n1", "n2", "n3"]]
    assert page.value("studio.editor.drawing.nodes.n3.at") == [0, 0]
    page.page.keyboard.press(",")
    page.page.keyboard.press("Shift+ArrowRight")
    page.page.keyboard.press("e")
    moved = page.value("studio.editor.drawing.nodes.n2")
    assert moved == {"at": [0.1, -0.2], "radius": pytest.approx(0.088)}
    # A loose connection is completed by the middle button and aborted by the right one.
    page.page.keyboard.press("d")
    page.page.mouse.click(*page.place(0.3, 0.3))
    page.page.mouse.click(*page.place(0.5, 0.3), button="middle")
    assert page.value("studio.editor.loose") is None
    assert page.value("studio.editor.drawing.chains[1].length") == 2
    page.page.mouse.click(*page.place(0.3, 0.6))
    page.page.mouse.click(*page.place(0.5, 0.6), button="right")
    assert page.value("studio.editor.loose") is None
    count = "Object.keys(studio.editor.drawing.nodes).length"
    nodes = page.value(count)
    page.page.mouse.click(*page.place(0.3, 0.6), button="middle")
    assert page.value(count) == nodes - 1
    # A drag of the middle button moves the board.
    before = page.value("studio.editor.view.x")
    page.page.mouse.move(*page.place(-0.4, 0.5))
    page.page.mouse.down(button="middle")
    page.page.mouse.move(*page.place(-0.2, 0.5), steps=4)
    page.page.mouse.up(button="middle")
    assert page.value("studio.editor.view.x") == pytest.approx(before - 0.2, abs=0.02)
    assert page.value(count) == nodes - 1


MEETING = """\
pronk: 1
duration: 3
terrain: {kind: flat, size: [16, 16], cells: [16, 16], material: turf}
materials:
  turf: {preset: grass, color: "#7d9a55"}
cast:
  - name: bug
    figure: beetle
    at: [0, 1.4]
    walk: {path: [[6, 1.4]], speed: 0.8}
  - name: mare
    figure: horse
    at: [-0.5, -1.2]
    walk: {path: [[6, -1.2]], speed: 1.2}
"""


def test_sounds_and_keys_are_explained_under_the_pointer_and_heard(page: Page) -> None:
    (page.served.folder / "walk.yaml").write_text(MEETING)
    page.open("walk.yaml")
    page.wait("studio.player.takes > 0 && Boolean(studio.player.hasSound)")
    page.value("studio.player.seek(1.2)")
    page.page.mouse.click(*_place_in(page, "world", "performerAt", "bug"))
    page.wait("studio.player.bars.curves.length > 0")
    page.picture("scene")
    at = (
        "(event => { const b = studio.player.bars, box = b.canvas.getBoundingClientRect();"
        " return [box.left + b.left + event.time / b.seconds * (box.width - b.left - 8),"
        " box.top + 8]; })(studio.player.facts.events[0])"
    )
    x, y = page.value(at)
    page.page.mouse.move(x, y)
    cause, who = page.value("(({cause, who}) => [cause, who])(studio.player.facts.events[0])")
    assert page.value("studio.player.bars.canvas.title").startswith(f"{cause} of {who} at ")
    page.page.mouse.click(x, y)
    assert page.value("studio.player.playing")
    assert page.page.inner_text("#status").startswith(f"{cause} of {who} at ")
    page.wait("!studio.player.playing")
    box = page.page.locator(".cm-line", has_text="terrain:").bounding_box()
    page.page.mouse.move(box["x"] + 20, box["y"] + 8, steps=3)
    page.wait("document.querySelector('.cm-tooltip-hover')?.textContent.startsWith('terrain: ')")


def test_a_file_that_another_program_changed_is_replaced_only_when_asked(page: Page) -> None:
    page.open("walk.yaml")
    file = page.served.folder / "walk.yaml"
    other = SCENE.replace("frames: 8", "frames: 10")
    file.write_text(other)
    _replace(page, "frames: 8", "frames: 12")
    asked: list[str] = []
    page.page.once("dialog", lambda dialog: _refused(dialog, asked))
    page.page.click("#save")
    page.wait("document.getElementById('status').classList.contains('bad')")
    assert "walk.yaml was changed by another program" in asked[0]
    assert file.read_text() == other
    page.page.once("dialog", lambda dialog: dialog.accept())
    _save(page)
    assert file.read_text() == SCENE.replace("frames: 8", "frames: 12")


def _refused(dialog: Any, asked: list[str]) -> None:
    asked.append(dialog.message)
    dialog.dismiss()


def test_a_document_that_is_not_there_is_told_and_the_library_shown(page: Page) -> None:
    page.open("gone.yaml")
    assert page.page.locator("#library").is_visible()
    assert "there is no file 'gone.yaml'" in page.page.inner_text("#status")


BEETLE = (library() / "figures" / "beetle.yaml").read_text(encoding="utf-8")


def test_a_wrong_figure_is_mended_in_its_text(page: Page) -> None:
    (page.served.folder / "figures").mkdir()
    file = page.served.folder / "figures" / "bad.yaml"
    file.write_text(BEETLE.replace("style:", "sytle:"))
    page.open("figures/bad.yaml")
    assert page.page.inner_text("#status").startswith("figures/bad.yaml:5:3: figure.sytle: ")
    assert page.page.inner_text("#figure-text .cm-lintRange-error") == "sytle"
    assert page.page.locator("#board[inert]").count() == 1
    page.picture("wrong_figure")
    # Saved as it is typed, even where it is no figure yet.
    _replace(page, "green chitin", "brown chitin", "editor.text")
    _save(page)
    assert file.read_text() == BEETLE.replace("style:", "sytle:").replace("green", "brown")
    _replace(page, "sytle", "style", "editor.text")
    page.wait("studio.editor.walks > 0 && studio.editor.isIdle")
    assert page.page.locator("#board[inert]").count() == 0
    assert page.value("studio.editor.isDirty")
    _save(page)
    assert file.read_text() == BEETLE.replace("green", "brown")
    assert not page.value("studio.editor.isDirty")


def test_the_text_of_a_figure_follows_its_drawing_and_is_followed(page: Page) -> None:
    page.open("library:figures/beetle.yaml")
    page.wait("studio.editor.walks > 0")
    page.page.focus("#canvas")
    page.page.keyboard.press("y")
    page.wait("studio.editor.text.isShown && studio.editor.isIdle")
    assert page.value("studio.editor.text.editor.text") == BEETLE
    page.value("studio.editor.select(['foot3_l'])")
    page.page.keyboard.press("Shift+ArrowDown")
    page.wait("studio.editor.isIdle")
    assert page.value("studio.editor.text.editor.text") == BEETLE.replace("1.40]", "1.50]")
    _replace(page, "-1.45, 1.50]", "-1.25, 1.70]", "editor.text")
    page.wait("studio.editor.drawing.nodes.foot3_l.at[1] === 1.7")
    for wanted in ([-1.45, 1.5], [-1.45, 1.4]):
        page.page.click("#undo")
        page.wait("studio.editor.isIdle")
        assert page.value("studio.editor.drawing.nodes.foot3_l.at") == wanted
    assert page.value("studio.editor.text.editor.text") == BEETLE
    # A joint that no limb has: right as a text, and told where it stands.
    wrong = "  joints: {l9: {joint1_bend: {rest_deg: 1}}}\n  skin:"
    _replace(page, "  skin:", wrong, "editor.text")
    page.wait("document.querySelector('#figure-text .cm-lintRange-error') !== null")
    assert page.page.inner_text("#figure-text .cm-lintRange-error") == "joint1_bend"
    page.picture("figure_text")


def test_a_picture_behind_is_moved_scaled_and_turned(page: Page, tmp_path: Path) -> None:
    page.open("library:figures/beetle.yaml")
    (tmp_path / "none.png").write_text("no picture")
    page.page.set_input_files("#picture", tmp_path / "none.png")
    page.wait("document.getElementById('status').textContent.includes('is no picture')")
    page.page.click("#move-picture")
    assert page.value("studio.editor.backdrop.isMoved") is False
    Image.new("RGB", (400, 300), "black").save(tmp_path / "skeleton.png")
    page.page.set_input_files("#picture", tmp_path / "skeleton.png")
    page.wait("studio.editor.backdrop.current !== null")
    before = page.value("JSON.stringify(studio.editor.drawing)")
    page.page.click("#move-picture")
    page.drag((0.0, 0.0), (0.4, -0.3))
    placed = "(({x, y, width, turn}) => [x, y, width, turn])(studio.editor.backdrop.current)"
    assert page.value(placed) == pytest.approx([0.4, -0.3, 2, 0], abs=0.02)
    page.page.mouse.move(*page.place(0.4, -0.3))
    page.page.mouse.wheel(0, -462)
    page.wait("studio.editor.backdrop.current.width > 3")
    assert page.value(placed) == pytest.approx([0.4, -0.3, 4, 0], abs=0.03)
    page.page.keyboard.down("Shift")
    page.page.mouse.wheel(0, 100)
    page.page.keyboard.up("Shift")
    page.wait("Math.abs(studio.editor.backdrop.current.turn) === 1")
    page.page.fill("#picture-turn", "90")
    page.page.press("#picture-turn", "Enter")
    assert page.value("studio.editor.backdrop.current.turn") == 90
    dark = "[...studio.editor.context.getImageData(%s, %s, 1, 1).data]"
    x, y = page.value("studio.editor.toScreen([0.35, 1.55])")
    assert page.value(dark % (round(x), round(y)))[3] > 100
    page.page.keyboard.press("Escape")
    assert page.value("studio.editor.backdrop.isMoved") is False
    assert page.value("JSON.stringify(studio.editor.drawing)") == before
    # It stays with its figure.
    page.page.click("#tab-library")
    page.page.click("[data-name='library:figures/horse.yaml']")
    page.wait("studio.editor.analysis?.headline.startsWith('mammal, 4 legs')")
    assert page.value("studio.editor.backdrop.current") is None
    page.page.click("#tab-library")
    page.page.click("[data-name='library:figures/beetle.yaml']")
    page.wait("studio.editor.backdrop.current !== null")


def test_what_is_not_drawn_yet_shows_no_other_creature(page: Page) -> None:
    page.open("library:figures/tripod.yaml")
    page.wait("studio.editor.walks > 0")
    page.page.click("#tab-library")
    page.page.click("[data-name='']")
    page.wait("document.getElementById('name').textContent === 'new figure'")
    assert page.value("studio.editor.viewer.model") is None
    assert page.page.inner_text("#headline") == ""
    page.page.click("#save")
    assert page.page.inner_text("#status") == "there is nothing to save yet"


def test_a_studio_that_has_ended_is_told(page: Page) -> None:
    page.open("walk.yaml")
    page.wait("studio.player.takes > 0")
    page.page.context.set_offline(True)
    page.page.click("#save")
    page.page.wait_for_selector("#status.bad")
    assert "start it again" in page.page.inner_text("#status")
