"""Dust and spray of the contacts of a take."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pipeline.production.shots.puff_tracks import MAX_PUFFS, PuffTracks
from pipeline.simulation.take import Contact
from render.backend import choose
from render.config import MATERIALS, Weather
from render.plume import Puff

STEP = Contact(
    *(47, 0.0, "camel", "camel.r1", "terrain", (1.0, 0.2, 3.0), (0.0, 1.0, 0.0)),
    *(1.2, 27.0, "fur", "sand", 1.0),
)


def tracks(
    *contacts: Contact, ground: str = "sand", rain: float = 0.0, level: float | None = None
) -> PuffTracks:
    take: Any = SimpleNamespace(header=SimpleNamespace(rate=24, steps=4), contacts=contacts)
    water: Any = None if level is None else SimpleNamespace(level=level)
    return PuffTracks.of(take, MATERIALS[ground], Weather(rain=rain), water)


def test_a_step_raises_dust_that_grows_drifts_and_goes() -> None:
    dust = tracks(STEP)
    assert dust.at(47 / 96 - 0.01) == ()
    (young,), (old,) = dust.at(47 / 96 + 0.05), dust.at(47 / 96 + 0.6)
    assert young.p_WP == pytest.approx((1.0, 0.35, 3.0), abs=0.12)
    assert old.radius > 1.3 * young.radius
    assert old.depth < young.depth
    assert old.p_WP[0] > young.p_WP[0]
    assert dust.at(3.0) == ()
    heavy = tracks(replace(STEP, energy=8 * 27.0)).at(47 / 96 + 0.05)[0]
    assert heavy.radius > 1.7 * young.radius


def test_no_dust_rises_from_hard_wet_or_gently_touched_ground() -> None:
    moment = 47 / 96 + 0.1
    assert tracks(STEP, ground="wood").at(moment) == ()
    assert tracks(STEP, rain=0.5).at(moment) == ()
    assert tracks(replace(STEP, speed=0.1)).at(moment) == ()
    assert tracks(replace(STEP, other="crate")).at(moment) == ()
    assert len(tracks(*[STEP] * 200).at(moment)) == MAX_PUFFS


def test_spray_rises_in_shallow_water_only() -> None:
    (spray,) = tracks(STEP, ground="wood", level=0.4).at(47 / 96 + 0.1)
    assert spray.p_WP[1] > 0.4
    assert min(spray.color) > 0.8
    assert tracks(STEP, level=9.0).at(47 / 96 + 0.1) == ()


@pytest.mark.slow
def test_puffs_hide_what_is_behind_them() -> None:
    backend = choose()
    if backend.variant == "scalar_rgb":
        pytest.skip("the scalar variant shows nothing in the air")
    backend.activate()
    import mitsuba as mi

    from render.airborne.plumes import PlumeLight
    from render.airborne.puffs import Puffs

    light = PlumeLight(np.array([0.0, 1.0, 0.0]), np.zeros(3), np.full(3, 0.5))
    puffs = Puffs.of([Puff((0.0, 0.0, 0.0), 0.3, 2.0, (0.8, 0.6, 0.4), 5)], light)
    x = np.linspace(-1.0, 1.0, 256)
    origin = np.stack([x, np.zeros(256), np.full(256, -3.0)]).astype(np.float32)
    ray = mi.Ray3f(mi.Point3f(origin), mi.Vector3f(0, 0, 1))

    def seen(distance: float) -> tuple[np.ndarray, np.ndarray]:
        passed, added = puffs.seen(ray, [mi.Float(np.full(256, distance, np.float32))])
        return np.array(passed), np.array(added)

    passed, added = seen(9.0)
    assert 0.3 < (1 - passed).max() < 0.99
    assert (1 - passed)[abs(x) > 0.7].max() == 0
    # What it hides it replaces with its own light.
    np.testing.assert_allclose(added[1], 1.25 * 0.3 * (1 - passed), atol=1e-5)
    assert (1 - seen(3.0)[0]).max() < 0.8 * (1 - passed).max()
    assert (1 - seen(2.0)[0]).max() < 0.01
