"""Troupe: all performers of one room, advanced together as arrays.

A troupe reads what the world was one step ago, so that the order of the cast cannot
matter, and writes nothing but its own state and its own slice of the take.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.clock import Clock
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.happenings import Happening
from pipeline.simulation.script import Orders
from pipeline.simulation.solid import Motion, Obstacle
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel, Contact, Mesh, Node, Note, Part
from pipeline.simulation.terrain import Ground
from pipeline.spec.mood import Mood
from pipeline.spec.script import Instruction
from pipeline.spec.sound_thresholds import Detect


@dataclass(frozen=True, slots=True)
class World:
    """What every troupe is shown.

    Attributes:
        ground: the terrain.
        clock: the grid of steps, rows and frames.
        seed: of the scene.
        script: what the scene asks of anybody.
        directed: whether more may be asked, from outside, as time goes by.
        moods: that performers may be in, by name.
        detect: what is heard, and from when on.
    """

    ground: Ground
    clock: Clock
    seed: int
    script: Sequence[Instruction] = ()
    moods: Mapping[str, Mood] = field(default_factory=dict)
    detect: Detect = field(default_factory=Detect)
    directed: bool = False


@dataclass(frozen=True, slots=True)
class Inventory:
    """What a troupe adds to the take; node numbers count from its own first node.

    Attributes:
        nodes: that move.
        channels: numbers that change.
        meshes: that follow its nodes.
        parts: what is seen.
        scaled: its nodes that have a scale.
        looks: meshes that are seen in place of others; the looks of parts are their numbers.
        solids: that others run into in place of what is seen of the same nodes.
    """

    nodes: tuple[Node, ...]
    channels: tuple[Channel, ...]
    meshes: tuple[Mesh, ...]
    parts: tuple[Part, ...]
    scaled: tuple[int, ...] = ()
    looks: tuple[Mesh, ...] = ()
    solids: tuple[Obstacle, ...] = ()


@dataclass(frozen=True, eq=False)
class Rows:
    """A troupe's slice of n rows of the take, to be written into.

    Attributes:
        positions: (n, J, 3) [m].
        rotations: (n, J, 3, 3) matrices; the take holds them as quaternions.
        alive: (n, J).
        values: (n, C) of its channels.
        scales: (n, N, 3) of its nodes that have one.
    """

    positions: Array
    rotations: Array
    alive: NDArray[np.bool_]
    values: Array
    scales: Array


@dataclass(frozen=True, slots=True)
class Facts:
    """What happened in one step.

    Attributes:
        contacts: that began in it.
        notes: that the author should have.
        arrived: who has come to the end of its way in it.
        touched: pairs who have begun to touch one another in it, by name.
        happened: what else those who direct the scene hear of.
    """

    contacts: tuple[Contact, ...] = ()
    notes: tuple[Note, ...] = ()
    arrived: tuple[str, ...] = ()
    touched: tuple[tuple[str, str], ...] = ()
    happened: tuple[Happening, ...] = ()


class Troupe(Protocol):
    """The passes of the step that a troupe takes part in."""

    inventory: Inventory

    def read(self, orders: Orders) -> None:
        """Take in what the script asks of its members from this step on."""

    def advance(self, step: int) -> None:
        """Go from `step` to `step + 1`; may take sub-steps."""

    def keep(self) -> None:
        """Keep the present state as the next row, to be written with others."""

    def write(self, rows: Rows) -> None:
        """Write all rows kept since the last call into the take."""

    def facts(self) -> Facts:
        """Return what happened in the last step."""


@runtime_checkable
class Meets(Troupe, Protocol):
    """A troupe that is pushed by others: it goes on from row to row, once these stand."""

    def meet(self, step: int, p: Array, R: Array) -> None:
        """Go on to the row at `step`, all nodes (J, 3), (J, 3, 3) that push standing there."""


@runtime_checkable
class Yields(Meets, Protocol):
    """A troupe that is pushed, and whose solids others feel as heavy as they are."""

    def solids(self) -> list[Obstacle]:
        """Return its solids; their nodes count from its own first."""

    def motion(self) -> Motion:
        """Return where they are in the last row, and how fast."""

    def push(self, impulses: Array, twists: Array) -> None:
        """Let them be pushed until the next row: (S, 3) [N s], about their nodes [N m s]."""


@runtime_checkable
class Bumps(Troupe, Protocol):
    """A troupe that runs into the solids of others, where they were one step ago, and as fast."""

    def surround(self, obstacles: Sequence[Obstacle]) -> list[Obstacle]:
        """Take in what there is to run into; return that of it which is told of from then on."""

    def feel(self, motion: Motion) -> None:
        """Take in where the solids are now, and how fast."""

    def pushed(self) -> tuple[Array, Array]:
        """Return what solids were pushed by since they were felt: (S, 3) [N s], (S, 3) [N m s]."""


@runtime_checkable
class Sees(Troupe, Protocol):
    """A troupe that looks at the solids of others before it does what it is told."""

    def sought(self, orders: Orders) -> Collection[str]:
        """Return whose solids somebody has to see now."""

    def see(self, solids: Mapping[str, Sequence[Array]]) -> None:
        """Take in the corners (n, 3) of the solids of each that was sought, as they are now [m]."""


@runtime_checkable
class Prepares(Troupe, Protocol):
    """A troupe that prepares for what its members will be asked, and refuses what they cannot."""

    def prepare(self, instruction: Instruction, where: str) -> None:
        """Be ready for an instruction of which nobody knew at the begin.

        Args:
            instruction: to anybody.
            where: its path in the scene.

        Raises:
            SceneError: its performer cannot do so.
        """


@runtime_checkable
class Follows(Troupe, Protocol):
    """A troupe that follows others and is followed by nobody: it goes last."""

    def look_around(
        self, nodes: Sequence[Node], meshes: Sequence[Mesh], figures: Mapping[str, Figure]
    ) -> None:
        """Find among the nodes and meshes of all performers those who are followed."""

    def follow(self, R: Array, p: Array) -> list[Contact]:
        """Write all rows kept, all nodes (n, J, 3, 3), (n, J, 3) standing there."""
