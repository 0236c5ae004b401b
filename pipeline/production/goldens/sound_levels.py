"""Sound levels: a track's loudness by time, channel and band, and how those of two tracks differ.

Levels are far apart only where it can be heard: a cell counts against the loudest one of its window
and against silence.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

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

_UNIFORM: Final = 0.5
"""Spread of a change that is the same everywhere [dB]."""


def window_of(samples: int) -> int:
    """Return the length of the windows of a sound [samples]."""
    return _WINDOW * max(1, -(-samples // (_WINDOW * MAX_WINDOWS)))


def levels_of(sides: NDArray[np.float64], window: int) -> Levels:
    """Return the levels of a sound (2, N) in windows: left, right and both together.

    Both together differ where one channel is inverted or late.
    """
    rows = np.vstack([sides, sides.mean(axis=0)])
    count = -(-rows.shape[1] // window)
    rows = np.pad(rows, ((0, 0), (0, count * window - rows.shape[1])))
    return tuple(
        tuple(map(tuple, _band_levels(rows[:, k * window : (k + 1) * window]).tolist()))
        for k in range(count)
    )


def _band_levels(block: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the levels (rows, bands) of a block (rows, N) [dBFS]."""
    size = block.shape[1]
    power = 2.0 * np.abs(np.fft.rfft(block)) ** 2 / size**2
    edges = [round(edge * size / RATE) for edge in BANDS]
    return decibels(np.add.reduceat(power, edges, axis=1))


def decibels(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return levels [dBFS] of mean squares, at least silence, to a tenth."""
    return np.maximum(np.round(10.0 * np.log10(np.maximum(power, 1e-12)), 1), SILENCE)


def level_changes(then: NDArray[np.float64], now: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the audible changes of levels (windows, ...) [dB]."""
    old, new = 10 ** (then / 10), 10 ** (now / 10)
    loudest = old.max(axis=tuple(range(1, old.ndim)), keepdims=True, initial=0.0)
    floor = 10 ** (SILENCE / 10) + _MASKING * loudest
    return 10.0 * np.log10((new + floor) / (old + floor))


def level_differences(then: Levels, now: Levels, seconds: float) -> Iterator[str]:
    """Yield the differences of levels from their golden as text, one per channel.

    Args:
        then: of the golden.
        now: of the film.
        seconds: length of a window [s].
    """
    count = min(len(then), len(now))
    if not count:
        return
    old, new = np.array(then[:count]), np.array(now[:count])
    changes = level_changes(old, new)
    heard = np.maximum(old, new) > SILENCE + 10.0
    sides = slice(0, len(CHANNELS))
    if not (np.abs(changes) > TOLERANCE).any():
        return
    if even := _even_change(changes[:, sides], heard[:, sides]):
        yield f"the sound is {_told(even)} throughout"
        return
    found = False
    for row, name in enumerate((*CHANNELS, "")):
        beyond = np.abs(changes[:, row]) > TOLERANCE
        if not beyond.any() or (not name and found):
            continue
        found = True
        channel = f"the {name} channel is" if name else "both channels together are"
        yield f"{channel} {_row_text(changes[:, row], old[:, row], new[:, row], seconds)}"


def _even_change(changes: NDArray[np.float64], heard: NDArray[np.bool_]) -> float:
    """Return the change [dB] of all that is heard if it is the same everywhere, else 0."""
    amounts = changes[heard]
    # Softer cells change less, because they are masked.
    middle = float(amounts[np.argmax(np.abs(amounts))]) if amounts.size else 0.0
    even = bool(np.abs(amounts - np.median(amounts)).max(initial=0.0) < _UNIFORM)
    return middle if even and abs(middle) > TOLERANCE else 0.0


def _row_text(
    changes: NDArray[np.float64],
    old: NDArray[np.float64],
    new: NDArray[np.float64],
    seconds: float,
) -> str:
    """Return the change of a channel, as text: changes and levels are (windows, bands)."""
    heard = np.maximum(old, new) > SILENCE + 10.0
    if heard.any() and (new <= SILENCE).all():
        return "silent"
    if even := _even_change(changes, heard):
        return f"{_told(even)} throughout"
    beyond = np.abs(changes) > TOLERANCE
    windows = np.flatnonzero(beyond.any(axis=1))
    first = int(windows[0])
    band = int(np.argmax(np.abs(changes[first])))
    text = (
        f"{_told(float(changes[first, band]))} from {first * seconds:.1f} to "
        f"{(first + 1) * seconds:.1f} s {band_text(band)}"
    )
    if len(windows) > 1:
        most, where = np.unravel_index(int(np.argmax(np.abs(changes))), changes.shape)
        text += (
            f"; {len(windows)} of {len(changes)} stretches differ, most the one at "
            f"{most * seconds:.1f} s, {_told(float(changes[most, where]))} {band_text(int(where))}"
        )
    return text


def _told(change: float) -> str:
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
