"""Layouts: the channels of a track, and how loud a sound from a direction is in each.

Sources: Pulkki 1997 for panning between neighbouring loudspeakers; ITU-R BS.775 for the places of
5.1; Nachbar et al. 2011 (AmbiX) for the order and the weights of B-format.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from audio.dsp import Signal, pan_gains

SIDE = 0x600
"""Speaker bits of a WAV file for loudspeakers at both sides."""


@dataclass(frozen=True, slots=True)
class Layout:
    """The channels of a track.

    Attributes:
        channels: their names, in the order of the file.
        gains: from an azimuth [rad], positive to the right, to the gain of each channel (C,).
        mask: speaker bits of a WAV file; 0 where channels are no loudspeakers.
        bed: azimuths from which the sides of an ambience are heard, of one or two stereo beds.
    """

    channels: tuple[str, ...]
    gains: Callable[[float], Signal]
    mask: int
    bed: tuple[tuple[float, float], ...]


def _stereo(azimuth: float) -> Signal:
    return np.array(pan_gains(float(np.sin(azimuth))))


_RING = ((-110.0, 4), (-30.0, 0), (0.0, 2), (30.0, 1), (110.0, 5))
"""Azimuths of the loudspeakers of 5.1 around the listener [degrees], and their channels."""


def _surround(azimuth: float) -> Signal:
    """Return gains of constant power between the two loudspeakers on both sides of a direction."""
    gains = np.zeros(6)
    angle = float(np.degrees(np.arctan2(np.sin(azimuth), np.cos(azimuth))))
    ring = [*_RING, (_RING[0][0] + 360.0, _RING[0][1])]
    if angle < _RING[0][0]:
        angle += 360.0
    for (low, first), (high, second) in pairwise(ring):
        if low <= angle <= high:
            share = (angle - low) / (high - low)
            gains[first] = np.cos(0.5 * np.pi * share)
            gains[second] = np.sin(0.5 * np.pi * share)
            break
    return gains


def _ambisonic(azimuth: float) -> Signal:
    """Return W, Y (left), Z (up) and X (ahead) of first order, in the weights of AmbiX."""
    return np.array([1.0, -np.sin(azimuth), 0.0, np.cos(azimuth)])


def _about(degrees: float) -> tuple[float, float]:
    return -float(np.radians(degrees)), float(np.radians(degrees))


STEREO = Layout(("left", "right"), _stereo, 0x3, ((-0.5 * np.pi, 0.5 * np.pi),))

LAYOUTS: Mapping[str, Layout] = {
    "stereo": STEREO,
    "5.1": Layout(
        *(("left", "right", "centre", "low", "left side", "right side"), _surround),
        *(0xF | SIDE, (_about(30.0), _about(110.0))),
    ),
    "b-format": Layout(("W", "Y", "Z", "X"), _ambisonic, 0, (_about(55.0), _about(125.0))),
}
"""Layouts by name."""
