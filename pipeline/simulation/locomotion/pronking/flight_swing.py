"""The swing of legs in flight, and how it pitches the body.

Hind legs are thrown back and then gathered below the body, forelegs are folded and then stretched
ahead for the landing, the more the faster and the longer a body flies. What the legs do to the
moment of momentum, the body undoes.

Source: Sims 1987, 11.1 for feet drawn up and held out; Muybridge 1887 for leaping deer and horses;
Hildebrand 1959 for cheetahs and horses.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import hermite
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.leg_forces import AttitudeState
from pipeline.simulation.scalar_rotation import (
    Vector,
    from_rotation_vector,
    matrix_rows,
    quaternion_product,
    rotate,
)
from pipeline.simulation.spatial import Array

KNOT_SHARES = (0.0, 0.30, 0.66, 1.0)
"""Times of the points of a foot's path in the air, as fractions of its duration."""

SWING_KNOTS = np.array(KNOT_SHARES)

TUCK_HEIGHT = 0.42
"""How high feet are drawn up in mid-flight, in leg lengths."""

UPRIGHT = 0.8
"""Depth of feet below their hips at rest, in their distance, from which on legs are drawn up fully:
those that sprawl more stay low, as insects' do."""

FULL_TUCK_TIME, FULL_LEAP_FROUDE = 0.5, 0.8
"""Duration of a flight, and speed in √(g l), from which on legs fold and stretch fully."""

BACK_REACH, FORE_REACH = 0.62, 0.46
"""How far hind feet are stretched back behind their hips after a lift-off, and forefeet ahead of
theirs before a landing, in leg lengths."""

BACK_STRETCH, FORE_STRETCH = 0.95, 0.90
"""Lengths of legs stretched so, in leg lengths."""

FORE_TUCK, HIND_GATHER = -0.06, 0.14
"""How far ahead of their hips forefeet are drawn up, and hind feet come forward, in leg lengths."""

HIND_GATHER_HEIGHT = 0.24
"""How high hind feet are while they come forward, in leg lengths."""

SIDE_BY_SIDE = 0.35
"""Distance along a leap up to which all feet are beside each other, in leg lengths."""

VAULT_TRAIL = 0.30
"""How far all feet trail that are drawn up over a hurdle, in leg lengths."""

LEG_CENTRE = 0.5
"""Centre of mass of a leg, on the way from its hip to its foot."""

MAX_PITCH = 0.2
"""Greatest pitch of a body by its legs [rad]."""

TRAIL_SPEED = 0.35
"""Speed with which feet trail after a lift-off, in body speeds."""


@dataclass(frozen=True, eq=False)
class SwingPath:
    """Paths of n feet in the air, relative to the body.

    Each has four points, at `SWING_KNOTS`: where the foot left the ground, where it is drawn up or
    stretched back while the body rises, where it is gathered or reaches ahead while the body falls,
    and the foot held for the landing.

    Attributes:
        begin: (n,) start times [s].
        time: (n,) durations [s].
        start, rising, falling, end: (n, 3) in the frame of the body [m].
        trail: (n, 3) initial velocities [m/s].
    """

    begin: Array
    time: Array
    start: Array
    rising: Array
    falling: Array
    end: Array
    trail: Array

    @staticmethod
    def still(feet: Array) -> SwingPath:
        """Return paths of feet (n, 3) at rest."""
        n, zero = len(feet), np.zeros_like(feet)
        return SwingPath(np.zeros(n), np.ones(n), feet, feet, feet, feet, zero)

    @cached_property
    def _knots(self) -> tuple[Array, Array]:
        """Points (4, n, 3) [m], and their velocities in path lengths (4, n, 3) [m]."""
        points = np.stack([self.start, self.rising, self.falling, self.end])
        slopes = np.zeros_like(points)
        slopes[0] = self.time[:, None] * self.trail
        spans = SWING_KNOTS[2:] - SWING_KNOTS[:-2]
        slopes[1:-1] = (points[2:] - points[:-2]) / spans[:, None, None]
        return points, slopes

    def tips(self, time: float) -> Array:
        """Return the feet (n, 3) in the frame of the body [m]."""
        s = np.minimum(np.maximum((time - self.begin) / self.time, 0.0), 1.0)
        k = (s > SWING_KNOTS[1]).astype(np.int64) + (s > SWING_KNOTS[2])
        legs, span = np.arange(len(s)), (SWING_KNOTS[k + 1] - SWING_KNOTS[k])[:, None]
        u = (s - SWING_KNOTS[k])[:, None] / span
        points, slopes = self._knots
        a, b = points[k, legs], points[k + 1, legs]
        return hermite(a, b, span * slopes[k, legs], span * slopes[k + 1, legs], u)

    def restarted(
        self,
        restarting: NDArray[np.bool_],
        time: float,
        start: Array,
        duration: float,
        way: tuple[Array, Array] | None = None,
    ) -> SwingPath:
        """Return paths in which some feet start again.

        Args:
            restarting: (n,) these feet.
            time: at which they do [s].
            start: (n, 3) where, in the frame of the body [m].
            duration: of their way to their ends [s].
            way: middle points (n, 3) [m] and initial velocities (n, 3) [m/s]; None for straight on,
                from rest.
        """
        mask = restarting[:, None]
        middle, trail = way or (0.5 * (start + self.end), np.zeros_like(start))
        return replace(
            self,
            begin=np.where(restarting, time, self.begin),
            time=np.where(restarting, duration, self.time),
            start=np.where(mask, start, self.start),
            rising=np.where(mask, middle, self.rising),
            falling=np.where(mask, 0.5 * (middle + self.end), self.falling),
            trail=np.where(mask, trail, self.trail),
        )

    @property
    def middle(self) -> Array:
        """Points (n, 3) in the middle of the paths [m]."""
        return 0.5 * (self.rising + self.falling)


@dataclass(frozen=True, slots=True)
class TrunkPitch:
    """How swinging legs pitch a flying body, beside its free rotation.

    Legs that are thrown back turn the body up in front, and legs that come forward turn it down:
    together they keep their angular momentum. It is zero at lift-off and at the planned landing.

    Attributes:
        begin: time of lift-off [s].
        time: duration [s].
        axis: about which it turns, in the frame of the body.
        angles: at `SWING_KNOTS` [rad].
    """

    begin: float = 0.0
    time: float = 1.0
    axis: Vector = (0.0, 0.0, 1.0)
    angles: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def at(self, time: float) -> tuple[float, float]:
        """Return angle [rad] and rate [rad/s] at a time [s]."""
        s = (time - self.begin) / self.time
        if not (0.0 < s < 1.0 and any(self.angles)):
            return 0.0, 0.0
        knots, a = KNOT_SHARES, self.angles
        k = int(s > knots[1]) + int(s > knots[2])
        slopes = (
            0.0,
            (a[2] - a[0]) / (knots[2] - knots[0]),
            (a[3] - a[1]) / (knots[3] - knots[1]),
            0.0,
        )
        span = knots[k + 1] - knots[k]
        u, m_a, m_b = (s - knots[k]) / span, span * slopes[k], span * slopes[k + 1]
        rise = a[k + 1] - a[k]
        angle = a[k] + u * (m_a + u * (3 * rise - 2 * m_a - m_b + u * (m_a + m_b - 2 * rise)))
        rate = m_a + u * (2 * (3 * rise - 2 * m_a - m_b) + 3 * u * (m_a + m_b - 2 * rise))
        return angle, rate / (span * self.time)

    def turned(self, attitude: AttitudeState, time: float) -> AttitudeState:
        """Return an attitude and its rate with the pitch at a time [s]."""
        angle, rate = self.at(time)
        if angle == rate == 0.0:
            return attitude
        q, w = attitude
        x, y, z = self.axis
        turn = from_rotation_vector((angle * x, angle * y, angle * z))
        dx, dy, dz = rotate(matrix_rows(q), (rate * x, rate * y, rate * z))
        return quaternion_product(q, turn), (w[0] + dx, w[1] + dy, w[2] + dz)


NO_PITCH = TrunkPitch()
"""Of a body on its feet."""


def flight_swing(
    hopper: Hopper,
    start: Array,
    landing_feet: Array,
    begin: float,
    time: float,
    v: Array,
    fold_legs: bool,
) -> SwingPath:
    """Return the paths of feet from lift-off to landing.

    Args:
        hopper: the creature.
        start: (n, 3) feet at lift-off, in the frame of the body [m].
        landing_feet: (n, 3) feet at the landing, in the frame of the body [m].
        begin: time of lift-off [s].
        time: duration of the flight [s].
        v: (3,) velocity of the body, in its frame [m/s].
        fold_legs: whether feet are drawn up as far as the legs fold.
    """
    length = hopper.leg_length
    low = np.maximum(start[:, 1], landing_feet[:, 1])
    highest = hopper.hips[:, 1] - 1.15 * hopper.folded_lengths
    apart = hopper.hips - hopper.rest_feet + hopper.standing_height * np.array([0.0, 1.0, 0.0])
    depth = apart[:, 1] / np.linalg.norm(apart, axis=1)
    upright = np.clip(depth / UPRIGHT, 0.0, 1.0) ** 2
    # Short flights leave no time for it.
    share = min(1.0, time / FULL_TUCK_TIME)
    level = np.array([v[0], 0.0, v[2]])
    speed = float(np.linalg.norm(level))
    along = level / max(speed, 1e-9)
    pace = min(1.0, speed / (FULL_LEAP_FROUDE * math.sqrt(GRAVITY * length)))

    def raised(height: float, place: float) -> Array:
        """Return feet (n, 3) between start and end, raised by a height in leg lengths [m]."""
        feet = start + place * (landing_feet - start)
        top = highest if fold_legs else np.minimum(low + height * length * share * upright, highest)
        feet[:, 1] = np.maximum(top, low)
        return feet

    rising, falling = (raised(TUCK_HEIGHT, place) for place in KNOT_SHARES[1:3])
    if fold_legs:
        for feet in (rising, falling):
            feet -= VAULT_TRAIL * length * share * pace * along
    else:
        fore = _fore_shares(hopper, along)[:, None]
        back = _stretched(hopper, start, low, -BACK_REACH * along, BACK_STRETCH)
        ahead = _stretched(hopper, landing_feet, low, FORE_REACH * along, FORE_STRETCH)
        tucked, gathered = rising.copy(), raised(HIND_GATHER_HEIGHT, KNOT_SHARES[2])
        for feet, reach in ((tucked, FORE_TUCK), (gathered, HIND_GATHER)):
            feet += ((hopper.hips - feet) @ along + reach * length)[:, None] * along
        leap = share * pace
        rising += leap * (fore * tucked + (1.0 - fore) * back - rising)
        falling += leap * (fore * ahead + (1.0 - fore) * gathered - falling)
    trail = np.tile(-TRAIL_SPEED * level, (len(start), 1))
    begins, times = np.full(len(start), begin), np.full(len(start), 0.97 * time)
    return SwingPath(begins, times, start, rising, falling, landing_feet, trail)


def _fore_shares(hopper: Hopper, along: Array) -> Array:
    """Return how far legs (n,) are forelegs, 1, rather than hind legs, 0, of a leap `along`.

    Legs beside each other are hind legs, as of a kangaroo.
    """
    place = hopper.rest_feet @ along
    room = float(np.ptp(place))
    if room < SIDE_BY_SIDE * hopper.leg_length:
        return np.zeros(len(place))
    return np.asarray((place - place.min()) / room)


def _stretched(hopper: Hopper, feet: Array, low: Array, way: Array, stretch: float) -> Array:
    """Return feet (n, 3) of legs stretched some way, but not below a height [m].

    Args:
        hopper: the creature.
        feet: (n, 3) of which they keep their distance to the side [m].
        low: (n,) that height, in the frame of the body [m].
        way: (3,) from the hip, level, in leg lengths.
        stretch: distance from hip to foot, in leg lengths.
    """
    length = hopper.leg_length
    along = way / float(np.linalg.norm(way) or 1.0)
    result = feet + ((hopper.hips - feet) @ along)[:, None] * along + length * way
    out = (result - hopper.hips)[:, [0, 2]]
    depth = np.sqrt(np.maximum((stretch * length) ** 2 - (out * out).sum(axis=-1), 0.0))
    result[:, 1] = np.maximum(hopper.hips[:, 1] - depth, low)
    return np.asarray(result)


def trunk_pitch(hopper: Hopper, swing: SwingPath, v: Array) -> TrunkPitch:
    """Return how legs on their paths from lift-off to landing pitch a body.

    The moment of momentum of legs that swing is that of the body the other way round.

    Args:
        hopper: the creature.
        swing: the paths of its feet.
        v: (3,) velocity of the body, in its frame [m/s].
    """
    speed = math.hypot(v[0], v[2])
    if speed < 1e-9:
        return NO_PITCH
    along = np.array([v[0] / speed, 0.0, v[2] / speed])
    axis = np.array([-along[2], 0.0, along[0]])
    inertia = float(axis @ np.array(hopper.inertia.tensor) @ axis)
    way, angles = swing.end - swing.start, [0.0]
    for share, feet in zip(KNOT_SHARES[1:3], (swing.rising, swing.falling), strict=True):
        behind = (swing.start + share * way - feet) @ along
        below = hopper.mass.centre[1] - 0.5 * (hopper.hips + feet)[:, 1]
        turn = float((hopper.leg_masses * LEG_CENTRE * below * behind).sum()) / inertia
        angles.append(MAX_PITCH * math.tanh(turn / MAX_PITCH))
    x, y, z = axis.tolist()
    begin, time = float(swing.begin[0]), float(swing.time[0])
    return TrunkPitch(begin, time, (x, y, z), (angles[0], angles[1], angles[2], 0.0))
