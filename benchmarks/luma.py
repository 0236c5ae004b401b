"""Luma: how much of a screen's range the shipped scenes span by day.

The middle frame of the first second of each scene is metered and rendered at 320x180, or another
size. Printed are the median and the 99th percentile of its luma, and a mark where the law of
daylight is broken: a median of 0.25 to 0.55 and a 99th percentile of 0.85 to 0.97. With a folder
the pictures are written there.

    python benchmarks/luma.py [--out folder] [--size 320x180] [scene ...]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from pipeline.production.shots.exposure_metering import metered_tones
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import find_scene, load_scene
from pipeline.spec.scene_library import shipped_scenes
from render.backend import choose
from render.exposure_meter import daylight
from render.image_files import write_png
from render.renderer import Renderer

SECONDS = 1.0
MEDIAN, BRIGHT = (0.25, 0.55), (0.85, 0.97)
"""Bounds of the median and of the 99th percentile."""


def main(names: list[str], folder: Path | None, size: str) -> None:
    """Measure and print."""
    renderer, broken = Renderer(choose()), 0
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        shorter = [
            f"duration={SECONDS}",
            f"film.size=[{size.replace('x', ',')}]",
            "film.preset=preview",
        ]
        scene = load_scene(find_scene(name), shorter)
        builder = ShotBuilder(scene, simulate(scene))
        builder.set_tones(metered_tones(builder, renderer))
        frame = renderer.render(builder.shot(scene.n_frames // 2 + 1))
        luma = frame.srgb8 @ np.array([0.2126, 0.7152, 0.0722]) / 255.0
        median, bright = np.percentile(luma, [50.0, 99.0])
        is_day = daylight(scene.light) == 1.0
        kept = MEDIAN[0] <= median <= MEDIAN[1] and BRIGHT[0] <= bright <= BRIGHT[1]
        broken += is_day and not kept
        note = "" if not is_day or kept else "  outside the law"
        hour = "day" if is_day else "dark"
        print(f"{name:24s}{hour:6s}{median:8.2f}{bright:8.2f}{note}", flush=True)
        if folder is not None:
            write_png(folder / f"{name}.png", frame.srgb8, name)
    print(f"{broken} of {len(names)} scenes break the law")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--size", default="320x180")
    given = parser.parse_args()
    main(given.scenes or shipped_scenes(), given.out, given.size)
