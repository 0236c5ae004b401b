"""Colliders: bodies that meet one another, the terrain and creatures.

They advance last, from row to row, when all that push them have written where they are at its end:
creatures go where they are told and feel no bodies, so nothing lags behind. Rows are written in
batches, so contacts are reported late, at their own step and fraction.

Source: Sims 1987, 7.1 and 13.1.1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.bodies.body_instances import (
    BodyInstance,
    body_inventory,
    initial_state,
    instantiate_bodies,
)
from pipeline.simulation.bodies.sliding_tracker import (
    ROLLING_SLIP_RATIO,
    SlidingInterval,
    SlidingTracker,
)
from pipeline.simulation.dynamics.kinematic_bodies import Poses
from pipeline.simulation.dynamics.mujoco_world import TERRAIN, MujocoWorld, Overlap, Strike
from pipeline.simulation.obstacles import Obstacle, ObstacleMass, SolidMotion, directions
from pipeline.simulation.spatial import Array, matrix, turn
from pipeline.simulation.take import Contact, Note
from pipeline.simulation.troupe import Facts, Rows, Troupe, World, WriteStage
from pipeline.spec.body import Body, Many

DROP_DEPTH = 10.0
"""Depth below the lowest ground at which what has left the terrain is dropped [m]."""

MAX_START_DEPTH = 1e-3
"""Depth in something else at the begin that is refused, in sizes of the body."""

BISECTIONS = 48


class ColliderTroupe(Troupe):
    """All bodies of a scene that meet one another.

    Args:
        cast: places in the cast, and words.
        world: what every troupe is shown.
        materials: of each member that names none.
        obstacles: what pushes them.

    Raises:
        SceneError: a shape is no solid, or two bodies begin in one another or in the ground.
    """

    write_stage = WriteStage.AFTER_PUSHERS

    def __init__(
        self,
        cast: Sequence[tuple[int, Body | Many]],
        world: World,
        materials: Sequence[str],
        obstacles: Sequence[Obstacle],
    ) -> None:
        self.world = world
        self.obstacles = obstacles
        clock = world.clock
        self.row_steps = clock.steps // clock.samples
        self.blocks = instantiate_bodies(cast, world, materials)
        state, on_ground = initial_state(self.blocks, world.ground)
        self.solver = MujocoWorld(
            [block.collider for block in self.blocks],
            state,
            world.ground.field,
            [one.corners for one in obstacles],
            clock.dt * self.row_steps,
        )
        self._put_down(state.p, np.array(on_ground))
        self.inventory = body_inventory(self.blocks, clock.rows)
        self._floor = float(world.ground.field.heights.min()) - DROP_DEPTH
        self.alive = np.ones(len(self.blocks), dtype=bool)
        self.step = 0
        self._heard: dict[tuple[int, int], float] = {}
        self._contacts: list[Contact] = []
        self._notes: list[Note] = []
        row = clock.dt * self.row_steps
        self._balls = np.array([block.collider.build.hull is None for block in self.blocks])
        self._rolls, self._slides = (
            SlidingTracker("roll", len(self.blocks), row, world.detect.roll),
            SlidingTracker("slide", len(self.blocks), row, world.detect.slide),
        )
        self._rows: list[tuple[Array, Array, Array]] = []

    # --- the passes of the step -----------------------------------------------------

    def advance_to_row(self, step: int, p: Array, R: Array) -> None:
        """Go on to the row at `step`.

        Args:
            step: 0 for the first row.
            p: (J, 3) positions of all nodes that are none of the bodies', at that row [m].
            R: (J, 3, 3) their rotations.

        Raises:
            SceneError: something is in something else at the begin.
        """
        nodes = [one.node for one in self.obstacles]
        poses = Poses(p[nodes], R[nodes]) if nodes else None
        if step > 0:
            self._go_on(step, poses)
        else:
            if poses is not None:
                self.solver.place_pushers(poses)
            self._refuse_overlap()
        state = self.solver.state
        self._rows.append((state.p, matrix(state.q), self.alive.copy()))

    def _go_on(self, step: int, poses: Poses | None) -> None:
        for strike in self.solver.advance(poses):
            if self._is_heard(strike):
                self._contacts.append(self._contact(strike))
        self._contacts += [self._rubbed(rub) for rub in self._rubs(step)]
        self.step = step
        lost = np.flatnonzero(self.alive & (self.solver.state.p[:, 1] < self._floor))
        if len(lost):
            self.alive[lost] = False
            self.solver.drop(lost)
        text = f"left the terrain, and was dropped {DROP_DEPTH:g} m below it"
        self._notes += [Note("dropped", step, self.blocks[i].name, text) for i in lost]

    def write(self, rows: Rows) -> None:
        """Write the rows that were gone through since the last call."""
        for k, (p, R, alive) in enumerate(self._rows):
            rows.positions[k], rows.rotations[k], rows.alive[k] = p, R, alive
        self._rows.clear()

    def facts(self) -> Facts:
        """Return what struck what since the last call, and what was lost."""
        facts = Facts(tuple(self._contacts), tuple(self._notes))
        self._contacts.clear()
        self._notes.clear()
        return facts

    # --- those who run into them ------------------------------------------------------

    def movable_solids(self) -> list[Obstacle]:
        """Return all bodies; their nodes count from the first."""
        return [_solid(i, block) for i, block in enumerate(self.blocks)]

    def solid_motion(self) -> SolidMotion:
        """Return where they are in the last row, and how fast."""
        state, R = self.solver.state, matrix(self.solver.state.q)
        borne = self.solver.asleep | self.solver.touching
        return SolidMotion(state.p, R, state.v, turn(R, state.w), self.alive.copy(), borne)

    def push_solids(self, impulses: Array, angular_impulses: Array) -> None:
        """Let them be pushed until the next row: (N, 3) [N s], about their middles [N m s]."""
        self.solver.push(impulses, angular_impulses)

    # --- what rolls and slides --------------------------------------------------------

    def _rubs(self, step: int) -> list[SlidingInterval]:
        """Return what has ended to roll or to slide, in rows."""
        found, row = self.solver.sliding_motion(), step // self.row_steps
        rolls = self._balls & (found.slip <= ROLLING_SLIP_RATIO * found.along)
        final = row == self.world.clock.rows - 1
        where = found.place, found.normal, final, found.other
        return [
            *self._rolls.look(row, found.touches & rolls, found.along, *where),
            *self._slides.look(row, found.touches & ~rolls, found.slip, *where),
        ]

    def _rubbed(self, rub: SlidingInterval) -> Contact:
        block = self.blocks[rub.body]
        return Contact(
            step=rub.first * self.row_steps,
            fraction=0.0,
            performer=block.performer,
            part=block.part,
            other=self._name(rub.other),
            place=rub.place,
            normal=rub.normal,
            speed=rub.speed,
            energy=0.5 * block.collider.build.mass.mass * rub.speed**2,
            material=block.material,
            surface=self._material(rub.other),
            size=block.size,
            kind=rub.kind,
            until=rub.last * self.row_steps,
            speeds=rub.speeds,
            places=rub.places,
        )

    # --- begin ------------------------------------------------------------------------

    def _put_down(self, p: Array, rows: Array) -> None:
        """Put bodies whose height is not given on the ground, by halving what is between."""
        if not rows.any():
            return
        reach = self.solver.substeps.reach
        heights = self.world.ground.field.heights
        low, high = float(heights.min()) - reach, float(heights.max()) + reach
        for _ in range(BISECTIONS):
            p[rows, 1] = 0.5 * (low + high)[rows]
            self.solver.lift(p)
            deep = np.zeros(len(p), dtype=bool)
            deep[[o.one for o in self.solver.overlaps() if o.other == TERRAIN]] = True
            low, high = np.where(deep, p[:, 1], low), np.where(deep, high, p[:, 1])
        p[rows, 1] = high[rows]
        self.solver.lift(p)

    def _refuse_overlap(self) -> None:
        problems = []
        for overlap in self.solver.overlaps():
            block = self.blocks[overlap.one]
            if overlap.depth > MAX_START_DEPTH * block.size:
                problems.append(Problem(block.path, self._too_deep(block, overlap)))
        if problems:
            raise SceneError(problems)

    def _too_deep(self, block: BodyInstance, overlap: Overlap) -> str:
        name = self._name(overlap.other)
        what = "the terrain" if overlap.other == TERRAIN else f"'{name}'"
        told = f"'{block.name}' begins {overlap.depth:.3g} m deep in {what}"
        advice = "raise it, or give [x, z]" if overlap.other == TERRAIN else "move one of them"
        return f"{told}; {advice}"

    # --- contacts ---------------------------------------------------------------------

    def _name(self, number: int) -> str:
        if number == TERRAIN:
            return "terrain"
        if number < len(self.blocks):
            return self.blocks[number].name
        return self.obstacles[number - len(self.blocks)].name

    def _material(self, number: int) -> str:
        if number == TERRAIN:
            return self.world.ground.material
        if number < len(self.blocks):
            return self.blocks[number].material
        return self.obstacles[number - len(self.blocks)].material

    def _is_heard(self, strike: Strike) -> bool:
        """Tell whether two have not struck one another just before."""
        now = self.step * self.world.clock.dt + strike.time
        pair = (strike.one, strike.other)
        quiet = now - self._heard.get(pair, -math.inf) >= self.world.detect.collision.pause
        self._heard[pair] = now
        return quiet

    def _contact(self, strike: Strike) -> Contact:
        block = self.blocks[strike.one]
        whole, fraction = divmod(strike.time / self.world.clock.dt, 1.0)
        last = self.row_steps - 1
        if whole > last:
            whole, fraction = last, math.nextafter(1.0, 0.0)
        return Contact(
            step=self.step + int(whole),
            fraction=float(fraction),
            performer=block.performer,
            part=block.part,
            other=self._name(strike.other),
            place=strike.place,
            normal=strike.normal,
            speed=strike.speed,
            energy=strike.energy,
            material=block.material,
            surface=self._material(strike.other),
            size=block.size,
            kind="hit",
        )


def _solid(number: int, block: BodyInstance) -> Obstacle:
    """Return a body as others feel it."""
    build = block.collider.build
    corners = build.hull.vertices if build.hull is not None else build.radius * directions()
    inverse = np.linalg.inv(build.mass.inertia).astype(np.float64)
    weight = ObstacleMass(build.mass.mass, inverse, build.friction, build.bounciness)
    return Obstacle(number, block.name, block.performer, block.material, corners, weight)
