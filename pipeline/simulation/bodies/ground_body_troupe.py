"""Ground bodies: rigid bodies that meet nothing but the terrain; they fall, bounce, roll and rest.

Source: Sims 1987, 7.1 and ch. 12.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.bodies.body_instances import initial_state, instantiate_bodies
from pipeline.simulation.bodies.body_troupe import MAX_START_DEPTH, BodyTroupe, lower_to_ground
from pipeline.simulation.bodies.sliding_tracker import ROLLING_SLIP_RATIO, SlidingInterval
from pipeline.simulation.dynamics.rigid_body import Bodies, dot
from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Contact
from pipeline.simulation.troupe import World
from pipeline.spec.body import Body

BISECTIONS = 60


class GroundBodyTroupe(BodyTroupe):
    """All bodies that collide with the terrain only.

    Raises:
        SceneError: if a shape is no solid, or a body begins in the ground.
    """

    def __init__(
        self, cast: Sequence[tuple[int, Body]], world: World, materials: Sequence[str]
    ) -> None:
        super().__init__(instantiate_bodies(cast, world, materials), world, world.clock.dt)
        models = Bodies.of([body.model for body in self.bodies])
        self.dynamics = TerrainBodies(models, initial_state(self.bodies), world.ground)
        self._lower_to_ground()
        self._refuse_overlap()
        self._buffered: list[tuple[Array, Array, Array]] = []

    def advance(self, step: int) -> None:
        """See `Troupe`."""
        ground = {"other": "terrain", "surface": self.world.ground.material}
        for impact in self.dynamics.advance(self.world.clock.dt):
            fraction = min(impact.time / self.world.clock.dt, math.nextafter(1.0, 0.0))
            self._contacts.append(self._contact(impact.body, impact, step, fraction, **ground))
        self._contacts += [self._ended_contact(i) for i in self._ended_intervals(step + 1)]
        self.dynamics.drop(self._remove_lost(step + 1, self.dynamics.state.p[:, 1]))

    def buffer_row(self) -> None:
        """See `Troupe`."""
        state = self.dynamics.state
        self._buffered.append((state.p.copy(), state.q.copy(), self.alive.copy()))

    def write(self, rows: Rows) -> None:
        """See `Troupe`."""
        p, q, alive = (np.array(values) for values in zip(*self._buffered, strict=True))
        rows.positions[:] = p
        rows.rotations[:] = matrix(q)
        rows.alive[:] = alive
        self._buffered.clear()

    def _ended_intervals(self, step: int) -> list[SlidingInterval]:
        """Returns the intervals of rolling and sliding that ended."""
        touches, place, normal, v, slip = self.dynamics.touching()
        final = step == self.world.clock.last_step
        speeds = [np.sqrt(dot(u, u)) for u in (v - dot(v, normal)[:, None] * normal, slip)]
        ball = self.dynamics.bodies.radius > 0.0
        rolls = ball & (speeds[1] <= ROLLING_SLIP_RATIO * speeds[0])
        where = place, normal, final
        return [
            *self._rolls.observe(step, touches & rolls, speeds[0], *where),
            *self._slides.observe(step, touches & ~rolls, speeds[1], *where),
        ]

    def _ended_contact(self, interval: SlidingInterval) -> Contact:
        clock = self.world.clock
        row_steps = clock.steps // clock.samples
        # The first and the last row may lie a little outside the interval.
        rows = range(interval.first // row_steps, interval.last // row_steps + 1)
        last = len(interval.speeds) - 1
        samples = [min(max(row * row_steps - interval.first, 0), last) for row in rows]
        steps = interval.first, interval.last
        ground = {"other": "terrain", "surface": self.world.ground.material}
        return self._sliding_contact(interval, steps, samples, **ground)

    def _lower_to_ground(self) -> None:
        """Puts bodies without a given height on the ground."""
        rows = np.array([body.on_ground for body in self.bodies])
        if not rows.any():
            return
        dynamics = self.dynamics
        heights, reach = dynamics.ground.field.heights, dynamics.bodies.reach
        low = np.full(len(rows), float(heights.min())) - reach
        high = np.full(len(rows), float(heights.max())) + reach
        lower_to_ground(
            dynamics.state.p, rows, (low, high), BISECTIONS, lambda: dynamics.depths() > 0.0
        )
        dynamics.find_contacts()

    def _refuse_overlap(self) -> None:
        """Refuses bodies that begin in the ground.

        Raises:
            SceneError: if there are any.
        """
        problems = [
            Problem(
                body.path,
                f"'{body.name}' begins {depth:.3g} m deep in the terrain; raise it, or give "
                f"[x, z] to put it on the ground",
            )
            for body, depth in zip(self.bodies, self.dynamics.depths(), strict=True)
            if depth > MAX_START_DEPTH * body.size
        ]
        if problems:
            raise SceneError(problems)
