"""Rooms: what ground and walls send back, and the reverberation after it.

First reflections come from images of the source behind each wall; after them the field of a room
is noise that dies away, highs first. Neither comes before the direct sound.

Source: Allen and Berkley 1979 (images); Moorer 1979 (reverberation as noise that decays).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, hypot, sin, sqrt

import numpy as np

from audio.banks import Signal
from audio.convolution import convolved
from audio.courses import SOUND
from audio.grid import SAMPLE_RATE
from audio.mixing import add, sides
from audio.score import ScoreEvent
from audio.track_words import Room, RoomName

# Ears above the ground, and how far a wall is at least from what sounds [m].
_EARS, _CLEAR = 1.6, 0.5
# Farther off nothing is heard, and squares stay finite [m].
_FARTHEST = 1e4
_SEED = 1979
# What the ground and walls leave of the highs: each sample after the first is so much less.
_DULL = 0.6
# The reverberation sets in after the direct sound, and swells [s].
_DELAY, _SWELL = 0.012, 0.02
# (edges of a band [Hz], its time of reverberation beside that of the room).
_BANDS = (((60.0, 400.0), 1.1), ((400.0, 2000.0), 1.0), ((2000.0, 7000.0), 0.55))
_SILENT = float(np.log(1000.0))


@dataclass(frozen=True, slots=True)
class Acoustics:
    """A room, all said.

    Attributes:
        size: width (left to right), height and depth [m]; None outdoors, with ground alone.
        reflected: share of the amplitude that ground and walls send back.
        seconds: time in which the reverberation falls by 60 dB [s]; 0 for none.
        wet: amplitude of the reverberation at full send, beside the direct sound.
    """

    size: tuple[float, float, float] | None
    reflected: float
    seconds: float
    wet: float


# size, absorption, seconds, wet [dB].
_PRESETS: dict[RoomName, tuple[tuple[float, float, float] | None, float, float, float]] = {
    "dry": (None, 1.0, 0.0, -80.0),
    "open": (None, 0.8, 0.5, -34.0),
    "room": ((6.0, 2.8, 5.0), 0.6, 0.5, -14.0),
    "hall": ((24.0, 11.0, 36.0), 0.55, 1.9, -10.0),
}


def acoustics_of(room: Room) -> Acoustics:
    """Return a room with what the author did not say as in its preset."""
    size, absorption, seconds, wet_db = _PRESETS[room.preset]
    absorbed = absorption if room.absorption is None else room.absorption
    wet = wet_db if room.wet_db is None else room.wet_db
    return Acoustics(
        size=room.size or size,
        reflected=sqrt(1 - absorbed),
        seconds=room.seconds or seconds,
        wet=10 ** (wet / 20) if wet > -80.0 else 0.0,
    )


@dataclass(frozen=True, slots=True)
class Image:
    """A reflection, beside the direct sound.

    Attributes:
        delay: after it, in samples; at least one.
        gain: beside it.
        pan: between left (-1) and right (1).
    """

    delay: int
    gain: float
    pan: float


def images_of(event: ScoreEvent, room: Acoustics) -> Iterator[Image]:
    """Give the first reflections of a sound, none where ground and walls send nothing back.

    Heights are guessed: ears as of one who stands, a source of its own size above the ground.
    """
    if room.reflected <= 0:
        return
    height = min(event.size, _EARS)
    away = min(max(event.distance, abs(_EARS - height), 0.1), _FARTHEST)
    flat = sqrt(max(away**2 - (_EARS - height) ** 2, 0.0))
    right, ahead = flat * sin(event.azimuth), flat * np.cos(event.azimuth)
    places = [(right, -height, ahead)]
    if room.size is not None:
        width, top, depth = room.size
        # Walls give way to what lies beyond them.
        half, far = max(width / 2, abs(right) + _CLEAR), max(depth / 2, abs(ahead) + _CLEAR)
        places += [(2 * half - right, height, ahead), (-2 * half - right, height, ahead)]
        places += [(right, height, 2 * far - ahead), (right, height, -2 * far - ahead)]
        places += [(right, 2 * max(top, _EARS + _CLEAR) - height, ahead)]
    for x, y, z in places:
        path = hypot(x, y - _EARS, z)
        late = max(round((path - away) / SOUND * SAMPLE_RATE), 1)
        yield Image(late, room.reflected * away / path, sin(atan2(x, z)))


class Space:
    """Two sides of what a room gives back, gathered event by event.

    Args:
        room: all said.
        samples: of the track.
    """

    def __init__(self, room: Acoustics, samples: int) -> None:
        self.room = room
        self._early = np.zeros((samples, 2)) if room.reflected > 0 else None
        self._late = np.zeros(samples) if room.wet * room.seconds > 0 else None

    def hear(self, event: ScoreEvent, start: int, sound: Signal, gain: float, send: float) -> None:
        """Take in a sound.

        Args:
            event: that it is of.
            start: sample of its onset.
            sound: (M,), as it comes from its place.
            gain: of the direct sound.
            send: share of its level that the reverberation is given.
        """
        if self._early is not None:
            for image in images_of(event, self.room):
                to_left, to_right = sides(image.pan)
                each = gain * image.gain
                add(self._early, start + image.delay, sound, (each * to_left, each * to_right))
        if self._late is not None and send > 0:
            part = sound[: max(self._late.size - start, 0)]
            self._late[start : start + part.size] += gain * send * part

    def add_to(self, stereo: Signal) -> None:
        """Add all that the room gives back to a mix (N, 2)."""
        for side in (0, 1):
            if self._early is not None and self._early.any():
                stereo[:, side] += convolved(self._early[:, side], _dulling())
            if self._late is not None and self._late.any():
                tail = reverberation(self.room.seconds, side)
                stereo[:, side] += self.room.wet * convolved(self._late, tail)


def _dulling() -> Signal:
    """Return what a wall does to a sample of 1: a one-pole low-pass, (24,)."""
    return np.asarray((1 - _DULL) * _DULL ** np.arange(24))


def reverberation(seconds: float, side: int) -> Signal:
    """Return the response of a room to a sample of 1, of energy 1, after the direct sound: (K,).

    Args:
        seconds: in which it falls by 60 dB.
        side: 0 or 1; both are noise of their own, as a field from all about is.
    """
    rng = np.random.default_rng((_SEED, side))
    late = int(_DELAY * SAMPLE_RATE)
    samples = int(1.1 * seconds * SAMPLE_RATE)
    t = np.arange(samples) / SAMPLE_RATE
    white = np.fft.rfft(rng.standard_normal(1 << (samples - 1).bit_length()))
    f = np.fft.rfftfreq(2 * (white.size - 1), 1 / SAMPLE_RATE)
    tail = np.zeros(samples)
    for (low, high), share in _BANDS:
        band = np.fft.irfft(white * ((f >= low) & (f < high)))[:samples]
        tail += band * np.exp(-_SILENT * t / (share * seconds))
    tail *= np.minimum(1, t / _SWELL)
    tail[-late:] *= np.linspace(1, 0, late)
    return np.concatenate((np.zeros(late), tail / np.sqrt(np.sum(tail**2))))
