"""Sound onsets: starts of sounds in a track, and how those of two tracks match."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

RATE: Final = 48_000
"""Rate of the sounds that are compared [samples/s]."""

SILENCE: Final = -70.0
"""Level of silence [dBFS]."""

EXACT: Final = 0.5
"""Of the instant of an onset [samples]. What the layer of motion lets pass moves it by less than
0.1."""

MIN_RISE: Final = 4.0
"""Least rise of an onset [dB]."""

CLEAR_RISE: Final = 9.0
"""Least rise of an onset that must be found again [dB]."""

_HOP: Final = 0.005
"""Time step of the envelope [s]."""

_RISE_HOPS: Final = 4
"""Hops over which a rise is measured."""

_BEFORE, _AFTER = round(0.002 * RATE), round(0.006 * RATE)
"""Window around the instant of an onset [samples]."""

_INSTANT_SHARE: Final = 0.1
"""Share of the energy in that window that has come by the instant: below the 0.25 of an even
sound, so that the search moves towards the attack."""

_MAX_ROUNDS: Final = 12

_MAX_MOVE: Final = round(0.015 * RATE)
"""Largest distance of an instant from the start of its hop [samples]."""

_BODY: Final = round(0.03 * RATE)
"""Length from the start of its hop over which the level of an onset is measured [samples]."""

_MAX_SHIFT: Final = 0.5
"""Largest shift of a whole track that is detected [s]."""

_COMPARED: Final = 100
"""Onsets from the start that tell whether a track is late."""

_EVEN: Final = 0.2
"""Of a shift of the whole track by whole samples [samples]: instants are known to a tenth."""

_COMMON_SHARE: Final = 0.75
"""Share of the onsets that a common shift explains."""


@dataclass(frozen=True, slots=True)
class Onset:
    """The start of a sound.

    Attributes:
        time: to about a hop [s].
        rise: in level [dB].
        instants: in each channel [samples], None where it has no attack; empty if not measured.
        levels: in each channel after the start [dBFS]; empty if not measured.
    """

    time: float
    rise: float
    instants: tuple[float | None, ...] = ()
    levels: tuple[float, ...] = ()

    @property
    def moment(self) -> float:
        """Its time [s], as exact as it is known."""
        known = [instant for instant in self.instants if instant is not None]
        return min(known) / RATE if known else self.time


def onsets_of(heard: NDArray[np.floating[Any]]) -> tuple[Onset, ...]:
    """Return the onsets in a sound (N,) at `RATE`, to about a hop."""
    hop = round(_HOP * RATE)
    count = len(heard) // hop
    power = np.mean(np.square(heard[: count * hop].reshape(count, hop)), axis=1, dtype=np.float64)
    level = np.maximum(10.0 * np.log10(np.maximum(power, 1e-12)), SILENCE)
    before = np.concatenate([np.full(_RISE_HOPS, SILENCE), level])
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


def measured_onsets(sides: NDArray[np.floating[Any]]) -> tuple[Onset, ...]:
    """Return the onsets in a sound (channels, N) with their instants and levels."""
    return tuple(
        Onset(
            onset.time,
            onset.rise,
            tuple(_rounded(instant_of(side, onset)) for side in sides),
            tuple(_level_of(side, onset) for side in sides),
        )
        for onset in onsets_of(sides.mean(axis=0))
    )


def _rounded(instant: float | None) -> float | None:
    return None if instant is None else round(instant, 1)


def _level_of(side: NDArray[np.floating[Any]], onset: Onset) -> float:
    start = round(onset.time * RATE)
    power = float(np.sum(side[start : start + _BODY].astype(np.float64) ** 2)) / _BODY
    return max(round(10.0 * float(np.log10(max(power, 1e-12))), 1), SILENCE)


def instant_of(sound: NDArray[np.floating[Any]], onset: Onset) -> float | None:
    """Return the instant of an onset [samples], to a fraction of a sample.

    A shift of the sound by whole samples shifts it by as many; a gain leaves it.

    Args:
        sound: (N,).
        onset: to about a hop.

    Returns:
        None for a sound that swells instead of starting, and for silence.
    """
    # The samples around the onset, with silence before the start and after the end of the sound.
    home = _MAX_MOVE + _BEFORE
    first = round(onset.time * RATE) - home
    energy = np.zeros(home + _MAX_MOVE + _AFTER)
    low, high = max(first, 0), min(first + energy.size, sound.size)
    energy[low - first : high - first] = sound[low:high].astype(np.float64) ** 2
    if energy.mean() <= 10 ** (SILENCE / 10):
        return None
    came = np.concatenate([[0.0], np.cumsum(energy)])
    instant = float(home)
    for _ in range(_MAX_ROUNDS):
        start = round(instant) - _BEFORE
        window = came[start : start + _BEFORE + _AFTER + 1]
        wanted = window[0] + _INSTANT_SHARE * (window[-1] - window[0])
        instant = start + _crossing(window, float(wanted))
        if abs(instant - home) > _MAX_MOVE:
            return None
        if round(instant) - _BEFORE == start:
            break
    return first + instant


def _crossing(rising: NDArray[np.float64], value: float) -> float:
    """Return the index at which a rising series reaches a value, between its entries too."""
    k = int(np.searchsorted(rising, value))
    if k == 0:
        return 0.0
    return k - 1 + float((value - rising[k - 1]) / (rising[k] - rising[k - 1]))


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


def common_shift(then: Sequence[Onset], now: Sequence[Onset]) -> float:
    """Return the delay of the sound [s] if it explains nearly all differences, else 0.

    Measured onsets move by whole samples; by less, an attack has another shape.
    """
    exact = all(onset.instants for onset in (*then, *now))
    step, bound = (1.0 / RATE, _EVEN / RATE) if exact else (2.0 * _HOP, 2.0 * _HOP)
    old, new = (
        np.array([onset.moment if exact else onset.time for onset in onsets])
        for onsets in (then[:_COMPARED], now)
    )
    new = new[new <= old[-1] + _MAX_SHIFT] if old.size else new
    if not old.size or not new.size:
        return 0.0
    delays = (new[None, :] - old[:, None]).ravel()
    delays = delays[np.abs(delays) <= _MAX_SHIFT]

    def explained(late: float) -> int:
        """Return how many onsets of the golden are found again that much later."""
        return int((np.abs(new[None, :] - old[:, None] - late) <= bound).any(axis=1).sum())

    if explained(0.0) >= _COMMON_SHARE * old.size:
        return 0.0
    # Equal delays once, the smallest first.
    tried = sorted(set(np.rint(delays / step).astype(int).tolist()), key=abs)
    best = max(tried, key=lambda k: explained(k * step), default=0)
    return best * step if explained(best * step) >= _COMMON_SHARE * old.size else 0.0
