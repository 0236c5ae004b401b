"""Body trajectory: the pose of the body as a function of its distance and the phase of its gait.

The body follows its route and the ground, and bounces with the gait. It depends on distance and
phase alone, so a step can be planned for where the body will be.

Source: Sims 1987, 10.1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import bounded, hinge
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.body_motion.trunk_oscillation import HerdTrunks
from pipeline.simulation.locomotion.foot_placement.support_surface import SupportSurface
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.gaits.pace_schedule import PaceSchedule
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.route import Route, heading_vector
from pipeline.simulation.spatial import Array, heading, turn_inverse
from pipeline.simulation.terrain import Ground

# Fractions of the ground's slope along the route that a body takes on: one that lies between
# forelegs and hind legs, and one that stands upright above its hips; and of the slope across it.
PITCH_LYING, PITCH_UPRIGHT, ROLL_FRACTION = 0.85, 0.15, 0.6

# Half the distance between first and last hips from which on a body lies between them, in body
# heights.
LYING_HALF_LENGTH = 0.25

# Least half length of the ground sampled under a body, in strides: feet are that far from where
# they rest, in the middle of their stance.
MIN_SAMPLED_STRIDES = 0.25

# Range over which a body feels the ground come near its belly, in body heights.
BELLY_SOFTNESS = 0.4

# Rounding of the highest ground under a body, in body heights: the body does not follow every
# corner of the terrain.
CREST_ROUNDING = 0.06

# Fraction of the lean that balances a body on a curve, and greatest lean [rad].
BANK_FRACTION, MAX_BANK = 0.6, math.radians(14.0)

# Greatest pitch that a motion style holds [rad].
MAX_STYLE_PITCH = math.radians(15.0)

# Lean of people that run, from the hips up (Novacheck 1998) [rad].
RUNNING_LEAN = math.radians(7.0)


@dataclass(frozen=True, eq=False)
class RouteSet:
    """The routes of a herd; replaced as a whole when one changes.

    Attributes:
        routes: of the creatures.
        straight: (C,) which of them are straight and endless.
    """

    routes: Sequence[Route]
    straight: NDArray[np.bool_]

    @staticmethod
    def of(routes: Sequence[Route]) -> RouteSet:
        """Collect routes."""
        return RouteSet(routes, np.array([route.goes_straight for route in routes], dtype=bool))


class BodyTrajectory:
    """The body trajectories of a herd.

    Attributes:
        herd: the creatures.
        ground: under them.
        surface: the part of the ground that supports them, smoothed.
        route_set: their routes; a route may change where its creature has not been yet.
        paces: of their gaits.
        style: (C,) their present motion style.
        trunks: oscillation of the bodies with the gaits.
    """

    def __init__(
        self, herd: Herd, ground: Ground, routes: Sequence[Route], paces: PaceSchedule
    ) -> None:
        self.herd, self.ground, self.paces = herd, ground, paces
        self.surface = SupportSurface(herd, ground)
        self.route_set = RouteSet.of(routes)
        self.style = MotionStyle.neutral(len(herd.names))
        self.trunks = HerdTrunks(paces)

    @property
    def routes(self) -> Sequence[Route]:
        """The routes; the same object until one changes."""
        return self.route_set.routes

    def set_route(self, c: int, route: Route) -> None:
        """Give creature `c` another route, the same as before up to where it is."""
        self.route_set = RouteSet.of([*self.routes[:c], route, *self.routes[c + 1 :]])

    @cached_property
    def _samples(self) -> tuple[Array, Array]:
        """Places under a body (C, 7, 2), five along it and one on either side, and weights (5,)."""
        half = self.herd.footprint.copy()
        half[:, 0] = np.maximum(half[:, 0], MIN_SAMPLED_STRIDES * self.herd.stride)
        u = np.array([[-1, 0], [-0.5, 0], [0, 0], [0.5, 0], [1, 0], [0, -0.5], [0, 0.5]])
        weights = np.exp(-1.2 * u[:5, 0] ** 2)
        return u * half[:, None], weights / weights.sum()

    @cached_property
    def _pitch_fraction(self) -> Array:
        """(C,) fraction of the slope along its route that each body takes on."""
        herd, spread = self.herd, np.zeros(len(self.herd.names))
        for c in range(len(spread)):
            hips = herd.hips[herd.owner == c, 0]
            spread[c] = 0.5 * np.ptp(hips) / herd.body_height[c] if len(hips) else LYING_HALF_LENGTH
        lying = np.minimum(spread / LYING_HALF_LENGTH, 1.0)
        return PITCH_UPRIGHT + lying * (PITCH_LYING - PITCH_UPRIGHT)

    def pose(
        self,
        creature: NDArray[np.int64],
        distance: Array,
        phase: Array,
        speed_fraction: Array | float = 1.0,
        style_pitch: Array | None = None,
    ) -> tuple[Array, Array]:
        """Return the planned poses of bodies.

        Args:
            creature: (N,) numbers of creatures, possibly repeated.
            distance: (N,) gone since the start [m].
            phase: (N,) of the gait, whole cycles counted.
            speed_fraction: (N,) a body at rest does not bounce.
            style_pitch: (N,) of the motion style; the present one if None [rad].

        Returns:
            R_WB (N, 3, 3) and p_WB (N, 3) [m].
        """
        herd = self.herd
        xz, headings, bank = self.on_route(creature, distance)
        height, slope, crest = self._ground_plane(creature, xz, headings)
        bounce = self.paces.heave(creature, phase) * np.minimum(speed_fraction, 1.0)
        tall = self.paces.value("body_height", creature, phase)
        lift = hinge(crest + herd.belly[creature] - tall, BELLY_SOFTNESS * tall)
        p = np.stack([xz[:, 0], height + tall + lift + bounce, xz[:, 1]], axis=-1)
        rocking = self._rocking(creature, phase, speed_fraction, style_pitch)
        pitch = self._pitch_fraction[creature] * np.arctan(slope[:, 0]) + rocking[0]
        roll = -ROLL_FRACTION * np.arctan(slope[:, 1])
        bank = np.clip(bank * speed_fraction * speed_fraction, -MAX_BANK, MAX_BANK)
        roll = roll - bank + rocking[1]
        return heading(headings) @ pitched_and_rolled(pitch, roll), p

    def _rocking(
        self,
        creature: NDArray[np.int64],
        phase: Array,
        speed_fraction: Array | float = 1.0,
        style_pitch: Array | None = None,
    ) -> tuple[Array, Array]:
        """Return pitch and roll (N,) of bodies by gait and motion style [rad]."""
        pitch, roll = self.trunks.at(phase, creature)
        part = np.minimum(speed_fraction, 1.0)
        lean = RUNNING_LEAN * self.herd.upright[creature]
        pitch = pitch - lean * self.paces.value("running", creature, phase)
        held = self.style.body_pitch[creature] if style_pitch is None else style_pitch
        return part * pitch + MAX_STYLE_PITCH * bounded(held / MAX_STYLE_PITCH), part * roll

    def without_rocking(self, creature: NDArray[np.int64], phase: Array, rest: Array) -> Array:
        """Return rest positions of feet (N, 3) below bodies that rock, as if these did not [m].

        A foot is placed below its hip: it does not swing out because a body holds its nose up.

        Args:
            creature: (N,) numbers of creatures.
            phase: (N,) of their gaits.
            rest: (N, 3) relative to bodies that do not rock [m].
        """
        return turn_inverse(pitched_and_rolled(*self._rocking(creature, phase)), rest)

    def on_route(self, creature: NDArray[np.int64], distance: Array) -> tuple[Array, Array, Array]:
        """Return places (N, 2) [m], headings (N,) and banks on curves (N,) [rad].

        Args:
            creature: (N,) numbers of creatures.
            distance: (N,) gone since the start [m].
        """
        herd = self.herd
        # Most routes are straight and need no table.
        headings = herd.headings[creature]
        xz = herd.starts[creature] + distance[:, None] * heading_vector(headings)
        bank, curved = np.zeros(len(creature)), creature[~self.route_set.straight[creature]]
        for c in np.unique(curved) if len(curved) else ():
            own = creature == c
            route, gone, pace = self.routes[c], distance[own], herd.paces[c]
            xz[own], headings[own] = route.at(gone)
            speed = pace.stride / pace.cycle
            balance = np.arctan(route.curvature(gone) * speed**2 / GRAVITY)
            bank[own] = np.clip(BANK_FRACTION * balance, -MAX_BANK, MAX_BANK)
        return xz, headings, bank

    def _ground_plane(
        self, creature: NDArray[np.int64], xz: Array, headings: Array
    ) -> tuple[Array, Array, Array]:
        """Fit a plane to the ground under bodies at `xz` (N, 2), `headings` (N,).

        Returns:
            Its height (N,) [m], its slopes along and across (N, 2), and how far the ground under
            the middle rises above the plane that the body lies in (N,) [m].
        """
        offsets, weights = self._samples
        own = offsets[creature]
        c, s = (f[:, None] for f in heading_vector(headings).T)
        # Along the heading and across it, to the right: (c, s) turned by a quarter.
        x = xz[:, 0, None] + own[..., 0] * c - own[..., 1] * s
        z = xz[:, 1, None] + own[..., 0] * s + own[..., 1] * c
        h, excess = self.surface.heights(creature, x, z)
        along, across = own[:, :5, 0], own[:, 6, 1] - own[:, 5, 1]
        middle = h[:, :5] * weights
        # Sums by rows, not by a BLAS, whose last bit depends on how many rows there are.
        height = middle.sum(axis=-1)
        ahead = (middle * along).sum(axis=-1) / (weights * along**2).sum(axis=-1)
        slope = np.stack([ahead, (h[:, 6] - h[:, 5]) / across], axis=-1)
        fraction = self._pitch_fraction[creature, None]
        plane = height[:, None] + fraction * ahead[:, None] * along
        rise = (h + excess)[:, :5] - plane
        highest = rise.max(axis=-1, keepdims=True)
        rounding = CREST_ROUNDING * self.herd.body_height[creature, None]
        # A maximum without corners, by log-mean-exp.
        crest = highest + rounding * np.log(
            np.exp((rise - highest) / rounding).mean(axis=-1, keepdims=True)
        )
        return height, slope, crest[:, 0]


def pitched_and_rolled(pitch: Array, roll: Array) -> Array:
    """Return the rotations (N, 3, 3) that turn by `pitch` about Z after `roll` about X."""
    a, b = np.cos(pitch), np.sin(pitch)
    c, d = np.cos(roll), np.sin(roll)
    R = np.zeros((len(pitch), 3, 3))
    R[:, 0, 0], R[:, 0, 1], R[:, 0, 2] = a, -b * c, b * d
    R[:, 1, 0], R[:, 1, 1], R[:, 1, 2] = b, a * c, -a * d
    R[:, 2, 1], R[:, 2, 2] = d, c
    return R
