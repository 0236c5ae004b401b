"""The main scene: simulation against real time, and where a warm render spends its time.

Prints two ratios measured in this run: seconds of film a second of simulation, and the
part of a warm preview render at 1280x720 that is spent inside Mitsuba and the denoiser.

    python benchmarks/first_steps.py [frames to render]
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from pipeline.production.run.outputs import Outputs
from pipeline.production.shots.frame_rendering import frame_key, render_frames
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import Simulation
from pipeline.spec import find_scene, load_scene
from render.backend import choose
from render.renderer import Renderer


def main(count: int) -> None:
    """Measure and print."""
    scene = load_scene(find_scene("first_steps"), ["film.size=[1280,720]"])
    length = scene.n_frames / float(scene.rate)
    steps, whole = [], []
    for _ in range(9):
        began = time.perf_counter()
        simulation = Simulation(scene)
        built = time.perf_counter()
        while not simulation.finished:
            simulation.step()
        ended = time.perf_counter()
        steps.append(length / (ended - built))
        whole.append(length / (ended - began))
    take = simulation.take()
    print(f"simulation: {sorted(steps)[4]:.1f} times real time (median of 9 runs),")
    print(f"  {sorted(whole)[4]:.1f} with the building of the world, once a scene")

    renderer = Renderer(choose())
    shooting = ShotBuilder(scene, take)
    renderer.render(shooting.shot(1))  # compiles the kernels
    cold = renderer.timings.seconds
    with tempfile.TemporaryDirectory() as folder:
        outputs = Outputs(Path(folder), "bench")
        outputs.frames.mkdir()
        began = time.perf_counter()
        keys = {k: frame_key(shooting, k, renderer.key_extra) for k in range(1, count + 1)}
        for _ in render_frames(renderer, shooting, outputs, keys):
            pass
        wall = time.perf_counter() - began
    split = renderer.timings
    inside = split.seconds - cold
    print(f"first frame, with build: {cold:.2f} s")
    print(f"warm preview: {wall / count:.2f} s a frame over {count} frames")
    print(f"inside Mitsuba and the denoiser: {100 * inside / wall:.1f}% of the wall time")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 24)
