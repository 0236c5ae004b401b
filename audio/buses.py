"""Buses: sounds that are mixed with a gain of their own, and what gives way to what."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal

import numpy as np

from audio.cause_voices import cause_voice
from audio.config.sound import Mix
from audio.dsp import Signal, upsampled
from audio.notes import MUSIC, Note
from audio.time_grid import SAMPLE_RATE

Bus = Literal["steps", "impacts", "voices", "motions", "music"]

BUS_OF: Mapping[str, Bus] = {
    **dict.fromkeys(("footfall", "scuff"), "steps"),
    **dict.fromkeys(("cry", "laugh", "gasp", "hug", "breath", "call", "growl", "whine"), "voices"),
    **dict.fromkeys(("swoosh", "whistle", "boing", "push off", "squeak", "squawk"), "motions"),
    **dict.fromkeys(("wings", "rustle"), "motions"),
    MUSIC: "music",
}
"""Bus of each cause; of all others that of impacts."""

CONTROL_RATE = 200
"""Values of the ducking a second."""

SOFTNESS = 0.09
"""Time over which something gives way, and comes back [s]."""


def bus_of(cause: str) -> Bus:
    """Return the bus of a cause."""
    return BUS_OF.get(cause, "impacts")


def bus_gain_db(mix: Mix, cause: str) -> float:
    """Return the gain of the sounds of a cause [dB]."""
    return float(getattr(mix, f"{bus_of(cause)}_db"))


def ducked(mix: Mix, notes: Iterable[Note], samples: int) -> Signal | float:
    """Return the gain of the ambience, (samples, 1) where it gives way to voices.

    Args:
        mix: gains of the scene.
        notes: of the score.
        samples: of the film.
    """
    return 10 ** (mix.ambience_db / 20) * yielding(mix, notes, samples)


def yielding(mix: Mix, notes: Iterable[Note], samples: int) -> Signal | float:
    """Return the gain of what gives way to voices, (samples, 1) where there are any.

    Args:
        mix: gains of the scene.
        notes: of the score.
        samples: of the film.
    """
    count = samples * CONTROL_RATE // SAMPLE_RATE + 2
    heard = np.zeros(count)
    for note in notes:
        if bus_of(note.event.cause) == "voices":
            voice = cause_voice(note.event.cause)
            seconds = note.event.duration or (voice.seconds if voice else 0.0)
            first = int(float(note.onset) * CONTROL_RATE)
            heard[first : first + max(round(seconds * CONTROL_RATE), 1)] = 1.0
    if not mix.duck_db or not heard.any():
        return 1.0
    reach = round(3 * SOFTNESS * CONTROL_RATE)
    window = np.exp(-0.5 * (np.arange(-reach, reach + 1) / (SOFTNESS * CONTROL_RATE)) ** 2)
    smooth = np.convolve(np.pad(heard, reach, mode="edge"), window / window.sum(), "valid")
    gain = 10 ** (-mix.duck_db * np.clip(smooth, 0.0, 1.0) / 20)
    return upsampled(gain, CONTROL_RATE, samples)[:, None]
