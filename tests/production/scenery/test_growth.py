"""Growth: bare ground bears no grass, trees stand in groves."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.growth import GATHERED, RASTER, TUFT_LEAST, Growth
from pipeline.production.scenery.species import KINDS
from render.config import MATERIALS, Weather
from render.ground_wear import TEXELS

CALM = Weather.model_validate("calm")


def places(count: int = 40_000, half: float = 60.0) -> tuple[np.ndarray, np.ndarray]:
    x, z = np.random.default_rng(3).uniform(-half, half, (2, count))
    return x, z


def test_bare_ground_bears_no_grass_and_stones_lie_there_as_well() -> None:
    x, z = places()
    growth = Growth(5)
    worn = growth.worn(x, z)
    # Trails and spots are a small part of the land, and bare in their middle.
    assert 0.01 < (worn > 0.7).mean() < 0.12
    bare = worn > 0.9
    assert growth.share("tufts", x[bare], z[bare]).max() < 0.11
    assert growth.share("rubble", x[bare], z[bare]).min() == 1.0
    assert growth.share("tufts", x, z).max() > 0.9


def test_trees_stand_in_groves_that_differ_by_the_seed() -> None:
    x, z = places(half=500.0)
    shares = [Growth(seed).share("grove", x, z) for seed in (5, 6)]
    for share in shares:
        assert 0.08 < (share > 0.5).mean() < 0.6
        assert (share < 0.2).mean() > 0.3
    assert np.corrcoef(shares)[0, 1] < 0.5
    assert KINDS["oak"].habitat == "grove"


@pytest.mark.nightly
def test_the_ground_is_drawn_bare_where_plants_find_it_bare_or_stand_thin() -> None:
    growth = Growth(5)
    wear = growth.wear(MATERIALS["grass"], CALM, np.array([3.0, -4.0]))
    assert wear is not None
    step = RASTER / TEXELS
    j, i = np.random.default_rng(1).integers(200, TEXELS - 200, (2, 500))
    x, z = wear.corner[0] + (i + 0.5) * step, wear.corner[1] + (j + 0.5) * step
    drawn = growth.drawn(x, z)
    np.testing.assert_allclose(wear.texels[j, i] / 255.0, drawn, atol=0.003)
    assert (drawn >= growth.worn(x, z)).all()
    # Soil shows where grass is thin, not in its tufts.
    free = growth.worn(x, z) == 0.0
    tufts = growth.gathered("tufts", np.stack([x, z], axis=-1))
    assert drawn[free & (tufts < TUFT_LEAST + 0.02)].min() > 0.12
    assert drawn[free & (tufts > 0.99)].max() < 0.01
    # It ends before its edge, so that no edge is seen.
    assert wear.texels[[0, -1]].max() == wear.texels[:, [0, -1]].max() == 0
    assert growth.wear(MATERIALS["snow"], CALM, np.zeros(2)) is None
    wet = growth.wear(MATERIALS["grass"], Weather.model_validate("rain"), np.zeros(2))
    assert wet is not None
    assert max(wet.color) < 0.5 * max(wear.color)


def test_ways_of_performers_show_soil() -> None:
    x, z = np.meshgrid(np.arange(-6, 6, 0.1), np.arange(-6, 6, 0.1))
    distance = np.minimum(np.abs(z) / Clearings.UNIT, 255).astype(np.uint8)
    growth = Growth(5, Clearings((-6.0, -6.0), 0.1, distance, np.zeros_like(x, bool)))
    along = np.linspace(-5, 5, 200)
    untrodden = Growth(5)
    more = growth.drawn(along, 0 * along) - untrodden.drawn(along, 0 * along)
    assert more.mean() > 0.1
    away = np.full(200, 3.0)
    np.testing.assert_array_equal(growth.drawn(along, away), untrodden.drawn(along, away))


def test_tufts_and_clumps_leave_the_share_on_average_that_densities_count_on() -> None:
    at = np.stack(places(half=300.0), axis=-1)
    for habitat, share in GATHERED.items():
        for seed in (5, 6):
            found = Growth(seed).gathered(habitat, at)
            assert abs(found.mean() - share) < 0.03
            assert (found > 0.8).mean() > 0.2
            # Turf has no gaps.
            assert (found < 0.3).mean() > 0.25 or (habitat == "turf" and found.min() > 0.5)


@pytest.mark.nightly
def test_dry_beds_cross_dry_land_and_stones_lie_along_them() -> None:
    x, z = places()
    dry, other = Growth(5, dry=True), Growth(5)
    wash = dry.wash(np.stack([x, z], axis=-1))
    assert 0.03 < (wash > 0.9).mean() < 0.3
    assert dry.worn(x, z)[wash > 0.95].min() > 0.94
    assert (dry.worn(x, z) >= other.worn(x, z)).all()
    stones = dry.share("rubble", x, z)
    edge = (wash > 0.4) & (wash < 0.6)
    assert stones[edge].min() > 0.9
    assert stones[wash == 0.0].mean() < 0.6
    wear = dry.wear(MATERIALS["dry soil"], CALM, np.zeros(2))
    assert wear is not None
    # The silt is paler than the soil.
    assert min(wear.color) > 0.3


@pytest.mark.nightly
def test_on_worn_moss_half_of_the_soil_shows() -> None:
    growth, middle = Growth(5), np.zeros(2)
    wears = [growth.wear(MATERIALS[name], CALM, middle) for name in ("grass", "moss")]
    assert wears[0] is not None
    assert wears[1] is not None
    assert 0.4 < wears[1].texels.sum() / wears[0].texels.sum() < 0.5


def test_tall_grass_keeps_off_the_ways_of_the_cast() -> None:
    distances = np.minimum(np.hypot(*np.mgrid[-40:41, -40:41]) * 0.1 / Clearings.UNIT, 255)
    used = Clearings((-4.0, -4.0), 0.1, distances.astype(np.uint8), np.zeros((81, 81), bool))
    growth = Growth(5, used)
    x = np.array([0.0, 0.2, 2.5])
    shares = growth.share("untrodden", x, np.zeros(3)) / growth.share("tufts", x, np.zeros(3))
    np.testing.assert_allclose(shares, [0.0, 0.0, 1.0])
