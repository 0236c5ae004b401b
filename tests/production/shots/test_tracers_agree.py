"""Tracers: pronk's and Mitsuba's agree on the light of whole scenes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import find_scene, load_scene
from render.backend import choose
from render.config import Film
from render.renderer import Renderer
from render.shot import Shot

SCENES = (
    "at_the_table",
    "block_pile",
    "campfire",
    "dice",
    "dunes",
    "first_steps",
    "stacking",
    "stepping_stones",
    "toy",
    "under_water",
)
SIZE, DEPTH, SAMPLES, ROUNDS = (96, 54), 5, 256, 16
TOLERANCE = 0.002


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer(choose())


def shot_of(name: str) -> Shot:
    """Return a frame in the first second of a shipped scene, small and without a denoiser."""
    scene = load_scene(find_scene(name), ["duration=1"])
    shot = ShotBuilder(scene, simulate(scene)).shot(scene.n_frames // 2)
    lit = shot.light.without_cloud_shadows()
    film = Film(size=SIZE, depth=DEPTH, denoise="off")
    # The other tracer knows nothing of water.
    return replace(shot, film=film, light=lit, later=(), water=None)


@pytest.mark.nightly
@pytest.mark.parametrize("name", SCENES)
def test_tracers_agree_on_the_light_of_shipped_scenes(renderer: Renderer, name: str) -> None:
    """Within 0.2 % in the mean, and at most four standard errors apart."""
    from render.mitsuba_scene import MitsubaScene
    from render.tracing.path_tracer import PathTracer

    shot = shot_of(name)
    scene = MitsubaScene(shot)
    assert scene.path_tracer_reason == ""
    judge = PathTracer(scene.whole(), scene.depth, air=scene.air)
    ours, theirs = (
        np.array([one(k) for k in range(ROUNDS)])
        for one in (
            lambda k: scene.trace(k, range(SAMPLES), SAMPLES).light.mean(dtype=float),
            lambda k: judge.trace(
                scene.sensor, 1_000_003 * (k + 1), range(SAMPLES), SAMPLES
            ).light.mean(dtype=float),
        )
    )
    apart = ours.mean() / theirs.mean() - 1.0
    error = np.hypot(ours.std(ddof=1), theirs.std(ddof=1)) / theirs.mean() / np.sqrt(ROUNDS)
    assert abs(apart) < TOLERANCE, f"{apart:.5f} with a standard error of {error:.5f}"
    assert abs(apart) < 4.0 * error + 1e-4, f"{apart:.5f} with a standard error of {error:.5f}"
