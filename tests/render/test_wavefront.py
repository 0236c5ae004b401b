"""The wavefront tracer agrees with Mitsuba's path tracer."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from render.config import Film, Light, Material, light, material
from render.frame import ALBEDO_BIAS
from render.renderer import Renderer
from render.shot import Mesh, Shot

Make = Callable[..., Shot]

LAMPS = light({"preset": "night", "lamps": [{"at": [0.8, 1.2, 0.6], "radius": 0.2}]})
MANY = [
    {"at": [3 * math.cos(i), 0.5 + 0.2 * (i % 5), 3 * math.sin(i)], "radius": 0.05 * (i % 3)}
    for i in range(20)
]
MANY_LAMPS = light({"preset": "night", "lamps": MANY})
CASES: dict[str, tuple[str | Light, str | Material]] = {
    "sun and sky": ("day", "bone"),
    "a sky without sun": ("overcast", "clay"),
    "a large light and a glossy body": ("studio", "red plastic"),
    "bare metal": ("studio", "brass"),
    "a body that gives off light": ("golden hour", material({"preset": "flame", "glow": 3})),
    "lamps by night": (LAMPS, "green chitin"),
    "many lamps": (MANY_LAMPS, "clay"),
    "fog": (light({"preset": "golden hour", "haze": "fog"}), "bone"),
}
DAILY = ("a large light and a glossy body",)
"""Cases of the full tier; the others run nightly."""


def light_of_both(
    shot: Shot, samples: int, rounds: int = 1
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the light of a shot by the wavefront and the path tracer, as means of samples."""
    from render.mitsuba_scene import MitsubaScene
    from render.tracing.path_tracer import PathTracer

    scene = MitsubaScene(replace(shot, light=shot.light.without_cloud_shadows()))
    assert scene.path_tracer_reason == ""
    reference = PathTracer(scene.whole(), shot.film.resolved().depth, air=scene.air)
    ours, theirs = [], []
    for seed in range(rounds):
        ours.append(scene.trace(seed, range(samples), samples).light)
        layers = reference.trace(scene.sensor, 100_000 * seed, range(samples), samples)
        theirs.append(layers.light)
    return np.mean(ours, axis=0, dtype=float), np.mean(theirs, axis=0, dtype=float)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [name if name in DAILY else pytest.param(name, marks=pytest.mark.nightly) for name in CASES],
)
def test_mean_light_equals_path(renderer: Renderer, make_shot: Make, name: str) -> None:
    lit, look = CASES[name]
    film = Film(size=(64, 48), depth=5, soft_light="full", denoise="off")
    ours, theirs = light_of_both(make_shot(film=film, lit=lit, look=look), 64, 4)
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.004)
    # Blocks of pixels agree within their noise: no light is lost or doubled locally.
    blocks = [x.reshape(6, 8, 8, 8, 3).mean(axis=(1, 3)) for x in (ours, theirs)]
    np.testing.assert_allclose(blocks[0], blocks[1], rtol=0.06, atol=0.01)


def test_haze_is_that_of_the_formula_and_no_light_is_lost(
    renderer: Renderer, make_shot: Make
) -> None:
    """The light of a shot in fog follows from the same shot in clear air and the distances."""
    import mitsuba as mi

    from render.mitsuba_scene import MitsubaScene

    film = Film(size=(16, 16), samples=16, depth=3, soft_light="full", denoise="off")
    clear, foggy = (
        MitsubaScene(make_shot(film=film, lit=light({"preset": "day", "haze": haze})))
        for haze in (0.0, 1.0)
    )
    assert clear.air is None
    assert foggy.air is not None
    seen, veiled = (scene.trace(0, range(16), 16) for scene in (clear, foggy))
    # Of flat ground in the middle of the frame the distance hardly varies within a pixel.
    ray, _ = clear.sensor.sample_ray(0.0, 0.5, mi.Point2f(13.5 / 16, 13.5 / 16), 0.5)
    hit = clear.scene.ray_intersect(ray)
    passed = np.array(foggy.air.transmittance(ray.o, ray.d, hit.t)).ravel()
    depth = float(hit.t[0]) * foggy.air.extinction
    np.testing.assert_allclose(passed, np.exp(-np.array(depth).ravel()), rtol=0.02)
    assert 0.7 < passed.min() < passed.max() < 0.95
    kept = (veiled.direct + veiled.indirect)[13, 13] / (seen.direct + seen.indirect)[13, 13]
    np.testing.assert_allclose(kept, passed, rtol=0.01)
    np.testing.assert_allclose(veiled.albedo[13, 13] / seen.albedo[13, 13], passed, rtol=0.01)
    glow = np.array(foggy.air.scattered(ray.d)).ravel() * (1.0 - passed)
    np.testing.assert_allclose(veiled.air[13, 13], glow, rtol=0.02)
    sky = seen.albedo.max(axis=-1) == 0.0
    np.testing.assert_array_equal(veiled.air[sky], seen.air[sky])


@pytest.mark.sample(1)
@pytest.mark.parametrize("depth", [1, 2, 3])
def test_each_depth_equals_path(renderer: Renderer, make_shot: Make, depth: int) -> None:
    film = Film(size=(64, 48), samples=64, depth=depth, denoise="off")
    ours, theirs = light_of_both(make_shot(film=film, lit="studio"), 64)
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.01)


def test_a_white_furnace_is_exact(renderer: Renderer) -> None:
    """In a sky of radiance 1 a white body is invisible."""
    import mitsuba as mi

    from render.tracing.wavefront import Wavefront

    scene = mi.load_dict(
        {
            "type": "scene",
            "ball": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": 1.0}},
            "sky": {"type": "constant", "sampling_weight": 0.0},
            # Emitter sampling needs an emitter besides the sky.
            "lamp": {"type": "point", "position": [0, 9, 0], "intensity": 0.0},
            "camera": {
                "type": "perspective",
                "fov": 30,
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
                "film": {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}},
            },
        }
    )
    seen = Wavefront(scene, (16, 16), 3).trace(scene.sensors()[0], 0, range(4), 4)
    inside = np.isclose(seen.indirect_albedo[..., 0], 1.0 + ALBEDO_BIAS)
    outside = seen.albedo[..., 0] == 0.0
    assert inside.sum() > 20
    assert outside.sum() > 20
    np.testing.assert_allclose(
        seen.light[inside & np.isclose(seen.albedo[..., 0], 1.0 + ALBEDO_BIAS)], 1.0, rtol=1e-5
    )
    np.testing.assert_allclose(seen.air[outside], 1.0, rtol=1e-5)
    # At the edge, paths and direct samples may meet the body in different numbers, so irradiance
    # is compared, which is that of the neighbours where no path met the body.
    irradiance = np.full_like(seen.indirect_albedo, 1.0 / (1.0 + ALBEDO_BIAS))
    np.divide(seen.indirect, seen.indirect_albedo, where=seen.indirect_albedo > 0.0, out=irradiance)
    np.testing.assert_allclose(seen.air + seen.albedo * irradiance, 1.0, rtol=1e-5)
    np.testing.assert_allclose(seen.albedo[8, 8], 1.0 + ALBEDO_BIAS, rtol=1e-5)
    np.testing.assert_allclose(seen.albedo[0, 0], 0.0)


def test_passes_of_a_frame_replay_one_recording(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import MitsubaScene, choose_tracer
    from render.tracing.wavefront import Wavefront

    shot = make_shot()
    scene = MitsubaScene(shot)
    tracer, _ = choose_tracer(scene.scene, shot.film.resolved(), scene.depth)
    assert isinstance(tracer, Wavefront)
    for seed in range(4):
        tracer.scene_changed()
        tracer.trace(scene.sensor, seed, range(4), 4)
        counts = dict(tracer.recordings)
        assert counts.pop("water") == 0
        # Few paths end at a lamp, or none.
        assert counts.pop("emission") <= 1
        assert set(counts.values()) == {1}


@pytest.mark.nightly
def test_roulette_loses_no_light(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import MitsubaScene
    from render.tracing.wavefront import Wavefront

    film = Film(size=(64, 48), depth=5, soft_light="half", denoise="off")
    found = []
    for depth in (5, 2):
        # The full tracer has no roulette, and its paths of two segments none that could end.
        shot = make_shot(film=film.model_copy(update={"depth": depth}), look="clay")
        for soft_light in ("half", "full"):
            size = film.model_copy(update={"depth": depth, "soft_light": soft_light})
            scene = MitsubaScene(replace(shot, film=size))
            assert isinstance(scene._tracer, Wavefront)
            found.append(scene.trace(1, range(256), 256).indirect.mean(dtype=float))
    half, full, half_sky, full_sky = found
    assert half - half_sky == pytest.approx(full - full_sky, rel=0.02)
    assert half == pytest.approx(full, rel=0.004)


@pytest.mark.nightly
def test_passes_may_be_added_in_parts(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import MitsubaScene

    scene = MitsubaScene(make_shot())
    whole = scene.trace(5, range(6), 6)
    accumulator = scene.accumulator()
    for k in (0, 2, 4):
        accumulator.add_passes(scene.view(), 5, range(k, k + 2), 6)
    parts = accumulator.layers()
    for name in ("direct", "albedo", "indirect", "indirect_albedo", "air"):
        np.testing.assert_allclose(getattr(parts, name), getattr(whole, name), rtol=1e-4, atol=1e-6)


@pytest.mark.nightly
def test_another_number_of_passes_is_recorded_anew(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import MitsubaScene

    scene, fresh = MitsubaScene(make_shot()), MitsubaScene(make_shot())
    scene.trace(5, range(2), 2)
    np.testing.assert_array_equal(
        scene.trace(5, range(6), 6).light, fresh.trace(5, range(6), 6).light
    )


@pytest.mark.nightly
def test_stratification_reduces_the_noise(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import MitsubaScene

    scene = MitsubaScene(replace(make_shot(), film=Film(size=(64, 48), depth=2, denoise="off")))
    # Few passes go through the same places of all pixels, with any seed; these have their own.
    count = 25
    spread = [scene.trace(seed, range(count), count).light for seed in range(8)]
    others = [[1000 + count * seed + k for k in range(count)] for seed in range(8)]
    rng = [
        np.mean([scene.trace(seed, range(1), count).light for seed in seeds], axis=0)
        for seeds in others
    ]
    assert np.std(spread, axis=0).mean() < 0.7 * np.std(rng, axis=0).mean()


def test_a_medium_is_left_to_the_path_tracer(renderer: Renderer) -> None:
    import mitsuba as mi

    from render.mitsuba_scene import choose_tracer
    from render.tracing.path_tracer import PathTracer

    fog = {"type": "homogeneous", "albedo": 0.5, "sigma_t": 1.0}
    scene = mi.load_dict(
        {"type": "scene", "ball": {"type": "sphere", "bsdf": {"type": "null"}, "interior": fog}}
    )
    found, why = choose_tracer(scene, Film(size=(16, 16)).resolved(), 3)
    assert isinstance(found, PathTracer)
    assert "medium" in why


def test_an_opacity_mask_is_left_to_the_path_tracer(renderer: Renderer) -> None:
    import mitsuba as mi

    from render.mitsuba_scene import wavefront_limitation

    def reason(bsdf: dict[str, object]) -> str:
        leaf = {"type": "rectangle", "bsdf": bsdf}
        return wavefront_limitation(mi.load_dict({"type": "scene", "leaf": leaf}))

    dull = {"type": "diffuse"}
    assert "mask" in reason({"type": "mask", "opacity": 0.5, "nested": dull})
    assert reason(dull) == reason({"type": "dielectric"}) == ""


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 12, 16, 30, 64])
def test_the_grid_has_one_stratum_per_pass(count: int) -> None:
    from render.tracing.stratification import stratum_grid

    columns, rows = stratum_grid(count)
    assert columns * rows == count
    assert rows <= math.sqrt(count) <= columns


def _leafy(shot: Shot) -> Shot:
    """Return a shot with a few hundred coloured, translucent leaves over its ground."""
    rng = np.random.default_rng(4)
    corners = rng.uniform((-2, 0.05, -2), (2, 1.2, 2), (300, 1, 3)) + rng.normal(
        0, 0.12, (300, 3, 3)
    )
    n = len(corners) * 3
    leaves = Mesh(
        "leaves",
        corners.reshape(n, 3).astype(np.float32),
        np.arange(n, dtype=np.uint32).reshape(-1, 3),
        "leaves",
        colors=rng.uniform(0.05, 0.6, (n, 3)).astype(np.float32),
        normals=np.tile(np.array([0.0, 0.8, 0.6], np.float32), (n, 1)),
    )
    look = Material(color=(1.0, 1.0, 1.0), roughness=1.0, translucency=0.4)
    return replace(shot, scenery=(leaves,), materials={**shot.materials, "leaves": look})


@pytest.mark.nightly
def test_scenery_lights_as_in_one_scene_of_path(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import MitsubaScene

    film = Film(size=(32, 24), depth=4, soft_light="full", denoise="off")
    shot = _leafy(make_shot(film=film))
    ours, theirs = light_of_both(shot, 128)
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.003)
    # Pixels agree within their noise, and far better than with a picture without leaves.
    apart = np.abs(ours - theirs).mean() / theirs.mean()
    bare = MitsubaScene(replace(shot, scenery=())).trace(0, range(32), 32).light
    assert np.abs(bare - theirs).mean() / theirs.mean() > 4.0 * apart


@pytest.mark.nightly
def test_scenery_stands_still_while_the_rest_moves(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import MitsubaScene

    film = Film(size=(16, 16), depth=2, denoise="off")
    shots = [_leafy(make_shot(x, film)) for x in (0.0, 0.6)]
    assert shots[0].build == shots[1].build != make_shot(0.0, film).build
    scene = MitsubaScene(shots[0])
    scene.trace(5, range(2), 2)
    scene.update(shots[1].moments[0])
    np.testing.assert_array_equal(
        scene.trace(5, range(2), 2).light, MitsubaScene(shots[1]).trace(5, range(2), 2).light
    )


@pytest.mark.nightly
def test_a_gpu_holds_scenery_and_the_rest_in_one_scene(
    renderer: Renderer, make_shot: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On CUDA rays through a second scene would be left out without an error."""
    from render import mitsuba_scene
    from render.tracing.scene_pair import ScenePair

    assert mitsuba_scene._holds_one_scene("cuda_ad_rgb")
    assert not mitsuba_scene._holds_one_scene("llvm_ad_rgb")
    film = Film(size=(32, 24), depth=3, denoise="off")
    first, second = (_leafy(make_shot(x, film)) for x in (0.0, 0.6))

    def seen() -> np.ndarray:
        scene = mitsuba_scene.MitsubaScene(first)
        assert isinstance(scene._traced, ScenePair) == is_pair
        scene.update(second.moments[0])
        return np.asarray(scene.trace(5, range(4), 4).light)

    is_pair = True
    pair = seen()
    monkeypatch.setattr(mitsuba_scene, "_holds_one_scene", lambda variant: True)
    is_pair = False
    np.testing.assert_allclose(seen(), pair, rtol=1e-3, atol=1e-4)
