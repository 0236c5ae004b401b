"""Random figures: two to twenty legs of two to five links around a body, of either style."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pipeline.errors import SceneError
from pipeline.simulation.figures.figure import build_figure
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene, load_scene, read_scene
from tests.simulation.locomotion.random_walk_scenes import KINDS, terrain_of

Config = dict[str, Any]

MOST_PAIRS, FEWEST_LINKS, MOST_LINKS = 10, 2, 5
ATTEMPTS = 12
"""Places, speeds and gentler slopes that are tried before a scene is given up."""


def random_figure(rng: np.random.Generator) -> Config:
    """Return the drawing of a figure: hips join in a ring, so that they belong to the body."""
    pairs = int(rng.integers(1, MOST_PAIRS + 1))
    links = int(rng.integers(FEWEST_LINKS, MOST_LINKS + 1))
    style = str(rng.choice(["insect", "mammal"]))
    nodes: dict[str, Config] = {}
    count = max(pairs, 2)
    half = 0.5 * rng.uniform(0.6, 1.6) * (0.4 + 0.2 * count)
    rows = np.linspace(-half, half, count + 2)
    for i, y in enumerate(rows):
        nodes[f"b{i}"] = {"at": [0.0, float(y)], "radius": float(rng.uniform(0.08, 0.2))}
    width = 0.15 * rng.uniform(0.7, 1.3)
    hips = rows[1:-1] if pairs > 1 else [0.0]
    length = rng.uniform(0.5, 1.5)
    chains = [[f"b{i}" for i in range(count + 2)]]
    legs = []
    for k, y in enumerate(hips):
        nodes[f"h{k}_l"] = {"at": [-float(width), float(y)], "radius": 0.07}
        legs.append([f"h{k}_l", *_leg(rng, nodes, f"l{k}", (-width, y), (length, links))])
    ring = [f"b{0}", *(leg[0] for leg in legs), f"b{count + 1}"]
    operations = [{"mirror": "x"}]
    return {"style": style, "nodes": nodes, "chains": [*chains, ring, *legs], "then": operations}


def _leg(
    rng: np.random.Generator,
    nodes: dict[str, Config],
    name: str,
    hip: tuple[float, float],
    size: tuple[float, int],
) -> list[str]:
    """Draw a zigzag leg to the left; return the names of its nodes after the hip."""
    (x, y), (length, links), names = hip, size, []
    parts = rng.uniform(0.6, 1.4, links)
    parts *= length * rng.uniform(0.9, 1.1) / parts.sum()
    angle, side = rng.uniform(-0.6, 0.6), rng.choice([-1, 1])
    for k in range(links):
        if k:
            angle += side * rng.uniform(0.0, 0.9)
            side = -side
        x, y = x - parts[k] * np.cos(angle), y + parts[k] * np.sin(angle)
        radius = 0.05 - 0.03 * (k + 1) / links
        nodes[f"{name}_{k}_l"] = {"at": [float(x), float(y)], "radius": float(radius)}
        names.append(f"{name}_{k}_l")
    return names


def random_figure_walk(
    number: int, folder: Path, seed: int, kind: str = "", duration: float = 3.0
) -> Scene | None:
    """Return a scene of a random figure on a path with corners; None if it finds no place.

    Args:
        number: of the figure.
        folder: to which files of its terrain are written.
        seed: of all numbers.
        kind: of terrain; by number if left out.
        duration: of the scene [s].
    """
    rng = np.random.default_rng([number, seed])
    figure = random_figure(rng)
    base = {"pronk": 1, "duration": duration, "seed": number, "figures": {"thing": figure}}
    plain = read_scene(yaml.safe_dump(base | {"cast": [{"figure": "thing"}]}))
    skeleton = build_figure("thing", plain.figures["thing"], 1.0).skeleton
    leg = float(np.mean([limb.length for limb in skeleton.legs]))
    kind = kind or list(KINDS)[number % len(KINDS)]
    terrain = terrain_of(kind, leg, rng, folder)
    speed = float(np.sqrt(9.81 * leg) * np.exp(rng.uniform(np.log(0.1), np.log(1.5))))
    for _ in range(ATTEMPTS):
        size = np.asarray(terrain.get("size", (30.0, 30.0)))
        at = rng.uniform(-0.15, 0.15, 2) * size
        corners = at + np.cumsum(rng.uniform(-2.0, 2.0, (3, 2)) * leg, axis=0)
        corners = np.clip(corners, -0.3 * size, 0.3 * size)
        walk = {"speed": speed, "path": corners.tolist()}
        member = {"figure": "thing", "at": at.tolist(), "walk": walk}
        member["heading_deg"] = float(rng.uniform(-180.0, 180.0))
        path = folder / f"figure{number}.yaml"
        scene = base | {"terrain": terrain, "cast": [member]}
        path.write_text(yaml.safe_dump(scene), encoding="utf-8")
        try:
            found = load_scene(path)
            Simulation(found)
        except SceneError as error:
            if "more than the legs can do" in str(error):
                speed *= 0.7
            elif "no foothold" in str(error):
                steep = terrain.get("unsteppable_slope_deg", 40.0) + 3.0
                terrain = terrain | {"unsteppable_slope_deg": min(steep, 60.0)}
            elif "outside the terrain" not in str(error):
                raise
            continue
        return found
    return None
