"""Footprints: at contacts, from then on, and only on soft ground."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.shots.footprint_timeline import SHAPE, SOFT_GROUNDS, footprint_timeline
from pipeline.simulation.take import Take
from render.footprints import BLOCK, MAX_FOOTPRINTS, FootprintRaster


@pytest.fixture(scope="session")
def first_steps(hills: tuple[object, Take]) -> Take:
    return hills[1]


def texel(prints: FootprintRaster, x: float, z: float) -> int:
    """Return the packed texel nearest to a place, 0 where there is no block."""
    i, j = (round((at - c) / prints.spacing) for at, c in zip((x, z), prints.corner, strict=True))
    rows, columns = prints.blocks.shape
    if not (0 <= i < columns * BLOCK and 0 <= j < rows * BLOCK):
        return 0
    block = prints.texels[prints.blocks[j // BLOCK, i // BLOCK]]
    return int(block[j % BLOCK, i % BLOCK])


def treads(take: Take) -> list[tuple[float, float, float]]:
    """Return rows and places of all feet that came down."""
    scale = take.header.samples / take.header.steps
    return [
        ((c.step + c.fraction) * scale, c.place[0], c.place[2])
        for c in take.contacts
        if c.kind == "touch" and c.other == "terrain"
    ]


def test_every_foot_leaves_a_footprint_at_its_contact(first_steps: Take) -> None:
    found = footprint_timeline(first_steps, "soil")
    assert found is not None
    expected = treads(first_steps)
    assert len(expected) > 10
    for number, (_, x, z) in enumerate(expected, start=1):
        word = texel(found.raster, x, z)
        # Who trod there before keeps the place.
        assert 1 <= word & MAX_FOOTPRINTS <= number
        assert (word >> 13) & 31 > 0
    seen = {int(n) for n in np.unique(found.raster.texels & MAX_FOOTPRINTS)} - {0}
    assert seen <= set(range(1, len(expected) + 1))
    assert len(seen) > 0.8 * len(expected)


def test_there_is_no_footprint_away_from_feet(first_steps: Take) -> None:
    found = footprint_timeline(first_steps, "soil")
    assert found is not None
    places = np.array([(x, z) for _, x, z in treads(first_steps)])
    rng = np.random.default_rng(2)
    for x, z in rng.uniform(places.min(0) - 1, places.max(0) + 1, (2000, 2)):
        if np.linalg.norm(places - (x, z), axis=1).min() > 0.25:
            assert texel(found.raster, x, z) == 0


def test_a_frame_shows_the_footprints_made_before_it(first_steps: Take) -> None:
    found = footprint_timeline(first_steps, "sand")
    assert found is not None
    rows = [row for row, _, _ in treads(first_steps)]
    for count, row in enumerate(rows):
        assert found.count(row - 1e-6) <= count < found.count(row)
    assert found.count(0.0) == sum(row <= 0 for row in rows)
    assert found.count(1e9) == len(rows)


@pytest.mark.parametrize("texture", ["rock", "tiles", "none"])
def test_hard_ground_has_no_footprints(first_steps: Take, texture: str) -> None:
    assert texture not in SOFT_GROUNDS
    assert footprint_timeline(first_steps, texture) is None


def test_footprints_are_as_wide_as_feet_and_repeat(first_steps: Take) -> None:
    first, again = (footprint_timeline(first_steps, "snow") for _ in range(2))
    assert first is not None
    assert again is not None
    assert first.raster.bytes == again.raster.bytes
    dark = ((first.raster.texels >> 13) & 31) > 0
    area = dark.sum() * first.raster.spacing**2 / len(treads(first_steps))
    assert SHAPE.min_radius**2 < area < 0.3**2
