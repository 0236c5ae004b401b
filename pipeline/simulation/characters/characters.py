"""Characters: the troupe of all that is made of nodes and links.

Source: Horswill 2008.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.characters.body_plan import crowd_of
from pipeline.simulation.characters.broad_phase import room_for
from pipeline.simulation.characters.character_plans import (
    before_of,
    plan_of,
    proportions_of,
    start_of,
)
from pipeline.simulation.characters.contact_response import new_log
from pipeline.simulation.characters.mind.mind_scheduler import Minds
from pipeline.simulation.characters.mind.perception import Surroundings
from pipeline.simulation.characters.person_controller import Stage
from pipeline.simulation.characters.person_record import persons_of
from pipeline.simulation.characters.pose_output import DEEP, Rolling, appearance, feet_of, gaze_of
from pipeline.simulation.characters.solid_arrays import Around
from pipeline.simulation.characters.step_report import Signals, Telling, footfalls
from pipeline.simulation.characters.task_dispatcher import Direction
from pipeline.simulation.characters.verlet_step import advance
from pipeline.simulation.characters.visibility_route import Barriers
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.grid import grid_of
from pipeline.simulation.script import Orders
from pipeline.simulation.solid import Motion, Obstacle
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact
from pipeline.simulation.troupe import Facts, Rows, Troupe, World
from pipeline.spec.cast import Character

SUB_STEPS = 240.0
"""Of a second, at least."""

SHOES = "leather"
"""What people step with."""

Kept = tuple[Array, Array, Records]
"""Of a row: nodes, rotations of balls, and those who act."""


class Characters(Troupe):
    """All characters of a scene."""

    hits_obstacles = True

    def __init__(self, cast: Sequence[Character], world: World) -> None:
        self.world, self.cast = world, cast
        self.plans = [plan_of(member) for member in cast]
        dt = world.clock.dt
        self.count = math.ceil(dt * SUB_STEPS - 1e-9)
        pairs = list(zip(cast, self.plans, strict=True))
        starts = [start_of(member, plan, world.ground) for member, plan in pairs]
        self.crowd = crowd_of(self.plans, starts)
        self.crowd.nodes["before"] = np.concatenate(
            [
                p if member.acts else before_of(member, p, plan.mass, dt / self.count)
                for (member, plan), p in zip(pairs, starts, strict=True)
            ]
        )
        self.persons = self._persons()
        self.grid = grid_of(world.ground.field)
        self.level = bool(np.ptp(world.ground.field.heights) == 0.0)
        self.room, self.log = room_for(self.crowd), new_log()
        self.telling = Telling(cast, self.crowd, world.ground.material)
        self.around = Around()
        self._look = appearance(cast, self.plans, world.seed, world.clock.rows)
        self._firsts = np.array([thing.nodes[0] for thing in self._look.things], dtype=np.int64)
        bodies = [proportions_of(member) is not None for member in cast]
        people = frozenset(i for i, one in enumerate(bodies) if one)
        self.barriers = Barriers(world.ground)
        names = [member.name for member in cast]
        stage = Stage(names, self.crowd, world.ground, people, self.barriers)
        poses = {member.name: member.pose for member in cast}
        self.direction = Direction(stage, self.persons, dt, poses)
        self.signals = Signals(self.direction)
        self.minds = self._minds(stage)
        channels = self.minds.channels if self.minds is not None else ()
        self.inventory = replace(self._look.inventory, channels=channels)
        balls = [k for k, thing in enumerate(self._look.things) if thing.directions is None]
        self._balls = np.array(balls, dtype=np.int64)
        self._rolls = self._firsts[self._balls]
        self.rolling = Rolling(self.crowd.nodes["radius"][self._rolls])
        owners = [int(owner) for owner in self.persons["owner"]]
        self._names = [cast[owner].name for owner in owners]
        self._masses = [float(self.crowd.owners["mass"][owner]) for owner in owners]
        self._facts = Facts()
        self._kept: list[Kept] = []
        self._values: list[list[float]] = []

    def _minds(self, stage: Stage) -> Minds | None:
        """Return the minds of those who have one, None if nobody has."""
        if not any(member.has_mind for member in self.cast):
            return None
        heights = [p.height if (p := proportions_of(member)) else 0.0 for member in self.cast]
        around = Surroundings(stage, [member.character for member in self.cast], heights)
        dt = self.world.clock.dt
        return Minds(self.cast, self.direction, around, self.world.seed, dt, dt / self.count)

    def _persons(self) -> Records:
        """Return those who act, see `record`."""
        owners = self.crowd.owners
        acting = [i for i, member in enumerate(self.cast) if member.acts]
        at = np.array([[self.cast[i].at[0], self.cast[i].at[-1]] for i in acting]).reshape(-1, 2)
        persons = persons_of(
            [p for i in acting if (p := proportions_of(self.cast[i])) is not None],
            [int(owners["nodes"][i, 0]) for i in acting],
            at,
            np.radians([self.cast[i].heading_deg for i in acting]),
            self.world.ground.height(at[:, 0], at[:, 1]),
        )
        grips = np.cumsum([0, *(plan.grips for plan in self.plans)])
        persons["owner"] = acting
        owners["acts"][acting] = True
        persons["grip"] = [grips[i] for i in acting]
        return persons

    # --- solids of other rooms --------------------------------------------------------

    def set_obstacles(self, obstacles: Sequence[Obstacle]) -> list[Obstacle]:
        """Take in what there is to run into; return that of it which is told of from then on."""
        self.around = Around(obstacles, len(self.cast))
        self.room = room_for(self.crowd, self.around.solids)
        self.telling.solids = self.around.obstacles
        self.barriers.put(self.around.solids.bodies)
        return self.around.obstacles

    def update_obstacles(self, motion: Motion) -> None:
        """Take in where the solids are now, and how fast."""
        spans = self.crowd.owners["nodes"].tolist()
        self.around.feel(motion, [self.crowd.p[first : first + n] for first, n in spans])

    def obstacle_impulses(self) -> tuple[Array, Array]:
        """Return what solids were pushed by since they were felt: (S, 3) [N s], (S, 3) [N m s]."""
        return self.around.pushed()

    # --- the passes of the step -----------------------------------------------------

    def read(self, orders: Orders) -> None:
        """Take in what the script asks of its members from this step on."""
        self.direction.read(orders)
        if self.minds is not None:
            self.minds.read(orders)

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        if self.minds is not None:
            self.minds.think(step, step * self.world.clock.dt)
        self.direction.before()
        before = self.direction.stage.p[self._rolls]
        self.move()
        self._roll(before)
        contacts = self.telling.contacts(self.log, step) + self._footfalls(step)
        arrived, touched = self.direction.arrived(), self.telling.touched(self.log)
        cries = self.minds.cries if self.minds is not None else ()
        signals = self.signals.of_step(cries)
        self._facts = Facts(contacts, arrived=arrived, touched=touched, signals=signals)

    def move(self) -> None:
        """Let all nodes go on by a step."""
        advance(
            *(self.crowd, self.persons, self.grid, self.level, self.room, self.log),
            *(GRAVITY, self.world.clock.dt, self.count),
        )

    def _footfalls(self, step: int) -> tuple[Contact, ...]:
        """Return what feet came down in a step."""
        world, who = self.world, (self._names, self._masses)
        return tuple(footfalls(self.persons, *who, SHOES, world.ground, world.clock, step))

    def _roll(self, before: Array) -> None:
        if not len(self._balls):
            return
        p, radius = self.direction.stage.p[self._rolls], self.rolling.radius
        floor = self.grid.vertices[0, 1]
        if not self.level:
            floor = self.world.ground.height(p[:, 0], p[:, 2])
        height = p[:, 1] - floor
        self.rolling.go(p - before, height < radius * (1.0 + DEEP) + 1e-3)

    def buffer_row(self) -> None:
        """Keep the present state as the next row."""
        self._kept.append((self.direction.stage.p.copy(), self.rolling.R, np.array(self.persons)))
        if self.minds is not None:
            self._values.append(self.minds.values())

    def write(self, rows: Rows) -> None:
        """Write all rows kept."""
        kept_p, kept_R, kept_persons = zip(*self._kept, strict=True)
        p, turned = np.array(kept_p), np.array(kept_R)
        persons = np.empty((len(p), len(self.persons)), self.persons.dtype)
        for k, kept in enumerate(kept_persons):
            persons[k] = kept
        spins = np.broadcast_to(np.eye(3), (len(p), len(self._firsts), 3, 3)).copy()
        spins[:, self._balls] = turned
        # Of all rows at once: it is the calls that cost.
        gaze, feet = gaze_of(persons), feet_of(persons, self.world.ground)
        posed = self._look.pose(p, spins, gaze, feet, persons["wraps"])
        rows.rotations[:], rows.positions[:] = posed
        rows.alive[:] = True
        if self._values:
            rows.values[:] = self._values
            self._values.clear()
        self._kept.clear()

    def facts(self) -> Facts:
        """Return what touched in the last step."""
        return self._facts
