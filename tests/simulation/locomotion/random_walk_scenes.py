"""Random scenes of a shipped figure that walks on a terrain sized to its legs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from PIL import Image

from pipeline.errors import SceneError
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.locomotion.gaits.named_gaits import LegRows, available_gaits
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene, load_scene, read_scene
from pipeline.spec.mood import MOODS
from pipeline.spec.terrain.base import TERRAIN_PRESETS

WALKERS = (
    "antelope beetle camel centipede hopper horse kangaroo ostrich person scorpion spider tripod"
).split()

SIZE = 14.0
"""Edge length of a terrain, in leg lengths."""

LEAST_GAP = 0.11
"""Least gap between stones, in leg lengths: three quarters of it are two cells or more."""

SEED, HELD_OUT = 1987, 1998
"""Seeds of the scenes, and of scenes that no constant was tuned on."""

Config = dict[str, Any]
Draw = Callable[[float, float], float]
"""Draws a number between two bounds."""


@dataclass(frozen=True)
class RandomWalk:
    """A figure that walks on a terrain.

    Attributes:
        number: of the scene.
        figure: name of a shipped figure.
        kind: of terrain, or name of a preset.
        gait_config: keys `walk` and `mood` of the creature.
        scene: of figure and terrain.
    """

    number: int
    figure: str
    kind: str
    gait_config: Config
    scene: Scene


def random_walk(number: int, folder: Path, seed: int = SEED) -> RandomWalk:
    """Return the scene of a number; files of its terrain are written to `folder`.

    Figures and kinds of terrain have different periods, so that 300 scenes hold every
    combination at least twice. A third of the creatures have a random gait and mood.
    """
    rng = np.random.default_rng([number, seed])
    figure = WALKERS[number % len(WALKERS)]
    kind = list(KINDS)[(number // len(WALKERS) + number) % len(KINDS)]
    scale = float(np.exp(rng.uniform(np.log(0.35), np.log(1.4))))
    leg = scale * leg_length(figure)
    terrain = terrain_of(kind, leg, rng, folder)
    gait_config = random_gait(figure, np.random.default_rng([number, seed, 1]))
    while True:
        at = (rng.uniform(-0.15, 0.15, 2) * terrain.get("size", (30.0, 30.0))).tolist()
        member = {"figure": figure, "scale": scale, "at": at} | gait_config
        member["heading_deg"] = float(rng.uniform(-180.0, 180.0))
        config = {"pronk": 1, "duration": 3, "seed": number, "terrain": terrain, "cast": [member]}
        path = folder / f"walk{number}.yaml"
        path.write_text(yaml.safe_dump(config), encoding="utf-8")
        try:
            scene = load_scene(path)
            Simulation(scene)
        except SceneError as error:
            if "lies outside the terrain" in str(error):
                continue  # one whose size is in its file
            if "no foothold" not in str(error):
                raise
            # Try another place, and allow steeper ground.
            steep = terrain.get("unsteppable_slope_deg", 40.0) + 1.0
            terrain = terrain | {"unsteppable_slope_deg": min(steep, 60.0)}
            continue
        return RandomWalk(number, figure, kind, gait_config, scene)


@cache
def _figure(name: str) -> Figure:
    scene = read_scene(f"pronk: 1\nduration: 1\ncast: [{{figure: {name}}}]\n")
    return build_figure(name, scene.figures[name], 1.0)


def random_gait(figure: str, rng: np.random.Generator) -> Config:
    """Return the keys `walk` and `mood`: defaults for two thirds, else random."""
    if rng.random() > 1.0 / 3.0:
        return {"walk": {}}
    skeleton = _figure(figure).skeleton
    forward = [float(skeleton.links[leg.links[0]].ends[0, 0]) for leg in skeleton.legs]
    gaits = available_gaits(LegRows.of([leg.side for leg in skeleton.legs], forward))
    gait_config: Config = {"walk": {"gait": str(rng.choice(list(gaits)))}}
    mood = rng.choice(["", *MOODS])
    return gait_config | ({"mood": str(mood)} if mood else {})


@cache
def leg_length(figure: str) -> float:
    """Return the mean leg length of an unscaled figure [m]."""
    skeleton = _figure(figure).skeleton
    lengths = [
        sum(float(np.linalg.norm(np.diff(skeleton.links[k].ends, axis=0))) for k in limb.links)
        for limb in skeleton.legs
    ]
    return float(np.mean(lengths))


def terrain_of(kind: str, leg: float, rng: np.random.Generator, folder: Path) -> Config:
    """Return the config of a terrain for legs of that length."""
    grid = {"size": [SIZE * leg] * 2, "foot_radius": 0.06 * leg}
    grid["unsteppable_slope_deg"] = float(rng.uniform(28.0, 45.0))
    if kind in TERRAIN_PRESETS and kind not in GENERATORS:
        return {"preset": kind}

    def draw(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    if kind == "sum":
        uneven = [k for k in GENERATORS if k != "flat"]
        two = rng.choice(len(uneven), 2, replace=False)
        terms = [{"kind": uneven[k]} | GENERATORS[uneven[k]](draw, leg) for k in two]
        return {"kind": kind, **grid, "cells": [360, 360], "of": terms}
    if kind == "mesh":
        del grid["size"]  # It has that of its file.
    if kind in FILES:
        return {"kind": kind, **grid} | FILES[kind](draw, leg, folder)
    return {"kind": kind, **grid, "cells": [360, 360]} | GENERATORS[kind](draw, leg)


def _fractal(draw: Draw, leg: float) -> Config:
    return {"height": draw(0.3, 2.0) * leg, "roughness": draw(0.4, 0.62)}


def _hills(draw: Draw, leg: float) -> Config:
    return {"height": draw(0.3, 2.0) * leg, "spacing": draw(2.5, 8.0) * leg}


def _stairs(draw: Draw, leg: float) -> Config:
    config: Config = {"step_height": draw(0.04, 0.5) * leg, "step_depth": draw(0.25, 1.0) * leg}
    course = ("up", "down", "up and down")[int(draw(0.0, 3.0))]
    return config | {
        "start": draw(0.0, 1.5) * leg,
        "landing": draw(0.5, 2.0) * leg,
        "course": course,
    }


def _ramp(draw: Draw, leg: float) -> Config:
    config: Config = {"slope_deg": draw(5.0, 40.0), "height": draw(0.3, 2.5) * leg}
    return config | {"start": draw(0.0, 1.5) * leg, "level": draw(0.5, 2.0) * leg}


def _ditches(draw: Draw, leg: float) -> Config:
    width = float(np.exp(draw(np.log(0.15), np.log(4.0)))) * leg
    config: Config = {"width": width, "depth": draw(0.1, 2.0) * leg, "variation": draw(0.0, 0.5)}
    return config | {"spacing": width + draw(0.6, 2.5) * leg, "start": draw(0.0, 1.0) * leg}


def _stones(draw: Draw, leg: float) -> Config:
    config: Config = {
        "diameter": draw(0.3, 0.9) * leg,
        "gap": max(draw(0.08, 0.9), LEAST_GAP) * leg,
    }
    config |= {"depth": draw(0.2, 1.5) * leg, "height_variation": draw(0.0, 0.25) * leg}
    return config | {"start": draw(0.0, 1.0) * leg, "length": draw(2.0, 5.0) * leg}


def _boulders(draw: Draw, leg: float) -> Config:
    small = draw(0.15, 0.4) * leg
    config: Config = {"diameters": [small, small * draw(1.5, 5.0)], "cover": draw(0.05, 0.35)}
    config |= {"height": draw(0.0, 0.5) * leg, "spacing": draw(3.0, 8.0) * leg}
    return config | {"buried": draw(0.3, 0.8), "clearing": draw(0.3, 1.0) * leg}


def _image(draw: Draw, leg: float, folder: Path) -> Config:
    """A picture of waves of two lengths."""
    u, v = np.meshgrid(*[np.linspace(0.0, 2.0 * np.pi, 128)] * 2)
    waves = np.sin(draw(1, 4) * u + draw(0, 6)) * np.cos(draw(1, 4) * v) + 0.3 * np.sin(
        draw(4, 9) * u + draw(4, 9) * v
    )
    pixels = np.rint((waves + 1.3) / 2.6 * 65535).clip(0, 65535).astype(np.uint16)
    Image.fromarray(pixels).save(folder / "land.png")
    return {"file": "land.png", "low": 0.0, "high": draw(0.3, 1.5) * leg}


def _mesh(draw: Draw, leg: float, folder: Path) -> Config:
    """A grid of triangles, a valley with a ridge along it."""
    side = np.linspace(-0.5, 0.5, 61) * SIZE * leg
    x, z = np.meshgrid(side, side)
    y = draw(0.02, 0.1) * x * x / leg + draw(0.05, 0.4) * leg * np.exp(-((z / leg) ** 2))
    rows = [f"v {a:.6f} {b:.6f} {c:.6f}" for a, b, c in zip(x.flat, y.flat, z.flat, strict=True)]
    n = len(side)
    for j in range(n - 1):
        for i in range(n - 1):
            a = j * n + i + 1
            rows += [f"f {a} {a + n + 1} {a + 1}", f"f {a} {a + n} {a + n + 1}"]
    (folder / "land.obj").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return {"file": "land.obj"}


GENERATORS: Mapping[str, Callable[[Draw, float], Config]] = {
    "flat": lambda _draw, _leg: {},
    "fractal": _fractal,
    "hills": _hills,
    "stairs": _stairs,
    "ramp": _ramp,
    "ditches": _ditches,
    "stones": _stones,
    "boulders": _boulders,
}
FILES: Mapping[str, Callable[[Draw, float, Path], Config]] = {"image": _image, "mesh": _mesh}
KINDS = (*GENERATORS, "sum", *FILES, *(p for p in TERRAIN_PRESETS if p not in GENERATORS))
"""Kinds of terrain, and presets of other names, which have their own size."""
