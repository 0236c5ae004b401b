"""Footfalls: what is known when feet meet the ground."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.locomotion.footing.footholds import Foothold
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import foot_materials, leg_mass
from pipeline.simulation.locomotion.postures import Postures
from pipeline.simulation.locomotion.swings.scuffing import Scuffing
from pipeline.simulation.locomotion.swings.swing import approach_speed
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, ContactKind
from pipeline.simulation.troupe import World

Moment = tuple[int, float]
"""The last step before it, and the fraction of a step after that."""


class Footfalls:
    """Contacts of the feet of a herd.

    Attributes:
        mass: (L,) of the legs [kg].
        contacts: since they were taken away.
    """

    def __init__(
        self, herd: Herd, world: World, postures: Postures, materials: Sequence[str]
    ) -> None:
        self.herd = herd
        self.world = world
        self.postures = postures
        self.scuffing = Scuffing(herd, world.ground)
        self.mass = leg_mass(herd)
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
        speed = approach_speed(start, hold.tip, height, hold.normal, time, bend)
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
