"""Footfalls: what is known when feet meet the ground."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.authored_poses import AuthoredPoses
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.gaits.gait_transition import StepTiming
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import foot_materials, leg_masses
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    swing_positions,
    touchdown_speed,
)
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, ContactKind
from pipeline.simulation.terrain import Ground
from pipeline.simulation.troupe import World

LOW = 0.015
"""A sole nearer to the ground than this part of its leg brushes over it."""

QUICK = 0.5
"""Slower than this along the ground nothing is heard, in lengths of the leg [1/s]."""

SHUFFLES = 0.1
"""Feet that step higher than this part of their legs do not scuff.

`lift_to_clear` leaves at least 0.4 of the step under the arch, whose height is 0.56 of its
top where the middle of a swing begins: 0.022 of the leg, more than `LOW` on slopes that can
be stepped on.
"""

MIDDLE = np.linspace(0.25, 0.75, 65)
"""Parts of a swing in which it scuffs; at its ends every foot is near the ground."""

LAST = np.array([0.999, 1.0])
"""The end of a swing: how fast it goes there is how fast the foot comes down."""

WEIGHT = 0.1
"""Part of a leg that its foot drags along as it scuffs, at most."""


@dataclass(frozen=True, eq=False)
class Scuff:
    """A foot that rubs over the ground.

    Attributes:
        part: of the swing at which it does so.
        place: (3,) on the ground [m].
        normal: (3,) of the ground there.
        way: how far it goes along the ground, per whole swing [m].
        weight: part of its leg that drags.
    """

    part: float
    place: Array
    normal: Array
    way: float
    weight: float


def scuff_in_swing(
    ground: Ground, tips: Array, parts: Array, sole: float, low: float
) -> Scuff | None:
    """Return where a foot scuffs the most, None if it is never as low as that.

    Args:
        ground: what it goes over.
        tips: (n, 3) places of its tip [m].
        parts: (n,) of its swing at which it is there.
        sole: radius of the tip [m].
        low: how near to the ground the sole has to come [m].
    """
    x, z = tips[:, 0], tips[:, 2]
    height, normals = ground.surface(x, z)
    depth = low - ((tips[:, 1] - height) * normals[:, 1] - sole)
    if (depth <= 0.0).all():
        return None
    way = _along(np.gradient(tips, parts, axis=0), normals)
    rubbed = depth * way
    # On level ground it rubs alike before and after the top; rounding is not to choose.
    worst = int(np.argmax(rubbed >= (1.0 - 1e-6) * rubbed.max()))
    place = np.array([x[worst], height[worst], z[worst]])
    weight = WEIGHT * min(float(depth[worst]) / low, 1.0)
    return Scuff(float(parts[worst]), place, normals[worst], float(way[worst]), weight)


def scuff_at_touchdown(tips: Array, parts: Array, place: Array, normal: Array) -> Scuff:
    """Return how a foot scuffs as it comes down.

    Args:
        tips: (2, 3) places of its tip at the end of its swing [m].
        parts: (2,) of the swing at which it is there.
        place: (3,) where it comes down [m].
        normal: (3,) of the ground there.
    """
    way = _along(np.diff(tips, axis=0) / np.diff(parts), normal)
    return Scuff(1.0, place, normal, float(way[0]), WEIGHT)


def _along(v: Array, normals: Array) -> Array:
    """Return the lengths (n,) of vectors (n, 3) along a surface."""
    across = (v * normals).sum(axis=-1, keepdims=True)
    result: Array = np.linalg.norm(v - across * normals, axis=-1)
    return result


class ScuffDetector:
    """The scuffs of a herd.

    Attributes of the state:
        at: (L,) phase at which the swing of each leg scuffs, infinite if it does not.
        span: (L,) how long the swing of each leg lasts, in cycles.
    """

    def __init__(self, herd: Herd, ground: Ground) -> None:
        self.herd = herd
        self.ground = ground
        self.at = np.full(len(herd.owner), np.inf)
        self.span = herd.swings.copy()
        self._planned: dict[int, Scuff] = {}
        # Swings are linear in their ways and heights, and plain ones come to rest.
        step, still = np.array([1.0, 0.0, 0.0]), np.zeros(3)
        ends = (
            _way(still, step, 0.0, LAST, None),
            _way(still, still, 1.0, LAST, None),
        )
        speeds = [np.linalg.norm(np.diff(tips, axis=0)) / np.diff(LAST)[0] for tips in ends]
        self._slides = float(max(speeds))

    def plan(
        self,
        leg: int,
        step: StepTiming,
        start: Array,
        end: Array,
        heights: tuple[float, float],
        bend: Array | None = None,
    ) -> None:
        """Find out where a swing will scuff.

        Args:
            leg: which.
            step: when it swings.
            start: (3,) tip at lifting [m].
            end: (3,) tip at coming down [m].
            heights: of the arch, and of that on level ground [m].
            bend: what the swing has beside the arch.
        """
        self.at[leg], self.span[leg] = np.inf, step.swing
        height, level = heights
        if level >= SHUFFLES * self.herd.legs.lengths[leg]:
            return
        herd = self.herd
        tips = _way(start, end, height, MIDDLE, bend)
        low = LOW * float(herd.legs.lengths[leg])
        scuff = scuff_in_swing(self.ground, tips, MIDDLE, float(herd.sole[leg]), low)
        if scuff is not None:
            self._planned[leg] = scuff
            self.at[leg] = step.up + scuff.part * step.swing

    def due(self, before: Array, phase: Array) -> NDArray[np.int64]:
        """Return the legs that scuff after their phases were `before` (L,), up to `phase` (L,)."""
        return np.flatnonzero((self.at > before) & (self.at <= phase))

    def heard(self, leg: int, rate: float) -> tuple[Scuff, float] | None:
        """Return the scuff planned for a leg and its speed [m/s], None if it is too slow.

        Args:
            leg: which.
            rate: of the phase, in cycles a second.
        """
        return self._loud(leg, self._planned[leg], rate)

    def landing(
        self,
        leg: int,
        start: Array,
        hold: Foothold,
        height: float,
        rate: float,
        bend: Array | None = None,
    ) -> tuple[Scuff, float] | None:
        """Return how a leg that comes down scuffs and its speed [m/s].

        Args:
            leg: which.
            start: (3,) tip at lifting [m].
            hold: where it comes down.
            height: of the arch [m].
            rate: of the phase, in cycles a second.
            bend: what the swing has beside the arch.

        Returns:
            None if it is too slow, or has scuffed in this swing already.
        """
        most = self._slides * (math.dist(start, hold.tip) + height)
        if np.isfinite(self.at[leg]) or not self._is_loud(leg, most, rate):
            return None
        tips = _way(start, hold.tip, height, LAST, bend)
        return self._loud(leg, scuff_at_touchdown(tips, LAST, hold.place, hold.normal), rate)

    def _loud(self, leg: int, scuff: Scuff, rate: float) -> tuple[Scuff, float] | None:
        speed = scuff.way * rate / float(self.span[leg])
        return (scuff, speed) if self._is_loud(leg, scuff.way, rate) else None

    def _is_loud(self, leg: int, way: float, rate: float) -> bool:
        return bool(way * rate >= QUICK * self.herd.legs.lengths[leg] * self.span[leg])


def _way(start: Array, end: Array, height: float, parts: Array, bend: Array | None) -> Array:
    """Return the tips (n, 3) of one foot at parts (n,) of its swing [m]."""
    n = len(parts)
    bends = None if bend is None else np.broadcast_to(bend, (n, *bend.shape))
    return swing_positions(start, end, height, parts, bends)


Moment = tuple[int, float]
"""The last step before it, and the fraction of a step after that."""


class FootContacts:
    """Contacts of the feet of a herd.

    Attributes:
        mass: (L,) of the legs [kg].
        contacts: since they were taken away.
    """

    def __init__(
        self, herd: Herd, world: World, postures: AuthoredPoses, materials: Sequence[str]
    ) -> None:
        self.herd = herd
        self.world = world
        self.postures = postures
        self.scuffing = ScuffDetector(herd, world.ground)
        self.mass = leg_masses(herd)
        self.contacts: list[Contact] = []
        self._materials = foot_materials(herd, materials)

    def scuff(self, moment: Moment, leg: int, rate: float) -> None:
        """Let a foot that swings brush over the ground.

        Args:
            moment: when.
            leg: whose foot.
            rate: of the phase, in cycles a second.
        """
        heard = self.scuffing.heard(leg, rate)
        if heard is not None and not self._is_posed(moment, leg):
            scuff, speed = heard
            mass = scuff.weight * float(self.mass[leg])
            self._meet(moment, leg, (scuff.place, scuff.normal), speed, mass, "scuff")

    def touch(
        self,
        moment: Moment,
        leg: int,
        hold: Foothold,
        way: tuple[Array, float, Array | None],
        pace: tuple[float, float],
    ) -> None:
        """Let a foot come down.

        Args:
            moment: when.
            leg: whose foot.
            hold: where.
            way: where its swing began (3,) [m], how high it arched [m], and its bend.
            pace: how long it swung [s], and the rate of the phase, in cycles a second.
        """
        if self._is_posed(moment, leg):
            return
        (start, height, bend), (time, rate) = way, pace
        speed = touchdown_speed(start, hold.tip, height, hold.normal, time, bend)
        mass = float(self.mass[leg])
        self._meet(moment, leg, (hold.place, hold.normal), speed, mass, "touch")
        slide = self.scuffing.landing(leg, start, hold, height, rate, bend)
        if slide is not None:
            scuff, speed = slide
            where = scuff.place, scuff.normal
            self._meet(moment, leg, where, speed, scuff.weight * mass, "scuff")

    def _is_posed(self, moment: Moment, leg: int) -> bool:
        """Tell whether its author has a foot somewhere else: it meets no ground."""
        time = np.array([moment[0] * self.world.clock.dt])
        return bool(self.postures.of) and bool(self.postures.free(time)[0, leg] < 0.5)

    def _meet(
        self,
        moment: Moment,
        leg: int,
        where: tuple[Array, Array],
        speed: float,
        mass: float,
        kind: ContactKind,
    ) -> None:
        """Note that a foot meets the ground.

        Args:
            moment: when.
            leg: whose foot.
            where: (3,) place [m] and (3,) normal of the ground.
            speed: of what kind of contact it is [m/s].
            mass: that has this speed [kg].
            kind: of contact.
        """
        herd, owner = self.herd, int(self.herd.owner[leg])
        place, normal = where
        step, fraction = moment
        self.contacts.append(
            Contact(
                step=step,
                fraction=min(max(fraction, 0.0), np.nextafter(1.0, 0.0)),
                performer=herd.names[owner],
                part=f"{herd.names[owner]}.{herd.leg_names[leg]}",
                other="terrain",
                place=_plain(place),
                normal=_plain(normal),
                speed=speed,
                energy=0.5 * mass * speed * speed,
                material=self._materials[leg],
                surface=self.world.ground.material,
                size=float(herd.legs.lengths[leg]),
                kind=kind,
            )
        )


def _plain(v: Array) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in v)
    return x, y, z
