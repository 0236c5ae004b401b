"""The troupe of simulation creatures.

Each advances through a step on its own, from event to event (`hop_simulation`); poses are computed
for many rows at once (`hopper_pose`).

Source: Sims 1987, 7.4 and ch. 11.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.body_motion.gaze import LookTargets
from pipeline.simulation.locomotion.body_motion.idle_motion import collect_free_joints
from pipeline.simulation.locomotion.foot_placement.leg_reachability import shortest_reaches
from pipeline.simulation.locomotion.herd import build_herd
from pipeline.simulation.locomotion.inventory import NodeTable, describe_herd
from pipeline.simulation.locomotion.pronking.hop_events import HopEventRecorder
from pipeline.simulation.locomotion.pronking.hop_simulation import HopSimulation
from pipeline.simulation.locomotion.pronking.hop_state import JumpOrder
from pipeline.simulation.locomotion.pronking.hopper import build_hoppers
from pipeline.simulation.locomotion.pronking.hopper_fall import Fall, RagdollFall, RigidFall
from pipeline.simulation.locomotion.pronking.hopper_pose import (
    HopperPoseBuffer,
    HopperPoser,
    HopperSnapshot,
)
from pipeline.simulation.locomotion.pronking.jump_orders import FALLEN, apply_order, scripted_jump
from pipeline.simulation.members import MemberState, members_named
from pipeline.simulation.order_outcome import Outcome
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.script import Orders
from pipeline.simulation.take import Contact, TakeNote
from pipeline.simulation.troupe import Facts, Troupe, World
from pipeline.spec.creature import Creature, Pronk
from pipeline.spec.script import Do, Instruction, JumpOnce, LookAhead, LookAt

FOOTHOLD_MISS = 1e-4
"""Distance between a foot and its foothold that is worth a note [m]."""

PHASE_INTERVALS = {"flight": (0.0, 0.5), "landing": (0.5, 0.25), "pushing": (0.75, 0.25)}
"""Start and length of each phase in a cycle from 0 to 1."""

FALL_MODELS: dict[str, Callable[[Figure], Fall]] = {"ragdoll": RagdollFall, "rigid": RigidFall}


class HopperTroupe(Troupe):
    """All simulation creatures.

    Attributes:
        herd: their figures.
        hoppers: their constants.
        simulations: their states.
    """

    def __init__(
        self, cast: Sequence[tuple[int, Creature, Figure]], world: World, materials: Sequence[str]
    ) -> None:
        self.world = world
        self.herd = herd = build_herd(cast, world.moods)
        free_joints = collect_free_joints(herd, world.seed)
        table = NodeTable.of(herd, free_joints)
        configs = [member.pronk or Pronk() for _, member, _ in cast]
        self.hoppers = build_hoppers(herd, [number for number, _, _ in cast], configs)
        above = [float(m.at[1]) if len(m.at) == 3 else None for _, m, _ in cast]
        for path, instruction in world.instructions:
            self.prepare(instruction, path)
        row_dt = world.clock.dt * world.clock.steps / world.clock.samples
        self.poser = HopperPoser(
            herd, world.ground, free_joints, table, shortest_reaches(herd), row_dt
        )
        self.pose_buffer = HopperPoseBuffer(self.poser, world.clock.dt)
        self.looks = LookTargets(herd, cast)
        self.simulations = [
            HopSimulation(
                hopper,
                world.ground,
                height,
                FALL_MODELS[hopper.config.fall](herd.figures[c]),
                partial(self.pose_buffer.joint_state, c),
            )
            for c, (hopper, height) in enumerate(zip(self.hoppers, above, strict=True))
        ]
        self.inventory = describe_herd(
            herd, free_joints, table, materials, world.clothes, world.clock.rows
        )
        self._recorder = HopEventRecorder(herd, world, materials)
        self.step = 0
        self._contacts: list[Contact] = []
        self._notes: list[TakeNote] = []
        self._pending_notes: list[TakeNote] = []
        self._row_notes: list[TakeNote] = []
        self._arrived: list[str] = []
        self._given: list[tuple[int, Do, JumpOrder]] = []
        self._outcomes: list[Outcome] = []
        self._pending_outcomes: list[Outcome] = []
        self._members: Mapping[str, MemberState] = {}

    def members_needed(self, orders: Orders) -> Collection[str]:
        """Return the members that creatures are to jump over, go to or look at."""
        return members_named(self.herd.names, orders) | self.looks.members_needed

    def see_members(self, members: Mapping[str, MemberState]) -> None:
        """Take in where these members are."""
        self._members = members
        self.looks.see_members(members)

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Check a scripted jump.

        Raises:
            SceneError: its values contradict each other.
        """
        if instruction.who in self.herd.names and isinstance(instruction.do, JumpOnce):
            hopper = self.hoppers[self.herd.names.index(instruction.who)]
            scripted_jump(hopper, instruction.do.jump, f"{path}.do.jump")

    def read(self, orders: Orders) -> None:
        """Apply the orders of this step."""
        for c, name in enumerate(self.herd.names):
            for order in orders.get(name, ()):
                if isinstance(order, LookAt | LookAhead):
                    self._look(c, order)
                elif self.simulations[c].state.phase == "fallen":
                    self._pending_outcomes.append(Outcome(name, order, FALLEN))
                else:
                    jumps = apply_order(self.simulations[c], order, self._members)
                    if jumps is not None:
                        self._given.append((c, order, jumps))

    def _look(self, c: int, order: LookAt | LookAhead) -> None:
        at = order.look_at if isinstance(order, LookAt) else None
        try:
            self.looks.set(c, at)
        except ValueError as error:
            self._pending_notes.append(
                TakeNote("clamped", self.step, self.herd.names[c], str(error))
            )

    def advance(self, step: int) -> None:
        """Advance from `step` to the next."""
        self._contacts.clear()
        self._notes, self._pending_notes = self._pending_notes, []
        self._outcomes, self._pending_outcomes = self._pending_outcomes, []
        stood = [simulation.state.phase == "standing" for simulation in self.simulations]
        end = (step + 1) * self.world.clock.dt
        for c, simulation in enumerate(self.simulations):
            simulation.events.clear()
            simulation.advance(end)
            contacts, notes = self._recorder.records(step, c, simulation.events)
            self._contacts += contacts
            self._notes += notes
        self._arrived = [
            self.herd.names[c]
            for c, simulation in enumerate(self.simulations)
            if simulation.state.phase == "standing" and not stood[c]
        ]
        self._end_orders()
        self.step = step + 1

    def _end_orders(self) -> None:
        """Record the outcomes of the orders whose jumps have ended."""
        lasting = []
        for c, order, jumps in self._given:
            state = self.simulations[c].state
            reasons = [reason for dropped, reason in state.queue.dropped if dropped is jumps]
            if state.phase == "fallen":
                reasons.append(FALLEN)
            is_over = not any(jumps is other for other in state.queue.orders)
            if reasons or (is_over and state.phase != "flight"):
                reason = reasons[0] if reasons else ""
                self._outcomes.append(Outcome(self.herd.names[c], order, reason))
            else:
                lasting.append((c, order, jumps))
        self._given = lasting
        for simulation in self.simulations:
            simulation.state.queue.dropped.clear()

    def buffer_row(self) -> None:
        """Append the current state as the next row."""
        poses = [simulation.pose() for simulation in self.simulations]
        hanging = ((c, simulation.fall.q) for c, simulation in enumerate(self.simulations))
        self.pose_buffer.keep(
            HopperSnapshot(
                step=self.step,
                R=np.stack([body.R for body, _ in poses]),
                p=np.stack([body.origin for body, _ in poses]),
                tips=np.concatenate([tips for _, tips in poses]),
                down=np.concatenate([simulation.state.down for simulation in self.simulations]),
                phase=np.array([cycle_phase(simulation) for simulation in self.simulations]),
                speed=np.array(
                    [np.hypot(*simulation.state.v[[0, 2]]) for simulation in self.simulations]
                ),
                looks=self.looks.current,
                limp=np.array(
                    [simulation.state.phase == "fallen" for simulation in self.simulations]
                ),
                hanging={c: q for c, q in hanging if q is not None},
            )
        )

    def write(self, rows: Rows) -> None:
        """Write nodes and channels of all kept rows."""
        first = 0
        for snapshots, poses in self.pose_buffer.take():
            here = slice(first, first + len(snapshots))
            rows.positions[here], rows.rotations[here] = poses.positions, poses.rotations
            rows.alive[here] = True
            rows.values[here] = poses.values
            for row, leg in np.argwhere(poses.residual > FOOTHOLD_MISS):
                part, gap = self._recorder.part(int(leg)), 1000.0 * float(poses.residual[row, leg])
                text = f"{gap:.2g} mm from its foothold"
                self._row_notes.append(TakeNote("clamped", snapshots[row].step, part, text))
            first = here.stop

    def facts(self) -> Facts:
        """Return the contacts, notes and outcomes of the last step."""
        # Rows may also have been written before the step.
        notes, self._row_notes = (*self._notes, *self._row_notes), []
        outcomes = tuple(self._outcomes)
        return Facts(tuple(self._contacts), notes, tuple(self._arrived), outcomes=outcomes)


def cycle_phase(simulation: HopSimulation) -> float:
    """Return the phase of a creature in its jump cycle, 0 to 1; 0 before and after all jumps."""
    state = simulation.state
    if state.phase not in PHASE_INTERVALS:
        return 0.0
    start, length = PHASE_INTERVALS[state.phase]
    v = float(state.v[1])
    if state.phase == "flight":
        up = float(state.lift_off[1][1])
        progress = 0.5 * (1.0 - v / up) if up > 0.0 else 0.5
    elif state.phase == "landing":
        progress = 1.0 - max(state.phase_end - state.time, 0.0) / 0.3
    else:
        up = v + float(state.a[1]) * (state.phase_end - state.time)
        progress = v / up if up > 0.0 and np.isfinite(up) else 0.0
    return start + length * min(max(progress, 0.0), 1.0)
