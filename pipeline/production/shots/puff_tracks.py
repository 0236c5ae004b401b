"""Puff tracks: dust where feet and bodies strike dry ground, and spray where they enter water.

Each contact of the take with the ground raises one puff, which grows, rises, drifts with the wind
and is gone within two seconds. Rain lays the dust.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.take import Contact, Take
from render.color import linear
from render.config import Material, Weather
from render.plume import Puff
from render.water import WaterSurface

DUST: Mapping[str, float] = {
    "sand": 1.6,
    "soil": 1.2,
    "snow": 0.8,
    "gravel": 0.6,
    "grass": 0.05,
    "moss": 0.03,
}
"""Optical depth of the dust of a strong step, by the texture of the ground."""

MAX_PUFFS = 64
"""Puffs in the air at once; of more, the latest are shown."""

_LEAST_SPEED = 0.25
"""Speed of an impact below which no dust rises [m/s]."""
_FULL_SPEED = 1.6
"""Speed of an impact from which it raises all the dust that it can [m/s]."""
_RADIUS_OF_JOULE = 0.105
"""Radius of a puff of one joule [m]; it grows with the cube root of the energy."""
_RADII = 0.02, 0.8
_LIFE, _LIFE_OF_RADIUS = 0.5, 1.6
"""Time that dust is seen [s], and what each metre of radius adds to it."""
_SPRAY_LIFE, _SPRAY_DEPTH, _SPRAY_SPEED = 0.55, 0.9, 1.1
"""Of spray: how long it is seen [s], its optical depth, and its first speed upward [m/s]."""
_GRAVITY = 9.81


@dataclass(frozen=True)
class _Birth:
    """A puff as it is raised.

    Attributes:
        time: since the film began [s].
        place: of the contact [m].
        radius: of the impact [m].
        depth: optical depth at first.
        life: how long it is seen [s].
        is_spray: whether it is water.
        seed: of its noise.
    """

    time: float
    place: tuple[float, float, float]
    radius: float
    depth: float
    life: float
    is_spray: bool
    seed: int


@dataclass(frozen=True, eq=False)
class PuffTracks:
    """All puffs of a film.

    Attributes:
        births: in the order of time.
        color: linear, of the dust.
        wind: near the ground, along x and z [m/s].
    """

    births: tuple[_Birth, ...]
    color: tuple[float, float, float]
    wind: tuple[float, float]

    @staticmethod
    def of(
        take: Take, ground: Material, weather: Weather, water: WaterSurface | None
    ) -> PuffTracks:
        """Return the puffs of a take.

        Args:
            take: with its contacts.
            ground: material of the terrain.
            weather: rain lays the dust.
            water: above the ground, or None.
        """
        dust = DUST.get(ground.texture, 0.0) * max(1.0 - 2.5 * weather.wetness, 0.0)
        level = -math.inf if water is None else water.level
        step = 1.0 / float(take.header.rate * take.header.steps)
        births = [
            born
            for i, contact in enumerate(take.contacts)
            if contact.other == "terrain" and contact.kind in ("touch", "hit")
            for born in [_birth(contact, step, dust, level, i)]
            if born is not None
        ]
        second = ground.color if ground.color2 is None else ground.color2
        r, g, b = (0.5 * (linear(ground.color) + linear(second))).tolist()
        # Fine dust is paler than the ground that it comes from.
        pale = tuple(float(min(0.25 + 0.75 * c, 0.9) if c > 0.4 else 0.08 + c) for c in (r, g, b))
        return PuffTracks(
            tuple(sorted(births, key=lambda born: born.time)),
            (pale[0], pale[1], pale[2]),
            weather.ground_wind,
        )

    def at(self, time: float) -> tuple[Puff, ...]:
        """Return the puffs in the air at a time [s]."""
        alive = [born for born in self.births if 0.0 <= time - born.time < born.life]
        return tuple(self._puff(born, time - born.time) for born in alive[-MAX_PUFFS:])

    def _puff(self, born: _Birth, age: float) -> Puff:
        part = age / born.life
        x, y, z = born.place
        if born.is_spray:
            radius = born.radius * (0.45 + 0.9 * part)
            rise = _SPRAY_SPEED * age - 0.5 * _GRAVITY * age * age
            depth = born.depth * (1.0 - part) ** 1.5
            return Puff((x, y + max(rise, -radius), z), radius, depth, (0.9, 0.92, 0.95), born.seed)
        # Fast at first; then the air holds it.
        radius = born.radius * (0.5 + 1.5 * math.sqrt(part))
        drift = 0.5 * age * part
        place = (
            x + self.wind[0] * drift,
            y + 0.3 * born.radius + 0.45 * born.radius * math.sqrt(part),
            z + self.wind[1] * drift,
        )
        thin = (born.radius / max(radius, born.radius)) ** 1.2
        depth = born.depth * thin * min(age / 0.05, 1.0) * (1.0 - part) ** 1.6
        return Puff(place, radius, depth, self.color, born.seed)


def _birth(contact: Contact, step: float, dust: float, level: float, number: int) -> _Birth | None:
    if contact.speed < _LEAST_SPEED:
        return None
    low, high = _RADII
    radius = float(np.clip(_RADIUS_OF_JOULE * max(contact.energy, 0.0) ** (1 / 3), low, high))
    share = min(contact.speed / _FULL_SPEED, 1.0)
    time = (contact.step + contact.fraction) * step
    x, y, z = contact.place
    below = level - y
    if below > 0.0:
        # Deep water is entered long before the ground is met.
        if below > 4.0 * radius:
            return None
        place = (x, level, z)
        return _Birth(time, place, 0.8 * radius, _SPRAY_DEPTH * share, _SPRAY_LIFE, True, number)
    if dust <= 0.0:
        return None
    life = _LIFE + _LIFE_OF_RADIUS * radius
    return _Birth(time, (x, y, z), radius, dust * share, life, False, number)
