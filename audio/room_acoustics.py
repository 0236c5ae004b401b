"""Room acoustics: early reflections by image sources, and late reverberation.

Early reflections come from images of the source behind each wall; late reverberation is noise
that decays, high frequencies first. Neither precedes the direct sound.

Source: Allen and Berkley 1979 (images); Moorer 1979 (reverberation as noise that decays).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import atan2, hypot, sin, sqrt

import numpy as np
from scipy.signal import lfilter

from audio.config.sound import Room, RoomName
from audio.dsp import SILENCE_EXPONENT, Signal, convolve, mix_in, silence
from audio.layouts import STEREO, Layout
from audio.score import ScoreEvent
from audio.source_motion import SPEED_OF_SOUND
from audio.time_grid import SAMPLE_RATE

# Height of the ears, and least distance of a wall from a source [m].
_EAR_HEIGHT, _WALL_CLEARANCE = 1.6, 0.5
# Greatest distance of a source [m]; keeps squares finite.
_MAX_DISTANCE = 1e4
_SEED = 1979
# Pole of the low-pass of ground and walls.
_WALL_POLE = 0.6
# Delay of the reverberation after the direct sound, and its attack [s].
_REVERB_DELAY, _REVERB_ATTACK = 0.012, 0.02
# (edges of a band [Hz], its reverberation time relative to that of the room).
_REVERB_BANDS = (((60.0, 400.0), 1.1), ((400.0, 2000.0), 1.0), ((2000.0, 7000.0), 0.55))
# A level at or below which there is no reverberation [dB].
_NO_REVERB_DB = -80.0


@dataclass(frozen=True, slots=True)
class RoomAcoustics:
    """A room with all values given.

    Attributes:
        size: width (left to right), height and depth [m]; None outdoors, with ground alone.
        reflectance: share of the amplitude that ground and walls reflect.
        seconds: time in which the reverberation falls by 60 dB [s]; 0 for none.
        wet: amplitude of the reverberation at full send, relative to the direct sound.
    """

    size: tuple[float, float, float] | None
    reflectance: float
    seconds: float
    wet: float


# size, absorption, seconds, wet [dB].
_PRESETS: dict[RoomName, tuple[tuple[float, float, float] | None, float, float, float]] = {
    "dry": (None, 1.0, 0.0, -80.0),
    "open": (None, 0.8, 0.5, -34.0),
    "room": ((6.0, 2.8, 5.0), 0.6, 0.5, -14.0),
    "hall": ((24.0, 11.0, 36.0), 0.55, 1.9, -10.0),
}


def room_acoustics(room: Room) -> RoomAcoustics:
    """Return the acoustics of a room; its preset supplies what is not given."""
    size, absorption, seconds, wet_db = _PRESETS[room.preset]
    absorbed = absorption if room.absorption is None else room.absorption
    wet = wet_db if room.wet_db is None else room.wet_db
    return RoomAcoustics(
        size=room.size or size,
        reflectance=sqrt(1 - absorbed),
        seconds=room.seconds or seconds,
        wet=10 ** (wet / 20) if wet > _NO_REVERB_DB else 0.0,
    )


@dataclass(frozen=True, slots=True)
class Reflection:
    """An early reflection relative to the direct sound.

    Attributes:
        delay: in samples; at least one.
        gain: relative to the direct sound.
        azimuth: from which it comes [rad], positive to the right.
    """

    delay: int
    gain: float
    azimuth: float


def early_reflections(event: ScoreEvent, room: RoomAcoustics) -> Iterator[Reflection]:
    """Yield the reflections of ground, walls and ceiling; none if they absorb everything.

    Heights are assumed: ears of a standing listener, a source at its own size above the ground.
    """
    if room.reflectance <= 0:
        return
    height = min(event.size, _EAR_HEIGHT)
    direct = min(max(event.distance, abs(_EAR_HEIGHT - height), 0.1), _MAX_DISTANCE)
    flat = sqrt(max(direct**2 - (_EAR_HEIGHT - height) ** 2, 0.0))
    right, ahead = flat * sin(event.azimuth), flat * np.cos(event.azimuth)
    images = [(right, -height, ahead)]
    if room.size is not None:
        width, ceiling, depth = room.size
        # Walls move out to enclose the source.
        x_wall = max(width / 2, abs(right) + _WALL_CLEARANCE)
        z_wall = max(depth / 2, abs(ahead) + _WALL_CLEARANCE)
        images += [(2 * x_wall - right, height, ahead), (-2 * x_wall - right, height, ahead)]
        images += [(right, height, 2 * z_wall - ahead), (right, height, -2 * z_wall - ahead)]
        images += [(right, 2 * max(ceiling, _EAR_HEIGHT + _WALL_CLEARANCE) - height, ahead)]
    for x, y, z in images:
        path = hypot(x, y - _EAR_HEIGHT, z)
        delay = max(round((path - direct) / SPEED_OF_SOUND * SAMPLE_RATE), 1)
        yield Reflection(delay, room.reflectance * direct / path, atan2(x, z))


class Reverberator:
    """Accumulates the reflections and reverberation of events.

    Args:
        room: the acoustics.
        samples: length of the track.
        layout: of its channels.
    """

    def __init__(self, room: RoomAcoustics, samples: int, layout: Layout = STEREO) -> None:
        self.room, self._layout = room, layout
        self._early = silence(samples, len(layout.channels)) if room.reflectance > 0 else None
        self._late = np.zeros(samples) if room.wet * room.seconds > 0 else None

    def feed(self, event: ScoreEvent, start: int, sound: Signal, gain: float, send: float) -> None:
        """Add a sound to the input.

        Args:
            event: its distance and direction are used.
            start: sample of its onset.
            sound: (M,), dry.
            gain: of the direct sound.
            send: share of its level that is sent to the late reverberation.
        """
        if self._early is not None:
            for reflection in early_reflections(event, self.room):
                level = gain * reflection.gain
                gains = tuple(level * self._layout.gains(reflection.azimuth))
                mix_in(self._early, start + reflection.delay, sound, gains)
        if self._late is not None and send > 0:
            part = sound[: max(self._late.size - start, 0)]
            self._late[start : start + part.size] += gain * send * part

    def add_to(self, mix: Signal) -> None:
        """Add all reflections and reverberation to a mix (N, C)."""
        if self._early is not None:
            for channel in range(mix.shape[1]):
                mix[:, channel] += lfilter(
                    [1 - _WALL_POLE], [1, -_WALL_POLE], self._early[:, channel]
                )
        if self._late is not None and self._late.any():
            # Around the listener, each from its own side and unlike the others.
            sides = [azimuth for pair in self._layout.bed for azimuth in pair]
            responses = [reverb_response(self.room.seconds, number) for number in range(len(sides))]
            tails = convolve(self._late, np.stack(responses))
            for tail, azimuth in zip(tails, sides, strict=True):
                for channel, gain in enumerate(self._layout.gains(azimuth)):
                    if gain:
                        mix[:, channel] += self.room.wet * gain * tail


@lru_cache(maxsize=16)
def reverb_response(seconds: float, side: int) -> Signal:
    """Return the impulse response of late reverberation, of energy 1: (K,).

    Args:
        seconds: time in which it falls by 60 dB.
        side: its number; all are uncorrelated, as in a diffuse field.
    """
    rng = np.random.default_rng((_SEED, side))
    delay = int(_REVERB_DELAY * SAMPLE_RATE)
    samples = int(1.1 * seconds * SAMPLE_RATE)
    t = np.arange(samples) / SAMPLE_RATE
    white = np.fft.rfft(rng.standard_normal(1 << (samples - 1).bit_length()))
    f = np.fft.rfftfreq(2 * (white.size - 1), 1 / SAMPLE_RATE)
    tail = np.zeros(samples)
    for (low, high), share in _REVERB_BANDS:
        band = np.fft.irfft(white * ((f >= low) & (f < high)))[:samples]
        tail += band * np.exp(-SILENCE_EXPONENT * t / (share * seconds))
    tail *= np.minimum(1, t / _REVERB_ATTACK)
    tail[-delay:] *= np.linspace(1, 0, delay)
    return np.concatenate((np.zeros(delay), tail / np.sqrt(np.sum(tail**2))))
