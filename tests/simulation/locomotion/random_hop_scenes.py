"""Random scenes of a hopping figure, a terrain and hop parameters."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from pipeline.spec import Scene, load_scene
from tests.simulation.locomotion.random_walk_scenes import (
    KINDS,
    SIZE,
    WALKERS,
    Config,
    leg_length,
    terrain_of,
)

LEGS = dict(zip(WALKERS, (4, 6, 4, 20, 1, 4, 2, 2, 2, 8, 8, 3), strict=True))


@dataclass(frozen=True)
class RandomHop:
    """A scene of a hopper, and its random choices."""

    number: int
    figure: str
    kind: str
    config: Config
    scene: Scene


def random_hop(number: int, folder: Path, seed: int = 11) -> RandomHop:
    """Return the scene of a number; figures and kinds of terrain have different periods."""
    rng = np.random.default_rng([number, seed])
    figure = WALKERS[number % len(WALKERS)]
    kind = list(KINDS)[(number // len(WALKERS) + number) % len(KINDS)]
    scale = float(np.exp(rng.uniform(np.log(0.35), np.log(1.4))))
    leg = scale * leg_length(figure)
    terrain = terrain_of(kind, leg, rng, folder)
    config = random_hop_config(figure, leg, rng)
    # Presets have the usual size, meshes that of their file.
    usual = (SIZE * leg, SIZE * leg) if kind == "mesh" else (30.0, 30.0)
    at = (rng.uniform(-0.15, 0.15, 2) * terrain.get("size", usual)).tolist()
    if rng.random() < 0.2:
        at.insert(1, float(leg * rng.uniform(0.2, 2.0)))
    member = {"figure": figure, "scale": scale, "at": at, "pronk": config}
    member["heading_deg"] = float(rng.uniform(-180.0, 180.0))
    content = {"pronk": 1, "duration": 3, "seed": number, "terrain": terrain, "cast": [member]}
    path = folder / f"hop{number}.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return RandomHop(number, figure, kind, config, load_scene(path))


def random_hop_config(figure: str, leg: float, rng: np.random.Generator) -> Config:
    """Return random hop parameters for legs of a length [m]; a third of them are defaults."""
    if rng.random() < 1.0 / 3.0:
        return {}
    config: Config = {
        "distance": float(leg * rng.uniform(0.0, 2.0)),
        "height": float(leg * rng.uniform(0.1, 1.0)),
        "direction_deg": float(rng.choice([0.0, 0.0, 90.0, 180.0, -30.0])),
        "turn_deg": float(rng.choice([0.0, 0.0, 25.0, -90.0])),
        "avoid": bool(rng.random() < 0.3),
    }
    if rng.random() < 0.25:
        config["max_force"] = float(rng.uniform(1.1, 4.0) / LEGS[figure])
    if rng.random() < 0.25:
        config["balance"] = float(rng.uniform(0.0, 1.0))
    return config
