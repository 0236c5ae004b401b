"""Specks: single pixels of the sky between leaves, and of another colour."""

from __future__ import annotations

import numpy as np

from render.frame import LightLayers
from render.specks import without_specks


def layers(sky: np.ndarray) -> LightLayers:
    """Return a frame with bright sky where `sky` (H, W) is 1, and dark leaves where it is 0."""
    share = sky.astype(np.float32)[..., None] * np.ones(3, np.float32)
    half = np.zeros((sky.shape[0] // 2, sky.shape[1] // 2, 3), np.float32)
    surface = np.float32(1.0) - share
    return LightLayers(0.02 * surface, 0.1 * surface, half, half, 2.0 * share + 0.01 * surface)


def test_single_pixels_of_sky_or_leaf_become_as_those_around() -> None:
    sky = np.zeros((16, 32))
    sky[:, 16:] = 1.0
    speckled = sky.copy()
    speckled[4, 5], speckled[9, 8], speckled[6, 25] = 1.0, 0.5, 0.0
    speckled[12, 4:6] = 1.0
    mended, clean = without_specks(layers(speckled)), layers(sky)
    for name in ("direct", "albedo", "air"):
        np.testing.assert_allclose(getattr(mended, name), getattr(clean, name), atol=1e-6)


def test_what_is_out_of_focus_stays() -> None:
    sky = np.zeros((16, 32))
    sky[4, 5] = sky[4, 25] = 1.0
    softness = np.zeros((16, 32, 1), np.float32)
    softness[:, 16:] = 1.0
    before = layers(sky)
    after = without_specks(before, softness)
    assert after.air[4, 5, 0] < 0.1
    assert after.air[4, 25, 0] == before.air[4, 25, 0]


def test_outlines_twigs_and_gaps_stay() -> None:
    sky = np.zeros((24, 32))
    sky[:, 16:] = 1.0
    # A twig before the sky, a gap of two by two, and a slanted outline.
    sky[3, 16:30] = 0.0
    sky[10:12, 5:7] = 1.0
    sky[np.arange(14, 22), np.arange(2, 10)] = 1.0
    before = layers(sky)
    after = without_specks(before)
    changed = np.any(after.air != before.air, axis=-1)
    # The twig and the line may end one pixel earlier.
    assert set(zip(*np.nonzero(changed), strict=True)) <= {(3, 29), (14, 2), (21, 9)}


def test_lamps_and_stars_stay() -> None:
    """What shines by itself has no less surface than what is around it."""
    dark = layers(np.zeros((9, 9)))
    dark.air[4, 4] = 5.0
    assert without_specks(dark).air[4, 4, 0] == 5.0
    night = layers(np.ones((9, 9)))
    night.air[:] = 0.01
    night.air[4, 4] = 1.0
    assert without_specks(night).air[4, 4, 0] == 1.0


def test_single_petals_take_the_colour_of_the_grass_and_keep_their_light() -> None:
    grass = layers(np.zeros((16, 16)))
    spotted = layers(np.zeros((16, 16)))
    spotted.albedo[5, 5], spotted.direct[5, 5] = 0.8, 8 * 0.02
    spotted.albedo[9, 9], spotted.direct[9, 9] = 0.05, 0.5 * 0.02
    # A blade of a pixel's width and a spot of two by two go on.
    spotted.albedo[12, 2:12] = spotted.albedo[2:4, 10:12] = 0.8
    after = without_specks(spotted)
    for at in ((5, 5), (9, 9)):
        np.testing.assert_allclose(after.albedo[at], grass.albedo[at], rtol=1e-6)
        np.testing.assert_allclose(after.direct[at], grass.direct[at], rtol=1e-5)
    changed = np.any(after.albedo != spotted.albedo, axis=-1)
    assert set(zip(*np.nonzero(changed), strict=True)) <= {(5, 5), (9, 9), (12, 2), (12, 11)}


def test_colours_beside_the_sky_stay() -> None:
    sky = np.zeros((16, 16))
    sky[6, 5] = 1.0
    before = layers(sky)
    before.air[:] = 0.1
    before.albedo[5, 5] = 0.8
    np.testing.assert_array_equal(without_specks(before).albedo, before.albedo)
