"""Time grids are exact, or refused."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.errors import AudioError, GridError
from audio.time_grid import SAMPLE_RATE, sample_of_frame, tick_grid

USUAL = [Fraction(r) for r in (10, 12, 15, 16, 24, 25, 30, 48, 50, 60, 100, 120, 240)]
NTSC = [Fraction(r * 1000, 1001) for r in (24, 30, 60)]


@pytest.mark.parametrize("rate", USUAL + NTSC, ids=str)
def test_usual_rates_have_24_frames_a_beat_and_40_ticks_a_frame(rate):
    grid = tick_grid(rate)
    assert (grid.ticks_per_beat, grid.ticks_per_frame) == (960, 40)
    assert grid.tempo == 24_000_000 / rate


def test_ntsc_rates_have_an_exact_tempo():
    assert tick_grid(Fraction(30000, 1001)).tempo == 800_800


@pytest.mark.parametrize("rate", [18, 72, 90, 144])
def test_multiples_of_18_have_9_frames_a_beat(rate):
    grid = tick_grid(Fraction(rate))
    assert (grid.ticks_per_beat, grid.frames_per_beat, grid.ticks_per_frame) == (954, 9, 106)


@given(
    st.one_of(
        st.fractions(Fraction(1, 30), 2000, max_denominator=2000),
        st.integers(1, 1000).map(lambda n: Fraction(n * 1000, 1001)),
    ),
    st.integers(1, 10**7),
)
def test_a_grid_is_exact_and_valid_or_refused(rate, frame):
    try:
        grid = tick_grid(rate)
    except GridError:
        # Only where a beat of whole microseconds is too long or has too many frames for a file.
        least = Fraction(1_000_000 / rate).denominator
        assert least > 32767 or least / rate > Fraction(2**24 - 1, 10**6)
        return
    assert grid.seconds(grid.tick(frame)) == (frame - 1) / rate
    assert 1 <= grid.tempo < 2**24
    assert 1 <= grid.ticks_per_beat < 2**15
    assert grid.tempo == grid.frames_per_beat * 1_000_000 / rate


@pytest.mark.parametrize("rate", [Fraction(0), Fraction(-24), Fraction(314159265, 10**7)])
def test_a_rate_without_a_grid_is_refused_by_name(rate):
    with pytest.raises(AudioError, match=str(rate)):
        tick_grid(rate)


@given(st.integers(1, 10**7), st.sampled_from(USUAL + NTSC + [Fraction(7), Fraction(18)]))
def test_a_frame_starts_at_the_nearest_sample(frame, rate):
    off = sample_of_frame(frame, rate) - (frame - 1) * SAMPLE_RATE / rate
    assert -Fraction(1, 2) < off <= Fraction(1, 2)


def test_half_a_sample_rounds_up():
    assert sample_of_frame(2, Fraction(96_000)) == 1
    assert sample_of_frame(4, Fraction(96_000)) == 2
