"""Pronkers: the troupe of creatures that hop.

Each goes through a step at its own pace, from event to event, see `hopping`; what joins feet
and bodies is worked out for many rows at once, see `posing`.

Source: Sims 1987, 7.4 and ch. 11.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.body_motion.gaze import (
    initial_look_targets,
    set_look_target,
)
from pipeline.simulation.locomotion.body_motion.idle_motion import collect_free_joints
from pipeline.simulation.locomotion.foot_placement.leg_reachability import shortest_reaches
from pipeline.simulation.locomotion.herd import build_herd
from pipeline.simulation.locomotion.inventory import NodeTable, describe_herd
from pipeline.simulation.locomotion.pronking.hop_events import HopEventRecorder
from pipeline.simulation.locomotion.pronking.hop_simulation import HopSimulation
from pipeline.simulation.locomotion.pronking.hopper import build_hoppers
from pipeline.simulation.locomotion.pronking.hopper_fall import Fall, RagdollFall, RigidFall
from pipeline.simulation.locomotion.pronking.hopper_pose import (
    HopperPoseBuffer,
    HopperPoser,
    HopperSnapshot,
)
from pipeline.simulation.locomotion.pronking.jump_orders import (
    Solids,
    apply_order,
    scripted_jump,
)
from pipeline.simulation.script import Orders
from pipeline.simulation.take import Contact, Note
from pipeline.simulation.troupe import Facts, Rows, Troupe, World
from pipeline.spec.creature import Creature, Pronk
from pipeline.spec.script import HopOver, Instruction, JumpOnce, LookAhead, LookAt

FOOTHOLD_MISS = 1e-4
"""Distance between a foot and its foothold that is worth a note [m]."""

PHASE_INTERVALS = {"flight": (0.0, 0.5), "landing": (0.5, 0.25), "pushing": (0.75, 0.25)}
"""Where the phases begin in a cycle that runs from 0 to 1, and how long they are."""

FALL_MODELS: dict[str, Callable[[Figure], Fall]] = {"ragdoll": RagdollFall, "rigid": RigidFall}


class HopperTroupe(Troupe):
    """All creatures that hop.

    Attributes:
        herd: what they are.
        hoppings: how each is.
    """

    def __init__(
        self, cast: Sequence[tuple[int, Creature, Figure]], world: World, materials: Sequence[str]
    ) -> None:
        self.world = world
        self.herd = herd = build_herd(cast, world.moods)
        idlers = collect_free_joints(herd, world.seed)
        table = NodeTable.of(herd, idlers)
        words = [member.pronk or Pronk() for _, member, _ in cast]
        self.pronkers = build_hoppers(herd, [number for number, _, _ in cast], words)
        above = [float(m.at[1]) if len(m.at) == 3 else None for _, m, _ in cast]
        for i, one in enumerate(world.script):
            self.prepare(one, f"script[{i}]")
        row_dt = world.clock.dt * world.clock.steps / world.clock.samples
        self.posing = HopperPoser(herd, world.ground, idlers, table, shortest_reaches(herd), row_dt)
        self.kept = HopperPoseBuffer(self.posing, world.clock.dt)
        self.looks = initial_look_targets(herd, cast)
        self.hoppings = [
            HopSimulation(
                of,
                world.ground,
                up,
                FALL_MODELS[of.words.fall](herd.figures[c]),
                partial(self.kept.limbs, c),
            )
            for c, (of, up) in enumerate(zip(self.pronkers, above, strict=True))
        ]
        self.inventory = describe_herd(herd, idlers, table, materials, world.clock.rows)
        self._telling = HopEventRecorder(herd, world, materials)
        self.step = 0
        self._contacts: list[Contact] = []
        self._notes: list[Note] = []
        self._told: list[Note] = []
        self._late: list[Note] = []
        self._arrived: list[str] = []
        self._solids: Solids = {}

    def solids_needed(self, orders: Orders) -> Collection[str]:
        """Return over whom somebody is to jump now."""
        return {
            order.hop_over
            for name in self.herd.names
            for order in orders.get(name, ())
            if isinstance(order, HopOver)
        }

    def see_solids(self, solids: Solids) -> None:
        """Take in where those are."""
        self._solids = {**self._solids, **solids}

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Refuse a jump that there is none of."""
        if instruction.who in self.herd.names and isinstance(instruction.do, JumpOnce):
            of = self.pronkers[self.herd.names.index(instruction.who)]
            scripted_jump(of, instruction.do.jump, f"{path}.do.jump")

    def read(self, orders: Orders) -> None:
        """Take in what the script asks from this step on."""
        for c, name in enumerate(self.herd.names):
            for order in orders.get(name, ()):
                if isinstance(order, LookAt | LookAhead):
                    self._look(c, order)
                elif self.hoppings[c].state.phase != "fallen":
                    apply_order(self.hoppings[c], order, self._solids)

    def _look(self, c: int, order: LookAt | LookAhead) -> None:
        at = order.look_at if isinstance(order, LookAt) else None
        try:
            self.looks = set_look_target(self.looks, self.herd, c, at)
        except ValueError as error:
            self._told.append(Note("clamped", self.step, self.herd.names[c], str(error)))

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        self._contacts.clear()
        self._notes, self._told = self._told, []
        stood = [hopping.state.phase == "standing" for hopping in self.hoppings]
        end = (step + 1) * self.world.clock.dt
        for c, hopping in enumerate(self.hoppings):
            hopping.happened.clear()
            hopping.advance(end)
            contacts, notes = self._telling.of(step, c, hopping.happened)
            self._contacts += contacts
            self._notes += notes
        self._arrived = [
            self.herd.names[c]
            for c, hopping in enumerate(self.hoppings)
            if hopping.state.phase == "standing" and not stood[c]
        ]
        self.step = step + 1

    def buffer_row(self) -> None:
        """Keep the present state as the next row."""
        poses = [hopping.pose() for hopping in self.hoppings]
        hanging = ((c, one.fall.q) for c, one in enumerate(self.hoppings))
        self.kept.keep(
            HopperSnapshot(
                step=self.step,
                R=np.stack([moved.R for moved, _ in poses]),
                p=np.stack([moved.origin for moved, _ in poses]),
                tips=np.concatenate([tips for _, tips in poses]),
                down=np.concatenate([one.state.down for one in self.hoppings]),
                phase=np.array([cycle_phase(one) for one in self.hoppings]),
                speed=np.array([np.hypot(*one.state.v[[0, 2]]) for one in self.hoppings]),
                looks=self.looks,
                limp=np.array([one.state.phase == "fallen" for one in self.hoppings]),
                hanging={c: q for c, q in hanging if q is not None},
            )
        )

    def write(self, rows: Rows) -> None:
        """Write nodes and channels of all rows kept."""
        first = 0
        for moments, poses in self.kept.taken():
            here = slice(first, first + len(moments))
            rows.positions[here], rows.rotations[here] = poses.positions, poses.rotations
            rows.alive[here] = True
            rows.values[here] = poses.values
            for row, leg in np.argwhere(poses.residual > FOOTHOLD_MISS):
                part, gap = self._telling.part(int(leg)), 1000.0 * float(poses.residual[row, leg])
                text = f"{gap:.2g} mm from its foothold"
                self._late.append(Note("clamped", moments[row].step, part, text))
            first = here.stop

    def facts(self) -> Facts:
        """Return the contacts and notes of the last step."""
        # Rows may have been written before the step, too.
        notes, self._late = (*self._notes, *self._late), []
        return Facts(tuple(self._contacts), notes, tuple(self._arrived))


def cycle_phase(hopping: HopSimulation) -> float:
    """Return where in the cycle of a jump a creature is, 0 to 1; 0 before and after all."""
    state = hopping.state
    if state.phase not in PHASE_INTERVALS:
        return 0.0
    begins, long = PHASE_INTERVALS[state.phase]
    v = float(state.v[1])
    if state.phase == "flight":
        up = float(state.lift[1][1])
        done = 0.5 * (1.0 - v / up) if up > 0.0 else 0.5
    elif state.phase == "landing":
        done = 1.0 - max(state.until - state.time, 0.0) / 0.3
    else:
        up = v + float(state.a[1]) * (state.until - state.time)
        done = v / up if up > 0.0 and np.isfinite(up) else 0.0
    return begins + long * min(max(done, 0.0), 1.0)
