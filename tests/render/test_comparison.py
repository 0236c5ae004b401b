"""Image comparison: FLIP against its authors' program, tiles and deviations by their laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from render.comparison.flip_metric import JUDGES, flip
from render.comparison.image_statistics import (
    TILE,
    exposure_change,
    psnr,
    region_deviation,
    seed_spread,
    tile_box,
    tile_deviations,
    tile_means,
)

Picture = NDArray[np.uint8]
PAIRS = 50


def pair(k: int) -> tuple[Picture, Picture]:
    """Return two pictures that differ in one of five ways, of odd and even sizes."""
    draw = np.random.default_rng(k)
    height, width = (int(n) for n in draw.integers(24, 90, 2))
    y, x = np.mgrid[:height, :width]
    waves = [np.sin(x / draw.uniform(2, 20) + y / draw.uniform(2, 20)) for _ in range(3)]
    base = np.clip(127 + 110 * np.stack(waves, axis=-1), 0, 255)
    match k % 5:
        case 0:
            other = base + draw.normal(0, 25, base.shape)
        case 1:
            other = np.roll(base, int(draw.integers(1, 4)), axis=int(draw.integers(2)))
        case 2:
            other = base.copy()
            other[8:20, 8:20] = 255 - other[8:20, 8:20]
        case 3:
            other = base * draw.uniform(0.3, 1.2, 3)
        case _:
            base, other = draw.integers(0, 256, (2, *base.shape)).astype(float)
    one, two = (np.clip(np.rint(picture), 0, 255).astype(np.uint8) for picture in (base, other))
    return one, two


@pytest.mark.slow
@pytest.mark.parametrize("k", range(PAIRS))
def test_flip_agrees_with_its_authors_program(k: int) -> None:
    pytest.importorskip("flip_evaluator", reason="there is no wheel for this platform")
    one, two = pair(k)
    ours, theirs = (JUDGES[name](one, two) for name in ("pronk", "flip-evaluator"))
    assert theirs.max() > 0.01
    assert np.abs(ours - theirs).max() < 1e-3
    assert np.abs(tile_means(ours) - tile_means(theirs)).max() < 1e-4


@pytest.mark.parametrize("name", JUDGES)
def test_flip_is_zero_for_equal_images_and_symmetric(name: str) -> None:
    if name == "flip-evaluator":
        pytest.importorskip("flip_evaluator", reason="there is no wheel for this platform")
    one, two = pair(1)
    assert not JUDGES[name](one, one).any()
    assert JUDGES[name](one, two) == pytest.approx(JUDGES[name](two, one), abs=1e-6)


def test_black_and_white_have_the_largest_difference() -> None:
    black = np.zeros((32, 32, 3), np.uint8)
    # White against black is at 100 of 203 on the compressed scale of colours.
    assert JUDGES["pronk"](black, ~black) == pytest.approx(np.full((32, 32), 0.966), abs=0.01)


def test_a_small_error_is_lost_in_the_mean_and_found_in_a_tile() -> None:
    grey = np.full((180, 320, 3), 128, np.uint8)
    spoilt = grey.copy()
    spoilt[100:108, 200:208] = [255, 0, 0]
    errors = flip(grey, spoilt)
    tiles = tile_means(errors)
    assert errors.mean() < 0.005
    assert tiles.max() > 0.2
    row, column = np.unravel_index(int(tiles.argmax()), tiles.shape)
    left, top, width, height = tile_box(int(row), int(column), grey.shape)
    assert left <= 204 < left + width
    assert top <= 104 < top + height


@pytest.mark.parametrize("shape", [(16, 16), (54, 96), (70, 33), (9, 40), (180, 320)])
def test_tiles_partition_an_image(shape: tuple[int, int]) -> None:
    values = np.random.default_rng(1).random((*shape, 3))
    tiles = tile_means(values)
    covered = np.zeros(shape, int)
    for row in range(tiles.shape[0]):
        for column in range(tiles.shape[1]):
            left, top, width, height = tile_box(row, column, shape)
            square = (slice(top, top + height), slice(left, left + width))
            covered[square] += 1
            assert tiles[row, column] == pytest.approx(values[square].mean(axis=(0, 1)))
            assert min(width, shape[1]) < 2 * TILE
    assert (covered == 1).all()


def test_images_of_two_sizes_are_rejected() -> None:
    with pytest.raises(ValueError, match="pixels"):
        flip(np.zeros((8, 8, 3), np.uint8), np.zeros((8, 9, 3), np.uint8))


def test_psnr_follows_its_definition() -> None:
    one = np.full((4, 4, 3), 100, np.uint8)
    assert psnr(one, one) == math.inf
    assert psnr(one, one + np.uint8(10)) == pytest.approx(20 * math.log10(25.5))


def noisy(seed: int, shift: float = 0.0) -> Picture:
    noise = np.random.default_rng(seed).normal(120 + shift, 20, (64, 96, 3))
    return np.clip(np.rint(noise), 0, 255).astype(np.uint8)


def test_deviations_of_noise_are_standardised() -> None:
    spread = seed_spread([noisy(k) for k in range(40)])
    found = np.concatenate([tile_deviations(spread, noisy(1000 + k)).ravel() for k in range(40)])
    # The largest of three normal deviates has a mean of 1.33 of its absolute value.
    assert found.mean() == pytest.approx(1.33, abs=0.08)
    assert found.max() < 6


def test_a_change_far_below_the_noise_is_found() -> None:
    spread = seed_spread([noisy(k) for k in range(8)])
    # The mean of a tile of 256 pixels is known to 20 / 16 of 255.
    assert tile_deviations(spread, noisy(99)).max() < 6
    assert tile_deviations(spread, noisy(99, shift=8)).min() > 3
    with pytest.raises(ValueError, match="tiles"):
        tile_deviations(spread, noisy(1)[:32])


@pytest.mark.parametrize("stops", [-1.0, -0.03, 0.03, 0.5])
def test_a_change_of_exposure_is_told_in_stops(stops: float) -> None:
    y, x = np.mgrid[:64, :96]
    light = 0.02 + 0.3 * np.stack([x / 96, y / 64, (x + y) / 160], axis=-1)

    def photographed(linear: NDArray[np.float64]) -> Picture:
        srgb = np.where(
            linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0) ** (1 / 2.4) - 0.055
        )
        return np.rint(255 * np.clip(srgb, 0, 1)).astype(np.uint8)

    found = exposure_change(photographed(light), photographed(light * 2**stops))
    assert found == pytest.approx(stops, abs=0.002)


def test_an_even_change_is_found_in_regions_where_tiles_hide_it() -> None:
    spread = seed_spread([noisy(k) for k in range(8)])
    same, brighter = noisy(99), noisy(99, shift=2)
    assert region_deviation(spread, same) < 6
    assert tile_deviations(spread, brighter).max() < 6
    assert region_deviation(spread, brighter) > 8
    half = same.copy()
    half[:, :32] = brighter[:, :32]
    assert region_deviation(spread, half) > region_deviation(spread, same) + 1
    with pytest.raises(ValueError, match="tiles"):
        region_deviation(spread, noisy(1)[:32])


def test_deviations_of_regions_are_standardised() -> None:
    spread = seed_spread([noisy(k) for k in range(40)])
    found = [region_deviation(spread, noisy(1000 + k)) for k in range(40)]
    # The largest of 27 normal deviates, some of which belong together.
    assert 1.5 < np.mean(found) < 2.5
    assert max(found) < 5


def test_black_pictures_have_an_exposure() -> None:
    black = np.zeros((32, 32, 3), np.uint8)
    assert exposure_change(black, black) == 0
    assert exposure_change(black, np.full_like(black, 5)) > 1
