"""Treads: where and when the performers of a take tread on the ground, or roll over it.

Grass lies flat from just before a tread, rises again once the foot has left, fast at first, and
stays a little bent.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pipeline.production.shots.footprint_timeline import contact_row, foot_radii
from pipeline.production.surroundings.lattice_noise import smoothstep
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, Take

PRESS_TIME = 0.1
"""Time in which grass is pressed down before a foot stands [s]."""

RISE_TIME = 1.2
"""Time constant with which it rises after the foot has left [s]."""

KEPT = 0.4
"""Part of the bend that is left in the end."""

RADIUS_OF_SIZE = 0.3
"""Radius of the tread of a body relative to its size."""

RADII = 0.03, 0.5
"""Least and greatest radius of a tread [m]."""

BORDER = 0.08
"""Distance beyond a tread over which grass leans away from it [m]."""

LYING = 1.35
"""Bend of grass under a foot [rad]."""

_NOWHERE = 1e-3
"""Distance from the middle of a tread below which grass falls to a side of its own [m]."""


@dataclass(frozen=True, eq=False)
class Treads:
    """M treads.

    Attributes:
        places: (M, 2) x and z of their middles [m].
        radii: (M,) [m].
        starts: (M,) rows of the take, with fractions, at which the ground is touched.
        ends: (M,) rows at which it is left; infinite where that never happens.
        rate: rows in a second.
    """

    places: Array
    radii: Array
    starts: Array
    ends: Array
    rate: float

    @staticmethod
    def of(take: Take) -> Treads:
        """Return the treads of a take."""
        found = np.array(list(_treads(take)), float).reshape(-1, 5)
        rate = float(take.header.rate * take.header.samples)
        return Treads(found[:, :2], found[:, 2], found[:, 3], found[:, 4], rate)

    def near(self, places: Array, widths: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return pairs of plants and treads that bend them, both (P,).

        Args:
            places: (N, 2) of plants [m].
            widths: (N,) their radii [m].
        """
        if not len(self.places) or not len(places):
            return np.zeros(0, np.int64), np.zeros(0, np.int64)
        reach = self.radii.max() + BORDER + widths
        found = cKDTree(self.places).query_ball_point(places, reach, workers=1, return_sorted=True)
        counts = [len(some) for some in found]
        plants = np.repeat(np.arange(len(places)), counts)
        treads = np.concatenate([np.asarray(some, np.int64) for some in found])
        apart = np.linalg.norm(places[plants] - self.places[treads], axis=-1)
        kept = apart < self.radii[treads] + BORDER + widths[plants]
        return plants[kept], treads[kept]

    def bends(self, plants: Array, treads: NDArray[np.int64], widths: Array, aside: Array) -> Array:
        """Return the bends (P, 2) along x and z of plants that lie flat beside treads [rad].

        Args:
            plants: (P, 2) places of plants [m].
            treads: (P,) numbers of the treads.
            widths: (P,) radii of the plants [m].
            aside: (P, 2) unit vectors to which those in the middle of a tread fall.
        """
        away = plants - self.places[treads]
        apart = np.linalg.norm(away, axis=-1)
        radii = self.radii[treads]
        share = 1.0 - smoothstep(0.0, 1.0, (apart - 0.7 * radii) / (0.3 * radii + BORDER + widths))
        way = away + np.maximum(0.3 * radii - apart, _NOWHERE)[:, None] * aside
        way /= np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-9)
        return np.asarray(LYING * share[:, None] * way)

    def pressed(self, row: float) -> Array:
        """Return how far (M,) the ground is pressed at a row of the take, 0 to 1."""
        press = self.rate * PRESS_TIME
        down = smoothstep(-press, 0.0, row - self.starts)
        since = np.maximum(row - self.ends, 0.0) / self.rate
        return np.asarray(down * (KEPT + (1.0 - KEPT) * np.exp(-since / RISE_TIME)))


def _treads(take: Take) -> Iterator[tuple[float, float, float, float, float]]:
    """Yield x, z and radius [m], and the rows of start and end, of each tread."""
    contacts = [c for c in take.contacts if c.other == "terrain"]
    radii = foot_radii(take)
    ends: dict[tuple[str, str], float] = {}
    low, high = RADII
    # From the end: a foot has left the ground when it is lifted, or treads elsewhere.
    for contact in sorted(contacts, key=lambda c: contact_row(take, c), reverse=True):
        limb, row = (contact.performer, contact.part), contact_row(take, contact)
        if contact.kind == "lift":
            ends[limb] = row
            continue
        radius = _radius(contact, radii)
        radius = min(max(radius, low), high)
        if contact.kind in ("roll", "slide"):
            for k, (x, _, z) in enumerate(contact.places):
                yield x, z, radius, row + k, row + k
        elif contact.kind in ("touch", "hit"):
            x, _, z = contact.place
            yield x, z, radius, row, row if contact.kind == "hit" else ends.get(limb, np.inf)
        ends[limb] = row


def _radius(contact: Contact, radii: dict[str, float]) -> float:
    foot = radii.get(contact.part, radii.get(f"{contact.performer}.{contact.part}"))
    return RADIUS_OF_SIZE * contact.size if foot is None else foot
