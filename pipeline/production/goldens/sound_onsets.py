"""Sound onsets: starts of sounds in a track, and how those of two tracks match."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

RATE: Final = 48_000
"""Rate of the sounds that are compared [samples/s]."""

_HOP: Final = 0.005
"""Time step of the envelope [s]."""

_RISE_HOPS: Final = 4
"""Hops over which a rise is measured."""

_SILENCE: Final = -70.0
"""Level of silence [dBFS]."""

MIN_RISE: Final = 4.0
"""Least rise of an onset [dB]."""

CLEAR_RISE: Final = 9.0
"""Least rise of an onset that must be found again [dB]."""

_MAX_SHIFT: Final = 6
"""Largest shift of a whole track that is detected [frames]."""


@dataclass(frozen=True, slots=True)
class Onset:
    """The start of a sound: its time [s] and its rise in level [dB]."""

    time: float
    rise: float


def onsets_of(heard: NDArray[np.float64]) -> tuple[Onset, ...]:
    """Return the onsets in a sound (N,) at `RATE`."""
    hop = round(_HOP * RATE)
    count = len(heard) // hop
    power = np.mean(heard[: count * hop].reshape(count, hop) ** 2, axis=1)
    level = np.maximum(10.0 * np.log10(np.maximum(power, 1e-12)), _SILENCE)
    before = np.concatenate([np.full(_RISE_HOPS, _SILENCE), level])
    # The loudest of the hops before, because the tremolo of a lasting sound is no onset.
    quiet = np.max([before[k : k + count] for k in range(_RISE_HOPS)], axis=0)
    rise = level - quiet
    found = []
    for k in np.flatnonzero(rise >= MIN_RISE).tolist():
        if k and rise[k - 1] >= MIN_RISE:
            continue  # Still the same onset.
        top = float(level[k : k + 3].max() - quiet[k])
        found.append(Onset(round(k * _HOP, 3), round(top, 1)))
    return tuple(found)


def unmatched_onsets(
    then: Sequence[Onset], now: Sequence[Onset], tolerance: float
) -> tuple[list[Onset], list[Onset]]:
    """Return the clear onsets that are gone, and those that are new.

    Args:
        then: of the golden.
        now: of the film.
        tolerance: of the time of an onset [s].
    """
    return _without_match(then, now, tolerance), _without_match(now, then, tolerance)


def _without_match(
    onsets: Sequence[Onset], others: Sequence[Onset], tolerance: float
) -> list[Onset]:
    times = np.array([onset.time for onset in others])
    # Times are multiples of a hop.
    bound = max(tolerance, _HOP) + 1e-9
    return [
        onset
        for onset in onsets
        if onset.rise >= CLEAR_RISE and not (np.abs(times - onset.time) < bound).any()
    ]


def best_shift(then: Sequence[Onset], now: Sequence[Onset], frame: float) -> int:
    """Return the delay of the sound in frames if it explains nearly all differences, else 0."""

    def mismatches(late: int) -> int:
        moved = [Onset(onset.time + late * frame, onset.rise) for onset in then]
        gone, new = unmatched_onsets(moved, now, 2 * _HOP)
        return len(gone) + len(new)

    best = min(range(-_MAX_SHIFT, _MAX_SHIFT + 1), key=lambda late: (mismatches(late), abs(late)))
    return best if mismatches(best) < mismatches(0) / 4 else 0
