"""Keyframe tracks: values interpolated between keys; cyclic tracks; tracks that fade in and out.

Between two keys a value follows a cubic Hermite with the speeds of the spline through the keys, or
an ease that starts or ends at rest.

Source: Sims 1987, 3.1.1; Catmull and Rom 1974, with keys at uneven times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.curves import ease
from pipeline.simulation.spatial import Array, rotation
from pipeline.spec.keyframes import Ease

SAME_TIME = 1e-9
"""Keys nearer in time than this are a jump at one moment [s]."""


Key = tuple[float, Sequence[float], Ease]
"""Time [s], values, and the ease that leads to them."""


@dataclass(frozen=True, eq=False)
class Track:
    """Values at given times.

    Attributes:
        times: (n,) ascending [s].
        values: (n, d).
        eases: ease that leads to each key.
        tangents: (n, d) given speeds, NaN for computed ones; None if all are computed.
    """

    times: Array
    values: Array
    eases: tuple[Ease, ...]
    tangents: Array | None = None

    @staticmethod
    def of(keys: Sequence[Key], tangents: Sequence[Sequence[float] | None] = ()) -> Track:
        """Returns the track through keys: time, value and ease of each.

        Args:
            keys: in the order of time.
            tangents: given speed at each key, None for a computed one; empty if none is given.
        """
        times, values, eases = zip(*keys, strict=True)
        given = None
        if any(tangent is not None for tangent in tangents):
            unknown = [np.nan] * len(values[0])
            given = np.array([t if t is not None else unknown for t in tangents], dtype=float)
        return Track(np.array(times, dtype=float), np.array(values, dtype=float), eases, given)

    @cached_property
    def speeds(self) -> Array:
        """Speeds (n, d) of the spline at each key."""
        n = len(self.times)
        spline = np.array([e == "spline" for e in self.eases])
        through = np.zeros_like(self.values)
        # Derivative of the parabola through a key and its neighbours; zero at both ends.
        for i in range(1, n - 1):
            a, b = self.times[i] - self.times[i - 1], self.times[i + 1] - self.times[i]
            if min(a, b) > SAME_TIME and spline[i] and spline[i + 1]:
                before = (self.values[i] - self.values[i - 1]) / a
                after = (self.values[i + 1] - self.values[i]) / b
                through[i] = (b * before + a * after) / (a + b)
        if self.tangents is not None:
            through = np.where(np.isnan(self.tangents), through, self.tangents)
        return through

    def __call__(self, times: Array) -> Array:
        """Returns the values (m, d) at `times` (m,); constant beyond the end keys."""
        if len(self.times) == 1:
            return np.repeat(self.values, len(times), axis=0)
        right = np.clip(np.searchsorted(self.times, times, side="right"), 1, len(self.times) - 1)
        left = right - 1
        span = self.times[right] - self.times[left]
        s = np.clip((times - self.times[left]) / np.maximum(span, SAME_TIME), 0.0, 1.0)
        kind = np.array(self.eases)[right]
        # Hermite's cubic; s is 0 at the left key and 1 at the right one.
        s1, h = s[:, None], span[:, None]
        a, b = self.values[left], self.values[right]
        spline = a + (b - a) * s1 * s1 * (3.0 - 2.0 * s1)
        speeds = self.speeds
        spline = spline + h * s1 * (1.0 - s1) * ((1.0 - s1) * speeds[left] - s1 * speeds[right])
        eased = np.select(
            [kind == "linear", kind == "in", kind == "out", kind == "hold"],
            [s, s * s * (1.5 - 0.5 * s), s * (1.5 - 0.5 * s * s), np.floor(s)],
            ease(s),
        )[:, None]
        return np.where((kind == "spline")[:, None], spline, a + (b - a) * eased)


LIFT_END = 0.3
"""Fraction of the way at each of its ends in which it rises to its full lift."""


def lift_share(s: Array) -> Array:
    """Returns the share (n,) of a lift at fractions (n,) of the time of a way."""
    return ease(np.clip(np.minimum(s, 1.0 - s) / LIFT_END, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class Lift:
    """Displacement of the way between two keys.

    Attributes:
        first, last: times of the keys [s].
        aside: (d,) displacement at the middle.
    """

    first: float
    last: float
    aside: Array


@dataclass(frozen=True, eq=False)
class LiftedTrack(Track):
    """A track that leads aside between some of its keys.

    Attributes:
        lifts: of the ways.
    """

    lifts: tuple[Lift, ...] = ()

    def __call__(self, times: Array) -> Array:
        """See `Track`."""
        values = super().__call__(times)
        for lift in self.lifts:
            s = np.clip((times - lift.first) / (lift.last - lift.first), 0.0, 1.0)
            values = values + lift_share(s)[:, None] * lift.aside
        return values


@dataclass(frozen=True, eq=False)
class CyclicTrack:
    """A track that repeats.

    Attributes:
        track: through its keys and copies of them before and after, so that a spline is continuous
            at the ends.
        first: start of the first period [s].
        period: [s].
    """

    track: Track
    first: float
    period: float

    @staticmethod
    def of(track: Track, first: float, period: float) -> CyclicTrack:
        """Returns the cycle of a track.

        Args:
            track: its keys lie within one `period` from `first`.
            first: start of the first period [s].
            period: [s].
        """
        # An angle that gains whole turns passes the ends at constant speed.
        gain = track.values[-1] - track.values[0]
        keys = range(len(track.times))
        # If keys stand at both ends, only one of the two is copied.
        both = track.times[-1] - track.times[0] > period - SAME_TIME
        before, after = keys[: -1 if both else None], keys[1 if both else 0 :]
        order = [*before, *keys, *after]
        shifts = np.repeat([-1.0, 0.0, 1.0], [len(before), len(keys), len(after)])
        given = None if track.tangents is None else track.tangents[order]
        whole_track = Track(
            track.times[order] + period * shifts,
            track.values[order] + gain * shifts[:, None],
            tuple(track.eases[i] for i in order),
            given,
        )
        return CyclicTrack(whole_track, first, period)

    def __call__(self, times: Array) -> Array:
        """Returns the values (m, d) at `times` (m,)."""
        # Tolerance for rounding: rows stand on keys.
        since = np.mod(times - self.first + SAME_TIME, self.period) - SAME_TIME
        return self.track(self.first + since)


@dataclass(frozen=True, eq=False)
class BlendedTrack:
    """A track that fades in over something else, and may fade out again.

    Attributes:
        track: the track.
        taken: start and end of fading in [s].
        let_go: start and end of fading out [s]; infinite if it never does.
    """

    track: Track
    taken: tuple[float, float]
    let_go: tuple[float, float] = (np.inf, np.inf)

    def weight(self, times: Array) -> Array:
        """Returns the weight of the track (m,) at `times` (m,), 0 to 1."""
        return _eased_step(times, *self.taken) * (1.0 - _eased_step(times, *self.let_go))


def _eased_step(times: Array, first: float, last: float) -> Array:
    if not np.isfinite(last):
        return np.zeros_like(times)
    if last - first < SAME_TIME:
        return (times >= last - SAME_TIME).astype(float)
    return ease(np.clip((times - first) / (last - first), 0.0, 1.0))


def rotation_from_angles(angles: Array) -> Array:
    """Returns the rotations (..., 3, 3) of angles (..., 3) about x, y and z [rad].

    About z first, then x, then y, each about a fixed axis.
    """
    x, y, z = (rotation(axis, angles[..., k]) for k, axis in enumerate(np.eye(3)))
    return y @ x @ z
