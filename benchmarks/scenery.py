"""Scenery: what plants and stones cost a frame.

Frames of a shipped scene are rendered in turn with and without what is scattered over its ground,
by two renderers, so that both meet the same load of the machine. Printed are the median processor
time of a frame of each, and the ratio; its building is not counted, and told apart.

    python benchmarks/scenery.py [scene] [width] [frames]
"""

from __future__ import annotations

import resource
import sys
import time
from dataclasses import replace

import numpy as np

from pipeline.production.scenery.expansion import MATERIALS
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import find_scene, load_scene
from render.backend import choose
from render.renderer import Renderer
from render.shot import Shot

WARM_UP = 2
"""Frames of each renderer that are not counted: kernels are compiled for them."""


def main(name: str, width: int, count: int) -> None:
    """Measure and print."""
    scene = load_scene(find_scene(name))
    size = (width, 2 * round(width * 9 / 32))
    film = scene.film.model_copy(update={"size": size})
    scene = scene.model_copy(update={"film": film})
    shooting = ShotBuilder(scene, simulate(scene))
    start = time.process_time()
    shots = [
        replace(shooting.shot(int(k)), later=(), after=None)
        for k in np.linspace(1, scene.n_frames, count + 2)[1:-1]
    ]
    made = time.process_time() - start
    renderers = {"bare": Renderer(choose()), "scattered": Renderer(choose())}
    seconds: dict[str, list[float]] = {key: [] for key in renderers}
    for key in WARM_UP * tuple(renderers):
        renderers[key].render(_chosen(shots[0], key))
    for shot in shots:
        for key, renderer in renderers.items():
            start = time.process_time()
            renderer.render(_chosen(shot, key))
            seconds[key].append(time.process_time() - start)
    triangles = sum(
        len(m.faces) for m in (*shots[0].meshes, *shots[0].scenery) if m.material in MATERIALS
    )
    bare, scattered = (float(np.median(values)) for values in seconds.values())
    print(f"{name}, {size[0]}x{size[1]}, {count} frames, {triangles} triangles scattered")
    print(f"  made in {made:.1f} s; largest memory of both together {_memory():.0f} MiB")
    print(f"  bare {bare:.2f} s, scattered {scattered:.2f} s of processor a frame", end="")
    print(f": x{scattered / bare:.2f}")


def _chosen(shot: Shot, key: str) -> Shot:
    """Return a shot with what is scattered, or without."""
    if key == "scattered":
        return shot
    meshes, scenery = (
        tuple(m for m in some if m.material not in MATERIALS)
        for some in (shot.meshes, shot.scenery)
    )
    return replace(shot, meshes=meshes, scenery=scenery)


def _memory() -> float:
    """Return the largest memory of the process so far [MiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    words = sys.argv[1:]
    main(
        words[0] if words else "antelope_herd",
        int(words[1]) if len(words) > 1 else 1280,
        int(words[2]) if len(words) > 2 else 5,
    )
