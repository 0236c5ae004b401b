"""Memory of a render: the most that a large frame takes, and what stays over thousands of frames.

Each is measured in a process of its own, as the resident set that the kernel tells:

- peak: the main scene at 1920x1080 as `final` has it, some frames one after the other, beside the
  bytes of one such picture of three floats a pixel;
- scenery: two frames at 1280x720 as `preview` has them, of scenes with millions of triangles;
- flat: the main scene as `draft` has it, over and over, at the tenth frame and at the last; their
  ratio is printed.

    python benchmarks/memory.py [frames of the large film] [frames of the long film]
"""

from __future__ import annotations

import multiprocessing
import resource
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

PAGE = resource.getpagesize()
MIB = 1 << 20
FRAME, EARLY = 40, 10
WITH_SCENERY = ("first_steps", "antelope_herd", "chase")


def main(large: int, long: int) -> None:
    """Measure and print."""
    size = (1920, 1080)
    top = _alone(peak, "first_steps", large, "final", size)
    picture = size[0] * size[1] * 3 * 4
    print(f"1920x1080 final, {large} frames: peak {top / MIB:.0f} MiB,")
    print(f"  {top / picture:.1f} times one picture of 32-bit floats")
    for name in WITH_SCENERY:
        most = _alone(peak, name, 2, "preview", (1280, 720))
        print(f"1280x720 preview, 2 frames of {name}: peak {most / MIB:.0f} MiB")
    early, late = _alone(kept, long)
    print(f"draft: {early / MIB:.0f} MiB after {EARLY} frames, {late / MIB:.0f} after {long}:")
    print(f"  a ratio of {late / early:.3f}")


def _alone(measure: Callable[..., Any], *words: Any) -> Any:
    """Return what is measured in a fresh process, which has taken nothing before."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(measure, words)


def peak(name: str, frames: int, preset: str, size: tuple[int, int]) -> int:
    """Return the most memory that some frames of a scene have taken [bytes]."""
    words = [f"film.preset={preset}", f"film.size=[{size[0]},{size[1]}]"]
    for _ in _rendered(name, frames, words):
        pass
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def kept(frames: int) -> tuple[int, int]:
    """Return the memory held after the first frames and after all of them [bytes]."""
    held = [_resident() for _ in _rendered("first_steps", frames, ["film.preset=draft"])]
    return held[min(EARLY, frames) - 1], held[-1]


def _resident() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE


def _rendered(name: str, frames: int, words: list[str]) -> Iterator[object]:
    from pipeline.production.shots.shot_builder import ShotBuilder
    from pipeline.simulation.simulate import simulate
    from pipeline.spec import find_scene, load_scene
    from render.backend import choose
    from render.renderer import Renderer

    scene = load_scene(find_scene(name), words)
    shooting = ShotBuilder(scene, simulate(scene))
    renderer = Renderer(choose())
    for k in range(frames):
        yield renderer.render(shooting.shot((FRAME + k - 1) % scene.n_frames + 1))


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    main(*given, *(4, 2000)[len(given) :])
