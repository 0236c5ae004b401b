"""Same way: a path that was gone, at the speeds of least jerk.

The path stays, p(s), and so does what was before and after, so that place, speed and acceleration
at both ends are as they were. Sought is when the hand is where, s(t), never backward, with the
least of what `jerk.jerk_of` measures:

    C = ∫ |d³/dt³ p(s(t))|² dt        over s(t) with s'(t) >= 0        [m²/s⁵]

s is a spline of degree five, with knots no closer than the filter of the measure lets through. Its
control points are sums of increments, of which none may be negative: then s never falls. Each step
of Gauss and Newton is a problem of least squares without negative unknowns, and as the splines
that never fall are a convex set, any part of the step stays within it.

A path over its length has corners where a hand turned back or rested. So s is ∫ √(|v|² + ε²) dt
along what was danced: nearly length for a small ε, nearly time for a large one, and smooth with
both. They are names of the same places; which of them a spline can follow better is tried.

Source: Flash and Hogan 1985, whose measure it is; Lawson and Hanson 1974, chapter 23, for least
squares without negative unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline
from scipy.optimize import nnls

from pipeline.simulation.curves import ease
from pipeline.simulation.dancers.jerk import (
    CUTOFF,
    RATE,
    low_passed,
    resampled,
    third_derivative,
    total_square_jerk,
)
from pipeline.simulation.spatial import Array

DEGREE = 5
"""Of the splines: its third derivative is smooth."""

SLOW = (0.01, 1.0)
"""ε, in mean speeds of the movement: as length on straight paths, and as time where it turns."""

FINER, TABLE = 3, 16
"""How much finer than the measure samples of a timing are, and those of the table of a path."""

ROUNDS, LESS = 40, 1e-4
"""Most steps of Gauss and Newton, and the share below which one is the last."""

HEAVY = 1e4
"""Weight of what has to hold, in a problem of least squares."""


@dataclass(frozen=True, eq=False)
class RetimedPath:
    """The same way, at the speeds of least jerk.

    Attributes:
        integral: C [m²/s⁵].
        danced: C of the way as it was danced [m²/s⁵].
        times: (n,) at 60 Hz, from the begin to the end of the movement [s].
        places: (n, 3) at these times [m].
    """

    integral: float
    danced: float
    times: Array
    places: Array


def retime_for_minimum_jerk(times: Array, p: Array, begin: float, end: float) -> RetimedPath:
    """Returns the timing of least jerk of a movement from `begin` to `end`, on its own path.

    It never has more than what was danced, which is one of the timings that are compared.

    Args:
        times: (K,) at equal distances [s].
        p: (K, 3) of the hand [m].
        begin: [s].
        end: [s].
    """
    t, x = resampled(times, p)
    x = low_passed(x)
    rows = np.flatnonzero((t >= begin - 1e-9) & (t <= end + 1e-9))
    if len(rows) < 2:
        return RetimedPath(0.0, 0.0, t[rows], x[rows])
    danced = total_square_jerk(x, rows)
    best = RetimedPath(danced, danced, t[rows], x[rows])
    for slow in SLOW:
        problem = _Problem.of(t, x, begin, end, slow)
        try:
            s = problem.descend(problem.start())
        except RuntimeError:
            # Rounding can let least squares without negative unknowns go round in a circle.
            continue
        places = x.copy()
        places[rows] = problem.path.at(np.interp(t[rows], problem.times, s))
        integral = total_square_jerk(places, rows)
        if integral < best.integral:
            best = RetimedPath(integral, danced, t[rows], places[rows])
    return best


@dataclass(frozen=True, eq=False)
class _Path:
    """A path over s.

    Attributes:
        place: x(t), a spline.
        pace: s'(t), a spline: √(|v|² + ε²) [m/s].
        along: s(t), its integral [m].
        table: (n,) times between which they are looked up [s].
        lengths: (n,) s there [m].
    """

    place: BSpline
    pace: BSpline
    along: BSpline
    table: Array
    lengths: Array

    @classmethod
    def of(cls, t: Array, x: Array, begin: float, end: float, slow: float) -> _Path:
        """Take a path from what was danced, x (n, 3) at times t (n,), with ε in mean speeds."""
        place = make_interp_spline(t, x, DEGREE)
        table = np.linspace(begin, end, int((end - begin) * RATE) * TABLE + 2 * DEGREE)
        speed = np.linalg.norm(place(table, 1), axis=1)
        least = max(slow * float(speed.mean()), 1e-6)
        pace = make_interp_spline(table, np.hypot(speed, least), DEGREE)
        along = pace.antiderivative()
        return cls(place, pace, along, table, along(table))

    def when(self, s: Array) -> Array:
        """Returns when the hand was at s (n,) as it was danced [s]."""
        t = np.interp(s, self.lengths, self.table)
        for _ in range(3):
            t = np.clip(t - (self.along(t) - s) / self.pace(t), self.table[0], self.table[-1])
        return t

    def at(self, s: Array) -> Array:
        """Return places (n, 3) at s (n,)."""
        return self.place(self.when(s))

    def slope(self, s: Array) -> Array:
        """Return dp/ds (n, 3) at s (n,)."""
        t = self.when(s)
        return self.place(t, 1) / self.pace(t)[:, None]


@dataclass(frozen=True, eq=False)
class _Problem:
    """What is to become least.

    Attributes:
        path: on which the hand stays.
        slow: ε in mean speeds.
        times: (n,) of the samples that are measured [s].
        danced: (n,) s there, as it was danced.
        outer: (n, 3) part of the weighted jerk that samples before and after have.
        inner: weighted jerk of places at the samples.
        fixed: (n,) s of the control points that the ends decide.
        sums: (n, m) s of a unit of each increment but the last.
        rise: sum of the increments.
    """

    path: _Path
    slow: float
    times: Array
    danced: Array
    outer: Array
    inner: _Differences
    fixed: Array
    sums: Array
    rise: float

    @classmethod
    def of(cls, t: Array, x: Array, begin: float, end: float, slow: float) -> _Problem:
        """State the problem.

        Args:
            t: (n,) times at 60 Hz [s].
            x: (n, 3) as it was danced, with the filter of the measure [m].
            begin: [s].
            end: [s].
            slow: ε in mean speeds.
        """
        path = _Path.of(t, x, begin, end, slow)
        # Finer than the measure, whose differences hardly see what is close to the
        # highest frequency of its samples.
        fine = t[0] + np.arange((len(t) - 1) * FINER + 1) / (FINER * RATE)
        rows = np.flatnonzero((fine >= begin - 1e-9) & (fine <= end + 1e-9))
        at = np.clip(fine[rows], begin, end)
        outer, inner = _weighted(path.place(fine), rows)
        knots = _knots(begin, end)
        basis = BSpline.design_matrix(at, knots, DEGREE).toarray()
        control = np.zeros(basis.shape[1])
        every = BSpline(knots, np.eye(len(control)), DEGREE)
        for when, three in ((begin, slice(0, 3)), (end, slice(-3, None))):
            rates = np.array([every(when, k)[three] for k in range(3)])
            wanted = [path.along(when), path.pace(when), path.pace(when, 1)]
            control[three] = np.linalg.solve(rates, wanted)
        # Those that are free rise from the last one that the begin decides.
        free = basis[:, 3:-3]
        fixed = basis @ control + free.sum(axis=1) * control[2]
        sums = np.cumsum(free[:, ::-1], axis=1)[:, ::-1]
        rise = float(control[-3] - control[2])
        return cls(path, slow, at, path.along(at), outer, inner, fixed, sums, rise)

    def cost(self, s: Array) -> float:
        """Return C of a timing s (n,)."""
        return float((self._jerk(s) ** 2).sum())

    def start(self) -> Array:
        """Return increments near what was danced; over length, near what is least if straight."""
        if self.slow >= 1.0:
            return self._nearest(self.sums, self.danced - self.fixed)
        first, last = self.danced[0], self.danced[-1]
        smooth = ease((self.times - self.times[0]) / (self.times[-1] - self.times[0]))
        return self._nearest(self.sums, first + (last - first) * smooth - self.fixed)

    def descend(self, increments: Array) -> Array:
        """Returns the timing s (n,) to which steps of Gauss and Newton lead."""
        d = increments
        s = self.fixed + self.sums @ d
        cost = self.cost(s)
        for _ in range(ROUNDS):
            slope = self.path.slope(s)
            jerk = self._jerk(s)
            # One column of coordinates after the other.
            change = np.concatenate([self.inner.of(slope[:, [k]] * self.sums) for k in range(3)])
            target = self._nearest(change, change @ d - jerk.T.ravel())
            part = 1.0
            while part > 1e-3:
                other = d + part * (target - d)
                tried = self.fixed + self.sums @ other
                lower = self.cost(tried)
                if lower < cost:
                    break
                part *= 0.5
            else:
                return s
            done = cost - lower < LESS * cost
            d, s, cost = other, tried, lower
            if done:
                break
        return s

    def _jerk(self, s: Array) -> Array:
        """Returns the weighted jerk (n, 3) of a timing."""
        return self.outer + self.inner.of(self.path.at(s))

    def _nearest(self, matrix: Array, wanted: Array) -> Array:
        """Return increments d (m,), none negative, with M d as near b (n,) as can be."""
        scale = float(np.abs(matrix).max()) or 1.0
        n, m = matrix.shape
        # What is left of the rise is the last increment.
        whole = np.full((n + 1, m + 1), HEAVY)
        whole[:n, :m] = matrix / scale
        whole[:n, m] = 0.0
        b = np.append(wanted / scale, HEAVY * self.rise)
        return nnls(whole, b, maxiter=20 * (m + 1))[0][:-1]


@dataclass(frozen=True, eq=False)
class _Differences:
    """Third derivatives of samples, times the roots of the weights of the trapezium rule.

    Attributes:
        root: (n,) of the weights.
        before: how many samples before them are known.
        after: how many after them.
    """

    root: Array
    before: int
    after: int

    def of(self, q: Array) -> Array:
        """Returns those of samples (n, any), with nothing before and after."""
        return self.among(np.pad(q, ((self.before, self.after), (0, 0))))

    def among(self, q: Array) -> Array:
        """Returns those of the samples in the middle, with those before and after."""
        result: Array = third_derivative(q, FINER * RATE)[
            self.before : self.before + len(self.root)
        ]
        return result * self.root[:, None]


def _weighted(x: Array, rows: NDArray[np.int64]) -> tuple[Array, _Differences]:
    """Returns what samples (N, 3) before and after `rows` give to the jerk, and how they do."""
    root = np.full(len(rows), np.sqrt(1.0 / (FINER * RATE)))
    root[[0, -1]] *= np.sqrt(0.5)
    # Differences reach two samples to both sides.
    first, last = max(int(rows[0]) - 4, 0), min(int(rows[-1]) + 4, len(x) - 1)
    inner = _Differences(root, int(rows[0]) - first, last - int(rows[-1]))
    rest = x[first : last + 1].copy()
    rest[rows - first] = 0.0
    return inner.among(rest), inner


def _knots(begin: float, end: float) -> Array:
    """Return knots, clamped, as far apart as the filter lets through."""
    count = max(int(np.ceil((end - begin) * 2.0 * CUTOFF)), 4)
    inner = np.linspace(begin, end, count + 1)
    return np.concatenate([[begin] * DEGREE, inner, [end] * DEGREE])
