"""Pulse: the even grid on which the events of a piece fall by themselves, where they do.

The grid is the one that chance explains worst: of N onsets, K lie within half a frame of a grid
of unit u frames, where chance would leave N / u of them. The binomial tail of that, times the
number of grids that were tried, has to be small.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import log, pi

import numpy as np
from numpy.typing import NDArray
from scipy.special import rel_entr

Array = NDArray[np.float64]

SHARE_ON_GRID = 0.95
"""Share of the onsets that has to lie within half a frame of the grid of a pulse."""

# Fewer onsets make no pulse: any few lie on some grid.
_MIN_ONSETS = 8
# Greatest probability of a grid by chance, all tried ones together.
_MAX_CHANCE = 1e-4
# Range of the unit of the grid [s], and its least length [frames].
_SHORTEST, _LONGEST, _MIN_FRAMES = 1 / 8, 2.0, 2.0
# A coarse search looks at so many onsets, so that hours cost no more than minutes.
_SEARCHED = 192
# Greatest phase by which neighbouring units differ over the onsets searched [frames].
_PHASE_STEP = 0.2
# The tempo of the beat that is nearest to this is chosen [1/min].
_TYPICAL_TEMPO = 110.0
_MAX_DENOMINATOR = 48


@dataclass(frozen=True, slots=True)
class Pulse:
    """An even grid of beats.

    Attributes:
        beat: length of a beat [frames].
        start: the beat of the first onset [frames from the start of the film].
    """

    beat: Fraction
    start: Fraction


def fit_pulse(frames: NDArray[np.int64], rate: Fraction) -> Pulse | None:
    """Return the pulse of onsets; None if they have none.

    Args:
        frames: of all onsets, from 0, sorted; several of one frame count once.
        rate: frames a second.
    """
    frames = np.unique(frames)
    if frames.size < _MIN_ONSETS:
        return None
    # The most significant unit of the first onsets, refined by all.
    first = frames[:_SEARCHED].astype(float)
    span = max(first[-1] - first[0], 1.0)
    shortest = max(_SHORTEST * float(rate), _MIN_FRAMES)
    longest = min(_LONGEST * float(rate), span / 3)
    if longest <= shortest or np.median(np.diff(frames)) > longest:
        return None
    count = int(np.ceil((1 / shortest - 1 / longest) * span / _PHASE_STEP)) + 1
    units = 1 / np.linspace(1 / shortest, 1 / longest, count)
    chances = _log_chances(first, units, _phases(first, units))
    order = np.argsort(chances, kind="stable")[:12]
    fits = [_refined(frames, float(units[k])) for k in order]
    found = [fit for fit in fits if fit is not None]
    if not found:
        return None
    log_chance, unit, start = min(found, key=lambda fit: (round(fit[0], 6), -fit[1]))
    if log_chance + log(count) > log(_MAX_CHANCE):
        return None
    # The piece begins with its first onset.
    steps = round((int(frames[0]) - start) / unit)
    return Pulse(_beat(unit, rate), start + steps * unit)


def _phases(frames: Array, units: Array) -> Array:
    """Return the offsets of the grids of units that fit the onsets: (U,) [frames]."""
    turns = np.exp(2j * pi * frames / units[:, None]).sum(axis=1)
    return np.asarray(np.angle(turns) / (2 * pi) * units)


def _phase(frames: Array, unit: float) -> float:
    return float(_phases(frames, np.array([unit]))[0])


def _distances(frames: Array, unit: float | Array, start: float | Array) -> Array:
    steps = np.rint((frames - start) / unit)
    return np.asarray(frames - start - steps * unit)


def _log_chances(frames: Array, units: Array, starts: Array) -> Array:
    """Return the logarithms of the chances of as many onsets on grids (Chernoff's bound): (U,).

    Source: Hoeffding 1963, (2.1).

    Args:
        frames: (N,) of the onsets.
        units: (U,) of the grids [frames], above 1.
        starts: (U,) of the grids [frames].
    """
    distances = _distances(frames, units[:, None], starts[:, None])
    share = (np.abs(distances) <= 0.5 + 1e-9).mean(axis=1)
    chance = 1 / units
    divergence = rel_entr(share, chance) + rel_entr(1 - share, 1 - chance)
    # A grid may be at any of its phases.
    return np.where(share <= chance, 0.0, np.log(units) - frames.size * divergence)


def _refined(frames: NDArray[np.int64], unit: float) -> tuple[float, Fraction, Fraction] | None:
    """Return chance, unit and start of the grid near a unit; None if too few onsets are on it."""
    onsets = frames.astype(float)
    start, used = _phase(onsets[:_SEARCHED], unit), min(_SEARCHED, onsets.size)
    while True:
        part = onsets[:used]
        for _ in range(3):
            steps = np.rint((part - start) / unit)
            near = np.abs(part - start - steps * unit) <= min(1.0, unit / 3)
            if near.sum() < _MIN_ONSETS or np.ptp(steps[near]) < 2:
                return None
            unit, start = (float(value) for value in np.polyfit(steps[near], part[near], 1))
            if not unit > 1:
                return None
        if used == onsets.size:
            break
        used = min(2 * used, onsets.size)
    length = (onsets[-1] - onsets[0]) / unit
    for tolerance in (0.5, 0.25, 0.1, 0.02):
        simple = simplest_fraction(unit - tolerance / length, unit + tolerance / length)
        for phase in _simple_phases(onsets, float(simple)):
            distances = _distances(onsets, float(simple), float(phase))
            if (np.abs(distances) <= 0.5 + 1e-9).mean() >= SHARE_ON_GRID:
                of_grid = np.array([float(simple)]), np.array([float(phase)])
                return float(_log_chances(onsets, *of_grid)[0]), simple, phase
    return None


def _simple_phases(onsets: NDArray[np.float64], unit: float) -> list[Fraction]:
    """Return phases near the best, whole frames first, then halves and quarters."""
    best = _phase(onsets, unit)
    middle = best + float(np.median(_distances(onsets, unit, best)))
    return [Fraction(round(middle * k), k) for k in (1, 2, 4)]


def _beat(unit: Fraction, rate: Fraction) -> Fraction:
    """Return the length of the beat of which the unit of a grid is a part or a multiple."""
    candidates = [unit * factor for factor in (Fraction(1, 4), Fraction(1, 2), 1, 2, 4)]
    return min(
        candidates,
        key=lambda frames: (abs(log(float(60 * rate / frames) / _TYPICAL_TEMPO)), frames),
    )


def simplest_fraction(low: float, high: float) -> Fraction:
    """Return the fraction of least denominator within a range of positive numbers."""
    for denominator in range(1, _MAX_DENOMINATOR + 1):
        numerator = int(np.ceil(low * denominator - 1e-12))
        if numerator <= high * denominator + 1e-12:
            return Fraction(numerator, denominator)
    return Fraction((low + high) / 2).limit_denominator(1000)


def nearest_phase(
    frames: NDArray[np.int64], unit: Fraction, start: Fraction, tick: Fraction
) -> Fraction:
    """Return the start of a grid, moved by at most a frame so that onsets are near it.

    Causes are shown up to a frame after they happen, and hands touch just before their beat. The
    start is moved no further than serves as many as possible of the onsets within a frame of it.

    Args:
        frames: of the onsets, from 0.
        unit: of the grid [frames].
        start: of the grid [frames].
        tick: of which the move is a multiple [frames].
    """
    distances = _distances(frames.astype(float), float(unit), float(start))
    near = np.sort(distances[np.abs(distances) <= 1.0 + 1e-9])
    if not near.size:
        return start
    # An onset is within half a frame of all starts from its lower edge to its upper one, so the
    # first start that serves most of them is at an edge of one.
    lower = np.ceil((near - 0.5) / float(tick) - 1e-6)
    upper = np.floor((near + 0.5) / float(tick) + 1e-6)
    moves = np.unique(np.concatenate(([0.0], lower, upper)))
    least = -float(min(start / tick, 1 / tick))
    moves = moves[(moves >= least) & (moves <= float(1 / tick))]
    moves = moves[np.argsort(np.abs(moves), kind="stable")]
    first = np.searchsorted(near, moves * float(tick) - 0.5 - 1e-9, "left")
    last = np.searchsorted(near, moves * float(tick) + 0.5 + 1e-9, "right")
    return start + int(moves[np.argmax(last - first)]) * tick
