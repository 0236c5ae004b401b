"""Playback of the studio's page by software GL: processor time of a frame, whole and moving.

Creatures are drawn with all of their triangles, and as the page does while they move, in turns in
one browser; the ratio is what counts. Needs playwright and Chromium:

    python benchmarks/studio.py [CREATURES ...]
"""

from __future__ import annotations

import os
import shutil
import statistics
import sys
import tempfile
import threading
import time
from importlib.util import find_spec
from pathlib import Path

import uvicorn

from pipeline.studio.app import Studio, application
from pipeline.studio.project import Project
from pipeline.studio.server import listener

FRAMES, TURNS = 20, 5

DRAW = """([frames, isMoving]) => {
  const { viewer, facts } = studio.player;
  const context = viewer.renderer.getContext();
  const pixel = new Uint8Array(4);
  for (let i = 0; i < frames; i++) {
    viewer.seek((i * 0.04) % facts.seconds);
    viewer.draw(isMoving);
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, pixel);
  }
  viewer.draw(isMoving);
  return viewer.triangles;
}"""
"""Draws frames, each waited for; returns the triangles of the last."""


def scene(count: int) -> str:
    """Return a scene with some creatures that walk."""
    members = (
        f"  - {{figure: {('beetle', 'horse')[i % 2]}, at: [{i // 5 * 4 - 6}, {i % 5 * 4 - 8}], "
        "walk: {speed: 0.6}}\n"
        for i in range(count)
    )
    ground = "terrain: {kind: flat, size: [60, 60], cells: [30, 30]}"
    return f"pronk: 1\nduration: 2\n{ground}\ncast:\n{''.join(members)}"


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


def main() -> None:
    """Measure each number of creatures."""
    counts = [int(word) for word in sys.argv[1:]] or [10, 20]
    program = os.environ.get("PRONK_BROWSER") or shutil.which("chromium")
    if program is None or find_spec("playwright") is None:
        print("left out: it needs Chromium and playwright")
        return
    import playwright.sync_api as driver

    with tempfile.TemporaryDirectory() as folder, listener(0) as bound:
        studio = Studio(Project.at(Path(folder)), None, "t0ken")
        port = bound.getsockname()[1]
        config = uvicorn.Config(application(studio, port), log_level="error", lifespan="off")
        server = uvicorn.Server(config)
        thread = threading.Thread(target=server.run, args=([bound],), daemon=True)
        thread.start()
        with driver.sync_playwright() as started:
            flags = ["--no-sandbox", "--enable-unsafe-swiftshader"]
            browser = started.chromium.launch(executable_path=program, args=flags)
            page = browser.new_page(viewport={"width": 1280, "height": 760})
            for count in counts:
                studio.first = f"creatures_{count}.yaml"
                (Path(folder) / studio.first).write_text(scene(count))
                page.goto(f"http://127.0.0.1:{port}/?token=t0ken")
                while not page.evaluate("Boolean(window.studio?.player?.film)"):
                    time.sleep(0.5)
                spent: dict[bool, list[float]] = {False: [], True: []}
                triangles = {}
                for _ in range(TURNS):
                    for is_moving, times in spent.items():
                        page.evaluate(DRAW, [2, is_moving])
                        time.sleep(0.3)
                        before = children_time()
                        triangles[is_moving] = page.evaluate(DRAW, [FRAMES, is_moving])
                        times.append((children_time() - before) / FRAMES * 1000)
                whole, moving = (statistics.median(spent[key]) for key in (False, True))
                print(f"{count} creatures: ratio {whole / moving:.1f}")
                print(f"  whole {triangles[False]} triangles, {whole:.0f} ms")
                print(f"  moving {triangles[True]} triangles, {moving:.0f} ms")
            browser.close()
        studio.stop()
        server.should_exit = True
        thread.join(10)


if __name__ == "__main__":
    main()
