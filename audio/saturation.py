"""Saturation: the tips of blows bent below a ceiling, sample by sample.

A blow's first millisecond stands 20 dB above its ring. A gain that catches it takes the ring along;
bending the tip leaves the ring as loud as it is, and is heard as a somewhat duller click.
"""

from __future__ import annotations

import numpy as np

from audio.banks import Signal

_KNEE = 0.5


def saturated(stereo: Signal, ceiling: float) -> Signal:
    """Return a mix whose samples stay below a ceiling; up to half of it nothing is bent: (N, 2)."""
    knee = _KNEE * ceiling
    room = ceiling - knee
    over = np.abs(stereo) > knee
    out = stereo.copy()
    bent = knee + room * np.tanh((np.abs(stereo[over]) - knee) / room)
    out[over] = np.copysign(bent, stereo[over])
    return out
