"""Footfalls: where the feet of acting people came down in a step, as contacts of the take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.step_report import LATEST, ContactReporter
from pipeline.simulation.clock import Clock
from pipeline.simulation.dynamics.compiled import Records, bound, entry
from pipeline.simulation.people.proportions import SEGMENT_MASSES
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact
from pipeline.simulation.terrain import Ground

LEG_MASS = SEGMENT_MASSES["thigh"] + SEGMENT_MASSES["shin"] + SEGMENT_MASSES["foot"]
"""Mass that comes down with a foot, as a fraction of the body."""

SHOES = "leather"
"""Sound material of steps."""


class FootfallReporter:
    """The footfalls of all acting people of a troupe.

    Args:
        persons: `PERSON` records.
        controllers: of the people.
        masses: of the people [kg].
        ground: the terrain.
        clock: of the scene.
        reporter: knows what feet stand on.
    """

    def __init__(
        self,
        persons: Records,
        controllers: Sequence[PersonController],
        masses: Sequence[float],
        ground: Ground,
        clock: Clock,
        reporter: ContactReporter,
    ) -> None:
        self._persons, self._controllers, self._masses = persons, controllers, masses
        self._ground, self._clock, self._reporter = ground, clock, reporter
        self._touchdowns = persons["touchdowns"]
        # Of level ground, which has one normal.
        self._normal: list[float] | None = None
        if np.ptp(ground.field.heights) == 0.0:
            self._normal = ground.field.normal(np.zeros(1), np.zeros(1))[0].tolist()

    @cached_property
    def _has_touchdowns(self) -> Callable[[], bool]:
        return bound(_has_touchdowns, self._persons)

    def contacts(self, step: int) -> tuple[Contact, ...]:
        """Return the footfalls since the last report as contacts of a step, and start a new one."""
        if not self._has_touchdowns():
            return ()
        people, feet = np.nonzero(self._touchdowns)
        normals = self._normals(self._persons["stance_place"][people, feet])
        self._touchdowns[:] = 0
        return tuple(
            self._footfall(n, k, normal, step)
            for n, k, normal in zip(people.tolist(), feet.tolist(), normals, strict=True)
        )

    def _normals(self, places: Array) -> Sequence[Sequence[float]]:
        """Return the normals of the ground at places (n, 3) [m]."""
        if self._normal is not None:
            return [self._normal] * len(places)
        normals: list[list[float]] = self._ground.field.normal(places[:, 0], places[:, 2]).tolist()
        return normals

    def _footfall(self, n: int, k: int, normal: Sequence[float], step: int) -> Contact:
        """Return the contact of a foot of a person on ground with a normal."""
        controller, person = self._controllers[n], self._controllers[n].record
        if person.stance_on_deck[k] == 1:
            normal = person.deck_axes[:, 1].tolist()
        other, surface = self._reporter.ground_below(person, k)
        x, y, z = person.stance_place[k].tolist()
        speed = float(person.touchdown_speed[k])
        fraction = float(person.touchdown_time[k]) / self._clock.dt
        return Contact(
            step=step,
            fraction=min(max(fraction, 0.0), LATEST),
            performer=controller.name,
            part=f"{controller.name}.foot_{'lr'[k]}",
            other=other,
            place=(x, y - float(person.ankle), z),
            normal=(normal[0], normal[1], normal[2]),
            speed=speed,
            energy=0.5 * self._masses[n] * LEG_MASS * speed * speed,
            material=SHOES,
            surface=surface,
            size=float(person.thigh + person.shin),
            kind="touch",
        )


@entry
def _has_touchdowns(persons: Records) -> bool:
    """Tell whether feet have touched down since the last report, and start a new one."""
    found = False
    for k in range(len(persons)):
        persons[k].report_time = 0.0
        found |= persons[k].touchdowns[0] != 0 or persons[k].touchdowns[1] != 0
    return found
