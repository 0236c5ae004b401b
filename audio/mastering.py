"""Mastering: a mix to 24-bit samples of a given loudness below a ceiling.

Peaks are first limited by a gain, then saturated: the first millisecond of an impact is 20 dB
above its ring, and a gain alone would lower the ring with it. Saturating the peak leaves the ring
as loud as it is, and sounds like a slightly duller click.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from audio.config.sound import Master
from audio.dsp import Signal, decibels
from audio.loudness_meter import integrated_loudness, true_peak, true_peaks
from audio.time_grid import SAMPLE_RATE

FULL_SCALE = 2**23 - 1
"""The largest sample."""

_CEILING_ONLY = Master(most_gain_db=0.0)
# Below the ceiling, because other meters oversample more finely or with other filters [dB].
_MARGIN = 0.3
# Greatest saturation, inaudible on impacts; the rest is limited [dB].
_MAX_SATURATION = 9.0
# Share of the ceiling up to which saturation is linear.
_KNEE = 0.5


@dataclass(frozen=True, slots=True)
class _GainSearch:
    """Secant search of the gain that reaches the target loudness.

    Attributes:
        max_rounds: number of limited mixes that are measured.
        tolerance: of the loudness [dB].
        min_slope: least change of loudness per gain, which bounds the steps.
    """

    max_rounds: int = 6
    tolerance: float = 0.05
    min_slope: float = 0.25


@dataclass(frozen=True, slots=True)
class _Limiter:
    """Envelope of the limiter's gain, in blocks of a millisecond.

    Attributes:
        block: samples per step of the gain.
        lookahead: blocks within which the gain falls ahead of a peak.
        hold: blocks for which it stays.
        release_db: recovery [dB/s], soon enough to leave the ring after the peak.
    """

    block: int = 48
    lookahead: int = 2
    hold: int = 4
    release_db: float = 300.0

    @property
    def release(self) -> float:
        """Factor by which the gain recovers from block to block."""
        return float(10 ** (self.release_db / 20 * self.block / SAMPLE_RATE))


_SEARCH = _GainSearch()
_LIMITER = _Limiter()


@dataclass(frozen=True, slots=True)
class Mastered:
    """A mastered track with its measurements.

    Attributes:
        samples: (N, 2) integers of 24 bits.
        lufs: integrated loudness [LUFS]; -inf for silence.
        true_peak_db: largest magnitude, between samples too [dB]; -inf for silence.
        gain_db: of the whole mix [dB].
        limited_db: reduction of the highest peak after that gain [dB].
    """

    samples: NDArray[np.int32]
    lufs: float
    true_peak_db: float
    gain_db: float
    limited_db: float


def master_mix(mix: Signal, master: Master | None, volume_db: float = 0.0) -> Mastered:
    """Return a mix at the target loudness.

    One gain raises the whole mix, so the balance of soft and loud stays; only peaks above the
    ceiling are lowered. Since that costs loudness, the gain is found iteratively.

    Args:
        mix: (N, 2), of any level.
        master: the target; None to apply the usual ceiling only.
        volume_db: configured volume, already in the mix, by which the target is raised [dB].
    """
    config = master or _CEILING_ONLY
    ceiling_db, target = config.true_peak_db - _MARGIN, config.lufs + volume_db
    peak_db = decibels(true_peak(mix))
    loudness = integrated_loudness(mix) if master else -np.inf
    gain_db = max_gain_db = 0.0
    if np.isfinite(loudness):
        max_gain_db = min(config.most_gain_db, ceiling_db + config.most_limiting_db - peak_db)
        gain_db = min(target - loudness, max_gain_db)
    if peak_db + gain_db <= ceiling_db:
        return _measured(mix * 10 ** (gain_db / 20), gain_db, 0.0)
    out = _limited(mix, gain_db, ceiling_db, peak_db)
    # Secant search: limiting makes loudness grow slower than the gain.
    slope, loudness = 1.0, integrated_loudness(out)
    for _ in range(_SEARCH.max_rounds if master else 0):
        step = min((target - loudness) / slope, max_gain_db - gain_db)
        if abs(step) < _SEARCH.tolerance or target - loudness < _SEARCH.tolerance:
            break
        gain_db += step
        out = _limited(mix, gain_db, ceiling_db, peak_db)
        previous, loudness = loudness, integrated_loudness(out)
        slope = min(max((loudness - previous) / step, _SEARCH.min_slope), 1.0)
    return _measured(out, gain_db, peak_db + gain_db - ceiling_db)


def _limited(mix: Signal, gain_db: float, ceiling_db: float, peak_db: float) -> Signal:
    """Return the mix with a gain, limited and saturated below the ceiling."""
    ceiling = 10 ** (ceiling_db / 20)
    raised = mix * 10 ** (gain_db / 20)
    headroom = 10 ** (min(peak_db + gain_db - ceiling_db, _MAX_SATURATION) / 20)
    eased, _ = limit(raised, ceiling * headroom)
    # Between samples, saturated peaks may exceed the ceiling slightly.
    return limit(_saturate(eased, ceiling), ceiling)[0]


def _saturate(stereo: Signal, ceiling: float) -> Signal:
    """Return a mix with its samples below a ceiling, unchanged up to the knee: (N, 2)."""
    knee = _KNEE * ceiling
    room = ceiling - knee
    over = np.abs(stereo) > knee
    out = stereo.copy()
    bent = knee + room * np.tanh((np.abs(stereo[over]) - knee) / room)
    out[over] = np.copysign(bent, stereo[over])
    return out


def _measured(out: Signal, gain_db: float, limited_db: float) -> Mastered:
    samples = np.rint(out * FULL_SCALE).astype("<i4")
    written = samples / FULL_SCALE
    return Mastered(
        samples=samples,
        lufs=integrated_loudness(written),
        true_peak_db=decibels(true_peak(written)),
        gain_db=float(gain_db),
        limited_db=limited_db,
    )


def limit(stereo: Signal, ceiling: float) -> tuple[Signal, float]:
    """Return the mix limited to a ceiling, and the greatest reduction [dB].

    One gain for both sides: silence stays silence, every onset stays on its sample, and parts far
    from any peak are not changed.

    Args:
        stereo: (N, 2).
        ceiling: of peaks, between samples too.
    """
    peaks = true_peaks(stereo, 0.5 * ceiling)
    if peaks.max(initial=0.0) <= ceiling:
        return stereo, 0.0
    gain = _limiter_gain(peaks, ceiling)
    return stereo * gain[:, None], float(-20 * np.log10(gain.min()))


def _limiter_gain(peaks: Signal, ceiling: float) -> Signal:
    """Return a gain that keeps peaks below the ceiling: (N,)."""
    blocks = -(-peaks.size // _LIMITER.block)
    padded = np.zeros(blocks * _LIMITER.block)
    padded[: peaks.size] = peaks
    needed = ceiling / np.maximum(padded.reshape(blocks, _LIMITER.block).max(axis=1), ceiling)
    # The window of the minimum is wider than that of the mean, so the mean reaches it in time.
    wide = np.pad(needed, (_LIMITER.hold, 2 * _LIMITER.lookahead), constant_values=1.0)
    lowest = sliding_window_view(wide, _LIMITER.hold + 2 * _LIMITER.lookahead + 1).min(axis=1)
    smooth = np.pad(_with_release(lowest), (_LIMITER.lookahead, _LIMITER.lookahead), mode="edge")
    mean = sliding_window_view(smooth, 2 * _LIMITER.lookahead + 1).mean(axis=1)
    centers = (np.arange(blocks) + 0.5) * _LIMITER.block
    return np.asarray(np.interp(np.arange(peaks.size), centers, mean))


def _with_release(needed: Signal) -> Signal:
    """Return a gain that falls at once and recovers at the release rate: (B,)."""
    gain, out, release = 1.0, needed.tolist(), _LIMITER.release
    for block, most in enumerate(out):
        gain = min(most, gain * release)
        out[block] = gain
    return np.array(out)
