"""Textures: seamless tiles, and mipmaps that match them."""

from __future__ import annotations

import numpy as np
import pytest

from render.backend import Backend
from render.config import MATERIALS
from render.textures import TILE, creases, patches, patterns, tile

PATTERNS = sorted(patterns())


def test_every_texture_has_a_pattern() -> None:
    from typing import get_args

    from render.config.material import Texture

    assert {*PATTERNS, "none"} == set(get_args(Texture))
    assert {config.texture for config in MATERIALS.values()} <= {*PATTERNS, "none"}


@pytest.mark.sample(5)
@pytest.mark.slow
@pytest.mark.parametrize("name", PATTERNS)
def test_a_tile_has_no_seam(name: str) -> None:
    drawn = tile(name)
    for plane in (drawn.shade, drawn.warmth, drawn.relief):
        assert plane.shape == (TILE, TILE)
        assert np.isfinite(plane).all()
        for axis in (0, 1):
            steps = np.abs(np.diff(plane, axis=axis)).mean(axis=1 - axis)
            first, last = (np.take(plane, i, axis=axis) for i in (0, -1))
            # A seam would be a step that is nowhere else between two rows.
            assert np.abs(first - last).mean() <= 1.1 * steps.max() + 1e-6


@pytest.mark.sample(5)
@pytest.mark.slow
@pytest.mark.parametrize("name", PATTERNS)
def test_a_tile_keeps_the_base_colour_on_average(name: str) -> None:
    drawn = tile(name)
    assert drawn.shade.mean() == pytest.approx(1.0, abs=1e-3)
    assert drawn.shade.min() > 0
    assert np.abs(drawn.warmth).max() <= 1.0


def test_patches_are_halves() -> None:
    assert patches().mean() == pytest.approx(0.5, abs=0.03)


def test_creases_of_cloth_have_no_seam_and_lie_aslant() -> None:
    relief = creases()
    across, along = (
        (np.roll(relief, -1, axis) - np.roll(relief, 1, axis)) * (0.5 * len(relief))
        for axis in (0, 1)
    )
    assert along.std() == pytest.approx(1.0, abs=1e-3)
    # Neither along the rows nor across them, and not alike on both sides.
    assert 0.5 < across.std() < 2.0
    assert 0.05 < abs((across * along).mean()) / across.std() < 0.8
    for axis in (0, 1):
        steps = np.abs(np.diff(relief, axis=axis)).mean(axis=1 - axis)
        first, last = (np.take(relief, i, axis=axis) for i in (0, -1))
        assert np.abs(first - last).mean() <= 1.1 * steps.max()


def test_a_kernel_reads_the_drawn_pattern(backend: Backend) -> None:
    """Kernels equal the pattern at texel centres and are linear between, also at the border."""
    if backend.variant.startswith("scalar"):
        pytest.skip("the scalar variant reads no packed tiles")
    backend.activate()
    import mitsuba as mi

    from render.surfaces.texture_mapping import lookup, pattern_mipmap

    drawn, mipmap = tile("soil"), pattern_mipmap("soil")
    rng = np.random.default_rng(1)
    j, i = rng.integers(0, TILE, (2, 400))
    i[:4] = TILE - 1
    at = (i + 1.0) / TILE, (j + 0.5) / TILE
    found = lookup(mi.UInt32(mipmap.texels), mipmap, mi.Float(at[0]), mi.Float(at[1]), None)
    right = (i + 1) % TILE
    shade = 0.5 * (drawn.shade[j, i] + drawn.shade[j, right])
    np.testing.assert_allclose(np.array(found.shade), shade.clip(0, 2), atol=1.5 / 255)
    slope = (np.roll(drawn.relief, -1, 1) - np.roll(drawn.relief, 1, 1)) * (TILE / drawn.size / 2)
    expected = 0.5 * (slope[j, i] + slope[j, right])
    np.testing.assert_allclose(np.array(found.slope_u), expected, atol=1.5 * mipmap.max_slope / 255)


def test_mip_levels_have_the_same_mean(backend: Backend) -> None:
    if backend.variant.startswith("scalar"):
        pytest.skip("the scalar variant reads no packed tiles")
    backend.activate()
    import mitsuba as mi

    from render.surfaces.texture_mapping import LEVELS, lookup, pattern_mipmap

    mipmap = pattern_mipmap("rock")
    u, v = (mi.Float(a) for a in np.random.default_rng(2).random((2, 200_000)))
    means = []
    for level in range(LEVELS):
        found = lookup(mi.UInt32(mipmap.texels), mipmap, u, v, mi.UInt32(level))
        means.append(float(np.array(found.shade).mean()))
    assert means == pytest.approx([means[0]] * LEVELS, abs=0.01)


def test_a_mipmap_of_shares_keeps_their_mean(backend: Backend) -> None:
    if backend.variant.startswith("scalar"):
        pytest.skip("a kernel needs a variant with arrays")
    from render.surfaces.texture_mapping import share_mipmap

    shares = np.zeros((TILE, TILE), np.uint8)
    shares[: TILE // 4] = 255
    last = share_mipmap(shares).texels[-4:] & 255
    assert last.mean() * 2.0 / 255.0 == pytest.approx(0.25, abs=0.01)
