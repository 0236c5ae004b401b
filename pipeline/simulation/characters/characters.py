"""Characters: the troupe of people, dolls and playthings, made of nodes and links.

Source: Horswill 2008.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.characters.body_arrays import CharacterArrays, IntArray
from pipeline.simulation.characters.body_plan import character_arrays
from pipeline.simulation.characters.broad_phase import workspace_for
from pipeline.simulation.characters.character_plans import (
    plan_of,
    previous_nodes,
    proportions_of,
    start_nodes,
)
from pipeline.simulation.characters.character_view import CharacterView
from pipeline.simulation.characters.companions import Companions
from pipeline.simulation.characters.contact_response import new_touch_log
from pipeline.simulation.characters.dance_task import (
    Dance,
    dance_contacts,
    rest_dances,
)
from pipeline.simulation.characters.footfalls import FootfallReporter
from pipeline.simulation.characters.gestures import Gestures
from pipeline.simulation.characters.mind.mind_scheduler import MindScheduler
from pipeline.simulation.characters.mind.perception import Surroundings
from pipeline.simulation.characters.pain_reflex import PainReflexes
from pipeline.simulation.characters.pain_rise import PainRise
from pipeline.simulation.characters.person_record import PLACED, REACHING, persons_of
from pipeline.simulation.characters.pose_output import BallRotations, eye_aims, frame_poser
from pipeline.simulation.characters.solid_arrays import SolidTracker
from pipeline.simulation.characters.step_report import ContactReporter, SignalDetector
from pipeline.simulation.characters.task_dispatcher import NO_FACTS, TaskDispatcher
from pipeline.simulation.characters.verlet_step import advance
from pipeline.simulation.characters.visibility_route import ObstacleCircles
from pipeline.simulation.dynamics.compiled import Records, bound
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.terrain_grid import grid_of
from pipeline.simulation.members import MemberState
from pipeline.simulation.obstacles import Obstacle, SolidMotion
from pipeline.simulation.people.face_tracker import FaceInputs, FaceTracker
from pipeline.simulation.people.guided_dance import DanceGuides, GuideMaker
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.script import Orders
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Face
from pipeline.simulation.troupe import Facts, Troupe, World
from pipeline.spec.character import Character, company_of
from pipeline.spec.character_kinds import PEOPLE
from pipeline.spec.script import Instruction

SUB_STEP_RATE = 240.0
"""Least number of sub-steps per second."""

LED_HAND_FLATNESS = 0.7
"""How far a hand is stretched that reaches for a place, or lies there."""

EMBRACE_FLATNESS = 0.5
"""How far a hand is stretched that lies on somebody's back."""


class Characters(Troupe):
    """All characters of a scene."""

    hits_obstacles = True

    def __init__(
        self, cast: Sequence[Character], world: World, guide: GuideMaker | None = None
    ) -> None:
        # By name, so that a film is the same whatever the order of its cast: minds take turns, and
        # contacts are resolved, one after the other.
        cast = sorted(cast, key=lambda member: member.name)
        self.world, self.cast = world, cast
        acting = (member for member in cast if member.acts)
        measures = {member.name: proportions_of(member) for member in acting}
        self.dances = DanceGuides({name: p for name, p in measures.items() if p}, guide)
        self.dances.prepare_all(world.instructions)
        dt = world.clock.dt
        self.count = math.ceil(dt * SUB_STEP_RATE - 1e-9)
        self.plans = [plan_of(member) for member in cast]
        self.arrays = self._start_arrays(dt / self.count)
        self.persons = self._start_persons()
        self.grid = grid_of(world.ground.field)
        self.level = bool(np.ptp(world.ground.field.heights) == 0.0)
        self.solid_tracker = SolidTracker()
        self.workspace, self.log = workspace_for(self.arrays), new_touch_log()
        self._move: Callable[[], None] | None = None
        self.obstacle_circles = ObstacleCircles(world.ground)
        self.contact_reporter = ContactReporter(cast, self.arrays, world.ground.material)
        self._poser = frame_poser(cast, self.plans, world.clothes, world.clock.rows)
        view = self._view()
        poses = {member.name: member.pose for member in cast}
        self.dispatcher = TaskDispatcher(view, self.persons, dt, poses)
        view.decks.start_on(self.persons)
        self.pains = PainRise(self.arrays.owners, self.persons)
        self.signals = SignalDetector(self.dispatcher, self.pains)
        owners = [int(owner) for owner in self.persons["owner"]]
        obediences = [cast[owner].obedience for owner in owners]
        self.reflexes = PainReflexes(self.dispatcher, obediences, self.pains)
        self.minds = self._start_minds(view)
        self.gestures = Gestures(self.dispatcher)
        self.companions = Companions(company_of(cast), self.dispatcher, world.seed)
        channels = self.minds.channels if self.minds is not None else ()
        # The acting people first, in the order of their records, then the limp ones.
        limp = [k for k, one in enumerate(cast) if one.character in PEOPLE and not one.acts]
        self._faced = np.array([*self.persons["owner"].tolist(), *limp], dtype=np.int64)
        faces = tuple(Face(cast[k].name) for k in self._faced.tolist())
        self.inventory = replace(self._poser.inventory, channels=channels, faces=faces)
        balls = [thing.nodes[0] for thing in self._poser.things if thing.axes is None]
        self._balls = np.array(balls, dtype=np.int64)
        self.ball_rotations = BallRotations(self.arrays.nodes, self._balls)
        self._ball_floor: Array = np.full(len(balls), self.grid.vertices[0, 1])
        masses = [float(self.arrays.owners["mass"][owner]) for owner in owners]
        self.footfalls = FootfallReporter(
            *(self.persons, self.dispatcher.controllers, masses),
            *(world.ground, world.clock, self.contact_reporter),
        )
        self._facts = Facts()
        self._faces = FaceTracker(
            [face.performer for face in faces], world.seed, world.clock.row_time
        )
        self._face_inputs: list[FaceInputs] = []
        # Rows to write: nodes, rotations of balls, records of acting people, whom they embrace.
        self._rows: list[tuple[Array, Array, Records, IntArray]] = []
        self._values: list[Array] = []

    def _start_arrays(self, h: float) -> CharacterArrays:
        """Return the characters as they start, for sub-steps of `h` [s]."""
        pairs = list(zip(self.cast, self.plans, strict=True))
        starts = [start_nodes(member, plan, self.world.ground) for member, plan in pairs]
        arrays = character_arrays(self.plans, starts)
        arrays.nodes["previous"] = np.concatenate(
            [
                p if member.acts else previous_nodes(member, p, plan.mass, h)
                for (member, plan), p in zip(pairs, starts, strict=True)
            ]
        )
        return arrays

    def _view(self) -> CharacterView:
        names = [member.name for member in self.cast]
        people = (k for k, member in enumerate(self.cast) if proportions_of(member) is not None)
        ground = self.world.ground
        sub_step = self.world.clock.dt / self.count
        return CharacterView(
            *(names, self.arrays, ground, frozenset(people), self.obstacle_circles, sub_step),
            dances=self.dances.guides,
        )

    def _start_minds(self, view: CharacterView) -> MindScheduler | None:
        if not any(member.has_mind for member in self.cast):
            return None
        heights = [p.height if (p := proportions_of(member)) else 0.0 for member in self.cast]
        surroundings = Surroundings(view, [member.character for member in self.cast], heights)
        dt = self.world.clock.dt
        return MindScheduler(
            *(self.cast, self.dispatcher, self.persons, surroundings),
            *(self.world.seed, dt, dt / self.count, self.pains),
            attitudes=self.world.attitudes,
        )

    def _start_persons(self) -> Records:
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
        persons["shift_phase"] = [
            generator(self.world.seed, f"{self.cast[i].name}.weight_shift").random() for i in acting
        ]
        return persons

    # --- solids of other rooms --------------------------------------------------------

    def set_obstacles(self, obstacles: Sequence[Obstacle]) -> list[Obstacle]:
        """Set the obstacles of other rooms; return those whose motion is needed from then on."""
        self.solid_tracker = SolidTracker(obstacles, len(self.cast))
        self.workspace = workspace_for(self.arrays, self.solid_tracker.solids)
        self._move = None
        self.contact_reporter.solids = self.solid_tracker.obstacles
        self.obstacle_circles.set_solids(self.solid_tracker.solids.bodies)
        self.dispatcher.view.body_masses.update(self.solid_tracker.masses())
        self.dispatcher.view.decks.tracker = self.solid_tracker
        return self.solid_tracker.obstacles

    def update_obstacles(self, motion: SolidMotion) -> None:
        """Update poses and velocities of the obstacles."""
        spans = self.arrays.owners["nodes"].tolist()
        self.solid_tracker.update(
            motion,
            [self.arrays.p[first : first + n] for first, n in spans],
            self.dispatcher.view.holders,
        )

    def obstacle_impulses(self) -> tuple[Array, Array]:
        """Return impulses (S, 3) [N s] and angular impulses (S, 3) [N m s] since the update."""
        return self.solid_tracker.impulses()

    # --- the passes of the step -----------------------------------------------------

    def members_needed(self, orders: Orders) -> Collection[str]:
        """Return the members whose states the tasks of people need."""
        return self.dispatcher.members_needed(orders) | self.gestures.members

    def see_members(self, members: Mapping[str, MemberState]) -> None:
        """Receive the states of these members in the row before."""
        self.dispatcher.view.members.update(members)

    def read(self, orders: Orders) -> None:
        """Accept the orders of the script from this step on."""
        self.dispatcher.read(orders)
        if self.minds is not None:
            self.minds.read(orders)

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Refuse a dance that a person cannot learn."""
        self.dances.prepare(instruction, path)

    def advance(self, step: int) -> None:
        """Advance from `step` to the next."""
        if self.dances.guides:
            rest_dances(self.persons)
        self.dispatcher.view.decks.forget_poses()
        if self.minds is not None:
            self.minds.think(step, step * self.world.clock.dt)
        self.companions.advance(step * self.world.clock.dt)
        self.dispatcher.command()
        if self.minds is not None:
            self.minds.gesture(self.gestures, step * self.world.clock.dt)
        self.gestures.advance(self.world.clock.dt)
        self.reflexes.react(step * self.world.clock.dt)
        for controller in self.dispatcher.acting:
            for name, v in controller.kicked_bodies:
                self.solid_tracker.set_velocity(name, v)
        self.move()
        self.pains.update()
        self._roll_balls()
        contacts = self.contact_reporter.contacts(self.log, step) + self.footfalls.contacts(step)
        if self.dances.guides:
            people = self.dispatcher
            dances = [(people.controllers[k], task) for k, task in people.busy(Dance)]
            contacts += dance_contacts(dances, self.cast, self.world.clothes, step)
        voices = self.minds.voices if self.minds is not None else ()
        done, signals = self.dispatcher.facts(), self.signals.signals(voices)
        touched = self.contact_reporter.touched(self.log)
        if done is NO_FACTS and not (contacts or signals or touched):
            self._facts = NO_FACTS
            return
        self._facts = Facts(
            contacts=contacts,
            arrived=done.arrived,
            touched=touched + done.touched,
            signals=signals,
            outcomes=done.outcomes,
            grips=done.grips,
        )

    def move(self) -> None:
        """Advance all nodes by a step."""
        if self._move is None:
            self._move = bound(
                advance,
                *(self.arrays, self.persons, self.grid, self.level, self.workspace, self.log),
                *(GRAVITY, self.world.clock.dt, self.count),
            )
        self._move()

    def _roll_balls(self) -> None:
        if not len(self._balls):
            return
        if not self.level:
            p = self.arrays.p[self._balls]
            self._ball_floor = self.world.ground.height(p[:, 0], p[:, 2])
        self.ball_rotations.advance(self._ball_floor)

    def buffer_row(self) -> None:
        """Keep the present state as the next row."""
        turned = self.ball_rotations.R.copy()
        embraced = self.arrays.owners["embraces"][self.persons["owner"]]
        self._rows.append((self.arrays.p.copy(), turned, self.persons.copy(), embraced))
        if self.minds is not None:
            self._values.append(self.minds.values())
        self._face_inputs.append(self._face_input())

    def _face_input(self) -> FaceInputs:
        """Return what moves faces and hands now."""
        count, persons = len(self.persons), self.persons
        found = FaceInputs.calm(len(self._faced))
        found.pain[:] = self.arrays.owners["pain"][self._faced]
        if self.minds is not None:
            found.felt[:count] = self.minds.felt
        found.told[:count] = self.dispatcher.expressions
        found.eyes[:count] = eye_aims(persons)
        found.stun[:count] = persons["stun"]
        found.grips[:count] = self.dispatcher.gripping()
        found.flat[:count] = np.maximum(
            LED_HAND_FLATNESS * np.isin(persons["arm_mode"], (REACHING, PLACED)),
            EMBRACE_FLATNESS * persons["embrace_blend"],
        )
        return found

    def write(self, rows: Rows) -> None:
        """Write all rows kept, at once because the calls dominate the cost."""
        nodes, turned, records, embraced = zip(*self._rows, strict=True)
        persons = np.empty((len(records), len(self.persons)), self.persons.dtype)
        for k, record in enumerate(records):
            persons[k] = record
        posed = self._poser.pose(
            *(np.array(nodes), np.array(turned), persons, np.array(embraced)), self.world.ground
        )
        rows.rotations[:], rows.positions[:] = posed
        rows.alive[:] = True
        rows.expressions[:] = self._faces.faces(self._face_inputs)
        self._face_inputs.clear()
        if self._values:
            rows.values[:] = self._values
            self._values.clear()
        self._rows.clear()

    def feelings(self) -> Mapping[str, Mapping[str, float]]:
        """Return what people with minds feel now, by name and feeling."""
        return self.minds.feelings() if self.minds is not None else {}

    def facts(self) -> Facts:
        """Return the facts of the last step."""
        return self._facts
