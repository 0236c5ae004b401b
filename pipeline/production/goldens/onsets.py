"""Onsets: when sounds begin, found in what is heard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

_HOP: Final = 0.005
"""Of the envelope [s]."""

_BEFORE: Final = 4
"""Hops over which a rise is measured."""

_FLOOR: Final = -70.0
"""Below it is silence [dB of full scale]."""

WEAK: Final = 4.0
"""The least rise that is kept [dB]."""

CLEAR: Final = 9.0
"""The least rise that must be found again [dB]: what is weak may be there and not there."""

_REACH: Final = 6
"""Frames by which a whole track may have been moved."""


@dataclass(frozen=True, slots=True)
class Onset:
    """The begin of a sound: its time [s] and by how much it becomes louder [dB]."""

    time: float
    rise: float


def onsets_of(heard: NDArray[np.float64], rate: int) -> tuple[Onset, ...]:
    """Return the onsets in a sound (N,) of `rate` samples a second."""
    hop = round(_HOP * rate)
    count = len(heard) // hop
    power = np.mean(heard[: count * hop].reshape(count, hop) ** 2, axis=1)
    level = np.maximum(10.0 * np.log10(np.maximum(power, 1e-12)), _FLOOR)
    before = np.concatenate([np.full(_BEFORE, _FLOOR), level])
    # The loudest of the hops before: the tremble of a sound that lasts is no onset.
    quiet = np.max([before[k : k + count] for k in range(_BEFORE)], axis=0)
    rise = level - quiet
    found = []
    for k in np.flatnonzero(rise >= WEAK).tolist():
        if k and rise[k - 1] >= WEAK:
            continue  # still the same one
        top = float(level[k : k + 3].max() - quiet[k])
        found.append(Onset(round(k * _HOP, 3), round(top, 1)))
    return tuple(found)


def unmatched(
    then: Sequence[Onset], now: Sequence[Onset], within: float
) -> tuple[list[Onset], list[Onset]]:
    """Return the clear onsets that are gone, and those that are new.

    Args:
        then: of the golden.
        now: of the film.
        within: how far two may lie apart that are one [s].
    """
    return _lonely(then, now, within), _lonely(now, then, within)


def _lonely(some: Sequence[Onset], others: Sequence[Onset], within: float) -> list[Onset]:
    times = np.array([onset.time for onset in others])
    # A hop is the unit in which times are known.
    bound = max(within, _HOP) + 1e-9
    return [
        onset
        for onset in some
        if onset.rise >= CLEAR and not (np.abs(times - onset.time) < bound).any()
    ]


def best_shift(then: Sequence[Onset], now: Sequence[Onset], frame: float) -> int:
    """Return by how many frames the sound is late if that explains nearly all, else 0."""

    def lonely(late: int) -> int:
        moved = [Onset(onset.time + late * frame, onset.rise) for onset in then]
        gone, new = unmatched(moved, now, 2 * _HOP)
        return len(gone) + len(new)

    best = min(range(-_REACH, _REACH + 1), key=lambda late: (lonely(late), abs(late)))
    return best if lonely(best) < lonely(0) / 4 else 0
