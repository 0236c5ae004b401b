"""Wing beats: the flaps of birds and the hum of insects.

A wing of length l beats at f = 3540 / l^1.15 [Hz, mm] at most: one of 0.2 m 8 times a second, one
of 1 cm 250 times. Slow wings are heard as puffs of air, fast ones as a tone with its harmonics.

Source: Greenewalt 1962.
"""

from __future__ import annotations

import numpy as np

from audio.dsp import Signal, band_noise
from audio.motion import MAX_FREQUENCY, Motion, drift, tone
from audio.time_grid import SAMPLE_RATE

WING_PITCH, WING_SLOPE = 17.7, 1.15
"""Beats a second of a wing of 0.1 m [Hz], and by what power of its length they fall."""

# Animals that are heard one by one, and by how much their beats differ.
_HEARD, _DETUNING = 5, 0.12
# Beats a second from which a tone is heard rather than single beats [Hz].
_TONE = 40.0
# Band of the air that a wing of 10 Hz moves [Hz]; small wings are higher.
_AIR = (350.0, 2200.0)
_ATTACK = int(0.05 * SAMPLE_RATE)


def wings(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return the wing beats of several animals together, which come and go."""
    profile, samples = motion.profile, motion.profile.samples
    seconds = np.arange(samples) / SAMPLE_RATE
    # Above some rate the ear hears no beats any more.
    hum = 1.0 / (1.0 + (_TONE / motion.pitch) ** 4)
    rise = float(np.clip((motion.pitch / 10.0) ** 0.5, 0.5, 2.5))
    air = band_noise(samples, (_AIR[0] * rise, _AIR[1] * rise), rng)
    harmonics = np.arange(1, int(np.clip(MAX_FREQUENCY / (4 * motion.pitch), 2, 12)))
    sound = np.zeros(samples)
    for _ in range(_HEARD):
        rate = motion.pitch * (1 + _DETUNING * rng.uniform(-1, 1)) * drift(samples, 0.06, rng)
        rate = rate * profile.doppler
        near = 0.55 + 0.45 * np.sin(2 * np.pi * (rng.uniform(0.15, 0.5) * seconds + rng.uniform()))
        phase = 2 * np.pi * (np.cumsum(rate) / SAMPLE_RATE + rng.uniform())
        flap = np.exp(6.0 * (np.cos(phase) - 1.0))
        # The noise of another stretch for each, at no further cost.
        puff = np.roll(air, int(rng.integers(samples))) * flap
        buzz = tone(rate, tuple((1.0 / harmonics**1.1).tolist())) if hum > 0.01 else 0.0
        sound += near * (hum * buzz + (1.0 - hum) * puff)
    edge = np.arange(samples) + 1.0
    ends = np.minimum(1.0, np.minimum(edge, edge[::-1]) / _ATTACK)
    return np.asarray(sound * ends * profile.relative_speed)
