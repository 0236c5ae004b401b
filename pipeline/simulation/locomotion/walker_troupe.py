"""Walker troupe: the creatures that walk on legs.

The phase of the gait grows, the body follows its route, and the feet step, see `step_sequencer`.
The poses that join them are solved for many moments at once, when they are written, see
`pose_solver`.

Source: Sims 1987, ch. 10.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.attachment import Attachment
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.surroundings import Surroundings
from pipeline.simulation.hand_grips import HandGrips
from pipeline.simulation.locomotion.authored_poses import AuthoredPoses
from pipeline.simulation.locomotion.body_motion.gaze import LookTargets
from pipeline.simulation.locomotion.body_motion.idle_motion import collect_free_joints
from pipeline.simulation.locomotion.dancing.walker_dances import WalkerDances
from pipeline.simulation.locomotion.gaits.moods import MoodSchedule
from pipeline.simulation.locomotion.gaits.pace_schedule import PaceSchedule
from pipeline.simulation.locomotion.herd import build_herd
from pipeline.simulation.locomotion.inventory import (
    NodeTable,
    describe_herd,
    legs_of,
    mechanisms_of,
)
from pipeline.simulation.locomotion.leaping.walker_jumps import WalkerJumps
from pipeline.simulation.locomotion.pose_solver import HerdSnapshot, PoseSolver
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.pursuit import Pursuits
from pipeline.simulation.locomotion.routes.route import plan_route
from pipeline.simulation.locomotion.routes.route_progress import is_blocked, start_progress
from pipeline.simulation.locomotion.routes.speed_control import advance
from pipeline.simulation.locomotion.routes.walk_orders import apply_order, chooses_speed
from pipeline.simulation.locomotion.stepping.initial_stance import place_feet
from pipeline.simulation.locomotion.stepping.setting_out import greatest_strides, phase_before_lift
from pipeline.simulation.locomotion.stepping.step_refusals import refuse_missed_steps
from pipeline.simulation.locomotion.stepping.step_sequencer import StepSequencer
from pipeline.simulation.locomotion.stepping.taking_steps import take_steps
from pipeline.simulation.locomotion.swing.foot_contacts import FootContacts
from pipeline.simulation.locomotion.swing.swing_planner import SwingPlanner
from pipeline.simulation.mechanism import Leg, Mechanism
from pipeline.simulation.members import MemberState, members_named
from pipeline.simulation.people.dressed_figure import hand_links
from pipeline.simulation.people.face_tracker import FaceTracker
from pipeline.simulation.people.guided_dance import GuideMaker
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Node, TakeNote
from pipeline.simulation.troupe import Facts, Troupe, World
from pipeline.spec.creature import Creature
from pipeline.spec.script import ChangeGait, ChangeMood, Chase, Do, Flee, Instruction, SetSpeed

# Greatest factor on a creature's speed by a change of mood, and by unknown orders.
MAX_SPEEDUP, UNKNOWN_SPEEDUP = 2.0, 10.0

# Rows that are solved together ahead of the simulation.
FORESEEN_ROWS = 96


class WalkerTroupe(Troupe):
    """All creatures on legs: their state, and how it advances.

    Attributes:
        progress: on their routes.
        sequencer: of their steps.
        leaps: jumps of the creatures.
    """

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        world: World,
        materials: Sequence[str],
        guide: GuideMaker | None = None,
    ) -> None:
        self.world, self._cast, self._materials = world, cast, materials
        self.herd = herd = build_herd(cast, world.moods)
        refuse_missed_steps(herd, [number for number, _, _ in cast])
        moods = MoodSchedule(cast, herd.neutral_paces, herd.leg_layouts, world.moods)
        farthest = self._farthest(moods)
        routes = [
            plan_route(member, herd.footprint[c], float(farthest[c]))
            for c, (_, member, _) in enumerate(cast)
        ]
        trajectory = BodyTrajectory(herd, world.ground, routes, PaceSchedule(herd))
        trajectory.style = moods.style(0.0)
        free_joints = collect_free_joints(herd, world.seed)
        table = NodeTable.of(herd, free_joints)
        self.authored_poses = AuthoredPoses(
            cast, herd, free_joints, world.seed, Surroundings(world.ground, world.solids)
        )
        self.pose_solver = PoseSolver(
            herd, trajectory, free_joints, table, self.authored_poses, world.clock
        )
        self.inventory = describe_herd(
            herd, free_joints, table, materials, world.clothes, world.clock.rows
        )
        faced = [face.performer for face in self.inventory.faces]
        self._faces = FaceTracker(faced, world.seed, world.clock.row_time)
        self._grips, self._written = HandGrips([]), 0
        self.step = 0
        looks = LookTargets(herd, cast)
        self.progress = start_progress(herd, trajectory, moods, world.clock.dt, looks)
        self.pursuits = Pursuits(self.progress, world.ground)
        swings = SwingPlanner.of(cast, self.progress, world.ground)
        contacts = FootContacts(herd, world, self.authored_poses, materials)
        self.sequencer = StepSequencer.of(world, self.progress, swings, contacts)
        self.leaps = WalkerJumps(cast, world, self.progress, self.sequencer, materials, self._apply)
        self.dances = WalkerDances(
            cast, world, self.progress, self.sequencer.feet, free_joints, guide
        )
        self._order_notes: list[TakeNote] = []
        self._pose_notes: list[TakeNote] = []
        self._arrived: list[str] = []
        self._buffered: list[HerdSnapshot] = []
        place_feet(self.sequencer, [number for number, _, _ in cast])
        self._notes: list[TakeNote] = list(self.sequencer.notes)

    @property
    def travelled(self) -> Array:
        """(C,) distance gone since the start [m]."""
        return self.progress.distance

    @property
    def phase(self) -> Array:
        """(C,) phases of the gaits, whole cycles counted."""
        return self.progress.phase

    @property
    def halted(self) -> NDArray[np.bool_]:
        """(C,) whether it found no foothold."""
        return self.progress.halted

    # --- the passes of the step -------------------------------------------------

    def members_needed(self, orders: Orders) -> Collection[str]:
        """Return the members that creatures are to jump over, to pursue and to look at."""
        ordered = members_named(self.herd.names, orders)
        own_needs = self.pursuits.members_needed() | self.progress.look_targets.members_needed
        return {*self.leaps.sought(orders), *ordered, *own_needs}

    def see_members(self, members: Mapping[str, MemberState]) -> None:
        """Take in where these members are."""
        self.leaps.see(members)
        self.pursuits.see_members(members)
        self.progress.look_targets.see_members(members)

    def read(self, orders: Orders) -> None:
        """Take in the orders from this step on."""
        for name, given in orders.items():
            if name not in self.herd.names:
                continue
            c = self.herd.names.index(name)
            if any(chooses_speed(order) for order in given):
                self.pursuits.keep_speed(c)
            for order in given:
                on_feet = self.dances.take(c, order)
                if not self.leaps.take(c, on_feet):
                    self._apply(c, on_feet)
        self.pursuits.advance()

    def _apply(self, c: int, order: Do) -> None:
        if self.pursuits.take(c, order):
            return
        unable = apply_order(self.progress, c, order)
        if c in self.progress.transition_ends:
            self.sequencer.feet.changing.add(c)
        if unable is not None:
            name = self.herd.names[c]
            self._order_notes.append(TakeNote("clamped", self.step, name, unable))

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        sequencer, progress = self.sequencer, self.progress
        sequencer.contacts.contacts.clear()
        sequencer.notes.clear()
        phase_before = self.phase
        progress.trajectory.style = progress.moods.style(progress.time)
        arrived = self._advance_on_routes()
        take_steps(sequencer, step, phase_before)
        self.leaps.advance(step)
        self.dances.advance(step)
        before = self.leaps, self.dances
        self._arrived = [name for name in arrived if not any(x.is_coming(name) for x in before)]
        self._arrived += [*self.leaps.arrived, *self.dances.arrived]
        self._arrived += [self.herd.names[c] for c in self.pursuits.arrived]
        self._notes = [*self._order_notes, *sequencer.notes, *self.leaps.notes]
        self._order_notes = []
        self.step = step + 1

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Refuse gaits that legs cannot do, and prepare jumps."""
        if isinstance(instruction.do, ChangeGait) and instruction.who in self.herd.names:
            c = self.herd.names.index(instruction.who)
            self.progress.moods.neutral_pace(c, instruction.do, f"{path}.do")
        self.leaps.prepare(instruction, path)
        self.dances.prepare(instruction, path)

    def buffer_row(self) -> None:
        """Keep the present state as the next row."""
        self._buffered.append(self._snapshot())

    def _snapshot(self) -> HerdSnapshot:
        progress, trajectory = self.progress, self.progress.trajectory
        now = self.step * self.world.clock.dt
        return HerdSnapshot(
            self.step,
            progress.sample,
            progress.stride_part,
            progress.smoothed_fraction,
            self.sequencer.feet.copied(),
            trajectory.style,
            trajectory.route_set,
            self.leaps.routes(),
            self.dances.gazes(progress.look_targets.current),
            self.leaps.aloft(now),
            self.dances.bodies(now),
        )

    def write(self, rows: Rows) -> None:
        """Write nodes and channels of all rows kept."""
        trajectory, first = self.progress.trajectory, 0
        present = trajectory.route_set
        # With the routes of their time: a later one is the same so far but for the last bit, which
        # may not depend on how many rows are written at once.
        for trajectory.route_set, moments in groupby(self._buffered, key=lambda row: row.route_set):
            poses = self.pose_solver.solve(list(moments))
            here = slice(first, first + len(poses.positions))
            rows.positions[here], rows.rotations[here] = poses.positions, poses.rotations
            rows.values[here] = poses.values
            self._pose_notes.extend(poses.notes)
            first = here.stop
        trajectory.route_set = present
        rows.alive[:] = True
        count = len(self._buffered)
        rows.expressions[:] = self._faces.calm(count, self._grips.at(self._written, count))
        self._written += count
        self._buffered.clear()

    def facts(self) -> Facts:
        """Return the contacts and notes of the last step."""
        contacts = [*self.sequencer.contacts.contacts, *self.leaps.contacts, *self.dances.contacts]
        # Rows may have been written before the step, too.
        notes, self._pose_notes = (*self._notes, *self._pose_notes), []
        outcomes = (*self.pursuits.outcomes, *self.leaps.outcomes, *self.dances.outcomes)
        touched = tuple(self.pursuits.touched)
        return Facts(tuple(contacts), notes, tuple(self._arrived), touched, outcomes=outcomes)

    def see_attachments(self, attachments: Sequence[Attachment], nodes: Sequence[Node]) -> None:
        """Close the hands of persons around what they hold."""
        numbers = {node.name: i for i, node in enumerate(nodes)}
        figures = {member.name: figure for _, member, figure in self._cast}
        faced = [face.performer for face in self.inventory.faces]
        hands = [[numbers[f"{n}.{link}"] for link in hand_links(figures[n])] for n in faced]
        self._grips = HandGrips(hands)
        self._grips.bind(attachments)

    def foreseen_notes(self) -> list[TakeNote]:
        """Return notes on the pose keys that creatures miss which stay where they stand.

        Their rows follow from the time alone, so those of their keys are solved without steps.
        """
        staying = [
            i for i, (_, member, _) in enumerate(self._cast) if member.pose and member.walk is None
        ]
        if not staying:
            return []
        cast, materials = [self._cast[i] for i in staying], [self._materials[i] for i in staying]
        return WalkerTroupe(cast, self.world, materials)._notes_of_keys()

    def _notes_of_keys(self) -> list[TakeNote]:
        """Return notes on all rows from the first key on to the last, in the present places."""
        clock = self.world.clock
        first, last = (clock.step_at(time) for time in self.authored_poses.span)
        steps = range(first, min(last + clock.steps, clock.last_step) + 1)
        here = self._snapshot()
        rows = [replace(here, step=step) for step in steps if clock.row_of_step(step) is not None]
        notes = list[TakeNote]()
        for start in range(0, len(rows), FORESEEN_ROWS):
            notes += self.pose_solver.solve(rows[start : start + FORESEEN_ROWS]).notes
        return notes

    def mechanisms(self) -> list[Mechanism]:
        """Return the joints and masses of the creatures."""
        return mechanisms_of(self.herd)

    def legs(self) -> list[Leg]:
        """Return the legs of the creatures, with the stances planned so far."""
        return legs_of(self.herd, self.progress.paces, self.phase)

    # --- parts ------------------------------------------------------------------

    def _farthest(self, moods: MoodSchedule) -> Array:
        """Return bounds on the distances (C,) that creatures go in the film [m].

        Raises:
            SceneError: if the script asks for a gait that legs do not have.
        """
        herd, clock = self.herd, self.world.clock
        stride, speed = herd.stride.copy(), herd.stride / herd.cycle
        top = np.array([pace.hurried_speed for pace in herd.paces])
        hurries, speedup = np.zeros(len(speed), dtype=bool), np.ones(len(speed))
        for path, instruction in self.world.instructions:
            if instruction.who not in herd.names:
                continue
            c, do = herd.names.index(instruction.who), instruction.do
            if isinstance(do, ChangeGait):
                pace = moods.neutral_pace(c, do, f"{path}.do")
                stride[c] = max(stride[c], pace.stride)
                speed[c] = max(speed[c], pace.speed)
                top[c] = max(top[c], pace.hurried_speed)
            elif isinstance(do, SetSpeed):
                speed[c] = max(speed[c], do.speed)
            elif isinstance(do, Chase | Flee):
                hurries[c] = True
            elif isinstance(do, ChangeMood):
                speedup[c] *= MAX_SPEEDUP
        speed = np.where(hurries, np.maximum(speed, top), speed) * speedup
        if self.world.directed:
            speed *= UNKNOWN_SPEEDUP
        return speed * float(clock.time_of(clock.last_step)) + stride

    def _advance_on_routes(self) -> list[str]:
        """Advance on the routes; return the names of creatures that have come to their ends."""
        progress, count = self.progress, len(self.herd.names)
        most = greatest_strides(self.sequencer)
        if not progress.can_rest:
            advance(progress, np.zeros(count, dtype=bool), most)
            return []
        before = progress.arrived
        swinging = self.herd.owner[self.sequencer.feet.swinging]
        advance(progress, np.bincount(swinging, minlength=count) > 0, most)
        arrived = np.flatnonzero(progress.arrived & ~before).tolist()
        for c in arrived:
            closing = float(progress.closing_phase[c])
            progress.closing_phase[c] = phase_before_lift(self.sequencer, c, closing)
        pursuits = self.pursuits
        here = [c for c in arrived if not is_blocked(progress, c) and not pursuits.is_active(c)]
        return [self.herd.names[c] for c in here]
