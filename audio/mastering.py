"""Mastering: a mix to 24-bit samples of a given loudness below a ceiling.

One gain raises the mix, and a limiter lowers what rises above the ceiling: by a few decibels where
that is rare, by next to nothing where it happens at every blow, so that loud ones stay louder than
soft ones. A mix that would need more than that is left below the target.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from audio.config.sound import Master
from audio.dsp import Signal, decibels
from audio.limiter import limiter_gain
from audio.loudness_meter import integrated_loudness, true_peak, true_peaks

FULL_SCALE = 2**23 - 1
"""The largest sample."""

_CEILING_ONLY = Master(most_gain_db=0.0)
# Below the ceiling, because other meters oversample more finely or with other filters [dB].
_MARGIN = 0.3
# Share of the attacks that may be limited by more than _USUAL_LIMITING [dB].
_RARE, _USUAL_LIMITING = 0.02, 0.7
# Length of a stretch in which one attack is looked for [samples], its rise over the stretch before
# [factor], and how far below the highest peak it may lie [factor].
_STRETCH, _ATTACK, _FAINT = 2400, 1.4, 0.03


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


_SEARCH = _GainSearch()


@dataclass(frozen=True, slots=True)
class Mastered:
    """A mastered track with its measurements.

    Attributes:
        samples: (N, 2) integers of 24 bits.
        lufs: integrated loudness [LUFS]; -inf for silence.
        true_peak_db: largest magnitude, between samples too [dB]; -inf for silence.
        gain_db: of the whole mix [dB].
        limited_db: reduction of the highest peak after that gain [dB].
        target: loudness that was aimed at [LUFS]: that of the configuration, or, where that would
            have flattened the peaks or needed too much gain, what the greatest gain gives; -inf
            for silence or without a target.
        curve: gain of the limiter (N,), by which all stems are lowered too; None without any.
    """

    samples: NDArray[np.int32]
    lufs: float
    true_peak_db: float
    gain_db: float
    limited_db: float
    target: float = -np.inf
    curve: Signal | None = None


def master_mix(
    mix: Signal, master: Master | None, volume_db: float = 0.0, bed: Signal | None = None
) -> Mastered:
    """Return a mix at the target loudness.

    One gain raises the whole mix, so the balance of soft and loud stays; only peaks above the
    ceiling are lowered. Since that costs loudness, the gain is found iteratively.

    Args:
        mix: (N, 2), of any level.
        master: the target; None to apply the usual ceiling only.
        volume_db: configured volume, already in the mix, by which the target is raised [dB].
        bed: (N, 2) of its final level, which no gain raises; only the limiter works on it.
    """
    config = master or _CEILING_ONLY
    ceiling_db, target = config.true_peak_db - _MARGIN, config.lufs + volume_db
    peaks = true_peaks(mix, 0.5 * float(np.abs(mix).max(initial=0.0)))
    peak_db = decibels(float(peaks.max(initial=0.0)))
    loudness = integrated_loudness(mix) if master else -np.inf
    gain_db = max_gain_db = 0.0
    if np.isfinite(loudness):
        room = min(
            ceiling_db + config.most_limiting_db - peak_db,
            ceiling_db + _USUAL_LIMITING - decibels(_usual_peak(peaks)),
        )
        max_gain_db = min(config.most_gain_db, room)
        gain_db = min(target - loudness, max_gain_db)
    out, curve = _limited(mix, gain_db, ceiling_db, bed)
    # Secant search: limiting makes loudness grow slower than the gain.
    slope, loudness = 1.0, integrated_loudness(out)
    # What the bed adds between the events counts for less than they do.
    is_searched = master and (curve is not None or bed is not None)
    for _ in range(_SEARCH.max_rounds if is_searched else 0):
        step = min((target - loudness) / slope, max_gain_db - gain_db)
        if abs(step) < _SEARCH.tolerance or target - loudness < _SEARCH.tolerance:
            break
        gain_db += step
        out, curve = _limited(mix, gain_db, ceiling_db, bed)
        previous, loudness = loudness, integrated_loudness(out)
        slope = min(max((loudness - previous) / step, _SEARCH.min_slope), 1.0)
    done = _measured(out, loudness, gain_db, max(peak_db + gain_db - ceiling_db, 0.0))
    if master is None:
        return replace(done, curve=curve)
    if done.lufs > target - _SEARCH.tolerance:
        return replace(done, curve=curve, target=target)
    # No greater gain is allowed: this is as loud as it can be.
    return replace(done, curve=curve, target=min(target, done.lufs))


def _raised(mix: Signal, gain_db: float, bed: Signal | None) -> Signal:
    """Return a mix with a gain, and its bed without."""
    raised = mix * 10 ** (gain_db / 20)
    return raised if bed is None else raised + bed


def ceiling_of(master: Master | None) -> float:
    """Return the ceiling of peaks, as a magnitude."""
    return float(10 ** (((master or _CEILING_ONLY).true_peak_db - _MARGIN) / 20))


def _usual_peak(peaks: Signal) -> float:
    """Return the level above which attacks are rare; that of the highest where there are few.

    Args:
        peaks: (N,) magnitudes.
    """
    count = -(-peaks.size // _STRETCH)
    padded = np.zeros(count * _STRETCH)
    padded[: peaks.size] = peaks
    levels = padded.reshape(count, _STRETCH).max(axis=1)
    before = np.concatenate(([0.0], levels[:-1]))
    attacks = np.sort(levels[(levels > _ATTACK * before) & (levels > _FAINT * levels.max())])
    if not attacks.size:
        return float(levels.max(initial=0.0))
    return float(attacks[attacks.size - 1 - int(_RARE * attacks.size)])


def _limited(
    mix: Signal, gain_db: float, ceiling_db: float, bed: Signal | None
) -> tuple[Signal, Signal | None]:
    """Return the mix with a gain and limited, and the gain of the limiter (N,), if it works."""
    raised = _raised(mix, gain_db, bed)
    curve = limiting_gain(raised, 10 ** (ceiling_db / 20))
    return (raised, None) if curve is None else (raised * curve[:, None], curve)


def _measured(out: Signal, loudness: float, gain_db: float, limited_db: float) -> Mastered:
    """Return a track as it is written; rounding to 24 bits does not change its loudness."""
    samples = np.rint(out * FULL_SCALE).astype("<i4")
    written = samples / FULL_SCALE
    return Mastered(
        samples=samples,
        lufs=loudness,
        true_peak_db=decibels(true_peak(written)),
        gain_db=float(gain_db),
        limited_db=limited_db,
    )


def limiting_gain(stereo: Signal, ceiling: float) -> Signal | None:
    """Return the gain (N,) that keeps a mix below a ceiling, None where it is below.

    One gain for both sides: silence stays silence, every onset stays on its sample, and parts far
    from any peak are not changed.

    Args:
        stereo: (N, 2).
        ceiling: of peaks, between samples too.
    """
    peaks = true_peaks(stereo, 0.5 * ceiling)
    return None if peaks.max(initial=0.0) <= ceiling else limiter_gain(peaks, ceiling)
