"""Triples: figures, terrains and parameters of hops that nobody thought of."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from pipeline.spec import Scene, load_scene
from tests.simulation.locomotion.random_walk_scenes import (
    KINDS,
    WALKERS,
    Words,
    leg_length,
    terrain_of,
)

LEGS = dict(zip(WALKERS, (4, 6, 4, 20, 1, 4, 2, 2, 2, 8, 8, 3), strict=True))


@dataclass(frozen=True)
class Triple:
    """A scene of one that hops, and what it was made of."""

    number: int
    figure: str
    kind: str
    words: Words
    scene: Scene


def triple(number: int, folder: Path, seed: int = 11) -> Triple:
    """Return a triple; figures and kinds of terrain go round with different periods."""
    chance = np.random.default_rng([number, seed])
    figure = WALKERS[number % len(WALKERS)]
    kind = list(KINDS)[(number // len(WALKERS) + number) % len(KINDS)]
    scale = float(np.exp(chance.uniform(np.log(0.35), np.log(1.4))))
    leg = scale * leg_length(figure)
    terrain = terrain_of(kind, leg, chance, folder)
    words = drawn(figure, leg, chance)
    at = (chance.uniform(-0.15, 0.15, 2) * terrain.get("size", (30.0, 30.0))).tolist()
    if chance.random() < 0.2:
        at.insert(1, float(leg * chance.uniform(0.2, 2.0)))
    member = {"figure": figure, "scale": scale, "at": at, "pronk": words}
    member["heading_deg"] = float(chance.uniform(-180.0, 180.0))
    content = {"pronk": 1, "duration": 3, "seed": number, "terrain": terrain, "cast": [member]}
    path = folder / f"triple{number}.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return Triple(number, figure, kind, words, load_scene(path))


def drawn(figure: str, leg: float, chance: np.random.Generator) -> Words:
    """Return how a creature with legs of that length is to hop; each third one as it likes."""
    if chance.random() < 1.0 / 3.0:
        return {}
    words: Words = {
        "distance": float(leg * chance.uniform(0.0, 2.0)),
        "height": float(leg * chance.uniform(0.1, 1.0)),
        "direction_deg": float(chance.choice([0.0, 0.0, 90.0, 180.0, -30.0])),
        "turn_deg": float(chance.choice([0.0, 0.0, 25.0, -90.0])),
        "avoid": bool(chance.random() < 0.3),
    }
    if chance.random() < 0.25:
        words["max_force"] = float(chance.uniform(1.1, 4.0) / LEGS[figure])
    if chance.random() < 0.25:
        words["balance"] = float(chance.uniform(0.0, 1.0))
    return words
