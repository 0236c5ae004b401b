"""Source motion: Doppler shift, speed and gains of sustained sounds over time.

Source: Doppler's law for a source that moves in air at rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from audio.dsp import Signal, upsampled
from audio.loudness_at_listener import MIN_DISTANCE
from audio.score import Bearing
from audio.time_grid import SAMPLE_RATE

SPEED_OF_SOUND = 343.0
"""At 20 °C [m/s]."""

CONTROL_RATE = 1000
"""Values a second of what follows a moving source."""

# Doppler's law has a pole at the speed of sound.
_MAX_SPEED = 0.8 * SPEED_OF_SOUND


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """Speed of a sustained sound.

    Attributes:
        samples: length in samples.
        speed: (K,) fraction of the greatest speed at the control rate, 0 to 1.
        pitch: (K,) frequency ratio at the listener at the control rate; None for a source at
            constant distance.
        is_steady: whether the speed is constant or unknown.
    """

    samples: int
    speed: Signal
    pitch: Signal | None
    is_steady: bool

    @cached_property
    def relative_speed(self) -> Signal:
        """Fraction of the greatest speed at each sample: (N,)."""
        return self.raised(1.0)

    @cached_property
    def doppler(self) -> Signal:
        """Frequency ratio at the listener at each sample: (N,)."""
        if self.pitch is None:
            return np.ones(self.samples)
        return upsampled(self.pitch, CONTROL_RATE, self.samples)

    def raised(self, exponent: float) -> Signal:
        """Return a power of the relative speed at each sample: (N,)."""
        if self.is_steady:
            return np.ones(self.samples)
        return upsampled(self.speed**exponent, CONTROL_RATE, self.samples)


def speed_profile(
    samples: int, duration: float, speeds: tuple[float, ...], approach_speeds: tuple[float, ...]
) -> SpeedProfile:
    """Return the speed profile of a sound.

    Args:
        samples: length of the profile.
        duration: from the first to the last speed [s]; the last speed continues after it.
        speeds: at even times [m/s]; empty if constant.
        approach_speeds: rates at which the distance shrinks, at even times [m/s]; empty if
            constant.
    """
    top = max(speeds, default=0.0)
    is_steady = len(speeds) < 2 or top <= 0.0
    relative = np.ones(1) if is_steady else _course(speeds, samples, duration) / top
    pitch = None
    if len(approach_speeds) > 1:
        approach = np.clip(_course(approach_speeds, samples, duration), -_MAX_SPEED, _MAX_SPEED)
        pitch = 1 / (1 - approach / SPEED_OF_SOUND)
    return SpeedProfile(samples, relative, pitch, is_steady)


def _course(values: tuple[float, ...], samples: int, duration: float) -> Signal:
    """Return values at even times, linearly interpolated at the control rate: (K,)."""
    times = np.linspace(0.0, max(duration, 1 / SAMPLE_RATE), len(values))
    steps = samples * CONTROL_RATE // SAMPLE_RATE + 2
    return np.asarray(np.interp(np.arange(steps) / CONTROL_RATE, times, np.asarray(values)))


def moving_gains(
    course: tuple[Bearing, ...],
    nearest: float,
    duration: float,
    samples: int,
    pan: float | None = None,
) -> tuple[Signal, Signal]:
    """Return the gains of left and right relative to the nearest point: (samples,) each.

    Args:
        course: bearings at even times, at least two.
        nearest: distance to which the level of the whole sound refers [m].
        duration: from the first to the last bearing [s].
        samples: of the sound.
        pan: fixed pan from left (-1) to right (1); None to follow the bearings.
    """
    # Interpolated sines: a source that passes behind the listener stays behind.
    sines = tuple(float(np.sin(b.azimuth)) if pan is None else pan for b in course)
    angle = (_course(sines, samples, duration) + 1) * np.pi / 4
    near = _nearness(course, nearest, duration, samples)
    left, right = (
        upsampled(near * side(angle), CONTROL_RATE, samples) for side in (np.cos, np.sin)
    )
    return left, right


def surrounding_gains(
    course: tuple[Bearing, ...],
    nearest: float,
    duration: float,
    samples: int,
    gains: Callable[[float], Signal],
) -> tuple[Signal, ...]:
    """Return the gains of each channel of a layout; see `moving_gains`.

    Args:
        course: bearings at even times, at least two.
        nearest: distance to which the level of the whole sound refers [m].
        duration: from the first to the last bearing [s].
        samples: of the sound.
        gains: of the layout, from an azimuth.
    """
    near = _nearness(course, nearest, duration, samples)
    each = np.array([gains(bearing.azimuth) for bearing in course])
    return tuple(
        upsampled(near * _course(tuple(row), samples, duration), CONTROL_RATE, samples)
        for row in each.T
    )


def _nearness(course: tuple[Bearing, ...], nearest: float, duration: float, samples: int) -> Signal:
    """Return how much softer a sound is than where it is nearest, at the control rate: (K,)."""
    distances = tuple(max(bearing.distance, MIN_DISTANCE) for bearing in course)
    distance = _course(distances, samples, duration)
    return np.asarray(max(nearest, MIN_DISTANCE) / distance)
