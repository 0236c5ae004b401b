"""The air: processor time of a frame with weather, fire or dust, and of the same frame without.

Both are rendered in turn in one process, so that what else runs slows both. Printed are the medians
[s] and their ratio.

    python benchmarks/air.py [width] [rounds]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import find_scene, load_scene
from render.backend import choose
from render.config import Weather
from render.renderer import Renderer
from render.shot import Shot

FRAME = 40


def main(width: int, rounds: int) -> None:
    """Measure and print."""
    backend = choose()
    for name, (scene_name, without, weather) in CASES.items():
        scene = load_scene(find_scene(scene_name), [f"film.size=[{width},{width * 9 // 16}]"])
        builder = ShotBuilder(scene, simulate(scene))
        if weather:
            # The same haze in both: what falls is measured, not what is seen through it.
            changed = {"weather": Weather.model_validate(weather), "haze": 0.3}
            builder.light = builder.light.model_copy(update=changed)
        kinds: tuple[Callable[[Shot], Shot], ...] = (lambda shot: shot, without)
        # One renderer each, or each frame would build its scene anew.
        renderers = [Renderer(backend) for _ in kinds]
        seconds: list[list[float]] = [[], []]
        for k in range(rounds + 1):
            for i, kind in enumerate(kinds):
                shot = kind(builder.shot(FRAME + k))
                began = time.process_time()
                renderers[i].render(shot)
                seconds[i].append(time.process_time() - began)
        # The first frame compiles kernels and builds the scene.
        full, bare = (float(np.median(times[1:])) for times in seconds)
        print(f"{name:16s} {full:6.2f} s, without {bare:6.2f} s: x{full / bare:.2f}", flush=True)


def _still_clouds(shot: Shot) -> Shot:
    light = shot.light.without_cloud_shadows()
    calm = light.weather.model_copy(update={"wind": 0.0})
    return replace(shot, light=light.model_copy(update={"weather": calm}), time=0.0)


def _dry(shot: Shot) -> Shot:
    none = shot.light.weather.model_copy(update={"rain": 0.0, "snow": 0.0})
    return replace(shot, light=shot.light.model_copy(update={"weather": none}))


def _cold(shot: Shot) -> Shot:
    return replace(shot, plumes=())


def _clean(shot: Shot) -> Shot:
    return replace(shot, puffs=())


CASES: Mapping[str, tuple[str, Callable[[Shot], Shot], dict[str, Any]]] = {
    "drifting clouds": ("first_steps", _still_clouds, {}),
    "rain": ("first_steps", _dry, {"rain": 0.6}),
    "snow": ("first_steps", _dry, {"snow": 0.6}),
    "fire and smoke": ("campfire", _cold, {}),
    "dust": ("antelope_herd", _clean, {}),
}
"""Scene, the frame without, and weather."""


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    main(*(numbers + [640, 5][len(numbers) :]))
