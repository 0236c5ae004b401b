"""What a run and its manifest say of the sound track."""

from __future__ import annotations

import math
from typing import Any

from audio.modal import WavReport


def loudness_told(wav: WavReport) -> str:
    """Return how loud a track is, in words."""
    if wav.peak_db == -math.inf:
        return "silent"
    peak = f"true peak {wav.true_peak_db:.1f} dB"
    return f"loud {wav.lufs:.1f} LUFS, {peak}" if wav.lufs > -math.inf else peak


def facts_of_track(wav: WavReport) -> dict[str, Any]:
    """Return what the manifest says of the track; what silence has not is null."""
    return {
        "samples": wav.samples,
        "lufs": _told(wav.lufs),
        "true_peak_db": _told(wav.true_peak_db),
        "peak_db": _told(wav.peak_db),
        "gain_db": _told(wav.gain_db),
        "limited_db": _told(wav.limited_db),
    }


def _told(decibels: float) -> float | None:
    return round(decibels, 2) if math.isfinite(decibels) else None
