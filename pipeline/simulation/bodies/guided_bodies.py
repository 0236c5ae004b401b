"""Guided bodies: those of a solver that hands hold, or that follow paths before they fall.

A body of the solver is pushed by all that it meets. While something else moves it, a kinematic
stand-in of its shape pushes the others instead, and the body itself meets nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from graphlib import CycleError, TopologicalSorter

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.bodies.body_guide import (
    AuthoredGrip,
    Fall,
    GuideState,
    node_pose,
)
from pipeline.simulation.bodies.body_instances import BodyInstance
from pipeline.simulation.bodies.guided_members import GuidedMember
from pipeline.simulation.clock import Clock
from pipeline.simulation.dynamics.kinematic_bodies import Poses, rotation_vectors
from pipeline.simulation.dynamics.mujoco_world import MujocoWorld
from pipeline.simulation.dynamics.rigid_body import State
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.obstacles import Obstacle
from pipeline.simulation.order_outcome import GripChange
from pipeline.simulation.spatial import Array, cross, matrix, quaternion, turn, turn_inverse
from pipeline.simulation.take import Node
from pipeline.spec.body import Many
from pipeline.spec.prop import Prop, PropHold

HOLDER_DEPTH = 1e-3
"""Depth in its holder below which a released body meets it at once, in sizes of the body."""

RELEASE_TIME = 0.15
"""Time after which a released thing meets people again: by then it has left the hand [s]."""


class GuidedBodies:
    """The guided bodies of one troupe and their stand-ins.

    Args:
        guided: in the order of their bodies.
        bodies: all bodies of the troupe.
        solver: of all bodies; its last kinematic bodies are the stand-ins.
        obstacles: its other kinematic bodies.
        clock: grid of steps and rows.

    Attributes:
        guides: what moves each of them.
        carriers: nodes that they go with by the scene, and the paths that name them.
    """

    def __init__(
        self,
        guided: Sequence[GuidedMember],
        bodies: Sequence[BodyInstance],
        solver: MujocoWorld,
        obstacles: Sequence[Obstacle],
        clock: Clock,
    ) -> None:
        self.guides = [one.guide for one in guided]
        self.carriers: dict[int, str] = {}
        self._guided, self._bodies, self._solver = guided, bodies, solver
        self._obstacles, self._clock = obstacles, clock
        self._row_time = clock.dt * (clock.steps // clock.samples)
        self._numbers = {bodies[guide.body].name: k for k, guide in enumerate(self.guides)}
        self._own = np.array([guide.body for guide in self.guides], dtype=np.int64)
        # Guides in an order in which each follows those that it goes with.
        self._order = list(range(len(self.guides)))
        self._nodes = Poses(np.zeros((0, 3)), np.zeros((0, 3, 3)))
        self._first_node = self._row = 0
        self._velocities = np.zeros((len(self.guides), 6))
        self._groups: dict[int, list[int]] = {}
        self._parting: list[tuple[int, int]] = []
        self._kicked: set[int] = set()
        self._lost: set[int] = set()
        self._held_by_people: set[int] = set()
        # Row from which people meet a thing again that they held.
        self._apart_until = np.zeros(len(bodies), dtype=np.int64)
        for k, guide in enumerate(self.guides):
            solver.ballistic[guide.body] = True
            self._show(k)

    def __bool__(self) -> bool:
        return bool(self.guides)

    @property
    def free(self) -> NDArray[np.bool_]:
        """(N,) which bodies of the troupe physics moves."""
        is_free = np.ones(len(self._bodies), dtype=bool)
        is_free[[g.body for g in self.guides if g.state is not GuideState.FREE]] = False
        return is_free

    @property
    def pushable(self) -> NDArray[np.bool_]:
        """(N,) which bodies of the troupe people can push: free ones, and those to be kicked."""
        can_be_pushed = self.free
        can_be_pushed[[self.guides[k].body for k in self._kicked]] = True
        return can_be_pushed

    @property
    def met_by_people(self) -> NDArray[np.bool_]:
        """(N,) which bodies of the troupe people collide with."""
        met = self._apart_until <= self._row
        met[[self.guides[k].body for k in self._held_by_people]] = False
        return met

    def bind(self, nodes: Sequence[Node], names: NodeNames) -> None:
        """Resolves parents and hands.

        Raises:
            SceneError: if a part does not exist, or bodies go with one another in a ring.
        """
        problems = list[Problem]()

        def node_of(part_name: str, path: str) -> int:
            found = names.find(part_name)
            if isinstance(found, str):
                problems.append(Problem(path, found))
                return -1
            self.carriers[found] = path
            return found

        self._first_node = names.nodes[self._bodies[0].name]
        for one in self._guided:
            member, path = one.member, f"cast[{one.number}]"
            if member.parent is not None:
                one.guide.parent = node_of(member.parent, f"{path}.parent")
            holds = () if isinstance(member, Many) else member.held
            one.guide.grips = tuple(
                AuthoredGrip(
                    node_of(hold.by, f"{path}.held[{k}].by"),
                    (self._row_at(hold.at), self._row_at(hold.until)),
                    not isinstance(hold, PropHold) or hold.then == "fall",
                )
                for k, hold in enumerate(holds)
            )
            if isinstance(member, Prop) and member.falls is not None:
                # The velocity that a parent gives is known one row later.
                first = 0 if one.guide.parent < 0 else 1
                row = max(self._row_at(member.falls), first)
                one.guide.fall = Fall(member.falls, row)
        if problems:
            raise SceneError(problems)
        self._order = self._carriers_first(nodes)
        self._group_holders(nodes)

    def _row_at(self, time: float | None) -> int:
        """Returns the first row at or after a time; one beyond the take for None."""
        if time is None:
            return self._clock.rows + 1
        return math.ceil(time / self._row_time - 1e-6)

    def _carriers_first(self, nodes: Sequence[Node]) -> list[int]:
        """Returns the guides in an order in which each follows its carriers.

        Raises:
            SceneError: if there is none.
        """
        needs = {
            k: {
                self._numbers[nodes[node].name]
                for node in guide.carriers
                if nodes[node].name in self._numbers
            }
            for k, guide in enumerate(self.guides)
        }
        try:
            return list(TopologicalSorter(needs).static_order())
        except CycleError as error:
            ring = [self._guided[k].member.name for k in error.args[1]]
            message = f"attachments form a ring: {' to '.join(ring)}; detach one of them"
            path = f"cast[{self._guided[error.args[1][0]].number}]"
            raise SceneError([Problem(path, message)]) from None

    def _group_holders(self, nodes: Sequence[Node]) -> None:
        """Groups the solids of each performer that bodies go with."""
        groups: dict[str, int] = {}
        for k, guide in enumerate(self.guides):
            for performer in sorted({nodes[node].performer for node in guide.carriers}):
                if performer not in groups:
                    pushers = self._pushers_of(performer)
                    if not pushers:
                        continue
                    groups[performer] = self._solver.masks.add_group(pushers)
                self._groups.setdefault(k, []).append(groups[performer])

    def _pushers_of(self, performer: str) -> list[int]:
        others, first = self._obstacles, len(self._obstacles)
        found = [k for k, obstacle in enumerate(others) if obstacle.performer == performer]
        return found + [
            first + k
            for k, guide in enumerate(self.guides)
            if self._bodies[guide.body].performer == performer
        ]

    # --- every row ----------------------------------------------------------------------

    def targets(self, row: int, p: Array, R: Array) -> Poses:
        """Returns the poses of the stand-ins at the end of a row; those of free bodies stay.

        Args:
            row: number of the row.
            p: (J, 3) positions of all nodes in it; those of the troupe are not known yet [m].
            R: (J, 3, 3) their rotations.
        """
        self._row, self._nodes = row, Poses(p.copy(), R.copy())
        self._show_nodes(np.arange(len(self._bodies)))
        goals = self._goals()
        if row > 0:
            before = self._stand_ins()
            turned = rotation_vectors(goals.R @ np.swapaxes(before.R, -1, -2))
            self._velocities = np.hstack([goals.p - before.p, turned]) / self._row_time
        return goals

    def settle(self) -> None:
        """Places the guided bodies where they are at the end of the row, after the solver."""
        free = self.free
        self._show_nodes(np.flatnonzero(free))
        guided = np.flatnonzero(~free[self._own])
        if len(guided):
            goals = self._goals()
            motion = self._velocities[guided]
            self._put(guided, Poses(goals.p[guided], goals.R[guided]), motion)
        self._part()
        for k in range(len(self.guides)):
            self._change_as_written(k)

    def drop(self, which: NDArray[np.int64]) -> None:
        """Lets nothing hold bodies that were removed."""
        self._lost.update(which.tolist())

    def node_poses(self) -> tuple[Array, Array]:
        """Returns positions (N, 3) [m] and rotations (N, 3, 3) of all nodes in the last row."""
        own = slice(self._first_node, self._first_node + len(self._bodies))
        return self._nodes.p[own].copy(), self._nodes.R[own].copy()

    def node_pose(self, body: int) -> Array:
        """Returns the pose (4, 4) of a body's node in the last row."""
        return node_pose(self._nodes, self._first_node + body)

    def _goals(self) -> Poses:
        """Returns the poses of the centres of mass of all guided bodies in the row."""
        now = self._stand_ins()
        p, R, time = now.p.copy(), now.R.copy(), self._row * self._row_time
        for k in self._order:
            guide = self.guides[k]
            if guide.state is GuideState.FREE:
                continue
            X, node = guide.pose(self._row, time, self._nodes), self._first_node + guide.body
            self._nodes.p[node], self._nodes.R[node] = X[:3, 3], X[:3, :3]
            R[k] = X[:3, :3]
            p[k] = X[:3, 3] - R[k] @ self._bodies[guide.body].origin
        return Poses(p, R)

    def _stand_ins(self) -> Poses:
        """Returns where the stand-ins are: before the first row, where the bodies are."""
        if self._row == 0:
            state = self._solver.state
            return Poses(state.p[self._own], matrix(state.q[self._own]))
        now, first = self._solver.pushers.now, len(self._obstacles)
        return Poses(now.p[first:], now.R[first:])

    def _show_nodes(self, which: NDArray[np.int64]) -> None:
        """Writes the nodes of some bodies as the solver has them."""
        state = self._solver.state
        R = matrix(state.q[which])
        origins = np.array([self._bodies[i].origin for i in which]).reshape(-1, 3)
        self._nodes.p[self._first_node + which] = state.p[which] + turn(R, origins)
        self._nodes.R[self._first_node + which] = R

    def _put(self, which: NDArray[np.int64], poses: Poses, motion: Array) -> None:
        """Sets poses and velocities (n, 6) of the bodies of some guides."""
        v, w = motion[:, :3], turn_inverse(poses.R, motion[:, 3:])
        self._solver.put(self._own[which], State(poses.p, quaternion(poses.R), v, w))

    # --- changes ------------------------------------------------------------------------

    def change_grips(self, changes: Sequence[GripChange], hands: Sequence[tuple[int, ...]]) -> None:
        """See `Troupe`."""
        for change, own in zip(changes, hands, strict=True):
            k = self._numbers[change.member]
            guide, X = self.guides[k], self.node_pose(self.guides[k].body)
            if change.taken:
                self._take(k, own)
                self._held_by_people.add(k)
            elif k in self._held_by_people:
                guide.release(own, X, self._nodes, falls=True)
                self._leave_people(k)
                if guide.state is GuideState.FREE:
                    self._set_free(k, change.velocity)

    def expect_kick(self, member: str) -> None:
        """Lets the next push by people set a guided body free."""
        if member in self._numbers:
            self._kicked.add(self._numbers[member])

    def pushed(self, impulses: Array, angular_impulses: Array) -> tuple[Array, Array]:
        """Returns the impulses (N, 3) that move bodies: nothing pushes guided ones.

        A kick sets free what it meets.
        """
        for k in sorted(self._kicked):
            if impulses[self.guides[k].body].any() and k not in self._held_by_people:
                self._kicked.remove(k)
                if self.guides[k].state is not GuideState.FREE:
                    self._set_free(k)
        free = self.free[:, None]
        return np.where(free, impulses, 0.0), np.where(free, angular_impulses, 0.0)

    def _change_as_written(self, k: int) -> None:
        """Changes what moves a body in this row by the scene: falls, releases, then grips."""
        guide, row = self.guides[k], self._row
        fall = guide.fall
        may_fall = guide.state in (GuideState.ON_PATH, GuideState.PUT_DOWN)
        if fall is not None and row == fall.row and may_fall:
            self._set_free(k)
        X = self.node_pose(guide.body)
        for grip in guide.grips:
            if grip.rows[1] == row and (grip.node,) in guide.holds:
                has_to_fall = fall is not None and fall.row <= row
                guide.release((grip.node,), X, self._nodes, grip.falls or has_to_fall)
                if guide.state is GuideState.FREE:
                    self._set_free(k)
        for grip in guide.grips:
            if grip.rows[0] == row:
                self._take(k, (grip.node,))

    def _take(self, k: int, hands: tuple[int, ...]) -> None:
        """Lets a hand, or both of a person, hold a body from this row on."""
        guide = self.guides[k]
        if guide.body in self._lost:
            return
        if guide.state is GuideState.FREE:
            state, which = self._solver.state, self._own[[k]]
            here = Poses(state.p[which], matrix(state.q[which]))
            self._solver.pushers.move(np.array([len(self._obstacles) + k]), here)
        guide.take(hands, self.node_pose(guide.body), self._nodes)
        self._show(k)

    def _set_free(self, k: int, velocity: Array | None = None) -> None:
        """Leaves a body to physics, with the velocity that it has or another (3,) [m/s]."""
        guide = self.guides[k]
        X = self.node_pose(guide.body)
        R, lever = X[:3, :3], -X[:3, :3] @ self._bodies[guide.body].origin
        motion = self._velocities[k]
        if guide.flight is not None:
            v, w = guide.flight.velocity[:3], guide.flight.velocity[3:]
            motion = np.concatenate([v + cross(w, lever), w])
        if velocity is not None:
            motion = np.concatenate([velocity, motion[3:]])
        p = X[:3, 3] + lever
        guide.set_free()
        self._put(np.array([k]), Poses(p[None], R[None]), motion[None])
        self._show(k)
        for group in self._groups.get(k, ()):
            depth = self._solver.masks.depth(guide.body, group)
            if depth > HOLDER_DEPTH * self._bodies[guide.body].size:
                self._solver.masks.set_meeting(guide.body, group, False)
                self._parting.append((guide.body, group))

    def _part(self) -> None:
        """Lets released bodies meet their holders again once they are apart."""
        masks = self._solver.masks
        apart = [pair for pair in self._parting if masks.depth(*pair) <= 0.0]
        for pair in apart:
            masks.set_meeting(*pair, meets=True)
            self._parting.remove(pair)

    def _leave_people(self, k: int) -> None:
        """Begins the time after which people meet a body again that none of them holds."""
        guide = self.guides[k]
        authored = {(grip.node,) for grip in guide.grips}
        if not set(guide.holds) - authored:
            self._held_by_people.discard(k)
            wait = math.ceil(RELEASE_TIME / self._row_time)
            self._apart_until[guide.body] = self._row + wait

    def _show(self, k: int) -> None:
        """Lets a body or its stand-in meet others."""
        guide = self.guides[k]
        is_free = guide.state is GuideState.FREE
        self._solver.set_present(guide.body, is_free)
        self._solver.masks.show_pusher(len(self._obstacles) + k, not is_free)
