"""Courses: how what lasts changes on its way, by its speed and by where it is heard.

Source: Doppler's law for a source that moves in air at rest; Catmull and Rom 1974.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from audio.banks import Signal
from audio.grid import SAMPLE_RATE
from audio.heard import NEAREST
from audio.score import Bearing

SOUND = 343.0
"""Speed of sound [m/s], at 20 °C."""

# Faster than this a source would outrun its own sound.
_FASTEST = 0.8 * SOUND


@dataclass(frozen=True, slots=True)
class Drive:
    """What drives a sound that lasts, at each of its samples.

    Attributes:
        share: (N,) of the greatest speed, 0 to 1.
        rate: (N,) how fast the listener hears the time of the source go by; 1 for what stays.
        steady: whether no speeds are known.
    """

    share: Signal
    rate: Signal
    steady: bool

    @property
    def samples(self) -> int:
        """How many."""
        return self.share.size


def drive_of(
    samples: int, whole: float, speeds: tuple[float, ...], nearings: tuple[float, ...]
) -> Drive:
    """Return the drive of a sound.

    Args:
        samples: that are heard.
        whole: duration from the first to the last speed [s]; after it the last one stays.
        speeds: at even times [m/s]; empty where it does not change.
        nearings: how fast it comes nearer, at even times [m/s]; empty where it stays.
    """
    top = max(speeds, default=0.0)
    steady = len(speeds) < 2 or top <= 0.0
    share = np.ones(samples) if steady else _along(speeds, samples, whole) / top
    rate = np.ones(samples)
    if len(nearings) > 1:
        nearing = np.clip(_along(nearings, samples, whole), -_FASTEST, _FASTEST)
        rate = 1 / (1 - nearing / SOUND)
    return Drive(share, rate, steady)


def _along(values: tuple[float, ...], samples: int, whole: float) -> Signal:
    """Return values at even times, on straight lines between them: (samples,)."""
    times = np.linspace(0.0, max(whole, 1 / SAMPLE_RATE), len(values))
    return np.asarray(np.interp(np.arange(samples) / SAMPLE_RATE, times, np.asarray(values)))


def read_at(profile: Signal, pace: Signal) -> Signal:
    """Return a profile read along at a pace: (N,).

    Args:
        profile: (K,) samples; read from its start again where it is too short.
        pace: (N,) samples of the profile a sample of the sound; not negative.
    """
    if (pace == 1.0).all() and pace.size <= profile.size:
        return np.array(profile[: pace.size])
    at = np.concatenate(([0.0], np.cumsum(pace)[:-1]))
    whole = np.floor(at)
    x, i = at - whole, whole.astype(np.int64)
    p0, p1, p2, p3 = (profile[(i + k) % profile.size] for k in (-1, 0, 1, 2))
    curve = x * (3 * (p1 - p2) + p3 - p0) + 2 * p0 - 5 * p1 + 4 * p2 - p3
    return np.asarray(p1 + 0.5 * x * (p2 - p0 + x * curve))


def gains_of(
    course: tuple[Bearing, ...],
    nearest: float,
    whole: float,
    samples: int,
    pan: float | None = None,
) -> tuple[Signal, Signal]:
    """Return the gains of left and right on the way, beside the nearest place: (samples,) each.

    Args:
        course: bearings at even times, at least two.
        nearest: distance that the loudness of the whole is given for [m].
        whole: duration from the first to the last bearing [s].
        samples: of the sound.
        pan: where it stays between left (-1) and right (1); None to follow the bearings.
    """
    distance = _along(tuple(max(b.distance, NEAREST) for b in course), samples, whole)
    # Sines, so that what passes behind the listener does not turn about by the front.
    at = tuple(float(np.sin(b.azimuth)) if pan is None else pan for b in course)
    sine = _along(at, samples, whole)
    angle = (np.clip(sine, -1.0, 1.0) + 1) * np.pi / 4
    near = max(nearest, NEAREST) / distance
    return near * np.cos(angle), near * np.sin(angle)
