"""Sound levels: a track's loudness by time, channel and band, and how those of two tracks differ.

Levels are far apart only where it can be heard: a cell counts against the loudest one of its window
and against silence.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pipeline.production.goldens.sound_onsets import RATE, SILENCE

Levels = tuple[tuple[tuple[float, ...], ...], ...]
"""Of windows, of rows (left, right, both), of bands [dBFS]."""

BANDS: Final = (0, 250, 1000, 4000)
"""Lower edges of the bands [Hz]; the last one ends at half the sample rate."""

CHANNELS: Final = ("left", "right")

TOLERANCE: Final = 0.3
"""Of a level [dB]. On another class of processor levels differ by less than 0.1; the strengths and
places that the layer of motion lets pass change them by up to 0.15."""

MAX_WINDOWS: Final = 600
"""Of a long sound, whose windows are longer."""

_WINDOW: Final = round(0.1 * RATE)

_MASKING: Final = 1e-3
"""Share of the power of the loudest cell of a window below which others are not heard."""

_HEARD: Final = 10.0
"""Ratio to the masked power above which a level changes by as much as its sound."""

_UNIFORM: Final = 0.5
"""Spread of a change that is the same everywhere [dB]."""


def window_of(samples: int) -> int:
    """Return the length of the windows of a sound [samples]."""
    return _WINDOW * max(1, -(-samples // (_WINDOW * MAX_WINDOWS)))


def levels_of(sides: NDArray[np.floating[Any]], window: int) -> Levels:
    """Return the levels of a sound (2, N) in windows: left, right and both together.

    Both together differ where one channel is inverted or late.
    """
    return tuple(
        tuple(map(tuple, _band_levels(sides[:, first : first + window], window).tolist()))
        for first in range(0, sides.shape[1], window)
    )


def _band_levels(sides: NDArray[np.floating[Any]], size: int) -> NDArray[np.float64]:
    """Return the levels (rows, bands) of a block (2, N) of at most `size` samples [dBFS]."""
    block = np.vstack([sides, sides.mean(axis=0)]).astype(np.float64)
    power = 2.0 * np.abs(np.fft.rfft(block, size)) ** 2 / size**2
    edges = [round(edge * size / RATE) for edge in BANDS]
    return decibels(np.add.reduceat(power, edges, axis=1))


def decibels(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return levels [dBFS] of mean squares, at least silence, to a tenth."""
    return np.maximum(np.round(10.0 * np.log10(np.maximum(power, 1e-12)), 1), SILENCE)


def level_changes(then: NDArray[np.float64], now: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the audible changes of levels (windows, ...) [dB]."""
    floor = _floor(then)
    return 10.0 * np.log10((10 ** (now / 10) + floor) / (10 ** (then / 10) + floor))


def _floor(levels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean square that counts as nothing in each window (windows, 1, ...)."""
    power = 10 ** (levels / 10)
    loudest = power.max(axis=tuple(range(1, power.ndim)), keepdims=True, initial=0.0)
    return np.asarray(10 ** (SILENCE / 10) + _MASKING * loudest)


def even_change(then: NDArray[np.float64], now: NDArray[np.float64]) -> float:
    """Return the change of all that is heard [dB] if it is the same everywhere, else 0."""
    heard = 10 ** (then / 10) > _HEARD * _floor(then)
    amounts = (now - then)[heard]
    if not amounts.size:
        return 0.0
    middle = float(np.median(amounts))
    even = bool(np.abs(amounts - middle).max() < _UNIFORM)
    return middle if even and abs(middle) > TOLERANCE else 0.0


def level_differences(then: Levels, now: Levels, seconds: float) -> list[str]:
    """Return the differences of levels from their golden as text, one per channel.

    Args:
        then: of the golden.
        now: of the film.
        seconds: length of a window [s].
    """
    count = min(len(then), len(now))
    if not count:
        return []
    old, new = np.array(then[:count]), np.array(now[:count])
    changes = level_changes(old, new)
    if not (np.abs(changes) > TOLERANCE).any():
        return []
    if even := even_change(old, new):
        return [f"the sound is {loudness_text(even)} throughout"]
    found: list[str] = []
    for row, name in enumerate((*CHANNELS, "")):
        beyond = np.abs(changes[:, row]) > TOLERANCE
        if not beyond.any() or (not name and found):
            continue
        channel = f"the {name} channel is" if name else "both channels together are"
        text = _row_text(changes[:, row], old[:, row], new[:, row], seconds)
        found.append(f"{channel} {text}")
    return found


def _row_text(
    changes: NDArray[np.float64],
    old: NDArray[np.float64],
    new: NDArray[np.float64],
    seconds: float,
) -> str:
    """Return the change of a channel, as text: changes and levels are (windows, bands)."""
    if (new <= SILENCE).all():
        return "silent"
    if even := even_change(old, new):
        return f"{loudness_text(even)} throughout"
    beyond = np.abs(changes) > TOLERANCE
    windows = np.flatnonzero(beyond.any(axis=1))
    first = int(windows[0])
    band = int(np.argmax(np.abs(changes[first])))
    text = (
        f"{loudness_text(float(changes[first, band]))} from {first * seconds:.1f} to "
        f"{(first + 1) * seconds:.1f} s {band_text(band)}"
    )
    if len(windows) > 1:
        most, where = map(int, np.unravel_index(np.argmax(np.abs(changes)), changes.shape))
        change = loudness_text(float(changes[most, where]))
        text += (
            f"; {len(windows)} of {len(changes)} stretches differ, most the one at "
            f"{most * seconds:.1f} s, {change} {band_text(where)}"
        )
    return text


def loudness_text(change: float) -> str:
    """Return a change of a level as text."""
    return f"{abs(change):.1f} dB {'louder' if change > 0 else 'softer'}"


def band_text(band: int) -> str:
    """Return a band as text."""
    if band == 0:
        return f"below {BANDS[1]} Hz"
    if band == len(BANDS) - 1:
        return f"above {BANDS[band]} Hz"
    return f"between {BANDS[band]} and {BANDS[band + 1]} Hz"


def level_rows(levels: Sequence[Sequence[Sequence[float]]]) -> Iterator[tuple[int, list[float]]]:
    """Yield number and levels of the windows that are not silent."""
    for k, rows in enumerate(levels):
        flat = [level for row in rows for level in row]
        if max(flat) > SILENCE:
            yield k, flat


def levels_from(rows: dict[int, list[float]], count: int) -> Levels:
    """Return the levels of `count` windows that `level_rows` told."""
    bands, silent = len(BANDS), [SILENCE] * (len(CHANNELS) + 1) * len(BANDS)
    return tuple(
        tuple(tuple(flat[first : first + bands]) for first in range(0, len(silent), bands))
        for flat in (rows.get(k, silent) for k in range(count))
    )
