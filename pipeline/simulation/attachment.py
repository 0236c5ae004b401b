"""Attaching: performers that go along with others, and props that are taken and put down.

Done after everybody has moved, parents first, so that nothing lags behind.

Source: Sims 1987, 3.2.1 (parents and children).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.clock import Clock
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.pose_plan import PartNames
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.take import Node
from pipeline.spec.cast import Member
from pipeline.spec.group import Group
from pipeline.spec.prop import Prop
from pipeline.spec.suggestions import hint


@dataclass(frozen=True, slots=True)
class Grip:
    """A time during which a prop is held.

    Attributes:
        node: that holds it.
        rows: the first, and the first after it.
    """

    node: int
    rows: tuple[int, int]


@dataclass(eq=False)
class Attachment:
    """What one performer goes along with.

    Attributes:
        name: of the performer.
        nodes: its own.
        parent: node that it goes along with, -1 for the world.
        grips: in the order of time.
        X_PB: (4, 4) where it was put down, relative to its parent; None before.
        X_HB: (4, 4) where it is in the hand that holds it.
    """

    name: str
    nodes: NDArray[np.int64]
    parent: int
    grips: tuple[Grip, ...]
    X_PB: Array | None = None
    X_HB: Array | None = None

    def apply(self, R: Array, p: Array, first: int) -> None:
        """Bring its nodes into the world in n rows, after all that it goes along with.

        Args:
            R: (n, J, 3, 3) rotations of all nodes; changed.
            p: (n, J, 3) their positions [m]; changed.
            first: number of the first of the rows; they follow those of the last call.
        """
        if self.parent >= 0:
            R_WP, p_WP = R[:, self.parent, None], p[:, self.parent, None]
            p[:, self.nodes] = p_WP + turn(R_WP, p[:, self.nodes])
            R[:, self.nodes] = R_WP @ R[:, self.nodes]
        if self.grips:
            for i in range(len(p)):
                self._hold(R[i], p[i], first + i, int(self.nodes[0]))

    def _hold(self, R: Array, p: Array, row: int, own: int) -> None:
        """Put a prop where it is in one row; R (J, 3, 3) and p (J, 3) are those of the row."""
        X_WP = np.eye(4) if self.parent < 0 else _pose(R, p, self.parent)
        X_WB = _pose(R, p, own) if self.X_PB is None else X_WP @ self.X_PB
        for grip in self.grips:
            # Let go where the hand has it now; then another may take it.
            if grip.rows[0] <= row <= grip.rows[1]:
                X_WH = _pose(R, p, grip.node)
                if row == grip.rows[0] or self.X_HB is None:
                    self.X_HB = np.linalg.inv(X_WH) @ X_WB
                X_WB = X_WH @ self.X_HB
                self.X_PB = np.linalg.inv(X_WP) @ X_WB
        R[own], p[own] = X_WB[:3, :3], X_WB[:3, 3]


def split(
    bonds: Sequence[Attachment], late: Sequence[int]
) -> tuple[list[Attachment], list[Attachment]]:
    """Return the bonds, parents first, that have nothing to do with some nodes, and the rest.

    Args:
        bonds: parents first.
        late: nodes whose poses are known later than others'.
    """
    waiting = set(late)
    early, rest = list[Attachment](), list[Attachment]()
    for bond in bonds:
        if waiting.isdisjoint([bond.parent, *(grip.node for grip in bond.grips)]):
            early.append(bond)
        else:
            waiting.update(bond.nodes.tolist())
            rest.append(bond)
    return early, rest


def _pose(R: Array, p: Array, node: int) -> Array:
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R[node], p[node]
    return X


def attachments_of(
    cast: Sequence[Member],
    figures: Mapping[str, Figure],
    nodes: Sequence[Node],
    clock: Clock,
) -> list[Attachment]:
    """Return what goes along with what, parents first.

    Args:
        cast: of the scene.
        figures: of the creatures, by name.
        nodes: of all performers.
        clock: of the scene.

    Raises:
        SceneError: if somebody has no such part, or two go along with one another.
    """
    numbers = {node.name: i for i, node in enumerate(nodes)}
    problems = list[Problem]()

    def node_of(whom: str, path: str) -> int:
        found = node_number(whom, figures, numbers)
        if isinstance(found, str):
            problems.append(Problem(path, found))
            return -1
        return found

    bonds = {}
    for i, member in enumerate(cast):
        holds = member.held if isinstance(member, Prop) else ()
        # A fire's flames leave their source; where that is, the group asks itself.
        if isinstance(member, Group) or (member.parent is None and not holds):
            continue
        own = [k for k, node in enumerate(nodes) if node.performer == member.name]
        parent = -1 if member.parent is None else node_of(member.parent, f"cast[{i}].parent")
        grips = tuple(
            Grip(
                node_of(hold.by, f"cast[{i}].held[{k}].by"),
                (_row(hold.at, clock), _row(hold.until, clock)),
            )
            for k, hold in enumerate(holds)
        )
        bonds[member.name] = Attachment(member.name, np.array(own), parent, grips)
    if problems:
        raise SceneError(problems)
    return _parents_first(bonds, nodes, [member.name for member in cast])


def node_number(whom: str, figures: Mapping[str, Figure], numbers: Mapping[str, int]) -> int | str:
    """Return the number of the node that a performer or a part of one is called by.

    Args:
        whom: such as bug, or bug.head.
        figures: of the creatures, by name.
        numbers: of all nodes, by name.

    Returns:
        The number, or what is wrong with the name.
    """
    name, _, part = whom.partition(".")
    figure = figures.get(name)
    found = _node(name, part, figure, numbers)
    if found is not None:
        return found
    if not part:
        return f"'{name}' is a group; say which of them, as {name}.0"
    known = [n.partition(".")[2] for n in numbers if n.startswith(f"{name}.")]
    known += list(PartNames(figure).nodes) if figure is not None else []
    return f"'{name}' has no part '{part}', {hint(part, known)}"


def _node(name: str, part: str, figure: Figure | None, numbers: Mapping[str, int]) -> int | None:
    """Return the number of a link, or of the link that ends at a node of the drawing."""
    if not part:
        whole = (name, f"{name}.body", f"{name}.pelvis")
        return next((numbers[one] for one in whole if one in numbers), None)
    if figure is not None:
        names = PartNames(figure)
        if part in names.nodes:
            limb, link = names.nodes[part]
            number = figure.skeleton.limbs[limb].links[link]
            part = figure.skeleton.links[number].name
        elif part in names.body:
            part = "body"
    return numbers.get(f"{name}.{part}")


def _row(time: float | None, clock: Clock) -> int:
    """Return the first row at or after a time; one that never comes for None."""
    if time is None:
        return clock.rows + 1
    per_row = clock.dt * clock.steps / clock.samples
    return math.ceil(time / per_row - 1e-6)


def _parents_first(
    bonds: Mapping[str, Attachment], nodes: Sequence[Node], names: Sequence[str]
) -> list[Attachment]:
    """Return the bonds in an order in which each comes after all that it depends on.

    Raises:
        SceneError: if there is none.
    """
    needs = {
        name: {nodes[n].performer for n in (bond.parent, *(g.node for g in bond.grips)) if n >= 0}
        for name, bond in bonds.items()
    }
    try:
        order = list(TopologicalSorter(needs).static_order())
    except CycleError as error:
        ring = error.args[1]
        message = f"go along with one another in a ring: {' with '.join(ring)}"
        raise SceneError([Problem(f"cast[{names.index(ring[0])}].parent", message)]) from None
    return [bonds[name] for name in order if name in bonds]
