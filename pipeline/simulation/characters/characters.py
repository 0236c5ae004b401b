"""Characters: the troupe of all that is made of nodes and links.

Source: Horswill 2008.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.characters.body_plan import character_arrays
from pipeline.simulation.characters.broad_phase import workspace_for
from pipeline.simulation.characters.character_plans import (
    before_of,
    plan_of,
    proportions_of,
    start_of,
)
from pipeline.simulation.characters.contact_response import new_touch_log
from pipeline.simulation.characters.mind.mind_scheduler import MindScheduler
from pipeline.simulation.characters.mind.perception import Surroundings
from pipeline.simulation.characters.person_controller import CharacterView
from pipeline.simulation.characters.person_record import persons_of
from pipeline.simulation.characters.pose_output import (
    DEEP,
    BallRotations,
    feet_of,
    frame_poser,
    gaze_of,
)
from pipeline.simulation.characters.solid_arrays import SolidTracker
from pipeline.simulation.characters.step_report import ContactReporter, SignalDetector, footfalls
from pipeline.simulation.characters.task_dispatcher import TaskDispatcher
from pipeline.simulation.characters.verlet_step import advance
from pipeline.simulation.characters.visibility_route import ObstacleCircles
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.terrain_grid import grid_of
from pipeline.simulation.obstacles import Obstacle, SolidMotion
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact
from pipeline.simulation.troupe import Facts, Rows, Troupe, World
from pipeline.spec.character import Character

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
        self.arrays = character_arrays(self.plans, starts)
        self.arrays.nodes["previous"] = np.concatenate(
            [
                p if member.acts else before_of(member, p, plan.mass, dt / self.count)
                for (member, plan), p in zip(pairs, starts, strict=True)
            ]
        )
        self.persons = self._persons()
        self.grid = grid_of(world.ground.field)
        self.level = bool(np.ptp(world.ground.field.heights) == 0.0)
        self.workspace, self.log = workspace_for(self.arrays), new_touch_log()
        self.contact_reporter = ContactReporter(cast, self.arrays, world.ground.material)
        self.solid_tracker = SolidTracker()
        self._look = frame_poser(cast, self.plans, world.seed, world.clock.rows)
        self._firsts = np.array([thing.nodes[0] for thing in self._look.things], dtype=np.int64)
        bodies = [proportions_of(member) is not None for member in cast]
        people = frozenset(i for i, one in enumerate(bodies) if one)
        self.obstacle_circles = ObstacleCircles(world.ground)
        names = [member.name for member in cast]
        view = CharacterView(names, self.arrays, world.ground, people, self.obstacle_circles)
        poses = {member.name: member.pose for member in cast}
        self.dispatcher = TaskDispatcher(view, self.persons, dt, poses)
        self.signals = SignalDetector(self.dispatcher)
        self.minds = self._minds(view)
        channels = self.minds.channels if self.minds is not None else ()
        self.inventory = replace(self._look.inventory, channels=channels)
        balls = [k for k, thing in enumerate(self._look.things) if thing.directions is None]
        self._balls = np.array(balls, dtype=np.int64)
        self._rolls = self._firsts[self._balls]
        self.rolling = BallRotations(self.arrays.nodes["radius"][self._rolls])
        owners = [int(owner) for owner in self.persons["owner"]]
        self._names = [cast[owner].name for owner in owners]
        self._masses = [float(self.arrays.owners["mass"][owner]) for owner in owners]
        self._facts = Facts()
        self._kept: list[Kept] = []
        self._values: list[list[float]] = []

    def _minds(self, view: CharacterView) -> MindScheduler | None:
        """Return the minds of those who have one, None if nobody has."""
        if not any(member.has_mind for member in self.cast):
            return None
        heights = [p.height if (p := proportions_of(member)) else 0.0 for member in self.cast]
        surroundings = Surroundings(view, [member.character for member in self.cast], heights)
        dt = self.world.clock.dt
        return MindScheduler(
            self.cast, self.dispatcher, surroundings, self.world.seed, dt, dt / self.count
        )

    def _persons(self) -> Records:
        """Return those who act, see `record`."""
        owners = self.arrays.owners
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
        self.solid_tracker = SolidTracker(obstacles, len(self.cast))
        self.workspace = workspace_for(self.arrays, self.solid_tracker.solids)
        self.contact_reporter.solids = self.solid_tracker.obstacles
        self.obstacle_circles.put(self.solid_tracker.solids.bodies)
        return self.solid_tracker.obstacles

    def update_obstacles(self, motion: SolidMotion) -> None:
        """Take in where the solids are now, and how fast."""
        spans = self.arrays.owners["nodes"].tolist()
        self.solid_tracker.feel(motion, [self.arrays.p[first : first + n] for first, n in spans])

    def obstacle_impulses(self) -> tuple[Array, Array]:
        """Return what solids were pushed by since they were felt: (S, 3) [N s], (S, 3) [N m s]."""
        return self.solid_tracker.pushed()

    # --- the passes of the step -----------------------------------------------------

    def read(self, orders: Orders) -> None:
        """Take in what the script asks of its members from this step on."""
        self.dispatcher.read(orders)
        if self.minds is not None:
            self.minds.read(orders)

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        if self.minds is not None:
            self.minds.think(step, step * self.world.clock.dt)
        self.dispatcher.before()
        before = self.dispatcher.view.p[self._rolls]
        self.move()
        self._roll(before)
        contacts = self.contact_reporter.contacts(self.log, step) + self._footfalls(step)
        arrived, touched = self.dispatcher.arrived(), self.contact_reporter.touched(self.log)
        cries = self.minds.cries if self.minds is not None else ()
        signals = self.signals.of_step(cries)
        self._facts = Facts(contacts, arrived=arrived, touched=touched, signals=signals)

    def move(self) -> None:
        """Let all nodes go on by a step."""
        advance(
            *(self.arrays, self.persons, self.grid, self.level, self.workspace, self.log),
            *(GRAVITY, self.world.clock.dt, self.count),
        )

    def _footfalls(self, step: int) -> tuple[Contact, ...]:
        """Return what feet came down in a step."""
        world, who = self.world, (self._names, self._masses)
        return tuple(footfalls(self.persons, *who, SHOES, world.ground, world.clock, step))

    def _roll(self, before: Array) -> None:
        if not len(self._balls):
            return
        p, radius = self.dispatcher.view.p[self._rolls], self.rolling.radius
        floor = self.grid.vertices[0, 1]
        if not self.level:
            floor = self.world.ground.height(p[:, 0], p[:, 2])
        height = p[:, 1] - floor
        self.rolling.go(p - before, height < radius * (1.0 + DEEP) + 1e-3)

    def buffer_row(self) -> None:
        """Keep the present state as the next row."""
        self._kept.append((self.dispatcher.view.p.copy(), self.rolling.R, np.array(self.persons)))
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
        posed = self._look.pose(p, spins, gaze, feet, persons["embrace_blend"])
        rows.rotations[:], rows.positions[:] = posed
        rows.alive[:] = True
        if self._values:
            rows.values[:] = self._values
            self._values.clear()
        self._kept.clear()

    def facts(self) -> Facts:
        """Return what touched in the last step."""
        return self._facts
