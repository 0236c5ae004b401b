"""Walking: the troupe of creatures on legs.

The gait's phase runs on, the body goes its way, and the feet step, see `feet`. What joins
them is worked out for many moments at once, when they are written; see `posing`.

Source: Sims 1987, ch. 10.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.authored_poses import AuthoredPoses
from pipeline.simulation.locomotion.body_motion.gaze import initial_look_targets
from pipeline.simulation.locomotion.body_motion.idle_motion import collect_free_joints
from pipeline.simulation.locomotion.gaits.gait_transition import PaceSchedule
from pipeline.simulation.locomotion.gaits.moods import MoodSchedule
from pipeline.simulation.locomotion.herd import build_herd
from pipeline.simulation.locomotion.inventory import NodeTable, describe_herd
from pipeline.simulation.locomotion.leaping.walker_jumps import WalkerJumps
from pipeline.simulation.locomotion.leg_records import legs_of, mechanisms_of
from pipeline.simulation.locomotion.pose_solver import HerdSnapshot, PoseSolver
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.route import plan_route
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
from pipeline.simulation.locomotion.routes.walk_orders import apply_order
from pipeline.simulation.locomotion.stepping import Feet
from pipeline.simulation.locomotion.swing.foot_contacts import FootContacts
from pipeline.simulation.mechanism import Leg, Mechanism
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Note
from pipeline.simulation.troupe import Facts, Rows, Troupe, World
from pipeline.spec.creature import Creature
from pipeline.spec.script import ChangeGait, ChangeMood, Instruction, SetSpeed

HURRY = 2.0
"""How much faster a creature may get by a change of mood or speed."""

UNKNOWN = 10.0
"""Likewise where it is not known what it will be asked."""


class Walkers(Troupe):
    """All creatures on legs: their state, and how it advances.

    Attributes of the state:
        going: how far they have gone, and how fast they go.
        feet: where they stand and how they step.
    """

    def __init__(
        self, cast: Sequence[tuple[int, Creature, Figure]], world: World, materials: Sequence[str]
    ) -> None:
        self.world = world
        self.herd = herd = build_herd(cast, world.moods)
        paces, manners = (
            PaceSchedule(herd),
            MoodSchedule(cast, herd.plain, herd.spreads, world.moods),
        )
        far = self._farthest(manners)
        routes = [
            plan_route(member, herd.footprint[c], float(far[c]))
            for c, (_, member, _) in enumerate(cast)
        ]
        path = BodyTrajectory(herd, world.ground, routes, paces)
        idlers = collect_free_joints(herd, world.seed)
        table = NodeTable.of(herd, idlers)
        self.postures = AuthoredPoses(cast, herd, idlers, world.seed)
        self.posing = PoseSolver(herd, path, idlers, table, self.postures, world.clock)
        self.inventory = describe_herd(herd, idlers, table, materials, world.clock.rows)
        self.step = 0
        path.bearing = manners.bearing(0.0)
        self.going = RouteProgress(herd, path, manners, world.clock.dt)
        self.going.looks = initial_look_targets(herd, cast)
        self.feet = Feet(
            cast, world, self.going, FootContacts(herd, world, self.postures, materials)
        )
        self.leaps = WalkerJumps(cast, world, self.going, self.feet, materials)
        self._notes: list[Note] = []
        self._told: list[Note] = []
        self._late: list[Note] = []
        self._arrived: list[str] = []
        self._kept: list[HerdSnapshot] = []
        self.feet.set_down()
        self._notes.extend(self.feet.notes)

    @property
    def travelled(self) -> Array:
        """(C,) way gone since the start [m]."""
        return self.going.way

    @property
    def phase(self) -> Array:
        """(C,) phases of the gaits, whole cycles counted."""
        return self.going.phase

    @property
    def halted(self) -> NDArray[np.bool_]:
        """(C,) whether it found no foothold."""
        return self.going.halted

    # --- the passes of the step -------------------------------------------------

    def solids_needed(self, orders: Orders) -> Collection[str]:
        """Return over whom somebody is to jump."""
        return self.leaps.sought(orders)

    def see_solids(self, solids: Mapping[str, Sequence[Array]]) -> None:
        """Take in where those are."""
        self.leaps.see(solids)

    def read(self, orders: Orders) -> None:
        """Take in what the script asks from this step on."""
        for name, given in orders.items():
            if name in self.herd.names:
                for order in given:
                    c = self.herd.names.index(name)
                    if self.leaps.take(self.step, c, order):
                        continue
                    unable = apply_order(self.going, c, order)
                    if self.going.changes(c):
                        self.feet.changing.add(c)
                    if unable is not None:
                        self._told.append(Note("clamped", self.step, name, unable))

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        feet = self.feet
        feet.footfalls.contacts.clear()
        feet.notes.clear()
        before = self.phase
        going = self.going
        going.path.bearing = going.manners.bearing(going.time)
        self._arrived = self._go_on()
        feet.take_steps(step, before)
        self.leaps.advance(step)
        self._arrived = [one for one in self._arrived if not self.leaps.is_coming(one)]
        self._arrived += self.leaps.arrived
        self._notes, self._told = [*self._told, *feet.notes, *self.leaps.notes], []
        self.step = step + 1

    def _farthest(self, manners: MoodSchedule) -> Array:
        """Return how far creatures (C,) can get in the film at most [m].

        Raises:
            SceneError: if the script asks for a gait that legs do not have.
        """
        herd, clock = self.herd, self.world.clock
        stride, speed = herd.stride.copy(), herd.stride / herd.cycle
        for i, one in enumerate(self.world.script):
            if one.who not in herd.names:
                continue
            c, hurry = herd.names.index(one.who), 1.0
            if isinstance(one.do, ChangeGait):
                pace = manners.possible(c, one.do, f"script[{i}].do")
                stride[c] = max(stride[c], pace.stride)
                speed[c] = max(speed[c], pace.stride / pace.cycle)
            elif isinstance(one.do, SetSpeed | ChangeMood):
                hurry = HURRY
            speed[c] *= hurry
        if self.world.directed:
            speed *= UNKNOWN
        return speed * float(clock.time_of(clock.last_step)) + stride

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Refuse what legs cannot do, and be ready for jumps."""
        if isinstance(instruction.do, ChangeGait) and instruction.who in self.herd.names:
            c = self.herd.names.index(instruction.who)
            self.going.manners.possible(c, instruction.do, f"{path}.do")
        self.leaps.prepare(instruction, path)

    def buffer_row(self) -> None:
        """Keep the present state as the next row."""
        feet = self.feet
        self._kept.append(
            HerdSnapshot(
                step=self.step,
                gone=self.going.gone,
                drive=self.going.drive,
                vigour=self.going.vigour,
                start=feet.start.copy(),
                end=feet.end.copy(),
                height=feet.height.copy(),
                lifted=feet.lifted.copy(),
                span=feet.span.copy(),
                swinging=feet.swinging.copy(),
                stoop=feet.stoop.copy(),
                tuck=feet.tuck.copy(),
                bearing=self.going.path.bearing,
                ways=self.going.path.ways,
                routes=self.leaps.routes(),
                looks=self.going.looks,
                bend=None if feet.bend is None else feet.bend.copy(),
                aloft=self.leaps.aloft(self.step * self.world.clock.dt),
            )
        )

    def write(self, rows: Rows) -> None:
        """Write nodes and channels of all rows kept."""
        path, first = self.going.path, 0
        ways = path.ways
        # On the ways that they had: another one is the same so far but for the last bit, which
        # may not depend on how many rows are written at once.
        for path.ways, moments in groupby(self._kept, key=lambda moment: moment.ways):
            poses = self.posing.poses(list(moments))
            here = slice(first, first + len(poses.positions))
            rows.positions[here], rows.rotations[here] = poses.positions, poses.rotations
            rows.values[here] = poses.values
            self._late.extend(poses.notes)
            first = here.stop
        path.ways = ways
        rows.alive[:] = True
        self._kept.clear()

    def facts(self) -> Facts:
        """Return the contacts and notes of the last step."""
        contacts = *self.feet.footfalls.contacts, *self.leaps.contacts
        # Rows may have been written before the step, too.
        notes, self._late = (*self._notes, *self._late), []
        return Facts(contacts, notes, tuple(self._arrived))

    def mechanisms(self) -> list[Mechanism]:
        """Return the joints and masses of the creatures."""
        return mechanisms_of(self.herd)

    def legs(self) -> list[Leg]:
        """Return the legs of the creatures, with the stances planned so far."""
        return legs_of(self.herd, self.going.paces, self.phase)

    def _go_on(self) -> list[str]:
        """Advance on the routes; return who has come to its end."""
        going, count = self.going, len(self.herd.names)
        if not going.may_rest:
            going.advance(np.zeros(count, dtype=bool))
            return []
        stood = going.arrived
        going.advance(np.bincount(self.herd.owner[self.feet.swinging], minlength=count) > 0)
        came = np.flatnonzero(going.arrived & ~stood)
        for c in came.tolist():
            going.closed[c] = self.feet.about_to_lift(c, float(going.closed[c]))
        return [self.herd.names[c] for c in came if not self.feet.is_barred(int(c))]
