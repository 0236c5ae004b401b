"""The studio's page in a browser: playback by software GL, drags, edits, and how soon it answers.

Creatures are drawn with all of their triangles, and as the page does while they move, in turns in
one browser; the ratio is what counts. The other figures are of a machine at rest only, and stand
beside the longest that an author should wait. Needs playwright and Chromium:

    python benchmarks/studio.py [CREATURES ...]
"""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

FRAMES, TURNS = 20, 5

DRAGS = 300
"""Movements of the mouse."""

EDITS, QUARTERS, WARM_UP = 1000, 4, 100

EDIT = """() => {
  studio.editor.select(["knee3_l"]);
  studio.editor.translate(studio.editor.undos.length % 2 ? 0.01 : -0.01, 0, false);
}"""

RETYPE = """(speed) => {
  const { view } = studio.player.editor;
  const found = /speed: ([0-9.]+)/.exec(view.state.doc.toString());
  const to = found.index + found[0].length;
  view.dispatch({ changes: { from: to - found[1].length, to, insert: speed } });
}"""

DRAW = """([frames, isMoving]) => {
  const { viewer, facts } = studio.player;
  const context = viewer.renderer.getContext();
  const pixel = new Uint8Array(4);
  const own = [];
  for (let i = 0; i < frames; i++) {
    const start = performance.now();
    viewer.seek((i * 0.04) % facts.seconds);
    viewer.draw(isMoving);
    own.push(performance.now() - start);
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, pixel);
  }
  viewer.draw(isMoving);
  own.sort((a, b) => a - b);
  return [viewer.triangles, viewer.renderer.info.render.calls, own[frames >> 1]];
}"""
"""Draws frames, each waited for; returns the triangles and calls of the last, and how long the page
itself took for one, the median [ms]: all that is left to it with a graphics processor."""


def scene(count: int) -> str:
    """Return a scene with some creatures that walk."""
    members = (
        f"  - {{figure: {('beetle', 'horse')[i % 2]}, at: [{i // 5 * 4 - 6}, {i % 5 * 4 - 8}], "
        "walk: {speed: 0.6}}\n"
        for i in range(count)
    )
    ground = "terrain: {kind: flat, size: [60, 60], cells: [30, 30]}"
    return f"pronk: 1\nduration: 2\n{ground}\ncast:\n{''.join(members)}"


def wait(page: Any, expression: str) -> None:
    """Wait until an expression of the page holds."""
    while not page.evaluate(expression):
        time.sleep(0.02)


@contextmanager
def served(folder: Path, document: str) -> Iterator[tuple[str, int]]:
    """Run the studio in a process of its own; give its address and process."""
    command = [sys.executable, "-m", "pipeline.cli", "studio", document, "--no-browser"]
    source = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[1])}
    with subprocess.Popen(
        command, cwd=folder, env=source, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        yield process.stdout.readline().strip(), process.pid
        process.terminate()


def memory(process: int) -> int:
    """Return the memory of a process [bytes]."""
    words = Path(f"/proc/{process}/statm").read_text().split()
    return int(words[1]) * os.sysconf("SC_PAGE_SIZE")


def children_time() -> float:
    """Return the processor time of all processes below this one so far [s]."""
    above: dict[int, tuple[int, int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                words = (entry / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            above[int(entry.name)] = int(words[1]), int(words[11]) + int(words[12])
    own = {os.getpid()}
    while more := {one for one, (parent, _) in above.items() if parent in own} - own:
        own |= more
    ticks = sum(above[one][1] for one in own - {os.getpid()} if one in above)
    return ticks / os.sysconf("SC_CLK_TCK")


def playback(page: Any, folder: Path, address: str, count: int) -> None:
    """Print the processor time of a frame of some creatures, whole and moving."""
    (folder / "creatures.yaml").write_text(scene(count))
    page.goto(address)
    wait(page, "Boolean(window.studio?.player?.film)")
    spent: dict[bool, list[float]] = {False: [], True: []}
    drawn = {}
    for _ in range(TURNS):
        for is_moving, times in spent.items():
            page.evaluate(DRAW, [2, is_moving])
            time.sleep(0.3)
            before = children_time()
            drawn[is_moving] = page.evaluate(DRAW, [FRAMES, is_moving])
            times.append((children_time() - before) / FRAMES * 1000)
    whole, moving = (statistics.median(spent[key]) for key in (False, True))
    print(f"{count} creatures: ratio {whole / moving:.1f}")
    for text, is_moving, cost in (("whole", False, whole), ("moving", True, moving)):
        triangles, calls, own = drawn[is_moving]
        print(f"  {text}: {triangles} triangles in {calls} calls, {cost:.0f} ms of processor time")
        print(f"    {own:.1f} ms a frame by the page alone (16.7)")


def opening(page: Any, address: str) -> None:
    """Print how long the page takes until a scene can be edited, and its first frames."""
    page.goto(address)
    wait(page, "Boolean(window.studio?.isReady)")
    ready = page.evaluate("performance.now()")
    wait(page, "studio.player.changeShown !== null")
    shown = page.evaluate("studio.player.changeShown")
    print(f"page ready after {ready:.0f} ms (2000), frames of its scene after {shown:.0f} ms more")
    times = []
    for speed in ("0.5", "0.7", "0.8"):
        page.evaluate(RETYPE, speed)
        wait(page, "studio.player.changeShown !== null")
        times.append(page.evaluate("studio.player.changeShown"))
    print(f"first frames {max(times):.0f} ms after a change (2000), worst of {len(times)}")


def dragging(page: Any, address: str) -> None:
    """Print how soon a dragged node is drawn, and its analysis, at the 95th percentile."""
    page.goto(address)
    wait(page, "window.studio?.editor?.walks > 0")
    page.keyboard.press("s")
    box = page.locator("#canvas").bounding_box()
    x, y = page.evaluate("studio.editor.toScreen(studio.editor.drawing.nodes.knee3_l.at)")
    page.mouse.move(box["x"] + x, box["y"] + y)
    page.mouse.down()
    for k in range(DRAGS):
        page.mouse.move(box["x"] + x - 20 + k % 40, box["y"] + y + k % 30)
        time.sleep(1 / 60)
    page.mouse.up()
    metrics = page.evaluate("studio.editor.metrics")
    for name, most in (("drawing", 20), ("analysis", 50)):
        cut = statistics.quantiles(metrics[name], n=20)[-1]
        count = len(metrics[name])
        print(f"{name} of a drag: {cut:.1f} ms ({most}), 95th percentile of {count}")


def editing(page: Any, address: str, server: int) -> None:
    """Print the page's memory after each quarter of many edits of a figure."""
    page.goto(address)
    wait(page, "window.studio?.editor?.walks > 0")
    session = page.context.new_cdp_session(page)
    sizes: list[tuple[float, float]] = []
    for _ in range(QUARTERS + 1):
        for _ in range(EDITS // QUARTERS if sizes else WARM_UP):
            page.evaluate(EDIT)
        wait(page, "studio.editor.isIdle")
        session.send("HeapProfiler.collectGarbage")
        heap = session.send("Runtime.getHeapUsage")["usedSize"] / 2**20
        sizes.append((heap, memory(server) / 2**20))
    for name, column in (("page", 0), ("server", 1)):
        listed = ", ".join(f"{size[column]:.0f}" for size in sizes)
        print(f"memory of the {name} over {EDITS} edits: {listed} MiB")


def main() -> None:
    """Measure all, playback for each number of creatures."""
    counts = [int(word) for word in sys.argv[1:]] or [10, 20]
    program = os.environ.get("PRONK_BROWSER") or shutil.which("chromium")
    if program is None or find_spec("playwright") is None:
        print("left out: it needs Chromium and playwright")
        return
    import playwright.sync_api as driver

    with tempfile.TemporaryDirectory() as name, driver.sync_playwright() as started:
        folder = Path(name)
        flags = ["--no-sandbox", "--enable-unsafe-swiftshader"]
        browser = started.chromium.launch(executable_path=program, args=flags)
        page = browser.new_page(viewport={"width": 1280, "height": 760})
        with served(folder, "beetle") as (address, server):
            dragging(page, address)
            editing(page, address, server)
        (folder / "creatures.yaml").write_text(scene(1))
        with served(folder, "creatures.yaml") as (address, _):
            opening(page, address)
            for count in counts:
                playback(page, folder, address, count)
        browser.close()


if __name__ == "__main__":
    main()
