"""Flames are tall over the middle of their foot, low at its rim, and narrow at their root."""

from __future__ import annotations

import numpy as np
import pytest

from render.plume import Plume

FIRE = Plume("flame", (0.0, 0.0, 0.0), 0.3, 1.0, 1.2, (0.0, 0.0), (1.0, 0.4, 0.1), 8.0, 3)


def burning(out: float, up: float) -> float:
    """Return the share of places around the middle [m], at ten times, that are seen to burn."""
    # Both load Dr.Jit, after the backend has been chosen.
    import mitsuba as mi

    from render.airborne.plumes import PlumeLight, PlumeVolume

    dark = PlumeLight(np.array([0.0, 1.0, 0.0]), np.zeros(3), np.zeros(3))
    angle = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    place = mi.Point3f(out * np.cos(angle), np.full(60, up), out * np.sin(angle))
    shares = []
    for time in np.arange(10) / 3.0:
        density, _, _ = PlumeVolume(FIRE, dark, (), float(time))._density(place, 3)
        shares.append(np.mean(np.array(density) > 0.06))
    return float(np.mean(shares))


@pytest.mark.parametrize(
    ("out", "up", "low", "high"),
    [
        (0.05, 0.2, 0.6, 1.0),
        (0.05, 0.995, 0.0, 0.02),
        (0.33, 0.2, 0.2, 1.0),
        (0.33, 0.02, 0.0, 0.0),
        (0.36, 0.4, 0.0, 0.1),
        (0.45, 0.2, 0.0, 0.0),
    ],
)
def test_flames_are_tall_in_the_middle_and_low_at_the_rim(
    out: float, up: float, low: float, high: float
) -> None:
    assert low <= burning(out, up) <= high
