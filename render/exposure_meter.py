"""Exposure meter: exposure and contrast with which pictures of a cut span the range of a screen.

The light of a scene is set up for a grey card, as a photographer meters it with a card in hand.
What the picture shows is lighter or darker than the card, and seldom spans what film can show. So
the middle of the picture is moved into a band, and the contrast brings its brightest parts near
white. Within the band a bright place stays brighter than a dark one. A place in even light, whose
brightest parts more contrast would bring no further, is shown brighter instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from render.color import luminance
from render.config import Light, Look
from render.development import LOWEST_WHITE, Development, Image, Tone, developed
from render.lights.environment_map import smoothstep
from render.lights.sun_position import sun_elevation_deg

MIDDLE = (0.38, 0.47)
"""Lowest and highest median of the luma."""

BRIGHTEST_MIDDLE = 0.52
"""Highest median of the luma of a place in even light."""

BRIGHT = 0.92
"""99th percentile of the luma."""

CONTRAST = (0.9, 2.1)
"""Least and greatest contrast."""

MAX_STOPS = 1.75
"""Greatest change of the exposure by the grey card, either way."""

_STEPS = 7
"""Halvings of the interval of contrast, and of that of the exposure."""

_ROUNDED = 64
"""Steps of a stop, and of contrast: processors that round differently meter alike."""

_NIGHT_DEG, _DAY_DEG = -6.0, 2.0
"""Elevations of the sun up to which nothing is metered, and from which all is."""


def daylight(light: Light) -> float:
    """Return how far pictures by a light are metered, 0 (night, which stays dark) to 1."""
    if light.sun is None:
        return 1.0
    elevation = sun_elevation_deg(light.sun)
    return float(smoothstep(np.array((elevation - _NIGHT_DEG) / (_DAY_DEG - _NIGHT_DEG))))


def metered_tone(pictures: Sequence[Image], look: Look, share: float = 1.0) -> Tone:
    """Return exposure and contrast for pictures of one cut.

    Args:
        pictures: scene light, (H, W, 3) each and of one size; at least one.
        look: with which they are developed.
        share: of the correction, 0 to 1.
    """
    low, high = CONTRAST
    for _ in range(_STEPS):
        contrast = (low + high) / 2
        stops = _stops_for_middle(pictures, look, contrast)
        bright = _percentile(pictures, Tone(stops, contrast), look, 99.0)
        low, high = (contrast, high) if bright < BRIGHT else (low, contrast)
    contrast = (low + high) / 2
    stops = _stops_for_middle(pictures, look, contrast)
    tone = Tone(stops, contrast)
    bright = _percentile(pictures, tone, look, 99.0)
    if bright < BRIGHT - 0.02:
        tone = _brightened(pictures, look, replace(tone, white=max(bright / BRIGHT, LOWEST_WHITE)))
    return Tone(
        _rounded(share * tone.stops),
        1.0 + _rounded(share * (tone.contrast - 1.0)),
        1.0 - _rounded(share * (1.0 - tone.white)),
    )


def _stops_for_middle(pictures: Sequence[Image], look: Look, contrast: float) -> float:
    """Return the exposure that brings the median into its band, at a contrast.

    As far as the median is inside without a change, nothing changes.
    """
    median = _percentile(pictures, Tone(0.0, contrast), look, 50.0)
    wanted = min(max(median, MIDDLE[0]), MIDDLE[1])
    if wanted == median:
        return 0.0
    low, high = (0.0, MAX_STOPS) if wanted > median else (-MAX_STOPS, 0.0)
    for _ in range(_STEPS):
        stops = (low + high) / 2
        is_dark = _percentile(pictures, Tone(stops, contrast), look, 50.0) < wanted
        low, high = (stops, high) if is_dark else (low, stops)
    return (low + high) / 2


def _brightened(pictures: Sequence[Image], look: Look, tone: Tone) -> Tone:
    """Return the exposure that brings the brightest parts or the median as far as they may go."""
    low, high = tone.stops - 1.0, MAX_STOPS
    for _ in range(_STEPS):
        stops = (low + high) / 2
        middle, bright = (
            _percentile(pictures, replace(tone, stops=stops), look, part) for part in (50.0, 99.0)
        )
        is_dark = middle < BRIGHTEST_MIDDLE and bright < BRIGHT
        low, high = (stops, high) if is_dark else (low, stops)
    return replace(tone, stops=low)


def _percentile(pictures: Sequence[Image], tone: Tone, look: Look, part: float) -> float:
    how = Development(tone, look)
    luma = [luminance(developed(picture, how).astype(np.float32)) for picture in pictures]
    return float(np.percentile(np.stack(luma), part)) / 255.0


def _rounded(value: float) -> float:
    return round(value * _ROUNDED) / _ROUNDED
