"""Scenery: what plants and stones cost a frame, or the coats of animals.

Frames of a shipped scene are rendered in turn with and without what is scattered over its ground,
or without hair and feathers, by two renderers, so that both meet the same load of the machine.
Printed are the median processor time of a frame of each, and the ratio; the making of the shots is
not counted, and told apart.

    python benchmarks/scenery.py [scene] [width] [frames] [scattered|coats]
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipeline.production.coats.coats import MATERIALS as COATS
from pipeline.production.scenery.expansion import MATERIALS as SCATTERED
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import find_scene, load_scene
from render.backend import choose
from render.config import Material
from render.renderer import Renderer
from render.shot import Shot

WARM_UP = 2
"""Frames of each renderer that are not counted: kernels are compiled for them."""


KINDS = {"scattered": SCATTERED, "coats": COATS}
"""Materials that are left out, by the word for them."""


def main(name: str, width: int, count: int, kind: str) -> None:
    """Measure and print."""
    materials = KINDS[kind]
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
    renderers = {"bare": Renderer(choose()), kind: Renderer(choose())}
    seconds: dict[str, list[float]] = {key: [] for key in renderers}
    for key in WARM_UP * tuple(renderers):
        renderers[key].render(shots[0] if key == kind else _without(shots[0], materials))
    for shot in shots:
        for key, renderer in renderers.items():
            start = time.process_time()
            renderer.render(shot if key == kind else _without(shot, materials))
            seconds[key].append(time.process_time() - start)
    triangles = sum(
        len(m.faces) for m in (*shots[0].meshes, *shots[0].scenery) if m.material in materials
    )
    bare, full = (float(np.median(values)) for values in seconds.values())
    print(f"{name}, {size[0]}x{size[1]}, {count} frames, {triangles} triangles of {kind}")
    print(f"  made in {made:.1f} s; largest memory of both together {_memory():.0f} MiB")
    print(f"  bare {bare:.2f} s, {kind} {full:.2f} s of processor a frame", end="")
    print(f": x{full / bare:.2f}")


def _without(shot: Shot, materials: Mapping[str, Material]) -> Shot:
    """Return a shot without the meshes of some materials."""
    meshes, scenery = (
        tuple(m for m in some if m.material not in materials)
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
        words[3] if len(words) > 3 else "scattered",
    )
