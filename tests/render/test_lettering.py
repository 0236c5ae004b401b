"""Lettering: words lie over the developed picture where they belong, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from render.development import Development, Tone, developed, developed16
from render.lettering import FOLDER, FONTS, Lettering, lettered, text_extent
from render.picture_levels import PictureLevels

WORDS = Lettering("Dawn\nover it", (0.5, 0.5), "center", 0.1, "serif", (1.0, 1.0, 1.0), 1.0, 0.6)
GREY = np.full((180, 320, 3), 90, np.uint8)


def test_letters_stand_in_the_middle_and_change_nothing_else() -> None:
    picture = lettered(GREY, [WORDS])
    rows, columns = np.nonzero((picture != GREY).any(axis=-1))
    assert abs(rows.mean() / 180 - 0.5) < 0.03
    assert abs(columns.mean() / 320 - 0.5) < 0.03
    wide, high = text_extent(WORDS.text, "serif", 0.1, (320, 180))
    assert np.ptp(columns) < 320 * wide + 12
    assert np.ptp(rows) < 180 * high + 12
    assert picture.max() == 255
    assert picture.min() < 80
    assert (GREY == 90).all()


def test_lines_are_aligned_to_their_place() -> None:
    for align, x in (("left", 0.1), ("right", 0.9)):
        words = replace(WORDS, text="Mabel\nit is", place=(x, 0.8), align=align, shadow=0.0)
        changed = (lettered(GREY, [words]) != GREY).any(axis=-1)
        for rows in (slice(0, 144), slice(144, 180)):
            columns = np.flatnonzero(changed[rows].any(axis=0)) / 320
            end = columns.min() if align == "left" else columns.max()
            assert end == pytest.approx(x, abs=0.012)


def test_levels_are_those_of_the_picture_below() -> None:
    black, how = np.zeros((90, 160, 3), np.float32), Development(words=(WORDS,))
    assert PictureLevels.of(black, how) == PictureLevels.of(black, Development())


def test_words_fade_and_vanish() -> None:
    strength = [
        int(np.abs(lettered(GREY, [replace(WORDS, opacity=k)]).astype(int) - 90).sum())
        for k in (0.0, 0.3, 0.6, 1.0)
    ]
    assert strength[0] == 0
    assert strength == sorted(strength)
    assert len(set(strength)) == 4


def test_both_depths_show_the_same_words() -> None:
    light = np.full((90, 160, 3), 0.18, np.float32)
    how = Development(Tone(0.5), words=(WORDS,))
    shallow, deep = developed(light, how), developed16(light, how)
    np.testing.assert_allclose(shallow / 255.0, deep / 65535.0, atol=0.004)
    assert (shallow != developed(light, replace(how, words=()))).any()


def test_a_development_with_words_is_read_again_and_one_without_is_as_before() -> None:
    how = Development(Tone(0.5, 1.1, 0.9), words=(WORDS, replace(WORDS, text="ü 'q' \"x\"")))
    assert Development.read(str(how)) == how
    plain = replace(how, words=())
    assert Development.read(str(plain)) == plain
    assert str(how).startswith(str(plain)[:-1])
    with pytest.raises(ValueError, match="lettering"):
        Development.read(str(how).replace("0.6]", "0.6, 1]"))


def test_fonts_are_packaged_with_their_licence() -> None:
    assert {path.name for path in FOLDER.iterdir()} == {*FONTS.values(), "LICENSE"}
