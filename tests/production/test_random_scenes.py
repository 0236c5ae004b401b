"""Random scenes: they end, every order is done or told, and they are the same every time."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.spec.script import order_text
from render.image_files import read_png
from tests.production.random_scenes import drawn_scene

Pronk = Callable[..., tuple[int, str, str]]

OUTCOMES = {"done", "begun", "replaced", "given up", "cut off", "never given"}
"""What may become of an order."""

EXPLAINED = {"given up", "never given"}
"""Outcomes that need a reason."""

CHEAP_SEEDS, QUICKEST = range(6), 3
SEEDS = range(500)
RENDERED = range(1000, 1050)

BLACK = 0.02
"""Luma below which 99 percent of a black picture lie; safely below the limit of the note."""

LEAST_ACCEPTED = 0.8
"""Share of drawn scenes that the checks must accept."""


def obey(scene: Scene, take: Take) -> None:
    """Assert the laws of every take."""
    for name in ("positions", "rotations", "values"):
        assert np.isfinite(getattr(take, name)).all(), f"{name} are not finite"
    orders = Counter((order.who, order.text) for order in take.orders)
    script = Counter((one.who, order_text(one.do)) for one in scene.script)
    assert script <= orders, f"neither done nor told: {script - orders}"
    for order in take.orders:
        assert order.outcome in OUTCOMES, order
        assert order.reason or order.outcome not in EXPLAINED, order


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(seed, marks=() if seed == QUICKEST else pytest.mark.nightly)
        for seed in CHEAP_SEEDS
    ],
)
def test_a_random_scene_without_people_and_bodies_obeys_the_laws(seed: int) -> None:
    _, scene, _ = drawn_scene(seed, cheap=True)
    obey(scene, simulate(scene))


@pytest.mark.nightly
@pytest.mark.parametrize("seed", SEEDS)
def test_a_random_scene_obeys_the_laws(seed: int) -> None:
    _, scene, _ = drawn_scene(seed)
    obey(scene, simulate(scene))


@pytest.mark.nightly
@pytest.mark.parametrize("seed", SEEDS[::10])
def test_a_random_scene_moves_the_same_every_time(seed: int) -> None:
    _, scene, _ = drawn_scene(seed)
    assert simulate(scene).digest == simulate(scene).digest


@pytest.mark.nightly
def test_few_random_scenes_are_refused() -> None:
    seeds = SEEDS[::5]
    drawn = len(seeds) + sum(drawn_scene(seed)[2] for seed in seeds)
    assert len(seeds) >= LEAST_ACCEPTED * drawn


def is_black(picture: np.ndarray) -> bool:
    """Return whether nothing can be told apart in a picture (H, W, 3)."""
    luma = picture @ np.array([0.2126, 0.7152, 0.0722]) / 255.0
    return bool(np.quantile(luma, 0.99) < BLACK)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", RENDERED)
def test_a_random_scene_is_rendered_and_a_black_film_is_noted(
    seed: int, pronk: Pronk, tmp_path: Path
) -> None:
    text, _, _ = drawn_scene(seed)
    (tmp_path / "random.yaml").write_text(text)
    code, _, errors = pronk("render", "random.yaml", "--frames", "1,48", cwd=tmp_path)
    assert code == 0, errors
    made = tmp_path / "out" / "random"
    kinds = {note["kind"] for note in json.loads((made / "manifest.json").read_text())["notes"]}
    pictures = [read_png(made / "frames" / f"{frame:04}.png") for frame in (1, 48)]
    assert [picture.shape for picture in pictures] == [(54, 96, 3)] * 2
    assert "picture_black" in kinds or not all(map(is_black, pictures))
