"""Attachment: performers that move with others, and props that are taken and put down for good.

It follows all motion of a step, parents first, so that nothing lags behind.

Source: Sims 1987, 3.2.1 (parents and children).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.clock import Clock
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.take import Node
from pipeline.spec.cast import Member
from pipeline.spec.group import Group
from pipeline.spec.hold import TAKEN_GRIP
from pipeline.spec.prop import Prop


@dataclass(frozen=True, slots=True)
class Grip:
    """An interval during which a prop is held.

    Attributes:
        node: number of the holding node.
        rows: first row, and first row after it.
        closure: how far the fingers close, 0 to 1.
    """

    node: int
    rows: tuple[int, int]
    closure: float = TAKEN_GRIP


@dataclass(eq=False)
class Attachment:
    """Parent and grips of one performer.

    Attributes:
        name: of the performer.
        nodes: numbers of its nodes.
        parent: number of the parent node, -1 for the world.
        grips: in the order of time.
        X_PB: (4, 4) pose where it was put down, relative to its parent; None before.
        X_HB: (4, 4) pose in the hand that holds it.
    """

    name: str
    nodes: NDArray[np.int64]
    parent: int
    grips: tuple[Grip, ...]
    X_PB: Array | None = None
    X_HB: Array | None = None

    def apply(self, R: Array, p: Array, first: int) -> None:
        """Transforms its nodes to the world in n rows, after all that it is attached to.

        Args:
            R: (n, J, 3, 3) rotations of all nodes; changed.
            p: (n, J, 3) their positions [m]; changed.
            first: number of the first row; rows follow those of the last call.
        """
        if self.parent >= 0:
            R_WP, p_WP = R[:, self.parent, None], p[:, self.parent, None]
            p[:, self.nodes] = p_WP + turn(R_WP, p[:, self.nodes])
            R[:, self.nodes] = R_WP @ R[:, self.nodes]
        if self.grips:
            for i in range(len(p)):
                self._hold(R[i], p[i], first + i, int(self.nodes[0]))

    def _hold(self, R: Array, p: Array, row: int, own: int) -> None:
        """Places a held prop in one row; R (J, 3, 3) and p (J, 3) are those of the row."""
        X_WP = np.eye(4) if self.parent < 0 else _pose(R, p, self.parent)
        X_WB = _pose(R, p, own) if self.X_PB is None else X_WP @ self.X_PB
        for grip in self.grips:
            # The pose in this hand is where the prop is released, or passed to another hand.
            if grip.rows[0] <= row <= grip.rows[1]:
                X_WH = _pose(R, p, grip.node)
                if row == grip.rows[0] or self.X_HB is None:
                    self.X_HB = np.linalg.inv(X_WH) @ X_WB
                X_WB = X_WH @ self.X_HB
                self.X_PB = np.linalg.inv(X_WP) @ X_WB
        R[own], p[own] = X_WB[:3, :3], X_WB[:3, 3]


def split_attachments(
    attachments: Sequence[Attachment], late: Sequence[int]
) -> tuple[list[Attachment], list[Attachment]]:
    """Returns the attachments that do not depend on some nodes, and the rest, parents first.

    Args:
        attachments: parents first.
        late: nodes whose poses are known later than others'.
    """
    waiting = set(late)
    early, rest = list[Attachment](), list[Attachment]()
    for attachment in attachments:
        if waiting.isdisjoint([attachment.parent, *(grip.node for grip in attachment.grips)]):
            early.append(attachment)
        else:
            waiting.update(attachment.nodes.tolist())
            rest.append(attachment)
    return early, rest


def _pose(R: Array, p: Array, node: int) -> Array:
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R[node], p[node]
    return X


def attachments_of(
    cast: Sequence[Member],
    names: NodeNames,
    nodes: Sequence[Node],
    clock: Clock,
    falling: Collection[str] = (),
) -> list[Attachment]:
    """Returns all attachments of a scene, parents first.

    What may fall goes with others as its troupe says (see `bodies.guided_bodies`).

    Args:
        cast: of the scene.
        names: of all nodes and parts.
        nodes: of all performers.
        clock: of the scene.
        falling: names of performers that may fall.

    Raises:
        SceneError: if a part does not exist, or attachments form a ring.
    """
    problems = list[Problem]()

    def node_of(part_name: str, path: str) -> int:
        found = names.find(part_name)
        if isinstance(found, str):
            problems.append(Problem(path, found))
            return -1
        return found

    attachments = {}
    for i, member in enumerate(cast):
        holds = member.held if isinstance(member, Prop) else ()
        # Groups follow their parents themselves: flames leave a moving source.
        is_attached = member.parent is not None or holds
        if isinstance(member, Group) or member.name in falling or not is_attached:
            continue
        own = [k for k, node in enumerate(nodes) if node.performer == member.name]
        parent = -1 if member.parent is None else node_of(member.parent, f"cast[{i}].parent")
        grips = tuple(
            Grip(
                node_of(hold.by, f"cast[{i}].held[{k}].by"),
                (_row_at(hold.at, clock), _row_at(hold.until, clock)),
                hold.grip,
            )
            for k, hold in enumerate(holds)
        )
        attachments[member.name] = Attachment(member.name, np.array(own), parent, grips)
    if problems:
        raise SceneError(problems)
    return _parents_first(attachments, nodes, [member.name for member in cast])


def _row_at(time: float | None, clock: Clock) -> int:
    """Returns the first row at or after a time; one beyond the take for None."""
    if time is None:
        return clock.rows + 1
    per_row = clock.dt * clock.steps / clock.samples
    return math.ceil(time / per_row - 1e-6)


def _parents_first(
    attachments: Mapping[str, Attachment], nodes: Sequence[Node], names: Sequence[str]
) -> list[Attachment]:
    """Returns the attachments in an order in which each follows all that it depends on.

    Raises:
        SceneError: if there is none.
    """
    needs = {
        name: {
            nodes[n].performer
            for n in (attachment.parent, *(g.node for g in attachment.grips))
            if n >= 0
        }
        for name, attachment in attachments.items()
    }
    try:
        order = list(TopologicalSorter(needs).static_order())
    except CycleError as error:
        ring = error.args[1]
        message = f"attachments form a ring: {' to '.join(ring)}; detach one of them"
        raise SceneError([Problem(f"cast[{names.index(ring[0])}].parent", message)]) from None
    return [attachments[name] for name in order if name in attachments]
