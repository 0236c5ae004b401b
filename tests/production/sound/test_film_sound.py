"""Sounds in the finished film: each of twenty on the frame that shows its cause.

Picture and sound are decoded again from the film; a matched filter finds each sound.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from numpy.typing import NDArray

from audio.config.sound import Sound
from audio.score import Score, ScoreEvent
from audio.time_grid import SAMPLE_RATE, sample_of_frame
from audio.wav_file import write_wav
from render.film_encoder import write_film

EVENTS = 20
APART = 0.5
"""Of the events [s]."""

WINDOW = int(0.04 * SAMPLE_RATE)
REACH = int(0.02 * SAMPLE_RATE)

MATERIALS = ("oak", "stone", "steel", "glass", "rubber", "bone", "soil", "grass", "sand", "skin")


def score_at(rate: Fraction) -> Score:
    """Return twenty impacts of various materials, about half a second apart."""
    frames = [1 + round(float(rate) * APART * (k + 1)) + k % 2 for k in range(EVENTS)]
    events = tuple(
        ScoreEvent(
            frame=frame,
            time=(frame - 1) / rate,
            cause=("footfall", "collision")[k % 2],
            who="bug",
            material=MATERIALS[k % len(MATERIALS)],
            surface=MATERIALS[(3 * k + 1) % len(MATERIALS)],
            strength=0.5 + 0.1 * k,
            distance=3.0,
            azimuth=0.06 * (k - 10),
        )
        for k, frame in enumerate(frames)
    )
    return Score(rate, round(float(rate) * APART * (EVENTS + 2)), events, Sound())


def decoded(film: Path) -> tuple[list[Fraction], NDArray[np.float64]]:
    """Return the times of white frames [s], and the sound from time 0 on: (N,)."""
    flashes, blocks = [], []
    with av.open(str(film)) as container:
        for frame in container.decode(video=0):
            if frame.to_ndarray(format="gray").mean() > 128:
                flashes.append(Fraction(frame.pts) * frame.time_base)
    with av.open(str(film)) as container:
        for block in container.decode(audio=0):
            first = round(Fraction(block.pts) * block.time_base * SAMPLE_RATE)
            blocks.append((first, block.to_ndarray().mean(axis=0)))
    heard = np.zeros(blocks[-1][0] + blocks[-1][1].size)
    for first, block in blocks:
        # Players skip what precedes time 0.
        cut = max(-first, 0)
        heard[first + cut : first + block.size] = block[cut:]
    return flashes, heard


def lag(heard: NDArray[np.float64], sound: NDArray[np.float64], onset: int) -> int:
    """Return the lag of a sound [samples] by correlation."""
    pattern = sound[onset : onset + WINDOW]
    around = heard[onset - REACH : onset + WINDOW + REACH]
    return int(np.argmax(np.correlate(around, pattern, "valid"))) - REACH


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("rate", [Fraction(24), Fraction(30000, 1001), Fraction(60)], ids=str)
def test_sounds_in_the_film_are_within_a_millisecond_of_their_frames(
    tmp_path: Path, rate: Fraction
) -> None:
    score = score_at(rate)
    write_wav(score, tmp_path / "s.wav")
    frames = {event.frame for event in score.events}
    assert len(frames) == EVENTS
    pictures = (
        np.full((36, 64, 3), 255 if f in frames else 0, np.uint8)
        for f in range(1, score.frames + 1)
    )
    write_film(tmp_path / "f.mp4", pictures, rate, tmp_path / "s.wav")
    flashes, heard = decoded(tmp_path / "f.mp4")
    assert flashes == [(event.frame - 1) / rate for event in score.events]
    with av.open(str(tmp_path / "s.wav")) as container:
        whole = [block.to_ndarray().reshape(-1, 2) for block in container.decode(audio=0)]
    sound = np.concatenate(whole).astype(float).mean(axis=1)
    for event, flash in zip(score.events, flashes, strict=True):
        onset = sample_of_frame(event.frame, rate)
        late = onset + lag(heard, sound, onset) - float(flash) * SAMPLE_RATE
        assert abs(late) / SAMPLE_RATE < 1e-3


def test_the_lag_filter_detects_a_late_sound(tmp_path: Path) -> None:
    score = score_at(Fraction(24))
    write_wav(score, tmp_path / "s.wav")
    with av.open(str(tmp_path / "s.wav")) as container:
        whole = [block.to_ndarray().reshape(-1, 2) for block in container.decode(audio=0)]
    sound = np.concatenate(whole).astype(float).mean(axis=1)
    onset = sample_of_frame(score.events[3].frame, score.rate)
    assert lag(np.roll(sound, 96), sound, onset) == 96
