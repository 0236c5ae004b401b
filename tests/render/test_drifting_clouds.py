"""Clouds that drift, and their shadows."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from render.backend import Backend
from render.config import Film, Light, light
from render.lights.cloud_shadows import CELLS, LENGTH, cloud_shadows, drift
from render.renderer import Renderer
from render.shot import CameraPose, Shot

SUN = np.array([0.6, 0.8, 0.0])


def under(wind: float = 10.0, **clouds: float) -> Light:
    return light(
        {
            "sun": {"hour": 15, "clouds": {"cumulus": 0.6, **clouds}},
            "weather": {"wind": wind, "wind_heading_deg": 0},
        }
    )


def test_the_scene_is_in_the_sun_when_the_film_begins() -> None:
    shadows = cloud_shadows(under(shadows=0.7), SUN, 0.0)
    assert shadows is not None
    assert shadows.passed[0, 0] > 0.99
    assert shadows.passed.min() == pytest.approx(0.3, abs=0.01)
    assert 0.2 < (shadows.passed < 0.65).mean() < 0.5


def test_there_are_no_shadows_without_heaps_or_by_wish() -> None:
    for clouds in ({"cumulus": 0.0}, {"shadows": 0.0}):
        assert cloud_shadows(under(**clouds), SUN, 0.0) is None
    assert cloud_shadows(light("studio"), SUN, 0.0) is None


def test_clouds_drift_with_the_wind() -> None:
    assert drift(under(), 3.0) == pytest.approx((30.0, 0.0))
    north = light({"weather": {"wind": 2.0, "wind_heading_deg": 90.0}})
    assert drift(north, 1.0) == pytest.approx((0.0, -2.0))
    assert under().changes
    assert not under(wind=0.0).changes
    assert not light({"sun": {"clouds": "clear"}}).changes


@pytest.mark.nightly
def test_direct_light_is_dimmed_by_what_the_clouds_let_pass(
    backend: Backend, renderer: Renderer, make_shot: Callable[..., Shot]
) -> None:
    """The light of a level floor is that without shadows, times the tile at its place and time."""
    from render.mitsuba_scene import MitsubaScene

    film = Film(size=(16, 16), samples=16, depth=2, soft_light="full", denoise="off")
    # Where it is darkest comes over the origin after a while.
    lit = under()
    shadows = cloud_shadows(lit, SUN, 0.0)
    assert shadows is not None
    column = int(np.argmin(shadows.passed[0]))
    time = (CELLS - column) * LENGTH / CELLS / 10.0
    shot = replace(make_shot(film=film, lit=lit), time=time)
    dim, bright = (
        MitsubaScene(replace(shot, light=one)).trace(0, range(16), 16)
        for one in (lit, lit.without_cloud_shadows())
    )
    seen = bright.direct.mean(axis=-1) > 0.2
    share = (dim.direct[seen] / bright.direct[seen]).mean()
    assert share == pytest.approx(shadows.passed[0, column], abs=0.02)
    np.testing.assert_allclose(dim.air, bright.air, atol=1e-4)


def test_the_sky_drifts_smoothly(backend: Backend) -> None:
    if backend.variant == "scalar_rgb":
        pytest.skip("the scalar variant paints no clouds")
    from render.lights.environment_emitters import surroundings

    sky = surroundings(under(), (0.3, 0.26, 0.21), 256).drifting
    assert sky is not None
    start, soon, later = (sky.image(t) for t in (0.0, 0.04, 6.0))
    changed = abs(later - start).mean()
    assert 0 < abs(soon - start).mean() < 0.05 * changed
    # Below the horizon nothing moves, and time alone decides.
    np.testing.assert_array_equal(later[129:], start[129:])
    np.testing.assert_array_equal(sky.image(0.0), start)
    # When the next painting takes over, nothing jumps.
    before, after = (sky.image(10.0 + dt) for dt in (-0.01, 0.01))
    assert abs(after - before).mean() < 0.02 * changed
    assert math.isfinite(float(later.sum()))


def test_a_scene_shows_the_sky_of_its_time_however_it_came_there(
    backend: Backend, make_shot: Callable[..., Shot]
) -> None:
    if backend.variant == "scalar_rgb":
        pytest.skip("the scalar variant paints no clouds")
    from render.mitsuba_scene import MitsubaScene

    film = Film(size=(16, 16), samples=1, depth=2, soft_light="full", denoise="off")
    up = CameraPose((0.0, 1.0, 0.0), (3.0, 4.0, 0.0))
    first = make_shot(film=film, lit=under(), camera=up)
    later = replace(first, time=6.0)
    updated = MitsubaScene(first)
    start = updated.trace(0, range(1), 1).air
    updated.update(later.moments[0])
    now = updated.trace(0, range(1), 1)
    assert abs(now.air - start).max() > 0.01
    new = MitsubaScene(later).trace(0, range(1), 1)
    np.testing.assert_array_equal(now.air, new.air)
    np.testing.assert_array_equal(now.direct, new.direct)
    np.testing.assert_array_equal(now.indirect, new.indirect)
