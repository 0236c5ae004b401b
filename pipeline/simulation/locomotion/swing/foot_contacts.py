"""Foot contacts: touchdowns of feet, and scuffs over the ground in their swings.

A swing is planned as a whole at lift-off, so where it will scuff is known then. A foot scuffs once
a swing at most, where it rubs most: one hears it scrape along, not every grain that it meets.

Source: Sims 1987, 13.1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.authored_poses import AuthoredPoses
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.gaits.pace_schedule import StepTiming
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import foot_materials, leg_masses
from pipeline.simulation.locomotion.swing.swing_trajectory import swing_positions, touchdown_speed
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, ContactKind
from pipeline.simulation.terrain import Ground
from pipeline.simulation.troupe import World

# Distance from the ground within which a sole brushes over it, in leg lengths.
SCUFF_DISTANCE = 0.015

# Least speed along the ground that is heard, in leg lengths [1/s].
MIN_SCUFF_SPEED = 0.5

# Step height from which on feet do not scuff, in leg lengths. `clearance_height` leaves at least
# 0.4 of the step under the arch, whose height is 0.56 of its top where the middle of a swing
# begins: 0.022 of the leg, more than `SCUFF_DISTANCE` on slopes that can be stepped on.
MAX_SHUFFLE_HEIGHT = 0.1

# Fractions of a swing in which it may scuff (at its ends every foot is near the ground), and those
# that give the speed along the ground at touchdown.
MID_SWING, SWING_END = np.linspace(0.25, 0.75, 65), np.array([0.999, 1.0])

# Greatest part of a leg's mass that its foot drags along.
DRAGGED_MASS = 0.1

# A world step, and the fraction of a step after it.
Moment = tuple[int, float]


# --- scuffs -------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Scuff:
    """A foot that rubs over the ground.

    Attributes:
        fraction: of the swing at which it does so.
        place: (3,) on the ground [m].
        normal: (3,) of the ground there.
        slide: speed along the ground, per whole swing [m].
        mass_fraction: part of the leg's mass that drags.
    """

    fraction: float
    place: Array
    normal: Array
    slide: float
    mass_fraction: float


def scuff_in_swing(
    ground: Ground, tips: Array, parts: Array, foot_radius: float, low: float
) -> Scuff | None:
    """Return where a foot scuffs the most, None if it stays clear of the ground.

    Args:
        ground: under the swing.
        tips: (n, 3) positions of its tip [m].
        parts: (n,) fractions of its swing.
        foot_radius: [m].
        low: distance from the ground within which it scuffs [m].
    """
    x, z = tips[:, 0], tips[:, 2]
    height, normals = ground.surface(x, z)
    depth = low - ((tips[:, 1] - height) * normals[:, 1] - foot_radius)
    if (depth <= 0.0).all():
        return None
    slide = _tangential(np.gradient(tips, parts, axis=0), normals)
    rubbed = depth * slide
    # On level ground it rubs alike before and after the top; rounding must not choose.
    worst = int(np.argmax(rubbed >= (1.0 - 1e-6) * rubbed.max()))
    place = np.array([x[worst], height[worst], z[worst]])
    mass = DRAGGED_MASS * min(float(depth[worst]) / low, 1.0)
    return Scuff(float(parts[worst]), place, normals[worst], float(slide[worst]), mass)


def scuff_at_touchdown(tips: Array, parts: Array, place: Array, normal: Array) -> Scuff:
    """Return how a foot scuffs as it comes down.

    Args:
        tips: (2, 3) positions of its tip at the end of its swing [m].
        parts: (2,) fractions of the swing.
        place: (3,) of touchdown [m].
        normal: (3,) of the ground there.
    """
    slide = _tangential(np.diff(tips, axis=0) / np.diff(parts), normal)
    return Scuff(1.0, place, normal, float(slide[0]), DRAGGED_MASS)


def _tangential(v: Array, normals: Array) -> Array:
    """Return the lengths (n,) of the parts of vectors (n, 3) along a surface."""
    across = (v * normals).sum(axis=-1, keepdims=True)
    return np.linalg.norm(v - across * normals, axis=-1)


class ScuffDetector:
    """The scuffs of a herd.

    Attributes:
        phase: (L,) at which the swing of each leg scuffs, infinite if it does not.
        span: (L,) duration of the swing of each leg, in cycles.
    """

    def __init__(self, herd: Herd, ground: Ground) -> None:
        self.herd, self.ground = herd, ground
        self.phase = np.full(len(herd.owner), np.inf)
        self.span = herd.swings.copy()
        self._planned: dict[int, Scuff] = {}
        # Speed at the end of a plain swing, per length and height, in both of which it is linear.
        step, still = np.array([1.0, 0.0, 0.0]), np.zeros(3)
        ends = (_path(still, step, 0.0, SWING_END, None), _path(still, still, 1.0, SWING_END, None))
        speeds = [np.linalg.norm(np.diff(tips, axis=0)) / np.diff(SWING_END)[0] for tips in ends]
        self._end_speed = float(max(speeds))

    def plan(
        self,
        leg: int,
        timing: StepTiming,
        start: Array,
        end: Array,
        heights: tuple[float, float],
        bend: Array | None,
    ) -> None:
        """Find out where a swing will scuff.

        Args:
            leg: its number.
            timing: of the step.
            start: (3,) tip at lift-off [m].
            end: (3,) tip at touchdown [m].
            heights: of the arch, and of that on level ground [m].
            bend: of the swing.
        """
        self.phase[leg], self.span[leg] = np.inf, timing.swing
        height, step_height = heights
        length = float(self.herd.legs.lengths[leg])
        if step_height >= MAX_SHUFFLE_HEIGHT * length:
            return
        tips = _path(start, end, height, MID_SWING, bend)
        low, foot_radius = SCUFF_DISTANCE * length, float(self.herd.foot_radius[leg])
        scuff = scuff_in_swing(self.ground, tips, MID_SWING, foot_radius, low)
        if scuff is not None:
            self._planned[leg] = scuff
            self.phase[leg] = timing.up + scuff.fraction * timing.swing

    def due(self, before: Array, phase: Array) -> NDArray[np.int64]:
        """Return the legs that scuff between their phases `before` (L,) and `phase` (L,)."""
        return np.flatnonzero((self.phase > before) & (self.phase <= phase))

    def mid_swing(self, leg: int, rate: float) -> tuple[Scuff, float] | None:
        """Return the scuff planned for a leg and its speed [m/s], None if it is too slow.

        Args:
            leg: its number.
            rate: of the phase [1/s].
        """
        return self._audible(leg, self._planned[leg], rate)

    def touchdown(
        self,
        leg: int,
        start: Array,
        hold: Foothold,
        height: float,
        rate: float,
        bend: Array | None,
    ) -> tuple[Scuff, float] | None:
        """Return the scuff of a leg that comes down and its speed [m/s].

        Args:
            leg: its number.
            start: (3,) tip at lift-off [m].
            hold: where it comes down.
            height: of the arch [m].
            rate: of the phase [1/s].
            bend: of the swing.

        Returns:
            None if it is too slow, or has scuffed in this swing already.
        """
        most = self._end_speed * (math.dist(start, hold.tip) + height)
        if np.isfinite(self.phase[leg]) or not self._is_audible(leg, most, rate):
            return None
        tips = _path(start, hold.tip, height, SWING_END, bend)
        scuff = scuff_at_touchdown(tips, SWING_END, hold.place, hold.normal)
        return self._audible(leg, scuff, rate)

    def _audible(self, leg: int, scuff: Scuff, rate: float) -> tuple[Scuff, float] | None:
        speed = scuff.slide * rate / float(self.span[leg])
        return (scuff, speed) if self._is_audible(leg, scuff.slide, rate) else None

    def _is_audible(self, leg: int, slide: float, rate: float) -> bool:
        return bool(slide * rate >= MIN_SCUFF_SPEED * self.herd.legs.lengths[leg] * self.span[leg])


def _path(start: Array, end: Array, height: float, parts: Array, bend: Array | None) -> Array:
    """Return the tips (n, 3) of one foot at fractions (n,) of its swing [m]."""
    bends = None if bend is None else np.broadcast_to(bend, (len(parts), *bend.shape))
    return swing_positions(start, end, height, parts, bends)


# --- contacts -----------------------------------------------------------------------


class FootContacts:
    """The contacts of the feet of a herd.

    Attributes:
        scuffs: of the swings.
        mass: (L,) of the legs [kg].
        contacts: of the last step.
    """

    def __init__(
        self, herd: Herd, world: World, poses: AuthoredPoses, materials: Sequence[str]
    ) -> None:
        self.herd, self.world, self.poses = herd, world, poses
        self.scuffs = ScuffDetector(herd, world.ground)
        self.mass = leg_masses(herd)
        self.contacts: list[Contact] = []
        self._materials = foot_materials(herd, materials)

    def scuff(self, moment: Moment, leg: int, rate: float) -> None:
        """Note that a swinging foot scuffs, at a rate of the phase [1/s]."""
        audible = self.scuffs.mid_swing(leg, rate)
        if audible is not None and not self._is_posed(moment, leg):
            scuff, speed = audible
            mass = scuff.mass_fraction * float(self.mass[leg])
            self._add(moment, leg, (scuff.place, scuff.normal), speed, mass, "scuff")

    def touch(
        self,
        moment: Moment,
        leg: int,
        hold: Foothold,
        swing: tuple[Array, float, Array | None],
        timing: tuple[float, float],
    ) -> None:
        """Note that a foot comes down.

        Args:
            moment: of touchdown.
            leg: its number.
            hold: its foothold.
            swing: tip at lift-off (3,) [m], height of the arch [m], and bend.
            timing: duration of the swing [s], and rate of the phase [1/s].
        """
        if self._is_posed(moment, leg):
            return
        (start, height, bend), (time, rate) = swing, timing
        speed = touchdown_speed(start, hold.tip, height, hold.normal, time, bend)
        mass = float(self.mass[leg])
        self._add(moment, leg, (hold.place, hold.normal), speed, mass, "touch")
        audible = self.scuffs.touchdown(leg, start, hold, height, rate, bend)
        if audible is not None:
            scuff, speed = audible
            surface = scuff.place, scuff.normal
            self._add(moment, leg, surface, speed, scuff.mass_fraction * mass, "scuff")

    def _is_posed(self, moment: Moment, leg: int) -> bool:
        """Return whether the author has posed a foot elsewhere, off the ground."""
        if not self.poses.postures:
            return False
        time = np.array([moment[0] * self.world.clock.dt])
        return bool(self.poses.free_fraction(time)[0, leg] < 0.5)

    def _add(
        self,
        moment: Moment,
        leg: int,
        surface: tuple[Array, Array],
        speed: float,
        mass: float,
        kind: ContactKind,
    ) -> None:
        """Add a contact.

        Args:
            moment: when.
            leg: its number.
            surface: place (3,) [m] and normal (3,) of the ground.
            speed: of the contact [m/s].
            mass: with this speed [kg].
            kind: of contact.
        """
        herd, owner = self.herd, int(self.herd.owner[leg])
        step, fraction = moment
        place, normal = ((float(x), float(y), float(z)) for x, y, z in surface)
        self.contacts.append(
            Contact(
                step=step,
                fraction=min(max(fraction, 0.0), np.nextafter(1.0, 0.0)),
                performer=herd.names[owner],
                part=f"{herd.names[owner]}.{herd.leg_names[leg]}",
                other="terrain",
                place=place,
                normal=normal,
                speed=speed,
                energy=0.5 * mass * speed * speed,
                material=self._materials[leg],
                surface=self.world.ground.material,
                size=float(herd.legs.lengths[leg]),
                kind=kind,
            )
        )
