"""Instruments: pitch, attack, decay and level of the families of General MIDI."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from audio.general_midi import DRUMS as DRUM_NAMES
from audio.general_midi import INSTRUMENTS, LOWEST_DRUM_KEY, drum_key, program_number
from audio.instruments.instrument_sound import instrument_note, instrument_sound
from audio.instruments.plucked_string import StringVoice, plucked_string
from audio.parts import DRUMS
from audio.time_grid import SAMPLE_RATE

NOISES = program_number("reverse cymbal"), *range(120, 123), *range(125, 128)
PITCHED = [program for program in range(128) if program not in NOISES]


def sound_of(name: str, pitch: int = 60, velocity: int = 90, seconds: float = 1.0) -> Any:
    """Return the samples of a note."""
    return instrument_sound(instrument_note(program_number(name), pitch, velocity, seconds))


def cents_off(signal: Any, pitch: int) -> float:
    """Return how far the partial nearest to a pitch is from it [cents]."""
    wanted = 440 * 2 ** ((pitch - 69) / 12)
    part = signal[2400:50_400] * np.hanning(len(signal[2400:50_400]))
    level = np.abs(np.fft.rfft(part, 1 << 19))
    f = np.fft.rfftfreq(1 << 19, 1 / SAMPLE_RATE)
    near = (f > wanted / 1.06) & (f < wanted * 1.06)
    k = int(np.flatnonzero(near)[level[near].argmax()])
    # Between the bins by a parabola through the logarithms.
    a, b, c = np.log(level[k - 1 : k + 2])
    found = f[k] + (f[1] - f[0]) * 0.5 * (a - c) / (a - 2 * b + c)
    assert level[k] > 0.02 * level.max(), "the note has no partial of its pitch"
    return float(1200 * np.log2(found / wanted))


def level_at(signal: Any, seconds: float) -> float:
    """Return the level of 50 ms after a time [dB]."""
    first = int(seconds * SAMPLE_RATE)
    return float(20 * np.log10(np.sqrt(np.mean(signal[first : first + 2400] ** 2)) + 1e-9))


@pytest.mark.nightly
@pytest.mark.parametrize("pitch", [40, 60, 76])
@pytest.mark.parametrize("program", PITCHED)
def test_every_instrument_is_in_tune(program: int, pitch: int) -> None:
    signal = instrument_sound(instrument_note(program, pitch, 90, 1.2))
    assert abs(cents_off(signal, pitch)) < 5, INSTRUMENTS[program]


BY_FAMILY = range(0, 112, 8)


@pytest.mark.parametrize("program", BY_FAMILY)
def test_each_family_is_in_tune(program: int) -> None:
    for pitch in (48, 67):
        signal = instrument_sound(instrument_note(program, pitch, 90, 1.2))
        assert abs(cents_off(signal, pitch)) < 5, INSTRUMENTS[program]


def test_all_sounds_are_finite_audible_and_begin_at_once() -> None:
    notes = [instrument_note(program, 60, 100, 0.4) for program in range(128)]
    notes += [instrument_note(DRUMS, LOWEST_DRUM_KEY + k, 100, 0.1) for k in range(len(DRUM_NAMES))]
    for note in notes:
        signal = instrument_sound(note)
        assert np.isfinite(signal).all()
        assert np.abs(signal).max() <= 1
        assert signal[0] != 0
        assert abs(signal[-1]) < 1e-3
        # Alike in loudness: the loudest 50 ms are within a few decibels of each other.
        stretches = range(min(max(signal.size // 2400, 1), 8))
        assert max(level_at(signal, k / 20) for k in stretches) > -24, note


@pytest.mark.parametrize("name", ["nylon guitar", "acoustic bass", "acoustic grand piano", "koto"])
def test_plucked_and_struck_strings_decay(name: str) -> None:
    signal = sound_of(name, seconds=2.0)
    levels = [level_at(signal, t) for t in (0.05, 0.5, 1.0, 1.5)]
    assert all(later < earlier - 2 for earlier, later in pairwise(levels))


SUSTAINED = ("violin", "string ensemble 1", "flute", "trumpet", "warm pad", "church organ")


@pytest.mark.parametrize("name", SUSTAINED)
def test_bowed_and_blown_tones_sustain_and_end(name: str) -> None:
    signal = sound_of(name, seconds=2.0)
    assert abs(level_at(signal, 0.8) - level_at(signal, 1.8)) < 2
    after = signal[int(2.0 * SAMPLE_RATE) :]
    assert np.abs(after[-240:]).max() < 0.02 * np.abs(signal).max()


def test_the_decay_of_a_string_is_that_of_its_voice() -> None:
    voice = StringVoice(2.0, 1.9)
    rng = np.random.default_rng(1)
    signal = plucked_string(voice, 261.63, 2 * SAMPLE_RATE, 0.7, rng)
    # 60 dB in two seconds, of the fundamental.
    t = np.arange(signal.size) / SAMPLE_RATE
    tone = signal * np.exp(-2j * np.pi * 261.63 * t)
    early, late = (abs(tone[a : a + 4800].mean()) for a in (4800, 4800 + SAMPLE_RATE))
    assert 20 * np.log10(early / late) == pytest.approx(30, abs=3)


def centroid(signal: Any) -> float:
    """Return the mean frequency of the spectrum of the first tenth of a second [Hz]."""
    part = signal[: SAMPLE_RATE // 10]
    level = np.abs(np.fft.rfft(part)) ** 2
    f = np.fft.rfftfreq(part.size, 1 / SAMPLE_RATE)
    return float((f * level).sum() / level.sum())


@pytest.mark.parametrize("name", ["acoustic grand piano", "trumpet", "violin", "marimba"])
def test_louder_notes_are_brighter(name: str) -> None:
    assert centroid(sound_of(name, velocity=120)) > 1.03 * centroid(sound_of(name, velocity=30))


def test_drums_are_low_and_high_and_short_and_long() -> None:
    def drum(name: str) -> Any:
        return instrument_sound(instrument_note(DRUMS, drum_key(name), 100, 0.1))

    order = ["bass drum", "low tom", "low conga", "hi bongo", "claves", "closed hi-hat"]
    heights = [centroid(drum(name)) for name in order]
    assert heights == sorted(heights)
    assert drum("open hi-hat").size > 4 * drum("closed hi-hat").size
    assert drum("crash cymbal 1").size > SAMPLE_RATE


def test_a_sound_is_the_same_again() -> None:
    note = instrument_note(program_number("violin"), 64, 80, 0.5)
    assert np.array_equal(instrument_sound(note), instrument_sound(note))
