"""The picture: seconds until a frame is as good as it should be, by several ways of rendering it.

Two scenes, sun and sky over textured ground and a studio with glossy bodies, are rendered with
ever more samples, and each picture is compared with a reference of 4,096 samples by Mitsuba's
`path`, which is kept in the user's cache. Printed are the seconds at which each way reaches 36, 40
and 44 dB of PSNR and a FLIP of 0.05, 0.035 and 0.025, between measured counts by interpolation:

- loop: `path`, independent samples, the scene built anew for each frame, no denoiser, as a first
  script of Mitsuba's would do it;
- path: `path` at its best: multijittered samples, the scene kept, and OIDN with colours;
- ours: looks and paths, soft light cleaned apart from colours, as in `final`;
- half: the same with soft light at half the size, as in `preview`;
- Cycles: where `bpy` is installed; it is told so where it is not.

    python benchmarks/picture.py [width] [samples of the reference]
"""

from __future__ import annotations

import hashlib
import importlib.util
import itertools
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import find_scene, load_scene
from render.backend import choose
from render.comparison.flip_metric import flip
from render.comparison.image_statistics import psnr
from render.config import Film
from render.denoiser import Denoiser
from render.development import developed
from render.frame import LightLayers
from render.shot import Shot

SCENES = {"first_steps": 40, "toy": 30}
"""And the frame of each."""

DEPTH = 4
COUNTS = {
    "loop": (4, 16, 64, 256),
    "path": (1, 4, 16, 64),
    "ours": (4, 8, 16, 32, 64, 128),
    "half": (1, 2, 4, 8, 16, 32),
}
"""Samples a pixel of each way; of ours, rays through each pixel."""
DECIBELS, FLIPS = (36.0, 40.0, 44.0), (0.05, 0.035, 0.025)
REPEATS = 3

Picture = NDArray[np.float32]


@dataclass(frozen=True)
class Point:
    """One way with one count of samples: seconds a frame, PSNR [dB] and FLIP."""

    count: int
    seconds: float
    psnr: float
    flip: float


def main(width: int, samples: int) -> None:
    """Measure and print."""
    choose().activate()
    size = (width, width * 9 // 16)
    for name, frame in SCENES.items():
        scene = load_scene(find_scene(name))
        shot = ShotBuilder(scene, simulate(scene)).shot(frame)
        # Mitsuba and Cycles, as they come, have neither haze nor shadows of clouds.
        clear = shot.light.model_copy(update={"haze": 0.0}).without_cloud_shadows()
        film = Film(size=size, depth=DEPTH, denoise="off")
        shot = replace(shot, film=film, light=clear, later=())
        print(f"{name}, frame {frame}, {size[0]}x{size[1]}, {samples} samples in the reference")
        judge = reference(shot, samples)
        curves = {way: measured(way, shot, judge) for way in COUNTS}
        table(curves)
        if importlib.util.find_spec("bpy") is None:
            print("Cycles: bpy is not installed, so that it is not measured")
        print()


def reference(shot: Shot, samples: int) -> Picture:
    """Return the light of the shot by `path`, from the cache where it was made before."""
    from render.mitsuba_scene import MitsubaScene
    from render.tracing.path_tracer import PathTracer

    key = hashlib.blake2b(f"{shot.digest}|{samples}".encode(), digest_size=10).hexdigest()
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    place = Path(base, "pronk", f"reference-{key}.npy")
    if place.exists():
        return np.asarray(np.load(place), np.float32)
    scene = MitsubaScene(shot)
    tracer = PathTracer(scene.whole(), scene.depth, air=scene.air)
    part = min(64, samples)
    rounds = max(samples // part, 1)
    total = np.zeros((*shot.film.resolved().size[::-1], 3))
    for k in range(rounds):
        total += tracer.trace(scene.sensor, 1_000_003 * (k + 1), range(part), part).light
    light = (total / rounds).astype(np.float32)
    place.parent.mkdir(parents=True, exist_ok=True)
    np.save(place, light)
    return light


def measured(way: str, shot: Shot, judge: Picture) -> list[Point]:
    """Return what one way reaches with each count of samples."""
    truth = developed(judge)
    points = []
    for count in COUNTS[way]:
        render = WAYS[way](shot, count)
        render(0)
        found = []
        for seed in range(REPEATS):
            began = time.perf_counter()
            light = render(seed + 1)
            seconds = time.perf_counter() - began
            picture = developed(np.ascontiguousarray(light, np.float32))
            found.append((seconds, psnr(truth, picture), float(flip(truth, picture).mean())))
        seconds, decibels, error = np.median(np.array(found), axis=0).tolist()
        points.append(Point(count, seconds, decibels, error))
        print(
            f"  {way:5s} {count:4d} samples  {seconds:7.3f} s  {decibels:6.2f} dB  FLIP {error:.4f}"
        )
    return points


def _loop(shot: Shot, count: int) -> Callable[[int], Picture]:
    import mitsuba as mi

    from render.mitsuba_scene import MitsubaScene

    def render(seed: int) -> Picture:
        scene = MitsubaScene(shot)
        sensor = mi.load_dict(_plain_sensor(scene.sensor, shot, count))
        plain = mi.load_dict(
            {"type": "path", "max_depth": scene.depth, "rr_depth": scene.depth + 1}
        )
        image = plain.render(scene.whole(), sensor, seed=seed, spp=count)
        return np.array(image, np.float32)

    return render


def _plain_sensor(sensor: Any, shot: Shot, count: int) -> dict[str, Any]:
    """Return a camera that stands where another does, with independent samples."""
    import mitsuba as mi

    values = mi.traverse(sensor)
    width, height = shot.film.resolved().size
    return {
        "type": "perspective",
        "fov": float(np.ravel(values["x_fov"])[0]),
        "fov_axis": "x",
        "near_clip": 0.01,
        "far_clip": 1e4,
        "to_world": mi.ScalarTransform4f(np.array(values["to_world"].matrix).reshape(4, 4)),
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent", "sample_count": count},
    }


def _path(shot: Shot, count: int) -> Callable[[int], Picture]:
    from render.mitsuba_scene import MitsubaScene
    from render.tracing.path_tracer import PathTracer

    scene, oidn = MitsubaScene(shot), _Albedo()
    tracer = PathTracer(scene.whole(), scene.depth, air=scene.air)
    return lambda seed: oidn.clean(
        tracer.trace(scene.sensor, 7919 * 65 * seed, range(count), count)
    )


class _Albedo:
    """The denoiser as it is meant: all light, with the colours beside it."""

    def __init__(self) -> None:
        import mitsuba_oidn

        self._oidn: Any = mitsuba_oidn
        self._device: Any = mitsuba_oidn.Device(mitsuba_oidn.DeviceType.CPU)
        self._device.commit()

    def clean(self, exposure: LightLayers) -> Picture:
        """Return the light without noise."""
        cleaned = self._oidn.denoise(
            exposure.light,
            albedo=exposure.albedo,
            hdr=True,
            quality=self._oidn.Quality.Fast,
            device=self._device,
        )
        return np.asarray(cleaned, np.float32)


def _ours(shot: Shot, count: int, soft_light: str = "full") -> Callable[[int], Picture]:
    from render.mitsuba_scene import MitsubaScene

    words = {"soft_light": soft_light, "samples": count}
    shot = replace(shot, film=shot.film.model_copy(update=words))
    scene, denoiser = MitsubaScene(shot), Denoiser()
    passes = shot.film.resolved().rounds
    return lambda seed: denoiser.clean(
        scene.trace(seed, range(passes), passes), "fast", has_soft_lights=scene.has_soft_lights
    )


def _half(shot: Shot, count: int) -> Callable[[int], Picture]:
    return _ours(shot, count, "half")


WAYS: dict[str, Callable[[Shot, int], Callable[[int], Picture]]] = {
    "loop": _loop,
    "path": _path,
    "ours": _ours,
    "half": _half,
}


def reached(points: list[Point], value: Callable[[Point], float], goal: float) -> float | None:
    """Return the seconds at which a value falls to a goal, None if it never does."""
    for a, b in itertools.pairwise(points):
        if value(a) <= goal:
            return a.seconds
        if value(b) <= goal:
            part = (value(a) - goal) / (value(a) - value(b))
            return float(np.exp(np.log(a.seconds) * (1 - part) + np.log(b.seconds) * part))
    return None


def table(curves: dict[str, list[Point]]) -> None:
    """Print the seconds at which each way reaches each goal, and how much sooner ours does."""
    rows: list[tuple[str, Callable[[Point], float], float]] = [
        *((f"{goal:g} dB", lambda p: -p.psnr, -goal) for goal in DECIBELS),
        *((f"FLIP {goal:g}", lambda p: p.flip, goal) for goal in FLIPS),
    ]
    print(f"  {'seconds to':12s}" + "".join(f"{way:>10s}" for way in curves) + "   ours sooner by")
    for name, value, goal in rows:
        found = {way: reached(points, value, goal) for way, points in curves.items()}
        cells = "".join(f"{'never' if s is None else f'{s:.3f}':>10s}" for s in found.values())
        ours = found["ours"]
        ratios = [
            f"{way} {s / ours:.1f}"
            for way, s in found.items()
            if s and ours and way not in ("ours", "half")
        ]
        print(f"  {name:12s}{cells}   {', '.join(ratios)}")


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    main(*(numbers + [640, 4096][len(numbers) :]))
