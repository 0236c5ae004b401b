"""Source motion: Doppler shift, speed and gains of sustained sounds over time.

Source: Doppler's law for a source that moves in air at rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """Speed of a sustained sound at each of its samples.

    Attributes:
        relative_speed: (N,) fraction of the greatest speed, 0 to 1.
        doppler: (N,) frequency ratio at the listener; 1 for a source at constant distance.
        is_steady: whether the speed is constant or unknown.
    """

    relative_speed: Signal
    doppler: Signal
    is_steady: bool

    @property
    def samples(self) -> int:
        """Length in samples."""
        return self.relative_speed.size


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
    relative = np.ones(samples) if is_steady else _interpolate(speeds, samples, duration) / top
    doppler = np.ones(samples)
    if len(approach_speeds) > 1:
        approach = np.clip(
            _interpolate(approach_speeds, samples, duration), -_MAX_SPEED, _MAX_SPEED
        )
        doppler = 1 / (1 - approach / SPEED_OF_SOUND)
    return SpeedProfile(relative, doppler, is_steady)


def _interpolate(values: tuple[float, ...], samples: int, duration: float) -> Signal:
    """Return values at even times, linearly interpolated at each sample: (samples,)."""
    return upsampled(_course(values, samples, duration), CONTROL_RATE, samples)


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
