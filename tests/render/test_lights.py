"""Light by day, in twilight and at night."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from render.backend import Backend
from render.color import luminance
from render.config import Light, Sun, light
from render.lights.sun_position import sun_direction, sun_elevation_deg

if TYPE_CHECKING:
    from render.lights.environment_emitters import Surroundings

GROUND = (0.3, 0.26, 0.21)


def sky_map(found: Surroundings) -> np.ndarray:
    """Return the map of the sky as the film begins, (H, W, 3)."""
    if found.drifting is not None:
        return np.asarray(found.drifting.image(0.0), np.float64)
    return np.array(found.emitters["sky"]["bitmap"], np.float64)[..., :3]


def irradiance_of(lit: Light) -> tuple[np.ndarray, np.ndarray]:
    """Return what sky and key light send on level ground and on a wall to the south."""
    from render.lights.environment_emitters import surroundings
    from render.lights.environment_map import irradiance

    around = surroundings(lit, GROUND)
    found, sky = around.emitters, sky_map(around)
    total = []
    for normal in (np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])):
        sent = irradiance(sky, normal)
        if "key" in found:
            T = np.array(found["key"]["to_world"].matrix)
            toward = T[:3, 3] / np.linalg.norm(T[:3, 3])
            area = np.pi * np.linalg.norm(T[:3, 0]) ** 2
            radiance = np.array(found["key"]["emitter"]["radiance"]["value"])
            sent += radiance * area / np.sum(T[:3, 3] ** 2) * max(float(normal @ toward), 0.0)
        total.append(sent)
    return total[0], total[1]


def at(hour: float, **config: float) -> Light:
    return light({"sun": {"hour": hour, "day": 172, "latitude_deg": 48, **config}})


@pytest.mark.nightly
@pytest.mark.parametrize("clouds", [0.0, 0.5])
def test_light_is_continuous_from_day_to_night(
    clouds: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where it changes most, while the sun sets, half the time changes it half as much.

    The clouds stay where they are: as a rule each hour has others, some before the glow.
    """
    from render.lights import environment_emitters

    monkeypatch.setattr(environment_emitters, "cloud_seed", lambda sun: 7)

    def steps(hours: np.ndarray) -> np.ndarray:
        seen = np.array([irradiance_of(at(h, clouds=clouds)) for h in hours])
        return np.asarray(np.abs(np.diff(np.log(seen), axis=0)).max(axis=(1, 2)))

    setting = np.arange(19.74, 20.22, 1 / 30)
    shift = steps(setting)
    assert shift.max() < 0.4
    assert steps(np.arange(20.3, 22.5, 0.1)).max() < 0.3
    worst = int(shift.argmax())
    assert steps(np.linspace(setting[worst], setting[worst + 1], 5)).max() < 0.4 * shift.max()


@pytest.mark.slow
def test_night_is_darker_and_bluer_than_dusk_and_dusk_than_day() -> None:
    level = {name: irradiance_of(light(name))[0] for name in ("day", "dusk", "night")}
    bright = {name: float(luminance(value)) for name, value in level.items()}
    assert bright["day"] > 1.5 * bright["dusk"] > 2 * bright["night"] > 0
    assert level["night"][2] > 1.5 * level["night"][0]
    assert level["day"][2] < level["day"][0]


@pytest.mark.nightly
def test_moon_and_clouds_set_the_light_of_a_night() -> None:
    def level(**config: object) -> float:
        return float(luminance(irradiance_of(light({"preset": "night", **config}))[0]))

    full, half, new = (level(moon={"phase": p}) for p in (1.0, 0.5, 0.0))
    assert full > 1.3 * half > 1.3 * new > 0
    assert level(sun={"clouds": 1.0}) < full


def test_stars_are_constant_and_wider_than_a_pixel() -> None:
    from render.lights.night_sky import star_map

    stars = star_map(0.5, -18.0)
    assert stars is not None
    np.testing.assert_array_equal(stars, star_map(0.5, -18.0))
    assert star_map(0.5, -5.9) is None
    assert star_map(0.0, -18.0) is None
    bright = luminance(stars)
    beside = sum(np.roll(bright, s, axis) for s in (-1, 1) for axis in (0, 1))
    top = bright > 0.05
    assert top.sum() > 500
    # No single bright pixel: each has bright neighbours.
    assert (beside[top] > 0).all()


def test_the_sun_may_be_below_the_horizon() -> None:
    assert sun_elevation_deg(Sun(hour=0)) < -15
    with pytest.raises(ValueError, match="need a sun"):
        light({"studio": {}, "stars": 0.5})
    dark = light({"stars": 0.8})
    assert dark.sun is not None
    assert dark.sun.hour == 0


def sky_of(hour: float, clouds: object, width: int = 512) -> np.ndarray:
    from render.lights.environment_emitters import surroundings

    found = surroundings(light({"sun": {"hour": hour, "clouds": clouds}}), GROUND, width)
    return sky_map(found)


def test_clouds_are_bright_towards_the_sun_and_dark_below(backend: Backend) -> None:
    """More of them cover more of the sky; ground, and the sun's own place, stay as they are."""
    if backend.variant.startswith("scalar"):
        pytest.skip("the scalar variant paints no clouds")
    from render.lights.environment_map import pixel_directions, resized

    clear = resized(sky_of(15, "clear"), 512, 256)
    bare = luminance(clear)
    shares = []
    for cumulus in (0.3, 0.6):
        image = luminance(sky_of(15, {"cumulus": cumulus}))
        np.testing.assert_allclose(image[140:], bare[140:], rtol=0.01)
        change = (image / bare)[:112]
        shares.append((abs(change - 1) > 0.1).mean())
        assert change.max() > 1.5
        sun = pixel_directions(512, 256) @ np.array(sun_direction(Sun(hour=15)))
        near = sun > np.cos(np.radians(3))
        np.testing.assert_allclose(image[near], bare[near], rtol=0.05)
    # Of the skies of other hours, covers of 0.3 hide 0.45 to 0.7 down to the horizon.
    assert 0.05 < shares[0] < 0.9 * shares[1] < 0.8


def test_clouds_repeat_and_differ_from_day_to_day(backend: Backend) -> None:
    if backend.variant.startswith("scalar"):
        pytest.skip("the scalar variant paints no clouds")
    from render.lights.environment_emitters import _PAINTED

    first = sky_of(10, "fair", 256)
    _PAINTED.clear()
    np.testing.assert_array_equal(first, sky_of(10, "fair", 256))
    other = light({"sun": {"hour": 10, "day": 200}})
    assert other.sun is not None
    assert other.sun.clouds.cumulus > 0


def test_clouds_are_a_name_a_number_or_values() -> None:
    assert Sun(clouds=0).clouds == Sun(clouds="clear").clouds.model_copy(update={"preset": None})
    assert Sun(clouds=1).clouds.overcast == 1
    assert Sun(clouds={"preset": "fair", "cirrus": 0}).clouds.cumulus == Sun().clouds.cumulus
    with pytest.raises(ValueError, match="did you mean 'cumulus'"):
        Sun(clouds="cumulous")
    with pytest.raises(ValueError, match="from 0 to 1"):
        Sun(clouds=2)
