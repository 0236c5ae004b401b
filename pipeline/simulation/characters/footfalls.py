"""Footfalls: feet of people that came down in a step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.clock import Clock
from pipeline.simulation.dynamics.compiled import Record, Records
from pipeline.simulation.people.proportions import SEGMENT_MASSES
from pipeline.simulation.take import Contact
from pipeline.simulation.terrain import Ground

LEG = SEGMENT_MASSES["thigh"] + SEGMENT_MASSES["shin"] + SEGMENT_MASSES["foot"]
"""What of a body comes down with a foot."""


def footfalls(
    persons: Records,
    names: Sequence[str],
    masses: Sequence[float],
    material: str,
    ground: Ground,
    clock: Clock,
    step: int,
) -> list[Contact]:
    """Return the footfalls since they were last asked for, and begin anew.

    Args:
        persons: records.
        names: of them.
        masses: of them [kg].
        material: of their shoes.
        ground: the terrain.
        clock: of the scene.
        step: that was taken.
    """
    found = []
    for n, k in np.argwhere(persons["landed"]).tolist():
        found.append(
            _contact(persons[n], k, names[n], masses[n] * LEG, material, ground, clock, step)
        )
    persons["landed"], persons["since"] = 0, 0.0
    return found


def _contact(
    person: Record,
    k: int,
    name: str,
    mass: float,
    material: str,
    ground: Ground,
    clock: Clock,
    step: int,
) -> Contact:
    x, y, z = (float(c) for c in person.stood[k])
    normal = ground.field.normal(np.asarray(x), np.asarray(z))
    speed = float(person.landing[k])
    fraction = min(max(float(person.landed_at[k]) / clock.dt, 0.0), float(np.nextafter(1.0, 0.0)))
    return Contact(
        step=step,
        fraction=fraction,
        performer=name,
        part=f"{name}.foot_{'lr'[k]}",
        other="terrain",
        place=(x, y - float(person.ankle), z),
        normal=(float(normal[0]), float(normal[1]), float(normal[2])),
        speed=speed,
        energy=0.5 * mass * speed * speed,
        material=material,
        surface=ground.material,
        size=float(person.thigh + person.shin),
        kind="touch",
    )
