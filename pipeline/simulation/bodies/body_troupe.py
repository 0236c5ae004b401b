"""Body troupe: what free rigid bodies have in common, whether or not they meet one another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.bodies.body_instances import BodyInstance, body_inventory
from pipeline.simulation.bodies.sliding_tracker import SlidingInterval, SlidingTracker
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, TakeNote
from pipeline.simulation.troupe import Facts, Troupe, World

if TYPE_CHECKING:
    from pipeline.simulation.dynamics.mujoco_world import Strike
    from pipeline.simulation.dynamics.terrain_bodies import GroundImpact

DROP_DEPTH = 10.0
"""Depth below the lowest ground at which a body that left the terrain is removed [m]."""

MAX_START_DEPTH = 1e-3
"""Initial overlap that is refused, in sizes of the body."""

DepthTest = Callable[[], NDArray[np.bool_]]
"""Returns (N,) which bodies are in the ground."""


class BodyTroupe(Troupe):
    """Bodies, their contacts and notes.

    Args:
        bodies: in the order of their nodes.
        world: constants of the scene.
        dt: interval between two observations of sliding [s].

    Attributes:
        bodies: all bodies.
        alive: (N,) which of them are not removed.
    """

    def __init__(
        self,
        bodies: Sequence[BodyInstance],
        world: World,
        dt: float,
    ) -> None:
        self.world, self.bodies = world, bodies
        self.inventory = body_inventory(self.bodies, world.clock.rows)
        self.alive = np.ones(len(self.bodies), dtype=bool)
        self._floor = float(world.ground.field.heights.min()) - DROP_DEPTH
        self._rolls = SlidingTracker("roll", len(self.bodies), dt, world.detect.roll)
        self._slides = SlidingTracker("slide", len(self.bodies), dt, world.detect.slide)
        self._contacts: list[Contact] = []
        self._notes: list[TakeNote] = []

    def facts(self) -> Facts:
        """See `Troupe`."""
        facts = Facts(tuple(self._contacts), tuple(self._notes))
        self._contacts.clear()
        self._notes.clear()
        return facts

    def _remove_lost(self, step: int, heights: Array) -> NDArray[np.int64]:
        """Marks bodies far below the terrain as removed; returns their numbers.

        Args:
            step: the present one.
            heights: (N,) of the bodies that move by themselves, infinite for others [m].
        """
        lost = np.flatnonzero(self.alive & (heights < self._floor))
        self.alive[lost] = False
        text = f"left the terrain; removed {DROP_DEPTH:g} m below it"
        self._notes += [TakeNote("dropped", step, self.bodies[i].name, text) for i in lost.tolist()]
        return lost

    def _contact(
        self,
        body: int,
        impact: GroundImpact | Strike,
        step: int,
        fraction: float,
        *,
        other: str,
        surface: str,
    ) -> Contact:
        """Returns the contact of an impact on a thing of a name and a material."""
        own = self.bodies[body]
        return Contact(
            step=step,
            fraction=fraction,
            performer=own.performer,
            part=own.part,
            place=impact.place,
            normal=impact.normal,
            speed=impact.speed,
            energy=impact.energy,
            material=own.material,
            size=own.size,
            kind="hit",
            other=other,
            surface=surface,
        )

    def _sliding_contact(
        self,
        interval: SlidingInterval,
        steps: tuple[int, int],
        samples: Sequence[int],
        *,
        other: str,
        surface: str,
    ) -> Contact:
        """Returns the contact of an interval of rolling or sliding.

        Args:
            interval: the interval.
            steps: first and last step.
            samples: observations that fall on rows of the take.
            other: name of the other thing.
            surface: its material.
        """
        own = self.bodies[interval.body]
        return Contact(
            step=steps[0],
            fraction=0.0,
            performer=own.performer,
            part=own.part,
            other=other,
            place=interval.place,
            normal=interval.normal,
            speed=interval.speed,
            energy=0.5 * own.model.mass.mass * interval.speed**2,
            material=own.material,
            surface=surface,
            size=own.size,
            kind=interval.kind,
            until=steps[1],
            speeds=tuple(interval.speeds[k] for k in samples),
            places=tuple(interval.places[k] for k in samples),
        )


def lower_to_ground(
    p: Array, rows: NDArray[np.bool_], bounds: tuple[Array, Array], rounds: int, is_deep: DepthTest
) -> None:
    """Lowers bodies onto the ground by bisection of their heights.

    Args:
        p: (N, 3) positions, changed [m].
        rows: (N,) which bodies to lower.
        bounds: (N,) lower and upper bound of the heights [m].
        rounds: number of bisections.
        is_deep: returns (N,) which bodies are in the ground at `p`.
    """
    low, high = bounds
    for _ in range(rounds):
        p[rows, 1] = 0.5 * (low + high)[rows]
        deep = is_deep()
        low, high = np.where(deep, p[:, 1], low), np.where(deep, high, p[:, 1])
    p[rows, 1] = high[rows]
