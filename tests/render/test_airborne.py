"""What is in the air between camera and surfaces: rain and snow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.production.shots.ground_weather import (
    frosted,
    ground_in_weather,
    snowed_cover,
    wetted,
)
from pipeline.production.surroundings.land_cover import SNOW
from render.backend import Backend
from render.color import linear, luminance
from render.config import MATERIALS, Material, Weather, light
from render.frame import LightLayers
from render.lights.haze import haze_of, haze_strength, sun_glow
from render.shot import CameraPose, Lens, Mesh

RAYS = 4096


@pytest.fixture(autouse=True)
def _vectorised(backend: Backend) -> None:
    if backend.variant == "scalar_rgb":
        pytest.skip("the scalar variant shows nothing in the air")


def passed(weather: Weather, time: float, lowered: float = 0.0) -> np.ndarray:
    """Return what passes along rays in a fan, from a camera that is lowered by some metres."""
    import mitsuba as mi

    from render.airborne.precipitation import Precipitation

    falling = Precipitation.of(weather, np.ones(3), np.zeros(3), time)
    angle = np.linspace(-0.7, 0.7, RAYS)
    d = np.stack([np.sin(angle), np.full(RAYS, 0.02), np.cos(angle)])
    d /= np.linalg.norm(d, axis=0)
    ray = mi.Ray3f(mi.Point3f(0.13, 2.0 - lowered, 0.21), mi.Vector3f(d.astype(np.float32)))
    share, light = falling.seen(ray, mi.Float(np.full(RAYS, 50.0, np.float32)), mi.Float(0.002))
    np.testing.assert_allclose(np.array(light)[0] > 0, np.array(share) < 1)
    return np.array(share)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["rain", "snow"])
def test_drops_fall_through_the_world(backend: Backend, kind: str) -> None:
    """A camera that falls as fast as they do sees the same drops; one that stands sees others."""
    weather = Weather(**{kind: 0.6, "wind": 0.0})
    speed = {"rain": 8.0, "snow": 1.3}[kind]
    before = passed(weather, 1.0)
    assert 0.002 < 1 - before.mean() < 0.5
    np.testing.assert_array_equal(passed(weather, 1.0), before)
    later = passed(weather, 1.5)
    assert abs(later - before).mean() > 1e-3
    if kind == "rain":
        followed = passed(weather, 1.5, lowered=speed * 0.5)
        assert abs(followed - before).mean() < 0.2 * abs(later - before).mean()


def test_more_rain_hides_more(backend: Backend) -> None:
    light_rain, heavy = (passed(Weather(rain=r), 2.0).mean() for r in (0.2, 1.0))
    assert 1 - heavy > 2 * (1 - light_rain) > 0


def seen_from(aside: float, lens: Lens | None) -> np.ndarray:
    """Return what passes along a fan of rays from a place of a lens to the same places in focus."""
    import mitsuba as mi

    from render.airborne.precipitation import OpenLens, Precipitation

    camera = CameraPose((0.13, 2.0, 0.21), (0.13, 2.0, 9.0), lens=lens)
    falling = Precipitation.of(Weather(rain=0.8), np.ones(3), np.zeros(3), 1.3, OpenLens.of(camera))
    angle = np.linspace(-0.5, 0.5, RAYS)
    origin = np.array([0.13 + aside, 2.0, 0.21])
    d = np.stack([0.13 + 4.0 * np.tan(angle), np.full(RAYS, 2.05), np.full(RAYS, 4.21)])
    d -= origin[:, None]
    d /= np.linalg.norm(d, axis=0)
    ray = mi.Ray3f(mi.Point3f(*origin.tolist()), mi.Vector3f(d.astype(np.float32)))
    distance = mi.Float(np.full(RAYS, 3.5, np.float32))
    share, _ = falling.seen(ray, distance, mi.Float(0.002))
    return np.array(share)


def test_near_rain_is_the_same_from_all_over_an_open_lens(backend: Backend) -> None:
    lens = Lens(0.02, 4.0)
    middle, rim = (seen_from(aside, lens) for aside in (0.0, 0.018))
    np.testing.assert_allclose(rim, middle, atol=5e-3)
    # Through a pinhole they are other rays, which meet other drops.
    sharp, shifted = (seen_from(aside, None) for aside in (0.0, 0.018))
    assert abs(shifted - sharp).max() > 0.02
    # Drops out of focus are wider and fainter, and hide as much together.
    assert 1 - middle.min() < 0.9 * (1 - sharp.min())
    assert (1 - middle).mean() == pytest.approx((1 - sharp).mean(), rel=0.3)


def test_layers_are_dimmed_and_lit(backend: Backend) -> None:
    from render.airborne.airborne_pass import AirborneExposure

    seen = np.full((4, 4, 4), 0.25, np.float32)

    class Fixed:
        def traced(self) -> np.ndarray:
            return seen.reshape(-1, 4)

    # Four of eight rows, in any order.
    pixels = np.random.default_rng(1).permutation(np.arange(8, 24, dtype=np.uint32))
    exposure = AirborneExposure(Fixed(), pixels)  # type: ignore[arg-type]
    exposure.add()
    for side in (1, 2):
        soft = (8 // side, 4 // side, 3)
        direct, albedo, air = (np.ones((8, 4, 3), np.float32) for _ in range(3))
        indirect, soft_albedo = (np.ones(soft, np.float32) for _ in range(2))
        layers = LightLayers(direct, albedo, indirect, soft_albedo, air)
        exposure.lay_over(layers)
        # Soft light is blended at the border where it is enlarged.
        np.testing.assert_allclose(layers.light[3:5], 0.25 * 3.0 + 0.25)
        np.testing.assert_allclose(layers.light[[0, 7]], 3.0)
        np.testing.assert_allclose(layers.albedo[2:6], 0.25)
        np.testing.assert_allclose(layers.albedo[[0, 1, 6, 7]], 1.0)
        np.testing.assert_allclose(layers.indirect / layers.indirect_albedo, 1.0)


@pytest.mark.parametrize("lens", [None, Lens(0.05, 3.0)])
def test_the_area_of_a_sphere_holds_all_of_its_pixels(lens: Lens | None) -> None:
    from render.airborne.picture_area import picture_area

    rng, size = np.random.default_rng(4), (96, 54)
    largest = []
    for _ in range(200):
        camera = CameraPose(
            tuple(rng.normal(0, 1, 3)),
            tuple(rng.normal(0, 1, 3)),
            fov_deg=rng.uniform(15, 100),
            lens=lens,
        )
        sphere = np.array([[*rng.normal(0, 4, 3), rng.uniform(0.05, 3.0)]])
        area = picture_area(camera, sphere, size)
        # Rays through the middles of pixels, from the middle of the lens or its rim.
        half = np.tan(np.radians(camera.fov_deg) / 2)
        x = ((np.arange(size[0]) + 0.5) / size[0] * 2 - 1) * half * size[0] / size[1]
        y = (1 - (np.arange(size[1]) + 0.5) / size[1] * 2) * half
        right, up, ahead = camera.axes
        d = x[None, :, None] * right + y[:, None, None] * up + ahead
        rim = 0.0 if lens is None else lens.radius
        focus = 1.0 if lens is None else lens.focus
        for turn in (0.0, 1.0, 2.5, 4.0):
            off = rim * (np.cos(turn) * right + np.sin(turn) * up)
            way = d * focus - off
            way /= np.linalg.norm(way, axis=-1, keepdims=True)
            to = sphere[0, :3] - camera.p_WC - off
            along = way @ to
            distance = np.linalg.norm(to - along[..., None].clip(0) * way, axis=-1)
            assert not (area < (distance < sphere[0, 3])).any()
        largest.append(area.mean())
    assert np.median(largest) < 0.5


def test_ground_is_dark_and_glossy_in_rain_and_white_under_snow() -> None:
    soil = MATERIALS["dry soil"]
    wet = ground_in_weather(soil, Weather(rain=1.0))
    white = ground_in_weather(soil, Weather(snow=1.0))
    brightness = [float(luminance(linear(m.color))) for m in (wet, soil, white)]
    assert brightness[0] < 0.5 * brightness[1] < brightness[2]
    assert brightness[2] > 0.7
    assert wet.roughness < soil.roughness
    assert 0.0 < wet.bump < soil.bump
    assert white.steep_color is not None
    assert ground_in_weather(soil, Weather()) is soil


def test_a_floor_is_soaked_by_less_rain_than_soil_and_shines_more() -> None:
    drizzle = Weather(rain=0.2)
    wet = {}
    for name in ("dry soil", "terracotta tiles", "concrete"):
        dry = MATERIALS[name]
        wet[name] = ground_in_weather(dry, drizzle)
        assert wet[name].roughness < dry.roughness
    assert wet["concrete"].roughness < 0.3 < wet["dry soil"].roughness
    assert ground_in_weather(MATERIALS["concrete"], Weather(rain=1.0)) == wet["concrete"]


def test_snow_lies_where_land_is_level() -> None:
    corners = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [9, 0, 0], [9, 5, 0.1], [9, 0, 1]])
    mesh = Mesh(
        *("land", corners.astype(np.float32), np.array([[0, 1, 2], [3, 4, 5]], np.uint32), "grass"),
        cover=np.full((6, 4), 0.1, np.float32),
    )
    cover = snowed_cover(mesh, Weather(snow=1.0)).cover
    assert cover is not None
    np.testing.assert_allclose(cover[:3, :3], np.tile(SNOW, (3, 1)), rtol=1e-5)
    np.testing.assert_allclose(cover[3:, :3], 0.1)
    assert snowed_cover(mesh, Weather()) is mesh
    grass = np.full((6, 3), 0.1, np.float32)
    plant = replace(
        mesh, colors=grass, normals=np.tile(np.float32([[0, 1, 0], [0, -1, 0]]), (3, 1))
    )
    white = frosted(plant, Weather(snow=1.0)).colors
    assert white is not None
    assert white[0].min() > 0.6
    assert 0.1 < white[1].max() < 0.25


def test_rain_needs_a_sky_and_thickens_the_haze() -> None:
    with pytest.raises(ValueError, match="need a sky"):
        light({"studio": {}, "weather": "rain"})
    with pytest.raises(ValueError, match="did you mean 'storm'"):
        light({"weather": "strom"})
    dry, wet = light("day"), light({"preset": "day", "weather": "rain"})
    assert haze_strength(wet) > haze_strength(dry)
    assert wet.changes


def test_haze_glows_before_a_low_sun_and_not_before_a_high_one() -> None:
    sky = np.ones((256, 512, 3))

    def glow(elevation_deg: float) -> np.ndarray:
        up, level = np.sin(np.radians(elevation_deg)), np.cos(np.radians(elevation_deg))
        # Towards +X, the 16th of 64 columns.
        added = sun_glow(np.array([level, up, 0.0]), np.ones(3))
        haze, plain = haze_of(0.2, sky, added), haze_of(0.2, sky)
        assert haze is not None
        assert plain is not None
        np.testing.assert_allclose(haze.light - plain.light, added)
        return np.asarray(added[0, :, 0])

    low = glow(5.0)
    assert low.argmax() == 16
    assert low[16] > 10.0 * low[48] > 0.0
    np.testing.assert_allclose(glow(40.0), 0.0)
    assert 0.0 < glow(20.0)[16] < 0.5 * low[16]


def test_what_is_out_in_the_rain_gets_a_film_of_water_and_darker_the_rougher_it_is() -> None:
    shell, cloth = (
        Material.model_validate({"color": "#408040", "color2": "#204020", "roughness": rough})
        for rough in (0.3, 0.9)
    )
    wet = [wetted(one, Weather(rain=1.0)) for one in (shell, cloth)]
    assert wet[0].clearcoat > 0.7 > 0.2 > wet[1].clearcoat
    for dry, one in zip((shell, cloth), wet, strict=True):
        assert one.roughness < dry.roughness
        assert one.color[1] < dry.color[1]
        assert one.color2 is not None
    darker = [one.color[1] / dry.color[1] for dry, one in zip((shell, cloth), wet, strict=True)]
    assert darker[1] < 0.8 < darker[0]
    assert wetted(shell, Weather(snow=1.0)) is shell
    leaf = Material.model_validate({"color": "#408040", "roughness": 0.9, "translucency": 0.4})
    assert wetted(leaf, Weather(rain=1.0)) is leaf
