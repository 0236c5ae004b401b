"""Mastering: a mix -> samples of 24 bits, as loud as asked and with no peak above the ceiling."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from audio.banks import Signal
from audio.limiter import limited
from audio.loudness import integrated, true_peak
from audio.saturation import saturated
from audio.track_words import Master

FULL = 2**23 - 1
"""The largest sample."""

_OFF = Master(most_gain_db=0.0)
# Meters that look between samples more finely, or with other filters, find a little more [dB].
_MARGIN = 0.3
# So much of what is too high is bent, which is not heard of blows; the rest is eased [dB].
_BENT = 9.0
_ROUNDS = 6
_NEAR_ENOUGH = 0.05
_LEAST_SLOPE = 0.25


@dataclass(frozen=True, slots=True)
class Mastered:
    """A track that is ready to be written, and what was done to it.

    Attributes:
        samples: (N, 2) integers of 24 bits.
        lufs: integrated loudness of these samples [LUFS]; -inf for silence.
        true_peak_db: their largest magnitude, between samples too [dB]; -inf for silence.
        gain_db: by which the whole mix was raised or lowered [dB].
        limited_db: the most that the highest peak was lowered after that [dB].
    """

    samples: NDArray[np.int32]
    lufs: float
    true_peak_db: float
    gain_db: float
    limited_db: float


def mastered(mix: Signal, master: Master | None, volume_db: float = 0.0) -> Mastered:
    """Return a mix made as loud as asked.

    The whole is raised by one gain, so that soft and loud keep their relation; only what would
    pass the ceiling is lowered again. Since that costs loudness, the gain is found in rounds.

    Args:
        mix: (N, 2), within any bounds.
        master: how loud; None to leave the loudness as it is, below the usual ceiling.
        volume_db: the author's, already in the mix: so much louder than asked it shall be [dB].
    """
    words = master or _OFF
    ceiling_db, wanted = words.true_peak_db - _MARGIN, words.lufs + volume_db
    peak_db, loud = decibels(true_peak(mix)), integrated(mix) if master else -np.inf
    gain_db = most = 0.0
    if np.isfinite(loud):
        most = min(words.most_gain_db, ceiling_db + words.most_limiting_db - peak_db)
        gain_db = min(wanted - loud, most)
    if peak_db + gain_db <= ceiling_db:
        return _measured(mix * 10 ** (gain_db / 20), gain_db, 0.0)
    out = _limited(mix, gain_db, ceiling_db, peak_db)
    # What is lowered is lost to loudness: by the slope of the last round, at first none.
    slope, heard = 1.0, integrated(out)
    for _ in range(_ROUNDS if master else 0):
        more = min((wanted - heard) / slope, most - gain_db)
        if abs(more) < _NEAR_ENOUGH or wanted - heard < _NEAR_ENOUGH:
            break
        gain_db += more
        out = _limited(mix, gain_db, ceiling_db, peak_db)
        before, heard = heard, integrated(out)
        slope = min(max((heard - before) / more, _LEAST_SLOPE), 1.0)
    return _measured(out, gain_db, peak_db + gain_db - ceiling_db)


def _limited(mix: Signal, gain_db: float, ceiling_db: float, peak_db: float) -> Signal:
    """Return the mix raised and below the ceiling."""
    ceiling = 10 ** (ceiling_db / 20)
    raised = mix * 10 ** (gain_db / 20)
    tips = 10 ** (min(peak_db + gain_db - ceiling_db, _BENT) / 20)
    eased, _ = limited(raised, ceiling * tips)
    # Between samples what is bent may reach a little over.
    return limited(saturated(eased, ceiling), ceiling)[0]


def _measured(out: Signal, gain_db: float, lowered: float) -> Mastered:
    samples = np.rint(out * FULL).astype("<i4")
    written = samples / FULL
    peak = true_peak(written)
    return Mastered(
        samples=samples,
        lufs=integrated(written),
        true_peak_db=decibels(peak),
        gain_db=float(gain_db),
        limited_db=lowered,
    )


def decibels(level: float) -> float:
    """Return an amplitude in decibels; -inf for none."""
    return float(20 * np.log10(level)) if level > 0 else -np.inf
