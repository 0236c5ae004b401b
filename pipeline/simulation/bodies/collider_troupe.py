"""Colliders: bodies that meet one another, the terrain and creatures.

They advance last, from row to row, when all that push them have written where they are at its end:
creatures go where they are told and feel no bodies, so nothing lags behind. Rows are written in
batches, so contacts are reported late, at their own step and fraction.

Source: Sims 1987, 7.1 and 13.1.1.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.bodies.body_instances import (
    BodyInstance,
    corners_of,
    initial_state,
    instantiate_bodies,
)
from pipeline.simulation.bodies.body_troupe import MAX_START_DEPTH, BodyTroupe, lower_to_ground
from pipeline.simulation.bodies.guided_bodies import GuidedBodies
from pipeline.simulation.bodies.guided_members import guided_members, rigid_notes
from pipeline.simulation.bodies.sliding_tracker import ROLLING_SLIP_RATIO, SlidingInterval
from pipeline.simulation.dynamics.kinematic_bodies import Poses
from pipeline.simulation.dynamics.mujoco_world import TERRAIN, MujocoWorld, Overlap, Strike
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.obstacles import Obstacle, ObstacleMass, SolidMotion
from pipeline.simulation.order_outcome import GripChange
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array, matrix, turn
from pipeline.simulation.take import Contact, Mesh, Node
from pipeline.simulation.troupe import World, WriteStage
from pipeline.spec.body import Body, Many
from pipeline.spec.prop import Prop
from pipeline.spec.script import Kick

BISECTIONS = 48


class ColliderTroupe(BodyTroupe):
    """All bodies of a scene that meet one another.

    Args:
        cast: performers with their numbers in the cast.
        world: constants of the scene.
        materials: of each performer that names none.
        obstacles: solids that push the bodies.
        handled: names of members that people may hold or kick.

    Raises:
        SceneError: if a shape is no solid, or bodies overlap at the start.
    """

    write_stage = WriteStage.AFTER_PUSHERS

    def __init__(
        self,
        cast: Sequence[tuple[int, Body | Many | Prop]],
        world: World,
        materials: Sequence[str],
        obstacles: Sequence[Obstacle],
        handled: Collection[str] = (),
    ) -> None:
        self.row_steps = world.clock.steps // world.clock.samples
        row = world.clock.dt * self.row_steps
        super().__init__(instantiate_bodies(cast, world, materials), world, row)
        self.obstacles = obstacles
        guided = guided_members(cast, self.bodies, world, handled)
        stand_ins = [corners_of(self.bodies[one.guide.body]) for one in guided]
        state = initial_state(self.bodies)
        self.solver = MujocoWorld(
            [body.collider for body in self.bodies],
            state,
            world.ground.field,
            [*(obstacle.corners for obstacle in obstacles), *stand_ins],
            row,
        )
        self.guided = GuidedBodies(guided, self.bodies, self.solver, obstacles, world.clock)
        self._notes += rigid_notes(self.bodies)
        self._lower_to_ground(state.p)
        self.step = 0
        self._last_strikes: dict[tuple[int, int], float] = {}
        self._balls = np.array([body.model.hull is None for body in self.bodies])
        self._rows: list[tuple[Array, Array, Array]] = []

    def advance_to_row(self, step: int, p: Array, R: Array) -> None:
        """See `Troupe`.

        Raises:
            SceneError: if bodies overlap at the start.
        """
        poses = self._pusher_poses(step // self.row_steps, p, R)
        if step > 0:
            self._advance_to(step, poses)
        elif poses is not None:
            self.solver.place_pushers(poses)
        if self.guided:
            self.guided.settle()
        if step == 0:
            self._refuse_overlap()
        self._rows.append((*self._node_poses(), self.alive.copy()))

    def _node_poses(self) -> tuple[Array, Array]:
        """Returns positions (N, 3) [m] and rotations (N, 3, 3) of its nodes."""
        if self.guided:
            return self.guided.node_poses()
        state = self.solver.state
        return state.p, matrix(state.q)

    def _pusher_poses(self, row: int, p: Array, R: Array) -> Poses | None:
        """Returns the poses of obstacles and stand-ins at the end of a row, None without any."""
        nodes = [obstacle.node for obstacle in self.obstacles]
        if not self.guided:
            return Poses(p[nodes], R[nodes]) if nodes else None
        goals = self.guided.targets(row, p, R)
        return Poses(np.concatenate([p[nodes], goals.p]), np.concatenate([R[nodes], goals.R]))

    def _advance_to(self, step: int, poses: Poses | None) -> None:
        for strike in self.solver.advance(poses):
            if self._is_new(strike):
                self._contacts.append(self._strike_contact(strike))
        self._contacts += [self._ended_contact(i) for i in self._ended_intervals(step)]
        self.step = step
        heights = np.where(self.guided.free, self.solver.state.p[:, 1], np.inf)
        lost = self._remove_lost(step, heights)
        if len(lost):
            self.solver.drop(lost)
            self.guided.drop(lost)

    def write(self, rows: Rows) -> None:
        """See `Troupe`."""
        for k, (p, R, alive) in enumerate(self._rows):
            rows.positions[k], rows.rotations[k], rows.alive[k] = p, R, alive
        self._rows.clear()

    # --- obstacles of other troupes ---------------------------------------------------

    def movable_solids(self) -> list[Obstacle]:
        """See `Troupe`."""
        return [_as_obstacle(i, body) for i, body in enumerate(self.bodies)]

    def solid_motion(self) -> SolidMotion:
        """See `Troupe`."""
        state, R = self.solver.state, matrix(self.solver.state.q)
        is_supported = self.solver.asleep | self.solver.touching | ~self.guided.free
        is_present = self.alive & self.guided.met_by_people
        flags = is_present, is_supported, self.guided.pushable
        return SolidMotion(state.p, R, state.v, turn(R, state.w), *flags)

    def push_solids(self, impulses: Array, angular_impulses: Array) -> None:
        """See `Troupe`."""
        self.solver.push(*self.guided.pushed(impulses, angular_impulses))

    # --- hands and paths --------------------------------------------------------------

    @property
    def carriers(self) -> Mapping[int, str]:
        """See `Troupe`."""
        return self.guided.carriers

    @property
    def goes_with_others(self) -> bool:
        """See `Troupe`."""
        return bool(self.guided)

    def bind(self, nodes: Sequence[Node], meshes: Sequence[Mesh], names: NodeNames) -> None:
        """See `Troupe`."""
        self.guided.bind(nodes, names)

    def read(self, orders: Orders) -> None:
        """See `Troupe`."""
        for given in orders.values():
            for order in given:
                if isinstance(order, Kick):
                    self.guided.expect_kick(order.kick)

    def change_grips(self, changes: Sequence[GripChange], hands: Sequence[tuple[int, ...]]) -> None:
        """See `Troupe`."""
        self.guided.change_grips(changes, hands)

    # --- start ------------------------------------------------------------------------

    def _lower_to_ground(self, p: Array) -> None:
        """Puts bodies without a given height on the ground."""
        rows = np.array([body.on_ground for body in self.bodies])
        if not rows.any():
            return
        reach = self.solver.substeps.reach
        heights = self.world.ground.field.heights
        bounds = float(heights.min()) - reach, float(heights.max()) + reach

        def is_deep() -> NDArray[np.bool_]:
            self.solver.lift(p)
            deep = np.zeros(len(p), dtype=bool)
            deep[[o.one for o in self.solver.overlaps() if o.other == TERRAIN]] = True
            return deep

        lower_to_ground(p, rows, bounds, BISECTIONS, is_deep)
        self.solver.lift(p)

    def _refuse_overlap(self) -> None:
        problems = []
        for overlap in self.solver.overlaps():
            body = self.bodies[overlap.one]
            if overlap.depth > MAX_START_DEPTH * body.size:
                problems.append(Problem(body.path, self._overlap_message(body, overlap)))
        if problems:
            raise SceneError(problems)

    def _overlap_message(self, body: BodyInstance, overlap: Overlap) -> str:
        on_terrain = overlap.other == TERRAIN
        other = "the terrain" if on_terrain else f"'{self._other(overlap.other)['other']}'"
        advice = "raise it, or give [x, z]" if on_terrain else "move one of them"
        return f"'{body.name}' begins {overlap.depth:.3g} m deep in {other}; {advice}"

    # --- contacts ---------------------------------------------------------------------

    def _other(self, number: int) -> dict[str, str]:
        """Returns name and material of a thing, numbered as in `Strike`."""
        if number == TERRAIN:
            return {"other": "terrain", "surface": self.world.ground.material}
        count = len(self.bodies)
        thing: BodyInstance | Obstacle
        if number < count:
            thing = self.bodies[number]
        elif number < count + len(self.obstacles):
            thing = self.obstacles[number - count]
        else:
            thing = self.bodies[self.guided.guides[number - count - len(self.obstacles)].body]
        return {"other": thing.name, "surface": thing.material}

    def _is_new(self, strike: Strike) -> bool:
        """Returns whether a pair has not struck just before."""
        now = self.step * self.world.clock.dt + strike.time
        pair = (strike.one, strike.other)
        pause = now - self._last_strikes.get(pair, -math.inf)
        self._last_strikes[pair] = now
        return pause >= self.world.detect.collision.pause

    def _strike_contact(self, strike: Strike) -> Contact:
        whole, fraction = divmod(strike.time / self.world.clock.dt, 1.0)
        last = self.row_steps - 1
        if whole > last:
            whole, fraction = last, math.nextafter(1.0, 0.0)
        step = self.step + int(whole)
        return self._contact(strike.one, strike, step, float(fraction), **self._other(strike.other))

    def _ended_intervals(self, step: int) -> list[SlidingInterval]:
        """Returns the intervals of rolling and sliding that ended, in rows."""
        found, row = self.solver.sliding_motion(), step // self.row_steps
        rolls = self._balls & (found.slip <= ROLLING_SLIP_RATIO * found.along)
        final = row == self.world.clock.rows - 1
        where = found.place, found.normal, final, found.other
        return [
            *self._rolls.observe(row, found.touches & rolls, found.along, *where),
            *self._slides.observe(row, found.touches & ~rolls, found.slip, *where),
        ]

    def _ended_contact(self, interval: SlidingInterval) -> Contact:
        steps = interval.first * self.row_steps, interval.last * self.row_steps
        samples = range(len(interval.speeds))
        return self._sliding_contact(interval, steps, samples, **self._other(interval.other))


def _as_obstacle(number: int, body: BodyInstance) -> Obstacle:
    """Returns a body as an obstacle that gives way."""
    model, corners = body.model, corners_of(body)
    inverse = np.linalg.inv(model.mass.inertia).astype(np.float64)
    mass = ObstacleMass(model.mass.mass, inverse, model.friction, model.bounciness)
    return Obstacle(number, body.name, body.performer, body.material, corners, mass)
