"""Flicker: how much a film changes from frame to frame, by the seeds of its noise.

Consecutive frames of a shipped scene are rendered with one seed for all of them, as films are,
with a seed of each frame's own, and with so many samples that no noise is left. Printed is the mean
change of a pixel from one frame to the next, of 255, which is least in the truth, and how far
frames are from it: a fixed seed could show as a pattern that stands still over what moves.

With `--still` the performers and the camera of some scenes are held, so that only light and air
move: printed is the FLIP between neighbouring frames as `final` has them, which is flicker.

    python benchmarks/flicker.py --still [scene ...]
    python benchmarks/flicker.py [scene] [first frame] [frames]
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import find_scene, load_scene
from render.backend import choose
from render.comparison.flip_metric import flip
from render.config import Film
from render.renderer import Renderer

SIZE, DEPTH, SAMPLES, ENOUGH = (320, 180), 4, 2, 256
STILL, STILL_SIZE, STILL_AT = ("antelope_herd", "chase", "first_steps"), (640, 360), 40
"""Scenes with grass, fur and drifting clouds, the size they are rendered at, and the frame."""

Frames = NDArray[np.float64]


def main(name: str, first: int, count: int) -> None:
    """Measure and print."""
    renderer = Renderer(choose())
    scene = load_scene(find_scene(name))
    shooting = ShotBuilder(scene, simulate(scene))

    def film(samples: int, soft_light: str, stride: int) -> Frames:
        words = Film.model_validate(
            {"size": SIZE, "samples": samples, "depth": DEPTH, "soft_light": soft_light}
        )
        shots = [shooting.shot(number) for number in range(first, first + count)]
        return np.array(
            [
                renderer.render(replace(shot, film=words, later=(), seed=stride * k)).srgb8
                for k, shot in enumerate(shots)
            ],
            float,
        )

    truth = film(ENOUGH, "full", 0)
    print(f"{name}, frames {first}-{first + count - 1}, {SIZE[0]}x{SIZE[1]}, {SAMPLES} samples")
    print(f"  {'':16s}{'change a frame':>16s}{'off the truth':>16s}{'its part that stays':>22s}")
    print(f"  {'truth':16s}{change(truth):16.3f}")
    for way, stride in (("one seed", 0), ("seeds of their own", 104_729)):
        seen = film(SAMPLES, "half", stride)
        error = seen - truth
        # What noise has in common over all frames is a pattern that stands still.
        stays = np.abs(error.mean(axis=0)).mean() / np.abs(error).mean()
        print(f"  {way:16s}{change(seen):16.3f}{np.abs(error).mean():16.3f}{stays:22.2f}")


def still(names: list[str]) -> None:
    """Measure and print the flicker of scenes in which only light and air move."""
    renderer = Renderer(choose())
    for name in names:
        words = ["film.preset=final", f"film.size=[{STILL_SIZE[0]},{STILL_SIZE[1]}]"]
        scene = load_scene(find_scene(name), words)
        shooting = ShotBuilder(scene, simulate(scene))
        held = replace(shooting.shot(STILL_AT), later=())
        times = [shooting.shot(STILL_AT + k).time for k in range(2)]
        one, two = (renderer.render(replace(held, time=time)).srgb8 for time in times)
        print(f"{name}, held at frame {STILL_AT}, final: FLIP {flip(one, two).mean():.4f}")


def change(frames: Frames) -> float:
    """Return the mean change of a pixel from one frame to the next, of 255."""
    return float(np.abs(np.diff(frames, axis=0)).mean())


if __name__ == "__main__":
    words = sys.argv[1:]
    if words[:1] == ["--still"]:
        still(words[1:] or list(STILL))
        sys.exit()
    main(
        words[0] if words else "first_steps",
        int(words[1]) if len(words) > 1 else 40,
        int(words[2]) if len(words) > 2 else 8,
    )
