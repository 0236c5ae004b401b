"""Development: looks, glare and vignette; and the meter."""

from __future__ import annotations

import numpy as np
import pytest

from render.color import luminance
from render.config import Film, Look, light
from render.development import Development, Tone, developed
from render.exposure_meter import BRIGHT, MAX_STOPS, MIDDLE, daylight, metered_tone

PLAIN = Look.model_validate("plain")


def shown(image: np.ndarray, look: object = "plain", tone: Tone | None = None) -> np.ndarray:
    how = Development(tone or Tone(), Look.model_validate(look))
    return developed(np.asarray(image, np.float32), how).astype(int)


def test_contrast_turns_about_middle_grey() -> None:
    greys = np.full((3, 8, 3), [[[0.06]], [[0.18]], [[0.5]]], np.float32)
    soft, hard = shown(greys), shown(greys, tone=Tone(0.0, 1.5))
    assert abs(hard[1] - soft[1]).max() <= 1
    # Shadows are darkened by a share of the contrast only, so that none is black.
    assert (hard[0] < soft[0] - 5).all()
    assert (hard[0] > soft[0] - 0.75 * (hard[2] - soft[2])).all()
    assert (hard[2] > soft[2] + 15).all()


def test_a_look_without_saturation_is_grey_and_black_and_white_points_bound_it() -> None:
    colors = np.random.default_rng(1).gamma(0.5, 0.5, (16, 16, 3))
    assert np.ptp(shown(colors, {"preset": "plain", "saturation": 0}), axis=2).max() <= 1
    flat = shown(colors * 1000, {"preset": "plain", "black": 0.1, "white": 0.7})
    assert flat.max() <= round(0.7 * 255) + 3
    assert shown(0 * colors, {"preset": "plain", "black": 0.1}).min() >= 25


def test_a_vignette_darkens_corners_alone() -> None:
    grey = np.full((90, 160, 3), 0.2)
    plain = shown(grey)
    dim = shown(grey, {"preset": "plain", "vignette": 0.4})
    assert abs(dim[45, 80] - plain[45, 80]).max() <= 1
    assert dim[0, 0].max() < 0.75 * plain[0, 0].min()
    np.testing.assert_array_equal(dim, dim[::-1, ::-1])


def test_shade_is_opened_as_contrast_was_added() -> None:
    """A wall in the sun beside one in the shade, both with a fine pattern."""
    pattern = np.where(np.arange(320) % 2, 1.15, 0.85)[None, :, None]
    scene = np.where(np.arange(320)[None, :, None] < 160, 0.4, 0.02) * pattern
    scene = np.broadcast_to(scene, (180, 320, 3))
    tone, open_shade = Tone(0.0, 1.8), {"preset": "plain", "shadows": 0.6}
    before, after = shown(scene, tone=tone)[90, :, 1], shown(scene, open_shade, tone)[90, :, 1]
    np.testing.assert_array_equal(after[:140], before[:140])
    assert after[180:].mean() > 1.3 * before[180:].mean()
    # Detail in the shade is as distinct as before, and the edge is as sharp but for a few pixels.
    assert np.ptp(after[200:240]) >= np.ptp(before[200:240])
    assert abs(np.diff(after[168:, None].reshape(-1, 2).mean(axis=1))).max() < 4
    for contrast in (1.0, 0.9):
        even = Tone(0.0, contrast)
        np.testing.assert_array_equal(shown(scene, open_shade, even), shown(scene, tone=even))


def test_only_what_is_very_bright_glares_and_in_its_colour() -> None:
    """Sizes that four does not divide, and rows that are developed in several bands."""
    scene = np.full((303, 157, 3), 0.05)
    bloom = {"preset": "plain", "bloom": 1.0}
    np.testing.assert_array_equal(shown(scene + 0.9, bloom), shown(scene + 0.9))
    scene[140:160, 60:80] = (30.0, 3.0, 0.1)
    added = shown(scene, bloom) - shown(scene)
    assert added[165, 70, 0] > 20
    assert added[165, 70, 0] > 2 * added[165, 70, 2]
    assert added[..., 0].min() >= 0
    # It falls off evenly: no step from band to band or block to block.
    fall = np.diff(added[162:220, 70, 0])
    assert fall.min() > -14
    assert fall.max() <= 1
    assert added[300, 150].max() < 4


def test_the_meter_brings_pictures_into_range() -> None:
    rng = np.random.default_rng(2)
    for level, spread in ((0.02, 1.0), (0.1, 0.6), (0.18, 1.2), (0.5, 0.9)):
        picture = (level * np.exp(spread * rng.normal(size=(60, 80, 1)))).astype(np.float32)
        pictures = [picture.repeat(3, axis=2)]
        tone = metered_tone(pictures, PLAIN)
        luma = luminance(developed(pictures[0], Development(tone)).astype(float)) / 255
        if abs(tone.stops) < MAX_STOPS - 0.1:
            assert MIDDLE[0] - 0.02 < np.median(luma) < 0.55
        assert np.percentile(luma, 99) < BRIGHT + 0.04
    assert metered_tone(pictures, PLAIN, 0.0) == Tone()


def test_by_night_nothing_is_metered() -> None:
    assert daylight(light("day")) == daylight(light("studio")) == 1.0
    assert daylight(light("night")) == 0.0


def test_a_development_survives_its_text() -> None:
    how = Development(Tone(0.25, 1.125), Look.model_validate({"preset": "warm", "vignette": 0.3}))
    again = Development.read(str(how))
    assert again.tone == how.tone
    assert again.look.model_dump(exclude={"preset"}) == how.look.model_dump(exclude={"preset"})


def test_looks_are_refused_with_the_nearest_name() -> None:
    with pytest.raises(ValueError, match="no look is called 'wram', did you mean 'warm'"):
        Film.model_validate({"look": "wram"})
    with pytest.raises(ValueError, match="white"):
        Film.model_validate({"look": {"black": 0.4, "white": 0.4}})
    adjusted = Film.model_validate({"look": {"vignette": 0.5}}).look
    assert adjusted.bloom == Film().look.bloom
    assert adjusted.vignette == 0.5
