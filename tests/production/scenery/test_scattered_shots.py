"""Scattered shots: one scenery for all frames and machines, refused at its line, calm in motion."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pipeline.errors import SceneError
from pipeline.production.scenery.expansion import MATERIALS
from pipeline.production.shots.film_tracks import FilmTracks
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.spec.scene_loader import read_scene
from render.backend import choose
from render.comparison.flip_metric import flip
from render.config import Film
from render.renderer import Renderer

TEXT = """\
pronk: 1
frames: 3
terrain: {kind: flat, size: [8, 8], cells: [8, 8], scatter: [dry grass, stone]}
cast: [{figure: beetle, scale: 0.6, walk: {gait: tripod}}]
camera: {distance: 3, height: 1, orbit: [0, 8]}
film: {size: [64, 36], samples: 1, depth: 2, denoise: "off"}
"""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return read_scene(TEXT.replace(", height: 1", ""))


@pytest.fixture(scope="module")
def take(scene: Scene) -> Take:
    return simulate(scene)


@pytest.mark.nightly
def test_all_frames_and_all_machines_have_one_scenery(scene: Scene, take: Take) -> None:
    here = ShotBuilder(scene, take)
    assert here.shot(1).scenery is here.shot(3).scenery
    names = {mesh.name for mesh in here.shot(1).scenery}
    assert {"scenery foliage", "scenery stone"} <= names <= {"terrain", "horizon", *MATERIALS}
    # Another machine has the tracks of the film, not the whole take.
    there = ShotBuilder(scene, take, FilmTracks.of_arrays(here.tracks.arrays()))
    assert there.shot(2).digest == here.shot(2).digest


@pytest.mark.nightly
def test_too_many_triangles_are_refused_at_their_line(
    scene: Scene, take: Take, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.production.scenery.scenery.MAX_TRIANGLES", 100)
    with pytest.raises(SceneError) as error:
        ShotBuilder(scene, take).shot(1)
    (problem,) = error.value.problems
    assert (problem.path, problem.line) == ("terrain.scatter", 3)
    assert "million triangles, which take" in problem.message


@pytest.mark.nightly
def test_a_slow_camera_makes_nothing_flicker(scene: Scene, take: Take) -> None:
    renderer = Renderer(choose())
    shot = ShotBuilder(scene, take).shot(1)
    film = Film.model_validate({"preset": "final", "size": [320, 180]})
    shot = replace(shot, film=film, later=())
    x, y, z = shot.camera.p_WC
    moved = replace(shot.camera, p_WC=(x + 0.0005, y, z))
    first, second = (renderer.render(one).srgb8 for one in (shot, replace(shot, camera=moved)))
    assert flip(first, second).mean() < 0.02
