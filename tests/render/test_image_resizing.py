"""Resizing: what is even stays even, a ramp keeps its place, also at odd sizes."""

from __future__ import annotations

import numpy as np
import pytest

from render.denoiser import Denoiser
from render.frame import LensBlur
from render.image_resizing import double_size, half_size


@pytest.mark.parametrize("size", [(6, 8), (5, 7), (1, 4), (1, 1)])
def test_an_even_picture_stays_even(size: tuple[int, int]) -> None:
    picture = np.full((*size, 3), 0.25, np.float32)
    small = half_size(picture)
    assert small.shape == (-(-size[0] // 2), -(-size[1] // 2), 3)
    np.testing.assert_array_equal(small, 0.25)
    np.testing.assert_array_equal(double_size(small), 0.25)


def test_a_ramp_keeps_its_place() -> None:
    ramp = np.broadcast_to(np.arange(12.0, dtype=np.float32)[None, :, None], (4, 12, 3))
    again = double_size(half_size(ramp))
    np.testing.assert_allclose(again[:, 1:-1], ramp[:, 1:-1], atol=1e-5)


def test_wide_blur_loses_its_grain_and_what_is_sharp_stays() -> None:
    """Of an odd size; a fault of one pixel would shift the step between the halves."""
    rng = np.random.default_rng(3)
    size = (65, 97, 1)
    true = np.where(np.arange(97)[None, :, None] < 48, 0.2, 0.6) * np.ones((65, 97, 3))
    noisy = np.asarray(true * rng.uniform(0.6, 1.4, size), np.float32)
    all_soft, none = np.ones(size, np.float32), np.zeros(size, np.float32)
    denoiser = Denoiser()
    fine = denoiser.clean_blur(noisy, LensBlur(all_soft, (none, none)), "fast")
    coarse = denoiser.clean_blur(noisy, LensBlur(all_soft, (all_soft, all_soft)), "fast")
    kept = denoiser.clean_blur(noisy, LensBlur(none, (none, none)), "fast")
    np.testing.assert_array_equal(kept, noisy)
    away = np.abs(np.arange(97) - 47.5) > 8
    errors = [np.abs(picture - true)[:, away].mean() for picture in (coarse, noisy)]
    assert errors[0] < 0.15 * errors[1]
    assert np.abs(coarse - fine).max() > 0.005
    assert np.abs(coarse.mean(axis=(0, 2)) - true.mean(axis=(0, 2)))[away].max() < 0.03
