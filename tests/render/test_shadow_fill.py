"""Shadow fill: shade is opened before a bright sky, and a night stays dark."""

from __future__ import annotations

import numpy as np

from render.shadow_fill import fill_stops


def _backlit(sky: float) -> np.ndarray:
    picture = np.full((90, 160, 3), sky, np.float32)
    picture[40:, 60:100] = 0.012
    return picture


def test_what_stands_before_a_bright_sky_is_filled_without_added_contrast() -> None:
    found = fill_stops(_backlit(1.4), 0.0, 1.0, 0.6)[..., 0]
    assert found[60:, 70:90].min() > 0.4
    assert found[:20].max() < 0.01


def test_a_night_is_not_filled() -> None:
    assert fill_stops(_backlit(0.05), 0.0, 1.0, 0.6).max() == 0.0
