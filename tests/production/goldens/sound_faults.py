"""Faults of the sound: as it is written, of its events and words, and of the film's track."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.production.goldens.golden_bases import FRAME, RATE, Sound
from tests.production.goldens.golden_faults import event, sound, track, word


def shifted(samples: int) -> Callable[[Sound], Sound]:
    """Return a delay by samples, with silence before."""

    def alter(x: Sound) -> Sound:
        silence = np.zeros((abs(samples), 2))
        if samples > 0:
            return np.concatenate([silence, x[:-samples]])
        return np.concatenate([x[-samples:], silence])

    return alter


def one_side(side: int, alter: Callable[[Sound], Sound]) -> Callable[[Sound], Sound]:
    """Return an alteration of one channel."""

    def both(x: Sound) -> Sound:
        out = x.copy()
        out[:, side] = alter(x)[:, side]
        return out

    return both


def from_to(first: float, last: float, alter: Callable[[Sound], Sound]) -> Callable[[Sound], Sound]:
    """Return an alteration of a stretch of time [s]."""

    def within(x: Sound) -> Sound:
        out = x.copy()
        stretch = slice(round(first * RATE), round(last * RATE))
        out[stretch] = alter(x[stretch])
        return out

    return within


def band(low: float, high: float) -> Callable[[Sound], Sound]:
    """Return a filter that keeps a band [Hz]."""

    def alter(x: Sound) -> Sound:
        spectrum = np.fft.rfft(x, axis=0)
        f = np.fft.rfftfreq(len(x), 1 / RATE)
        spectrum[(f < low) | (f > high)] = 0.0
        return np.fft.irfft(spectrum, len(x), axis=0)

    return alter


def faster(ratio: float) -> Callable[[Sound], Sound]:
    """Return a change of speed and pitch."""

    def alter(x: Sound) -> Sound:
        at = np.arange(len(x)) * ratio
        return np.stack([np.interp(at, np.arange(len(x)), x[:, c], right=0.0) for c in (0, 1)], 1)

    return alter


def hiss(level: float) -> Callable[[Sound], Sound]:
    """Return the addition of noise [dBFS]."""
    return lambda x: (
        x + 10 ** (level / 20) * np.random.default_rng(1).normal(size=(len(x), 1)) * np.ones(2)
    )


def hum(x: Sound) -> Sound:
    """Add a hum of 50 Hz at -40 dBFS."""
    return x + 0.014 * np.sin(2 * np.pi * 50 * np.arange(len(x)) / RATE)[:, None]


def echo(x: Sound) -> Sound:
    """Add an echo 100 ms later, 20 dB softer."""
    return x + 0.1 * shifted(RATE // 10)(x)


def gain(decibels: float) -> Callable[[Sound], Sound]:
    """Return a gain [dB]."""
    return lambda x: x * 10 ** (decibels / 20)


SOUND = (
    sound("6 dB softer", gain(-6), "the sound is 6.0 dB softer throughout"),
    sound("1 dB softer", gain(-1), "the sound is 1.0 dB softer throughout"),
    sound("half a decibel louder", gain(0.5), "louder throughout"),
    sound("left channel silent", lambda x: x * [0, 1], "the left channel is silent"),
    sound("right channel 3 dB softer", lambda x: x * [1, 0.708], "right channel is 3.0 dB softer"),
    sound("channels swapped", lambda x: x[:, ::-1], "the left channel is"),
    sound("both channels the same", lambda x: np.repeat(x.mean(1, keepdims=True), 2, 1)),
    sound("right channel inverted", lambda x: x * [1, -1]),
    sound("right channel half a millisecond late", one_side(1, shifted(24)), "24 samples"),
    sound("a quarter of a frame late", shifted(FRAME // 4), "500 samples (10.4 ms) late"),
    sound("a sample late", shifted(1), "1.0 samples (0.0208 ms) late"),
    sound("a frame early", shifted(-FRAME), "2000 samples (41.7 ms) early: a frame"),
    sound(
        "one blow two milliseconds late",
        from_to(0.40, 0.455, shifted(96)),
        "the sound at 0.417 s is 96 samples (2 ms) late",
    ),
    sound("nothing above 4 kHz", band(0, 4000), "above 4000 Hz"),
    sound("nothing below 250 Hz", band(250, 24000), "below 250 Hz"),
    sound("hiss at -55 dB", hiss(-55), "above 4000 Hz"),
    sound("hum of 50 Hz", hum, "below 250 Hz"),
    sound("clipped at half its peak", lambda x: np.clip(x, -np.ptp(x) / 4, np.ptp(x) / 4)),
    sound("drop-out of 30 ms", from_to(0.3, 0.33, gain(-90)), "from 0.3 to 0.4 s"),
    sound("cut off before the end", from_to(0.4, 0.5, gain(-200)), "no longer heard at 0.415 s"),
    sound("one percent faster", faster(1.01)),
    sound("echo after 100 ms", echo),
    event("event at 0.8 of its strength", "film", 3, "softer", strength=lambda e: 0.8 * e.strength),
    event("a footfall at 1.25 of its strength", "motion", 4, strength=lambda e: 1.25 * e.strength),
    event("event of another material", "film", 3, material="steel"),
    event("event on another ground", "film", 10, surface="snow"),
    event("event half a metre off", "motion", 3, "lies 500 mm off", place=(0.55, 0.0, 0.95)),
    word("word: volume", "film", "{room: dry}", "{room: dry, volume_db: -2}", "dB softer"),
    word("word: room", "film", "{room: dry}", "{room: hall}"),
    word(
        "word: instrument",
        "motion",
        "{room: dry}",
        "{room: dry, voices: [{when: {who: ball}, instrument: marimba}]}",
        "program 12",
    ),
    word(
        "word: panned",
        "film",
        "{room: dry}",
        "{room: dry, voices: [{when: {who: bug}, pan: -0.6}]}",
        "the right channel is",
    ),
    word(
        "word: muted",
        "motion",
        "{room: dry}",
        "{room: dry, voices: [{when: {who: ball}, mute: true}]}",
        "'ball'",
    ),
    track("late by the priming of the encoder", shifted(1024), "1024 samples (21.3 ms) late"),
    track(
        "left channel silent", lambda x: x * [0, 1], "the film's track: the left channel is silent"
    ),
    track("right channel inverted", lambda x: x * [1, -1], "right channel is silent or inverted"),
    track("1 dB softer", gain(-1), "the film's track: the left channel is 1.0 dB softer"),
    track("without its last blow", from_to(0.45, 0.5, gain(-200)), "the film's track"),
)
