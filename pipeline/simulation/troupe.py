"""Base class of troupes: all performers of one room, advanced together as arrays.

A troupe reads the world of the previous step, so the order of the cast has no effect. It
changes only its own state and its own slice of the take.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import ClassVar

from pipeline.simulation.attachment import Attachment
from pipeline.simulation.clock import Clock
from pipeline.simulation.figures.surroundings import MovingSolid
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.mechanism import Leg, Mechanism
from pipeline.simulation.members import MemberState
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.obstacles import Obstacle, SolidMotion
from pipeline.simulation.order_outcome import GripChange, Outcome
from pipeline.simulation.people.wardrobe import Clothes
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.script import Orders
from pipeline.simulation.signals import Signal
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, Mesh, Node, TakeNote
from pipeline.simulation.terrain import Ground
from pipeline.spec.mood import Mood
from pipeline.spec.relations import Attitudes
from pipeline.spec.script import Instruction
from pipeline.spec.sound_thresholds import Detect


@dataclass(frozen=True, slots=True)
class World:
    """The constants of a scene that every troupe reads.

    Attributes:
        ground: terrain.
        clock: grid of steps, rows and frames.
        seed: seed of the scene.
        script: all instructions of the scene's script.
        beat_orders: instructions of the beats of its story, with their paths.
        attitudes: what people feel towards others by the relations of the story.
        moods: moods by name.
        detect: thresholds of the sound detectors.
        directed: whether further instructions may arrive while the simulation runs.
        places: named places (3,) of the scene [m].
        solids: things whose motion is known before, that limbs keep clear of.
        clothes: what each person wears, by its name.
    """

    ground: Ground
    clock: Clock
    seed: int
    script: Sequence[Instruction] = ()
    moods: Mapping[str, Mood] = field(default_factory=dict)
    detect: Detect = field(default_factory=Detect)
    directed: bool = False
    places: Mapping[str, Array] = field(default_factory=dict)
    solids: Sequence[MovingSolid] = ()
    clothes: Mapping[str, Clothes] = field(default_factory=dict)
    beat_orders: Sequence[tuple[str, Instruction]] = ()
    attitudes: Attitudes = field(default_factory=dict)

    @property
    def instructions(self) -> list[tuple[str, Instruction]]:
        """All instructions of the scene, with their paths in it."""
        script = [(f"script[{i}]", instruction) for i, instruction in enumerate(self.script)]
        return [*script, *self.beat_orders]


@dataclass(frozen=True, slots=True)
class Facts:
    """Contacts and signals of one step.

    Attributes:
        contacts: contacts that began in the step.
        notes: messages for the author.
        arrived: performers that reached the end of their routes.
        touched: pairs of performers that began to touch, by name.
        signals: further signals for the director and the voice detector.
        outcomes: orders that ended, other than by arriving.
        grips: hands that took hold of members of other troupes, or released them.
    """

    contacts: tuple[Contact, ...] = ()
    notes: tuple[TakeNote, ...] = ()
    arrived: tuple[str, ...] = ()
    touched: tuple[tuple[str, str], ...] = ()
    signals: tuple[Signal, ...] = ()
    outcomes: tuple[Outcome, ...] = ()
    grips: tuple[GripChange, ...] = ()

    @staticmethod
    def merged(facts: Sequence[Facts]) -> Facts:
        """Returns the facts of all troupes together, contacts in the order of time."""
        contacts = [contact for one in facts for contact in one.contacts]
        arrived = tuple(name for one in facts for name in one.arrived)
        touched = tuple(pair for one in facts for pair in one.touched)
        outcomes = tuple(outcome for one in facts for outcome in one.outcomes)
        return Facts(
            contacts=tuple(sorted(contacts, key=lambda c: (c.step, c.fraction, c.part))),
            notes=tuple(note for one in facts for note in one.notes),
            arrived=arrived,
            touched=touched,
            signals=(
                *(Signal("arrived", name) for name in arrived),
                *(Signal("touch", *pair) for pair in touched),
                *(signal for one in facts for signal in one.signals),
            ),
            outcomes=outcomes,
            grips=tuple(change for one in facts for change in one.grips),
        )


class WriteStage(Enum):
    """When the rows of a troupe are computed, relative to those of the other troupes."""

    INDEPENDENT = "from its own state alone"
    AFTER_PUSHERS = "row by row, after all nodes that push it are in the world frame"
    LAST = "after all other nodes are in the world frame"


class Troupe:
    """The passes of the step; each default does nothing.

    Attributes:
        inventory: nodes, channels, meshes and parts that the troupe adds to the take.
        write_stage: when its rows are computed. At most one troupe is `AFTER_PUSHERS`.
        hits_obstacles: whether it collides with the solids of other troupes, as they were one
            step ago. At most one troupe does.
    """

    inventory: Inventory
    write_stage: ClassVar[WriteStage] = WriteStage.INDEPENDENT
    hits_obstacles: ClassVar[bool] = False

    # --- before the first step --------------------------------------------------------

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Prepares for an instruction that arrives while the simulation runs.

        Args:
            instruction: to any performer.
            path: its path in error messages.

        Raises:
            SceneError: if the performer cannot carry it out; the state is unchanged.
        """

    def bind(self, nodes: Sequence[Node], meshes: Sequence[Mesh], names: NodeNames) -> None:
        """Resolves references to the nodes and meshes of all performers.

        Raises:
            SceneError: if a reference names no part.
        """

    def see_attachments(self, attachments: Sequence[Attachment], nodes: Sequence[Node]) -> None:
        """Takes note of what goes with its nodes, among which are things that hands hold."""

    def foreseen_notes(self) -> list[TakeNote]:
        """Returns notes of rows to come that are known without taking steps."""
        return []

    # --- every step -------------------------------------------------------------------

    def members_needed(self, orders: Orders) -> Collection[str]:
        """Returns the members of other troupes whose states it needs to read `orders`."""
        return ()

    def see_members(self, members: Mapping[str, MemberState]) -> None:
        """Receives the states of these members in the row before."""

    def read(self, orders: Orders) -> None:
        """Applies the orders of the script to its members."""

    def advance(self, step: int) -> None:
        """Advances its state from `step` to `step + 1`; may take sub-steps."""

    def buffer_row(self) -> None:
        """Stores the present state as the next row, to be written with others by `write`."""

    def write(self, rows: Rows) -> None:
        """Writes all rows buffered since the last call into the take."""

    def facts(self) -> Facts:
        """Returns the contacts, notes and signals of the last step."""
        return Facts()

    def feelings(self) -> Mapping[str, Mapping[str, float]]:
        """Returns what its members with minds feel now, by name and feeling, from 0 to 1."""
        return {}

    # --- after the last step ----------------------------------------------------------

    def mechanisms(self) -> list[Mechanism]:
        """Returns the joints and masses of its members on legs."""
        return []

    def legs(self) -> list[Leg]:
        """Returns the legs of its members, with the stances planned so far."""
        return []

    # --- troupes that are pushed (WriteStage.AFTER_PUSHERS) ---------------------------

    def advance_to_row(self, step: int, p: Array, R: Array) -> None:
        """Advances to the row at `step`; p (J, 3) and R (J, 3, 3) are all nodes at that row."""

    @property
    def goes_with_others(self) -> bool:
        """Whether `advance_to_row` needs the nodes of all troupes that come before it."""
        return False

    @property
    def carriers(self) -> Mapping[int, str]:
        """Nodes that its members go with by the scene, and the paths that name them."""
        return {}

    def movable_solids(self) -> list[Obstacle]:
        """Returns its solids; node numbers start at its own first node."""
        return []

    def solid_motion(self) -> SolidMotion:
        """Returns pose and velocity of its solids in the last row."""
        raise NotImplementedError

    def change_grips(self, changes: Sequence[GripChange], hands: Sequence[tuple[int, ...]]) -> None:
        """Lets hands hold its members, or release them, from the next row on.

        Args:
            changes: in the order of time.
            hands: numbers of the nodes of these hands in the take.
        """

    def push_solids(self, impulses: Array, angular_impulses: Array) -> None:
        """Applies (S, 3) impulses [N s] and [N m s] to its solids, spread until the next row."""

    # --- troupes that collide with others (hits_obstacles) ----------------------------

    def set_obstacles(self, obstacles: Sequence[Obstacle]) -> list[Obstacle]:
        """Receives all solids of other troupes; returns those whose motion it has to know."""
        return []

    def update_obstacles(self, motion: SolidMotion) -> None:
        """Receives present pose and velocity of the obstacles it asked for."""

    def obstacle_impulses(self) -> tuple[Array, Array]:
        """Returns impulses on the obstacles since the update, (S, 3) [N s] and (S, 3) [N m s]."""
        raise NotImplementedError

    # --- troupes that are written last (WriteStage.LAST) ------------------------------

    def write_last(self, R: Array, p: Array) -> list[Contact]:
        """Writes all rows buffered; returns the contacts that began in them.

        Args:
            R: (n, J, 3, 3) rotations of all nodes in these rows.
            p: (n, J, 3) their positions [m].
        """
        return []


def pushed_troupe(troupes: Sequence[Troupe]) -> Troupe | None:
    """Returns the troupe that is pushed by others, None without any."""
    return next((t for t in troupes if t.write_stage is WriteStage.AFTER_PUSHERS), None)


def node_range(troupes: Sequence[Troupe], troupe: Troupe) -> range:
    """Returns the numbers of a troupe's nodes in the take."""
    before = troupes[: troupes.index(troupe)]
    first = sum(len(other.inventory.nodes) for other in before)
    return range(first, first + len(troupe.inventory.nodes))
