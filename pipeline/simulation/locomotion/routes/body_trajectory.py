"""Body path: how the body follows its route and the ground, and bounces with the gait.

The body's pose is a function of the way it has gone and of the phase of its gait, so
a step can be planned for where the body will be.

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
from pipeline.simulation.locomotion.gaits.gait_transition import PaceSchedule
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.route import Route, heading_vector
from pipeline.simulation.spatial import Array, heading, unturn
from pipeline.simulation.terrain import Ground

PITCH_FOLLOWS, UPRIGHT_FOLLOWS = 0.85, 0.15
"""How much of the ground's slope along the way the body takes on: one that lies between
forelegs and hind legs, and one that stands upright above its hips."""

LYING = 0.25
"""Half the distance along a body between its first and its last hips from which on it lies
between them, as a part of its height."""

PACED = 0.25
"""How far the ground under a body reaches at least, to the front and to the back, in strides:
so far are the feet from where they rest, in the middle of what they do while they stand."""

ROLL_FOLLOWS = 0.6
"""How much of the slope across it takes on."""

CORNER = 0.4
"""Over how much of its height a body feels the ground come near its belly."""

BLUNT = 0.06
"""How blunt the highest ground under a body is taken to be, as a part of its height:
the body does not follow every corner of the terrain."""

BANK = 0.6
"""How much of the lean that balances a body on a curve it takes on."""

MOST_BANK = math.radians(14.0)

MOST_PITCH = math.radians(15.0)
"""How far a bearing holds a body nose up or down."""


@dataclass(frozen=True, eq=False)
class Ways:
    """Where a herd goes; whoever is led elsewhere makes another.

    Attributes:
        routes: ways of its creatures over the plane.
        straight: (C,) which of them go straight from where they started.
    """

    routes: Sequence[Route]
    straight: NDArray[np.bool_]

    @staticmethod
    def of(routes: Sequence[Route]) -> Ways:
        """Return ways that have these routes."""
        return Ways(routes, np.array([route.goes_straight for route in routes], dtype=bool))


class BodyTrajectory:
    """Poses of the bodies of a herd on a ground.

    Attributes:
        herd: the creatures.
        ground: what they go over.
        footing: the ground that they can stand on, and the surface it makes.
        ways: where they go; a route may be changed where its creature has not been yet.
        paces: how they go.
        bearing: (C,) how they carry themselves now.
        trunks: how their bodies rock with their gaits.
    """

    def __init__(
        self, herd: Herd, ground: Ground, routes: Sequence[Route], paces: PaceSchedule
    ) -> None:
        self.herd = herd
        self.ground = ground
        self.paces = paces
        self.footing = SupportSurface(herd, ground)
        self.ways = Ways.of(routes)
        self.bearing = MotionStyle.neutral(len(herd.names))
        self.trunks = HerdTrunks(paces)

    @property
    def routes(self) -> Sequence[Route]:
        """Their ways over the plane; the same object as long as nobody is led elsewhere."""
        return self.ways.routes

    def lead(self, c: int, route: Route) -> None:
        """Give creature `c` another way, which is as before up to where it is."""
        self.ways = Ways.of([*self.routes[:c], route, *self.routes[c + 1 :]])

    @cached_property
    def _samples(self) -> tuple[Array, Array]:
        """Places under a body (C, 7, 2), five along it and one on either side, and weights (5,)."""
        herd = self.herd
        half = herd.footprint.copy()
        half[:, 0] = np.maximum(half[:, 0], PACED * herd.stride)
        u = np.array([[-1, 0], [-0.5, 0], [0, 0], [0.5, 0], [1, 0], [0, -0.5], [0, 0.5]])
        weights = np.exp(-1.2 * u[:5, 0] ** 2)
        return u * half[:, None], weights / weights.sum()

    @cached_property
    def _follows(self) -> Array:
        """(C,) how much of the slope along its way each body takes on."""
        herd, spread = self.herd, np.zeros(len(self.herd.names))
        for c in range(len(spread)):
            hips = herd.hips[herd.owner == c, 0]
            spread[c] = 0.5 * np.ptp(hips) / herd.body_height[c] if len(hips) else LYING
        lies = np.minimum(spread / LYING, 1.0)
        return UPRIGHT_FOLLOWS + lies * (PITCH_FOLLOWS - UPRIGHT_FOLLOWS)

    def pose(
        self,
        creature: NDArray[np.int64],
        travelled: Array,
        phase: Array,
        drive: Array | float = 1.0,
        nose_up: Array | None = None,
    ) -> tuple[Array, Array]:
        """Return the poses that bodies are to have.

        Args:
            creature: (N,) which creatures; one may occur more than once.
            travelled: (N,) way gone since the start [m].
            phase: (N,) phase of the gait, whole cycles counted.
            drive: (N,) part of its speed at which it goes: who rests does not bounce.
            nose_up: (N,) how far its bearing holds it nose up, if that is another than now [rad].

        Returns:
            R_WB (N, 3, 3) and p_WB (N, 3) [m].
        """
        herd = self.herd
        xz, turned, lean = self.on_route(creature, travelled)
        height, slope, crest = self._under(creature, xz, turned)
        beat = self.paces.heave(creature, phase) * np.minimum(drive, 1.0)
        # The belly has to clear the ground under it.
        tall = self.paces.value("body_height", creature, phase)
        lift = hinge(crest + herd.belly[creature] - tall, CORNER * tall)
        p = np.stack([xz[:, 0], height + tall + lift + beat, xz[:, 1]], axis=-1)
        rocks = self._rocks(creature, phase, drive, nose_up)
        pitch = self._follows[creature] * np.arctan(slope[:, 0]) + rocks[0]
        roll = -ROLL_FOLLOWS * np.arctan(slope[:, 1]) - lean * drive * drive + rocks[1]
        return heading(turned) @ pitched_and_rolled(pitch, roll), p

    def _rocks(
        self,
        creature: NDArray[np.int64],
        phase: Array,
        drive: Array | float = 1.0,
        nose_up: Array | None = None,
    ) -> tuple[Array, Array]:
        """Return by how much bodies pitch and roll (N,), whatever they go over [rad]."""
        pitch, roll = self.trunks.at(phase, creature)
        part = np.minimum(drive, 1.0)
        held = self.bearing.body_pitch[creature] if nose_up is None else nose_up
        return part * pitch + MOST_PITCH * bounded(held / MOST_PITCH), part * roll

    def below(self, creature: NDArray[np.int64], phase: Array, rest: Array) -> Array:
        """Return places of feet (N, 3) relative to bodies that rock, as if these did not [m].

        A foot is put below its hip: it does not swing out because a body holds its nose up.

        Args:
            creature: (N,) which creatures.
            phase: (N,) of their gaits.
            rest: (3,) relative to a body that does not rock [m].
        """
        pitch, roll = self._rocks(creature, phase)
        return unturn(pitched_and_rolled(pitch, roll), np.broadcast_to(rest, (len(phase), 3)))

    def on_route(self, creature: NDArray[np.int64], travelled: Array) -> tuple[Array, Array, Array]:
        """Return places (N, 2) [m], headings (N,) and how far curves make bodies lean (N,) [rad].

        Args:
            creature: (N,) which creatures.
            travelled: (N,) way gone since the start [m].
        """
        herd = self.herd
        # Most go straight from where they started: no table is needed.
        turned = herd.headings[creature]
        xz = herd.starts[creature] + travelled[:, None] * heading_vector(turned)
        lean, curved = np.zeros(len(creature)), creature[~self.ways.straight[creature]]
        for c in np.unique(curved) if len(curved) else ():
            own = creature == c
            route, way = self.routes[c], travelled[own]
            xz[own], turned[own] = route.at(way)
            balance = np.arctan(route.curvature(way) * self._speed(c) ** 2 / GRAVITY)
            lean[own] = np.clip(BANK * balance, -MOST_BANK, MOST_BANK)
        return xz, turned, lean

    def _speed(self, c: int) -> float:
        """Return the greatest speed of a creature, by which it leans on curves [m/s]."""
        pace = self.herd.paces[c]
        return pace.stride / pace.cycle

    def _under(
        self, creature: NDArray[np.int64], xz: Array, turned: Array
    ) -> tuple[Array, Array, Array]:
        """Fit a plane to the ground under bodies at `xz` (N, 2), headings `turned` (N,).

        Returns:
            Its height (N,) [m], its slopes along and across (N, 2), and how far the ground
            under the middle rises above the plane that the body lies in (N,) [m].
        """
        offsets, weights = self._samples
        own = offsets[creature]
        c, s = (f[:, None] for f in heading_vector(turned).T)
        # Along the heading and across it, to the right: (c, s) turned by a quarter.
        x = xz[:, 0, None] + own[..., 0] * c - own[..., 1] * s
        z = xz[:, 1, None] + own[..., 0] * s + own[..., 1] * c
        h, excess = self.footing.surface(creature, x, z)
        along, across = own[:, :5, 0], own[:, 6, 1] - own[:, 5, 1]
        middle = h[:, :5] * weights
        # Sums by rows, not by a BLAS, whose last bit depends on how many rows there are.
        height = middle.sum(axis=-1)
        ahead = (middle * along).sum(axis=-1) / (weights * along**2).sum(axis=-1)
        slope = np.stack([ahead, (h[:, 6] - h[:, 5]) / across], axis=-1)
        follows = self._follows[creature, None]
        plane = height[:, None] + follows * ahead[:, None] * along
        rise = (h + excess)[:, :5] - plane
        highest = rise.max(axis=-1, keepdims=True)
        blunt = BLUNT * self.herd.body_height[creature, None]
        # A maximum without corners, by log-mean-exp.
        crest = highest + blunt * np.log(
            np.exp((rise - highest) / blunt).mean(axis=-1, keepdims=True)
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
