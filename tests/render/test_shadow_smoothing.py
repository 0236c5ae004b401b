"""Shadow smoothing: noise of shadows goes, and all that is no shadow stays as it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from render.config import Film
from render.frame import LightLayers
from render.renderer import Renderer
from render.shadow_smoothing import BAND_ROWS, smooth_shadows
from render.shot import Shot

HEIGHT, WIDTH = 2 * BAND_ROWS + 10, 60


def _relief() -> np.ndarray:
    """Return light without shadows: coloured, rough, and black in some pixels."""
    rng = np.random.default_rng(5)
    light = rng.uniform(0.1, 2.0, (HEIGHT, WIDTH, 3)).astype(np.float32)
    light[rng.random((HEIGHT, WIDTH)) < 0.1] = 0.0
    return light


def test_light_without_shadows_stays_as_it_is() -> None:
    light = _relief()
    np.testing.assert_allclose(smooth_shadows(light, light), light, rtol=1e-6)
    np.testing.assert_array_equal(smooth_shadows(np.zeros_like(light), light), 0.0)


def test_the_noise_of_a_soft_shadow_goes_and_its_mean_and_the_relief_stay() -> None:
    """Two samples of a pixel in the half shade on rough ground."""
    rng = np.random.default_rng(6)
    open_light = _relief()
    seen = np.linspace(0.1, 0.9, WIDTH, dtype=np.float32)[:, None]
    share = rng.binomial(2, np.broadcast_to(seen, (HEIGHT, WIDTH, 1))).astype(np.float32) / 2
    truth = open_light * seen
    smooth = smooth_shadows(open_light * share, open_light)
    noise = np.abs(open_light * share - truth).mean()
    assert np.abs(smooth - truth).mean() < 0.5 * noise
    thirds = [light.mean(axis=(0, 2)).reshape(3, -1).mean(axis=1) for light in (smooth, truth)]
    np.testing.assert_allclose(*thirds, rtol=0.03)
    red, green = smooth[..., 0] * open_light[..., 1], smooth[..., 1] * open_light[..., 0]
    np.testing.assert_allclose(red, green, rtol=1e-4)


def test_bands_leave_no_seams() -> None:
    """An image turned upside down, whose bands lie elsewhere, is the same."""
    rng = np.random.default_rng(7)
    open_light = _relief()
    direct = open_light * rng.integers(0, 3, (HEIGHT, WIDTH, 1)).astype(np.float32) / 2
    once = smooth_shadows(direct, open_light)
    turned = smooth_shadows(np.flipud(direct).copy(), np.flipud(open_light).copy())
    np.testing.assert_allclose(once, np.flipud(turned), rtol=1e-5, atol=1e-6)


@pytest.mark.slow
def test_light_without_shadows_is_traced_of_one_lamp_alone(
    renderer: Renderer, make_shot: Callable[..., Shot]
) -> None:
    from render.mitsuba_scene import MitsubaScene

    film = Film(size=(64, 48), preset="preview", depth=2)
    layers: LightLayers = MitsubaScene(make_shot(film=film)).trace(0, range(2), 2)
    assert layers.open_light is not None
    # The body throws a shadow, and nothing else differs.
    assert (layers.direct <= layers.open_light).all()
    is_equal = (layers.direct == layers.open_light).all(axis=-1)
    assert 0.5 < is_equal.mean() < 1.0
    studio = MitsubaScene(make_shot(film=film, lit="studio")).trace(0, range(2), 2)
    assert studio.open_light is None
    full = film.model_copy(update={"soft_light": "full"})
    assert MitsubaScene(make_shot(film=full)).trace(0, range(1), 1).open_light is None
