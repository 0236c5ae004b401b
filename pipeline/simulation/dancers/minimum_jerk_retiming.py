"""Minimum-jerk retiming of a recorded path.

The path p(s) and the motion before and after the movement are kept, and with them position,
velocity and acceleration at both ends. The timing s(t) minimises the cost of `jerk.measure_jerk`:

    C = ∫ |d³/dt³ p(s(t))|² dt        over s(t) with s'(t) >= 0        [m²/s⁵]

s is a spline of degree five with knots no closer than the cut-off of the measurement's filter. Its
control points are cumulative sums of non-negative increments, so s is monotonic. Each Gauss-Newton
step is a non-negative least squares problem; monotonic splines form a convex set, so every
fraction of a step is feasible.

Parametrised by arc length, a path has corners where the hand turned back or rested. So s is
∫ √(|v|² + ε²) dt along the recorded motion: near arc length for a small ε, near time for a large
one, and smooth for both. Both parametrisations are tried, and the better result is kept.

Source: Flash and Hogan 1985 for the cost; Lawson and Hanson 1974, chapter 23, for non-negative
least squares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline
from scipy.optimize import nnls

from pipeline.simulation.curves import ease
from pipeline.simulation.dancers.jerk import (
    CUTOFF_FREQUENCY,
    SAMPLE_RATE,
    filtered_movement,
    third_derivative,
    total_square_jerk,
)
from pipeline.simulation.spatial import Array

DEGREE = 5
"""Degree of the splines: the third derivative is smooth."""

SPEED_FLOORS = (0.01, 1.0)
"""ε per mean speed: near arc length for straight paths, near time for paths that turn back."""

OVERSAMPLING = 3
"""Samples of a timing per sample of the measurement."""

TABLE_OVERSAMPLING = 16
"""Entries of a path's lookup table per sample of the measurement."""

MAX_ITERATIONS = 40
"""Largest number of Gauss-Newton steps."""

RELATIVE_TOLERANCE = 1e-4
"""Relative decrease of the cost below which the search ends."""

CONSTRAINT_WEIGHT = 1e4
"""Weight of the equality constraint in the least squares problem."""


@dataclass(frozen=True, eq=False)
class RetimedPath:
    """Recorded path with minimum-jerk timing.

    Attributes:
        integral: C [m²/s⁵].
        danced: C of the recorded motion [m²/s⁵].
        times: (n,) times at 60 Hz, from start to end of the movement [s].
        places: (n, 3) positions at these times [m].
    """

    integral: float
    danced: float
    times: Array
    places: Array


def retime_for_minimum_jerk(times: Array, p: Array, start: float, end: float) -> RetimedPath:
    """Returns a movement on its own path with minimum-jerk timing.

    C is never above the recorded C: the recorded timing is one of the candidates.

    Args:
        times: (K,) equally spaced times [s].
        p: (K, 3) positions of the hand [m].
        start: start of the movement [s].
        end: end of the movement [s].
    """
    t, x, rows = filtered_movement(times, p, start, end)
    if len(rows) < 2:
        return RetimedPath(0.0, 0.0, t[rows], x[rows])
    danced = total_square_jerk(x, rows)
    best = RetimedPath(danced, danced, t[rows], x[rows])
    for floor in SPEED_FLOORS:
        problem = _Problem.from_motion(t, x, start, end, floor)
        try:
            s = problem.minimise(problem.initial_increments())
        except RuntimeError:
            # Rounding errors can make the active set method cycle.
            continue
        places = x.copy()
        places[rows] = problem.path.at(np.interp(t[rows], problem.times, s))
        integral = total_square_jerk(places, rows)
        if integral < best.integral:
            best = RetimedPath(integral, danced, t[rows], places[rows])
    return best


@dataclass(frozen=True, eq=False)
class _Path:
    """Path parametrised by s.

    Attributes:
        place: spline x(t) [m].
        pace: spline s'(t) = √(|v|² + ε²) [m/s].
        along: s(t), integral of `pace` [m].
        table: (n,) times of the lookup table [s].
        lengths: (n,) s at these times [m].
    """

    place: BSpline
    pace: BSpline
    along: BSpline
    table: Array
    lengths: Array

    @classmethod
    def from_motion(cls, t: Array, x: Array, start: float, end: float, floor: float) -> _Path:
        """Returns the path of positions x (n, 3) at times t (n,), with ε = `floor` × mean speed."""
        place = make_interp_spline(t, x, DEGREE)
        table = np.linspace(
            start, end, int((end - start) * SAMPLE_RATE) * TABLE_OVERSAMPLING + 2 * DEGREE
        )
        speed = np.linalg.norm(place(table, 1), axis=1)
        epsilon = max(floor * float(speed.mean()), 1e-6)
        pace = make_interp_spline(table, np.hypot(speed, epsilon), DEGREE)
        along = pace.antiderivative()
        return cls(place, pace, along, table, along(table))

    def when(self, s: Array) -> Array:
        """Returns the recorded times (n,) at s (n,) [s]."""
        t = np.interp(s, self.lengths, self.table)
        for _ in range(3):
            t = np.clip(t - (self.along(t) - s) / self.pace(t), self.table[0], self.table[-1])
        result: Array = t
        return result

    def at(self, s: Array) -> Array:
        """Returns the positions (n, 3) at s (n,) [m]."""
        result: Array = self.place(self.when(s))
        return result

    def slope(self, s: Array) -> Array:
        """Returns dp/ds (n, 3) at s (n,)."""
        t = self.when(s)
        result: Array = self.place(t, 1) / self.pace(t)[:, None]
        return result


@dataclass(frozen=True, eq=False)
class _Problem:
    """Non-linear least squares problem of a timing.

    Attributes:
        path: path of the hand.
        floor: ε per mean speed.
        times: (n,) times of the samples [s].
        danced: (n,) recorded s at these times [m].
        outer: (n, 3) contribution of the samples before and after to the weighted jerk.
        inner: operator from positions at the samples to weighted jerk.
        fixed: (n,) contribution to s of the control points given by the end states [m].
        sums: (n, m) derivative of s by each increment but the last.
        rise: sum of the increments [m].
    """

    path: _Path
    floor: float
    times: Array
    danced: Array
    outer: Array
    inner: _Differences
    fixed: Array
    sums: Array
    rise: float

    @classmethod
    def from_motion(cls, t: Array, x: Array, start: float, end: float, floor: float) -> _Problem:
        """Returns the problem of a recorded movement.

        Args:
            t: (n,) times at 60 Hz [s].
            x: (n, 3) low-passed positions [m].
            start: start of the movement [s].
            end: end of the movement [s].
            floor: ε per mean speed.
        """
        path = _Path.from_motion(t, x, start, end, floor)
        # Oversampled, since differences attenuate frequencies near the Nyquist frequency.
        fine = t[0] + np.arange((len(t) - 1) * OVERSAMPLING + 1) / (OVERSAMPLING * SAMPLE_RATE)
        rows = np.flatnonzero((fine >= start - 1e-9) & (fine <= end + 1e-9))
        at = np.clip(fine[rows], start, end)
        outer, inner = _weighted_differences(path.place(fine), rows)
        knots = _knots(start, end)
        basis = BSpline.design_matrix(at, knots, DEGREE).toarray()
        control = np.zeros(basis.shape[1])
        splines = BSpline(knots, np.eye(len(control)), DEGREE)
        for when, three in ((start, slice(0, 3)), (end, slice(-3, None))):
            rates = np.array([splines(when, k)[three] for k in range(3)])
            wanted = [path.along(when), path.pace(when), path.pace(when, 1)]
            control[three] = np.linalg.solve(rates, wanted)
        # Free control points rise from the last one given by the start state.
        free = basis[:, 3:-3]
        fixed = basis @ control + free.sum(axis=1) * control[2]
        sums = np.cumsum(free[:, ::-1], axis=1)[:, ::-1]
        rise = float(control[-3] - control[2])
        return cls(path, floor, at, path.along(at), outer, inner, fixed, sums, rise)

    def cost(self, s: Array) -> float:
        """Returns C of a timing s (n,) [m²/s⁵]."""
        return float((self._jerk(s) ** 2).sum())

    def initial_increments(self) -> Array:
        """Returns increments near the recorded timing, or near a minimum-jerk step for small ε."""
        if self.floor >= 1.0:
            return self._nearest(self.sums, self.danced - self.fixed)
        first, last = self.danced[0], self.danced[-1]
        smooth = ease((self.times - self.times[0]) / (self.times[-1] - self.times[0]))
        return self._nearest(self.sums, first + (last - first) * smooth - self.fixed)

    def minimise(self, increments: Array) -> Array:
        """Returns the timing s (n,) found by Gauss-Newton steps with a backtracking line search."""
        d = increments
        s = self.fixed + self.sums @ d
        cost = self.cost(s)
        for _ in range(MAX_ITERATIONS):
            slope = self.path.slope(s)
            jerk = self._jerk(s)
            # Stacked by coordinate.
            change = np.concatenate([self.inner.apply(slope[:, [k]] * self.sums) for k in range(3)])
            target = self._nearest(change, change @ d - jerk.T.ravel())
            step = 1.0
            while step > 1e-3:
                trial = d + step * (target - d)
                trial_s = self.fixed + self.sums @ trial
                lower = self.cost(trial_s)
                if lower < cost:
                    break
                step *= 0.5
            else:
                return s
            converged = cost - lower < RELATIVE_TOLERANCE * cost
            d, s, cost = trial, trial_s, lower
            if converged:
                break
        return s

    def _jerk(self, s: Array) -> Array:
        """Returns the weighted jerk (n, 3) of a timing s (n,)."""
        result: Array = self.outer + self.inner.apply(self.path.at(s))
        return result

    def _nearest(self, matrix: Array, wanted: Array) -> Array:
        """Returns the non-negative increments d (m,) that minimise |M d - b|, with b (n,)."""
        scale = float(np.abs(matrix).max()) or 1.0
        n, m = matrix.shape
        # The last unknown is the last increment; the last row fixes the sum.
        system = np.full((n + 1, m + 1), CONSTRAINT_WEIGHT)
        system[:n, :m] = matrix / scale
        system[:n, m] = 0.0
        b = np.append(wanted / scale, CONSTRAINT_WEIGHT * self.rise)
        result: Array = nnls(system, b, maxiter=20 * (m + 1))[0][:-1]
        return result


@dataclass(frozen=True, eq=False)
class _Differences:
    """Third differences, scaled by the square roots of the trapezoidal weights.

    Attributes:
        root: (n,) square roots of the weights.
        before: number of known samples before the movement.
        after: number of known samples after the movement.
    """

    root: Array
    before: int
    after: int

    def apply(self, q: Array) -> Array:
        """Returns the scaled differences of samples (n, m), with zeros before and after."""
        return self.apply_within(np.pad(q, ((self.before, self.after), (0, 0))))

    def apply_within(self, q: Array) -> Array:
        """Returns the scaled differences (n, m) of samples with known neighbours."""
        result: Array = third_derivative(q, OVERSAMPLING * SAMPLE_RATE)[
            self.before : self.before + len(self.root)
        ]
        return result * self.root[:, None]


def _weighted_differences(x: Array, rows: NDArray[np.int64]) -> tuple[Array, _Differences]:
    """Returns the weighted jerk of the samples (N, 3) outside `rows`, and the operator."""
    root = np.full(len(rows), np.sqrt(1.0 / (OVERSAMPLING * SAMPLE_RATE)))
    root[[0, -1]] *= np.sqrt(0.5)
    # Differences reach two samples to each side.
    first, last = max(int(rows[0]) - 4, 0), min(int(rows[-1]) + 4, len(x) - 1)
    inner = _Differences(root, int(rows[0]) - first, last - int(rows[-1]))
    rest = x[first : last + 1].copy()
    rest[rows - first] = 0.0
    return inner.apply_within(rest), inner


def _knots(start: float, end: float) -> Array:
    """Returns clamped knots, at half the period of the filter's cut-off frequency."""
    count = max(int(np.ceil((end - start) * 2.0 * CUTOFF_FREQUENCY)), 4)
    inner = np.linspace(start, end, count + 1)
    return np.concatenate([[start] * DEGREE, inner, [end] * DEGREE])
