"""Fires and smoke of a scene as the renderer is given them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import find_scene, load_scene
from pipeline.spec.scene import Scene
from render.backend import choose
from render.plume import Plume


@pytest.fixture(scope="module")
def campfire() -> tuple[Scene, Take]:
    changes = ["duration=0.5", "light.sun.hour=22", "terrain.scatter=none"]
    scene = load_scene(find_scene("campfire"), [*changes, "terrain.surroundings=none"])
    return scene, simulate(scene)


def test_fires_are_shown_as_flames_and_smoke(campfire: tuple[Scene, Take]) -> None:
    shot = ShotBuilder(*campfire).shot(6)
    assert [plume.kind for plume in shot.plumes] == ["flame", "flame", "smoke"]
    torch, fire, smoke = shot.plumes
    assert fire.p_WP == pytest.approx((0.0, 0.03, 0.0))
    assert smoke.glow == 0 < fire.glow
    # The torch is carried, and its flames lag behind it.
    assert torch.p_WP[1] > 1.0
    assert torch.wind != (0.0, 0.0)
    assert not {"fire", "torchlight", "smoke"} & {mesh.owner for mesh in shot.meshes}
    # Two lamps for each fire, which flicker, besides those of the scene.
    own = len(campfire[0].light.lamps)
    lamps = len(shot.light.lamps), len(shot.lamps)
    assert lamps == (own + 4, own + 4)
    gains = [place.gain for place in ShotBuilder(*campfire).shot(9).lamps]
    assert gains != [place.gain for place in shot.lamps]
    assert all(0.6 < gain < 1.4 for gain in gains)


def test_flames_of_another_material_are_shown_one_by_one(campfire: tuple[Scene, Take]) -> None:
    scene, take = campfire
    cast = tuple(
        m.model_copy(update={"material": "leaf"}) if m.name == "fire" else m for m in scene.cast
    )
    shot = ShotBuilder(scene.model_copy(update={"cast": cast}), take).shot(6)
    assert [plume.kind for plume in shot.plumes] == ["flame", "smoke"]
    assert "fire" in {mesh.owner for mesh in shot.meshes}


def test_a_frame_depends_on_its_plumes(campfire: tuple[Scene, Take]) -> None:
    shot = ShotBuilder(*campfire).shot(6)
    fire, *others = shot.plumes
    other = replace(shot, plumes=(replace(fire, seed=fire.seed + 1), *others))
    assert other.digest != shot.digest
    assert other.build == shot.build


@pytest.mark.slow
def test_flames_glow_and_smoke_hides() -> None:
    backend = choose()
    if backend.variant == "scalar_rgb":
        pytest.skip("the scalar variant shows nothing in the air")
    backend.activate()
    import mitsuba as mi

    from render.airborne.plumes import PlumeLight, PlumeVolume

    light = PlumeLight(np.array([0.0, 1.0, 0.0]), np.zeros(3), np.full(3, 0.5))
    base = Plume("flame", (0, 0, 0), 0.3, 1.2, 2.0, (0.3, 0.0), (1.0, 0.2, 0.01), 8.0, 3)
    smoke = replace(base, kind="smoke", glow=0.0, color=(0.4, 0.4, 0.4))
    x = np.linspace(-1.2, 1.2, 512)
    origin = np.stack([x, np.full(512, 0.4), np.full(512, -3.0)]).astype(np.float32)
    ray = mi.Ray3f(mi.Point3f(origin), mi.Vector3f(0, 0, 1))

    def seen(plume: Plume, time: float, distance: float) -> tuple[np.ndarray, np.ndarray]:
        volume = PlumeVolume(plume, light, [], time)
        far = mi.Float(np.full(512, distance, np.float32))
        passed, added = volume.seen(ray, far, mi.Float(0.5))
        return np.array(passed), np.array(added)

    (lit, fire), (hidden, grey) = seen(base, 1.0, 9.0), seen(smoke, 1.0, 9.0)
    assert fire[0].max() > 1.0 > 0.5 > (1 - lit).max() > 0.05
    assert fire[0].max() > 3 * fire[2].max()
    assert 0.2 < (1 - hidden).max() < 1
    # Smoke shows no more than the light around it.
    assert (grey <= 0.4 * 0.5 * (1 - hidden) + 1e-4).all()
    # Nothing is far aside, or behind a surface before it; time moves it, the same time does not.
    edge = abs(x) > 1.15
    assert fire[:, edge].max() == 0
    assert seen(base, 1.0, 2.0)[1].max() == 0
    np.testing.assert_array_equal(seen(base, 1.0, 9.0)[1], fire)
    assert abs(seen(base, 1.1, 9.0)[1] - fire).max() > 0.5
