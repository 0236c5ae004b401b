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

TOUCHDOWN = (
    *("person", "foot", "x", "y", "z", "ankle", "leg"),
    *("time", "speed", "is_on_deck"),
)
"""Columns of a table of touchdowns: number of the person and of the foot; place of the ankle,
height of the ankle above the sole and length of the leg [m]; time since the last report [s], speed
[m/s], and 1 for a foot on a deck."""

Normal = tuple[float, float, float]


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
        self._found: Array = np.zeros((2 * len(persons), len(TOUCHDOWN)))
        self._parts = [[f"{one.name}.foot_{side}" for side in "lr"] for one in controllers]
        # Of level ground, which has one normal.
        self._normal: Normal | None = None
        if np.ptp(ground.field.heights) == 0.0:
            self._normal = normal_at(ground, 0.0, 0.0)

    @cached_property
    def _take_touchdowns(self) -> Callable[[], int]:
        return bound(take_touchdowns, self._persons, self._found)

    def contacts(self, step: int) -> tuple[Contact, ...]:
        """Return the footfalls since the last report as contacts of a step, and start a new one."""
        count = self._take_touchdowns()
        if not count:
            return ()
        return tuple(self._footfall(row, step) for row in self._found[:count].tolist())

    def _footfall(self, row: Sequence[float], step: int) -> Contact:
        """Return the contact of a touchdown, a row of `TOUCHDOWN`."""
        n, k, x, y, z, ankle, leg, time, speed, is_on_deck = row
        n, k, other, surface = int(n), int(k), "terrain", self._reporter.surface
        normal = self._normal
        if is_on_deck:
            person = self._controllers[n].record
            up_x, up_y, up_z = person.deck_axes[:, 1].tolist()
            normal = up_x, up_y, up_z
            other, surface = self._reporter.deck_below(person)
        return Contact(
            step=step,
            fraction=min(max(time / self._clock.dt, 0.0), LATEST),
            performer=self._controllers[n].name,
            part=self._parts[n][k],
            other=other,
            place=(x, y - ankle, z),
            normal=normal_at(self._ground, x, z) if normal is None else normal,
            speed=speed,
            energy=0.5 * self._masses[n] * LEG_MASS * speed * speed,
            material=SHOES,
            surface=surface,
            size=leg,
            kind="touch",
        )


def normal_at(ground: Ground, x: float, z: float) -> Normal:
    """Return the normal of the ground at x and z [m]."""
    n_x, n_y, n_z = ground.field.normal(np.array([x]), np.array([z]))[0].tolist()
    return n_x, n_y, n_z


@entry
def take_touchdowns(persons: Records, found: Array) -> int:
    """Write the touchdowns of feet since the last report, start a new one, and return how many.

    Args:
        persons: `PERSON` records; changed.
        found: (2 P, 10) rows of `TOUCHDOWN`; changed.
    """
    count = 0
    for n in range(len(persons)):
        person = persons[n]
        person.report_time = 0.0
        for k in range(2):
            if person.touchdowns[k] == 0:
                continue
            person.touchdowns[k] = 0
            row, place = found[count], person.stance_place[k]
            row[0], row[1] = n, k
            row[2], row[3], row[4] = place[0], place[1], place[2]
            row[5], row[6] = person.ankle, person.thigh + person.shin
            row[7], row[8] = person.touchdown_time[k], person.touchdown_speed[k]
            row[9] = person.stance_on_deck[k]
            count += 1
    return count
