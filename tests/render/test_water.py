"""Water: words, waves, absorption, reflection and light patterns."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from render.config import Film, Water, material
from render.renderer import Renderer
from render.shot import CameraPose, Shot
from render.water import GRAVITY, WaterSurface, travelling_waves

Make = Callable[..., Shot]

FILM = Film(size=(32, 24), depth=3, soft_light="full", denoise="off")
NORTH = CameraPose((0.0, 1.5, 0.0), (0.0, 0.9, 3.0))
"""A view over the water."""


def surface(**values: object) -> WaterSurface:
    return WaterSurface.of(Water.model_validate(values))


def test_bad_words_are_refused_with_the_nearest_name() -> None:
    with pytest.raises(ValidationError, match="no water is called 'lak', did you mean 'lake'"):
        Water.model_validate("lak")
    with pytest.raises(ValidationError, match="no waves is called 'rogh', did you mean 'rough'"):
        Water.model_validate({"waves": "rogh"})
    with pytest.raises(ValidationError, match="clarity"):
        Water.model_validate({"preset": "pond", "clarity": 0})


def test_waves_follow_the_dispersion_of_deep_water_and_grow_with_the_strength() -> None:
    calm, rough = travelling_waves(0.15, 0.0), travelling_waves(0.85, 0.0)
    assert travelling_waves(0.0, 0.0) == ()
    for wave in (*calm, *rough):
        assert wave.speed**2 == pytest.approx(GRAVITY * math.hypot(*wave.k))
        assert wave.phase_at(3.0) == pytest.approx((wave.phase - 3.0 * wave.speed) % (2 * math.pi))
    slopes = [sum((w.amplitude * math.hypot(*w.k)) ** 2 / 2 for w in ws) for ws in (calm, rough)]
    assert slopes[1] > 30.0 * slopes[0]
    # Long waves travel in their heading: 90 degrees is -Z.
    assert min(w.k[1] for w in travelling_waves(0.5, 90.0)[-3:]) < 0.0


def test_a_tenth_of_the_light_is_left_at_the_clarity_and_red_goes_first() -> None:
    water = surface(preset="lagoon", clarity=4.0)
    left = np.exp(-4.0 * np.array(water.extinction))
    assert np.exp(np.log(left).mean()) == pytest.approx(0.1)
    assert left[0] < left[1]
    assert left[0] < left[2]


def test_light_patterns_gather_no_more_light_than_there_is(renderer: Renderer) -> None:
    import mitsuba as mi

    from render.tracing.water import Water as Optics

    optics = Optics.of(surface(preset="lake"), np.ones(3), 1.7)
    x, z = (60.0 * a for a in np.random.default_rng(3).random((2, 40_000)))
    for depth in (0.1, 0.5, 1.5):
        found = np.array(optics._focus(mi.Float(x), mi.Float(z), mi.Float(depth)))
        assert found.mean() == pytest.approx(1.0, rel=0.04)
    assert found.max() > 2.0


def test_straight_segments_are_dimmed_by_their_length_under_water(renderer: Renderer) -> None:
    import mitsuba as mi

    from render.tracing.water import Water as Optics

    water = surface(level=1.0, waves=0.0)
    optics = Optics.of(water, np.ones(3))
    up = mi.Vector3f(0.0, 1.0, 0.0)
    sunk = np.array(optics.along(mi.Point3f(0.0, -2.0, 0.0), up, mi.Float(1.5))).ravel()
    np.testing.assert_allclose(sunk, np.exp(-1.5 * np.array(water.extinction)), rtol=1e-4)
    # 2 % are reflected where light leaves the water upright.
    out = np.array(optics.along(mi.Point3f(0.0, 0.0, 0.0), up, mi.Float(np.inf))).ravel()
    np.testing.assert_allclose(out, 0.98 * np.exp(-np.array(water.extinction)), rtol=2e-3)
    dry = np.array(optics.along(mi.Point3f(0.0, 1.1, 0.0), up, mi.Float(9.0))).ravel()
    np.testing.assert_array_equal(dry, 1.0)


@pytest.mark.nightly
def test_a_mirror_reflects_what_path_sees_in_a_dielectric(
    renderer: Renderer, make_shot: Make
) -> None:
    from render.mitsuba_scene import MitsubaScene
    from render.tracing.path_tracer import PathTracer

    shot = make_shot(film=FILM, camera=NORTH, lit="overcast")
    black = {**shot.materials, "dry soil": material({"color": "#000000", "roughness": 1.0})}
    ground = shot.meshes[0]
    base = replace(shot, meshes=(ground,), materials=black)
    water = replace(surface(level=0.5, waves=0.0), albedo=(0.0, 0.0, 0.0))
    ours = MitsubaScene(replace(base, water=water)).trace(0, range(64), 64).light
    clear = material({"color": "#ffffff", "transmission": 1.0, "ior": 1.333, "roughness": 0.0})
    lifted = ground.vertices + np.array([0.0, 0.5, 0.0], np.float32)
    pane = replace(ground, name="pane", vertices=lifted, material="clear", uv=None)
    scene = MitsubaScene(replace(base, meshes=(ground, pane), materials={**black, "clear": clear}))
    judge = PathTracer(scene.whole(), 3, air=scene.air)
    theirs = judge.trace(scene.sensor, 7, range(8192), 8192).light
    lower = slice(14, None)
    assert ours[lower].mean() == pytest.approx(theirs[lower].mean(), rel=0.003)
    assert theirs[lower].mean() > 0.01


def test_water_is_refused_where_only_path_can_trace(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    from render import mitsuba_scene
    from render.errors import ShotError
    from render.tracing.water import Water as Optics

    monkeypatch.setattr(mitsuba_scene, "wavefront_limitation", lambda scene: "of a reason")
    optics = Optics.of(surface(preset="pond"), np.ones(3))
    with pytest.raises(ShotError, match="there is water, but of a reason; render with"):
        mitsuba_scene.choose_tracer(None, FILM.resolved(), 3, None, optics)


def test_breakers_run_up_the_shore_of_a_sea_alone(renderer: Renderer) -> None:
    import mitsuba as mi

    from render.tracing.water import Water as Optics

    # A beach that falls by 5 cm a metre along x.
    x = np.linspace(0.0, 60.0, 6_000)
    p = mi.Point3f(x, np.zeros_like(x), np.zeros_like(x))
    depth = 0.05 * x

    def foam(preset: str, time: float, waves: str = "breeze") -> np.ndarray:
        optics = Optics.of(surface(preset=preset, waves=waves), np.ones(3), time)
        share = optics.foam.share(p, mi.Float(depth), mi.Normal3f(0.0, 1.0, 0.0))
        return np.array(share)

    def crest(time: float) -> float:
        beyond = (depth > 0.35) & (depth < 1.2)
        return float(x[beyond][np.argmax(foam("sea", time)[beyond])])

    offshore = (depth > 0.3) & (depth < 1.2)
    assert foam("sea", 1.0)[offshore].max() > 0.3
    assert foam("lake", 1.0)[offshore].max() == 0.0
    assert foam("sea", 1.0, "calm")[offshore].max() == 0.0
    assert foam("sea", 1.0)[depth > 2.0].max() == 0.0
    assert crest(0.4) - 4.0 < crest(0.9) < crest(0.4)


def test_foam_lies_in_the_shallows_and_more_of_it_where_waves_break(renderer: Renderer) -> None:
    import mitsuba as mi

    from render.tracing.water import Water as Optics

    x, z = (20.0 * a for a in np.random.default_rng(3).random((2, 20_000)))
    p = mi.Point3f(x, np.zeros_like(x), z)

    def mean(waves: str, depth: float, upright: float = 1.0) -> float:
        optics = Optics.of(surface(preset="lake", waves=waves), np.ones(3), 1.7)
        ground = mi.Normal3f(math.sqrt(1.0 - upright**2), upright, 0.0)
        share = np.array(optics.foam.share(p, mi.Float(depth), ground))
        assert share.min() >= 0.0
        assert share.max() <= 1.0
        return float(share.mean())

    assert mean("rough", 0.0) > 0.1 > mean("ripples", 0.0) > 0.0
    assert mean("rough", 0.05) > 0.02 > mean("ripples", 0.05)
    assert mean("calm", 0.0) == 0.0
    assert mean("rough", 2.0) == 0.0
    # A broken trace beside a steep stone.
    assert mean("rough", 0.0, upright=1.0) > 4.0 * mean("rough", 0.0, upright=0.0) > 0.0


def test_shafts_of_light_lean_with_the_refracted_sun_and_keep_the_mean(renderer: Renderer) -> None:
    import mitsuba as mi

    from render.tracing.water import Water as Optics

    optics = Optics.of(surface(preset="lagoon", level=3.0), np.ones(3), 0.4)
    angle = np.random.default_rng(4).random(4000) * 2.0 * np.pi
    ways = mi.Vector3f(mi.Float(np.cos(angle)), mi.Float(0.0 * angle), mi.Float(np.sin(angle)))
    origins = mi.Point3f(mi.Float(40.0 * angle), mi.Float(0.0 * angle + 1.0), mi.Float(0.0))
    plain = np.array(optics.scattered(origins, ways, mi.Float(20.0)))
    optics.show_shafts((0.6, 0.8, 0.0))
    assert optics.shafts is not None
    assert float(np.array(optics.shafts.x).item()) == pytest.approx(0.6 / 1.33, rel=0.01)
    shown = np.array(optics.scattered(origins, ways, mi.Float(20.0)))
    share = (shown / plain).ravel()
    assert share.min() > 0.3
    assert share.mean() == pytest.approx(1.0, abs=0.35)
    assert share.std() > 0.1


def test_waves_below_a_pixel_mirror_the_mean_of_what_their_slopes_mirror(
    renderer: Renderer,
) -> None:
    """A flat ray far out meets them all: as many random slopes give the same light."""
    import drjit as dr
    import mitsuba as mi

    from render.tracing.water import Water as Optics

    optics = Optics.of(surface(preset="lake"), np.ones(3), 1.7)
    down = math.radians(2.0)
    ray = mi.Ray3f(mi.Point3f(0.0, 30.0, 0.0), mi.Vector3f(0.0, -math.sin(down), math.cos(down)))
    face = optics.interface(ray, optics.crossing(ray))
    roughness = float(np.array(face.roughness)[0])
    assert roughness > 1e-3

    def seen(passes: int) -> float:
        looks = [
            optics.mirrored(face, ray, lambda d: mi.Color3f(dr.exp(-8.0 * d.y)), k, passes)
            for k in range(passes)
        ]
        return float(np.mean([np.array(look)[0] for look in looks]))

    slopes = np.random.default_rng(3).normal(0.0, math.sqrt(roughness / 2.0), (2, 400_000))
    mean = np.array([np.array(face.unbent.x)[0], np.array(face.unbent.z)[0]])
    slopes += (mean / float(np.array(face.unbent.y)[0]))[:, None]
    n = np.stack([slopes[0], np.ones(slopes.shape[1]), slopes[1]])
    n /= np.linalg.norm(n, axis=0)
    way = np.array([0.0, -math.sin(down), math.cos(down)])
    cosine = -(way @ n)
    is_seen = cosine > 0.005
    cosine, n = cosine[is_seen], n[:, is_seen]
    up = np.abs(way[1] + 2.0 * cosine * n[1])
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / 1.333**2)
    across = (cosine - 1.333 * inside) / (cosine + 1.333 * inside)
    along = (1.333 * cosine - inside) / (1.333 * cosine + inside)
    weight = cosine / n[1] * 0.5 * (across**2 + along**2)
    expected = float((weight * np.exp(-8.0 * up)).sum() / weight.sum())
    assert seen(8) == pytest.approx(expected, rel=0.01)
    assert seen(2) == pytest.approx(expected, rel=0.03)
    # A mirror that is only tilted towards the camera would show what is lower in the sky.
    flat = math.exp(-8.0 * math.sin(down))
    assert expected < 0.8 * flat
