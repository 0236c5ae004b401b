"""Rule: what a group of any kind is to its troupe."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pipeline.simulation.bodies.groups.others import Cast, Others
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact
from pipeline.simulation.troupe import Inventory, Rows, World


@dataclass(frozen=True, eq=False)
class Setting:
    """What is known of a group before it moves.

    Attributes:
        name: of it.
        path: where its words stand in the scene.
        place: (3,) where it is said to be [m].
        parent: whom it goes along with, if anybody.
        material: of its members.
        world: that it is in.
    """

    name: str
    path: str
    place: Array
    parent: str | None
    material: str
    world: World

    @property
    def seed(self) -> tuple[int, str]:
        """Seed of the scene, and the name that it is split by."""
        return self.world.seed, self.name

    def height(self, places: Array) -> Array:
        """Return the heights (...) of the ground at places (..., 3) [m]."""
        return self.world.ground.height(places[..., 0], places[..., 2])


class Rule(Protocol):
    """A group that moves by its rule."""

    inventory: Inventory

    def meet(self, cast: Cast) -> None:
        """Find those that its words name.

        Raises:
            SceneError: somebody has no such part.
        """

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """Make for a place (x, z) from `time` on, if it is one that can be sent."""

    def write(self, rows: Rows, times: Array, others: Others) -> list[Contact]:
        """Go on through n rows and write them.

        Args:
            rows: its slice of the take; all of it alive.
            times: (n,) of the rows, later than those before [s].
            others: everybody else in these rows.

        Returns:
            The contacts that have begun since the rows before.
        """


def start_of(at: tuple[float, ...], world: World) -> Array:
    """Return the place (3,) that two or three numbers stand for: two are on the ground [m]."""
    if len(at) == 3:
        return np.array(at)
    height = float(world.ground.height(np.array(at[0]), np.array(at[1])))
    return np.array([at[0], height, at[1]])
