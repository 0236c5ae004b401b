"""Simulate: Scene -> Take, step by step."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, cached_property
from importlib.metadata import version
from pathlib import Path

import numpy as np

import pipeline
from pipeline.errors import SceneError, SimulationError
from pipeline.processor import class_of
from pipeline.simulation.attaching import Bond, bonds_of, split
from pipeline.simulation.casting import figures_of, refuse_to_direct, troupes_of
from pipeline.simulation.clock import Clock
from pipeline.simulation.detect import OF_CONTACTS, OF_HAPPENINGS, OF_MOTIONS
from pipeline.simulation.detect.contacts import Contacts
from pipeline.simulation.detect.motions import Motions
from pipeline.simulation.detect.scenery import Scenery, solids_of
from pipeline.simulation.detect.voices import Voices
from pipeline.simulation.encounters import Encounters, encounters_of
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.happenings import Happening
from pipeline.simulation.mechanism import Leg, Legged
from pipeline.simulation.obstacles import obstacles_of
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.script import Script
from pipeline.simulation.solid import Obstacle
from pipeline.simulation.take import Contact, Header, Note, Take
from pipeline.simulation.terrain import build_ground
from pipeline.simulation.troupe import (
    Bumps,
    Follows,
    Meets,
    Prepares,
    Rows,
    Sees,
    Troupe,
    World,
    Yields,
)
from pipeline.spec.cast import Creature, Dancer, Group, Prop
from pipeline.spec.scene import VERSION, Scene
from pipeline.spec.script import Instruction

ROWS_AT_ONCE = 96
"""Rows are worked out and written together: as arrays they cost a tenth."""

ROWS_BEFORE_BODIES = 24
"""Likewise where bodies follow, which go from row to row."""

POSES_AT_ONCE = 65_536
"""Nodes times rows that are, about: so many stay in memory that is at hand."""


COMMAND = "command"
"""What an instruction from outside is called in messages."""


class Simulation:
    """The world of one scene, one step at a time.

    Args:
        scene: what the author asked for.
        key: of the take.
        directed: whether instructions may come from outside, by `tell`.

    Attributes:
        happened: in the last step, for those who direct it.

    Raises:
        SceneError: if a figure is none, or cannot do what it is asked to.
        SimulationError: if the scene cannot begin, or diverges.
    """

    def __init__(self, scene: Scene, key: str = "", directed: bool = False) -> None:
        clock = Clock(scene.rate, scene.n_frames, scene.steps, scene.samples)
        try:
            ground = build_ground(scene.terrain, scene.seed)
            detect = scene.sound.detect
            script = scene.script
            self.world = World(ground, clock, scene.seed, script, scene.all_moods, detect, directed)
            figures = figures_of(scene)
            self.troupes: list[Troupe] = troupes_of(scene, figures, self.world)
            self._lookers = [troupe for troupe in self.troupes if isinstance(troupe, Sees)]
            self._groups = [troupe for troupe in self.troupes if isinstance(troupe, Follows)]
            self.recorder = Recorder(
                _header(scene, key), clock, self.world.ground, [t.inventory for t in self.troupes]
            )
            self.bonds = bonds_of(scene.cast, figures, self.recorder.nodes, clock)
            for groups in self._groups:
                groups.look_around(self.recorder.nodes, self.recorder.meshes, figures)
        except SceneError as error:
            raise scene.places.located(error) from None
        self.recorder.hang(self.bonds)
        self._contacts = Contacts(OF_CONTACTS, detect, clock)
        self._voices = Voices(OF_HAPPENINGS, detect, clock)
        self._motions = Motions(OF_MOTIONS, detect, self._scenery(scene, figures))
        self.script = Script(scene.script, clock)
        refuse_to_direct(scene, self.troupes)
        self._arrived: tuple[str, ...] = ()
        self._touched: tuple[tuple[str, str], ...] = ()
        self.happened: tuple[Happening, ...] = ()
        self.step_number = 0
        self._kept = self._written = 0
        room = POSES_AT_ONCE // max(len(self.recorder.nodes), 1)
        self._at_once = min(max(room, ROWS_AT_ONCE // 6), ROWS_AT_ONCE)
        self.colliders = next((t for t in self.troupes if isinstance(t, Meets)), None)
        self._early: list[Bond] = []
        self._late = self.bonds
        if self.colliders is not None:
            # What they meet should not be told much later.
            self._at_once = min(self._at_once, ROWS_BEFORE_BODIES)
            self._early, self._late = split(self.bonds, self._nodes_of(self.colliders))
        self._encounters = self._who_bumps(scene)
        self._behind: list[Troupe] = []
        if self._encounters is not None and not self._encounters.still:
            # They are felt where they were one step ago.
            self._behind = self._who_is_not_felt(self._encounters)
            self._at_once = self._at_once if self._behind else 1
        try:
            self._keep()
        except SceneError as error:
            raise scene.places.located(error) from None
        contacts, notes = self._facts()
        self.recorder.happened(contacts, [], notes)

    def _scenery(self, scene: Scene, figures: Mapping[str, Figure]) -> Scenery:
        recorder = self.recorder
        return Scenery(
            clock=self.world.clock,
            nodes=recorder.nodes,
            solids=solids_of(recorder.parts, recorder.meshes),
            channels=recorder.channels,
            figures=figures,
            groups=frozenset(m.name for m in scene.cast if isinstance(m, Group)),
        )

    def _who_bumps(self, scene: Scene) -> Encounters | None:
        """Return who runs into the solids of others, None if nobody can."""
        one = next((t for t in self.troupes if isinstance(t, Bumps)), None)
        if one is None:
            return None
        hard = {m.name for m in scene.cast if isinstance(m, Creature | Dancer | Prop)}
        # What they carry goes where they go.
        _, carried = split(self.bonds, self._nodes_of(one))
        borne = {int(node) for bond in carried for node in bond.nodes}
        fixed = [o for o in self._obstacles if o.performer in hard and o.node not in borne]
        yields = self.colliders if isinstance(self.colliders, Yields) else None
        first = self._nodes_of(yields).start if yields is not None else 0
        moving = {m.name for m in scene.cast if not (isinstance(m, Prop) and _stands(m))}
        still = yields is None and moving.isdisjoint(o.performer for o in fixed)
        return encounters_of(one, self.recorder, fixed, yields, first, still)

    def _who_is_not_felt(self, encounters: Encounters) -> list[Troupe]:
        """Return those whose rows may be written by the dozen while others are felt in each.

        They are none if somebody hangs on them.
        """
        bumps = encounters.troupe
        if split(self.bonds, self._nodes_of(bumps))[1]:
            return []
        return [bumps, *self._groups]

    def _nodes_of(self, troupe: Troupe) -> range:
        before = self.troupes[: self.troupes.index(troupe)]
        first = sum(len(one.inventory.nodes) for one in before)
        return range(first, first + len(troupe.inventory.nodes))

    @cached_property
    def _obstacles(self) -> list[Obstacle]:
        return obstacles_of([troupe.inventory for troupe in self.troupes])

    @property
    def finished(self) -> bool:
        """Whether the last row is written."""
        return self.step_number >= self.world.clock.last_step

    def step(self) -> None:
        """Advance the world by one step."""
        self._read()
        self._advance()
        self.step_number += 1
        self._keep()
        contacts, notes = self._facts()
        events = self._contacts.hear(contacts)
        voices = self._voices.hear(self.happened, self.step_number)
        self._motions.met(contacts)
        self.recorder.happened(contacts, [*events, *voices], notes)

    def tell(self, instruction: Instruction) -> None:
        """Take in an instruction from outside; one without delay is given in the next step.

        Raises:
            SceneError: its performer cannot do so; nothing has changed.
        """
        for troupe in self.troupes:
            if isinstance(troupe, Prepares):
                troupe.prepare(instruction, COMMAND)
        self.script.tell(instruction, self.step_number)

    def last_row(self) -> int:
        """Return the last row there is, after all up to it are written."""
        self._write_kept()
        return self._kept - 1

    def take(self) -> Take:
        """Return what has happened, once finished."""
        legged = [troupe for troupe in self.troupes if isinstance(troupe, Legged)]
        mechanisms = tuple(one for troupe in legged for one in troupe.mechanisms())
        return replace(self.recorder.take(), mechanisms=mechanisms, legs=tuple(self.legs()))

    def legs(self) -> list[Leg]:
        """Return the legs of all creatures on legs, with the stances planned so far."""
        return [leg for t in self.troupes if isinstance(t, Legged) for leg in t.legs()]

    def _read(self) -> None:
        """Show everybody what the script asks of them, and let them see the step before."""
        hugged = [(one.who, one.other) for one in self.happened if one.kind == "hug"]
        orders = self.script.orders(self.step_number, self._arrived, self._touched, hugged)
        for looker in self._lookers:
            if sought := looker.sought(orders):
                self._write_kept()
                looker.see(self.recorder.solids(self._obstacles, sought, self._kept - 1))
        if self._encounters is not None:
            self._encounters.feel(self._kept - 1)
        self.recorder.told(self.step_number, orders)
        for troupe in self.troupes:
            troupe.read(orders)

    def _advance(self) -> None:
        for troupe in self.troupes:
            troupe.advance(self.step_number)

    def _keep(self) -> None:
        """Let the troupes keep this step if a row stands on it, and write rows by the dozen."""
        if self.world.clock.row_of_step(self.step_number) is None:
            return
        for troupe in self.troupes:
            troupe.keep()
        self._kept += 1
        if self._behind:
            self._write_felt(slice(self._kept - 1, self._kept))
        begins = self._kept == 1 and (self.colliders or self._encounters) is not None
        if begins or self._kept - self._written == self._at_once or self.finished:
            self._write_kept()

    def _write_kept(self) -> None:
        """Write the rows that are kept and not written yet."""
        if self._kept > self._written:
            self._write(slice(self._written, self._kept))
            self._written = self._kept

    def _write_felt(self, which: slice) -> None:
        """Write a row of those who are felt in it; that of the others is kept."""
        rows = self.recorder.rows(which, self._written)
        for troupe, own in zip(self.troupes, rows, strict=True):
            if troupe not in self._behind:
                self._write_own(troupe, own, which)
        self.recorder.attached(which, self._late)
        if self._encounters is not None and len(self._encounters.nodes):
            self.recorder.show(which, self._encounters.nodes)

    def _write_own(self, troupe: Troupe, rows: Rows, which: slice) -> None:
        """Write the rows of one troupe, those before it having written theirs."""
        if troupe is self.colliders:
            R, p = self.recorder.attached(which, self._early)
            if self._encounters is not None:
                self._encounters.push()
            for k, row in enumerate(range(which.start, which.stop)):
                step = row * self.world.clock.steps // self.world.clock.samples
                self.colliders.meet(step, p[k], R[k])
        troupe.write(rows)

    def _write(self, which: slice) -> None:
        first = self._written if self._behind else -1
        for troupe, rows in zip(self.troupes, self.recorder.rows(which, first), strict=True):
            if troupe in self._behind or not self._behind:
                self._write_own(troupe, rows, which)
        R, p = self.recorder.attached(which, () if self._behind else self._late)
        for groups in self._groups:
            # Nobody depends on them, so they see everybody in place.
            contacts = groups.follow(R, p)
            self.recorder.happened(contacts, self._contacts.hear(contacts), ())
        wrong = self.recorder.keep(which)
        if wrong is not None:
            row, node = wrong
            step = row * self.world.clock.steps // self.world.clock.samples
            raise SimulationError(
                f"the simulation diverged at step {step} "
                f"({float(self.world.clock.time_of(step)):.3f} s): "
                f"the pose of {node} is no longer finite"
            )
        alive, values = self.recorder.alive[which], self.recorder.values[which]
        self.recorder.happened((), self._motions.look(which, p, R, alive, values), ())

    def _facts(self) -> tuple[list[Contact], list[Note]]:
        facts = [troupe.facts() for troupe in self.troupes]
        contacts = [contact for fact in facts for contact in fact.contacts]
        notes = [note for fact in facts for note in fact.notes]
        self._arrived = tuple(name for fact in facts for name in fact.arrived)
        self._touched = tuple(pair for fact in facts for pair in fact.touched)
        self.happened = (
            *(Happening("arrived", name) for name in self._arrived),
            *(Happening("touch", *pair) for pair in self._touched),
            *(one for fact in facts for one in fact.happened),
        )
        return sorted(contacts, key=lambda c: (c.step, c.fraction, c.part)), notes


def _stands(prop: Prop) -> bool:
    """Tell whether a prop stays where it begins."""
    moved = prop.keyframes, prop.velocity, prop.spin_deg, prop.force, prop.held, prop.parent
    return not any(moved)


def simulate(
    scene: Scene, key: str = "", progress: Callable[[int, int], None] | None = None
) -> Take:
    """Simulate the whole of `scene`.

    Args:
        scene: what the author asked for.
        key: digest of what the simulation reads, kept in the take.
        progress: called now and then with (frames done, frames in all).
    """
    simulation = Simulation(scene, key)
    clock = simulation.world.clock
    while not simulation.finished:
        simulation.step()
        if progress and simulation.step_number % (8 * clock.steps) == 0:
            progress(simulation.step_number // clock.steps, clock.frames)
    return simulation.take()


def versions() -> dict[str, str]:
    """Return the versions of all that decides a take's last bit."""
    return {
        "pronk": pipeline.__version__,
        "simulation": code_digest(),
        "language": str(VERSION),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "machine": processor_class(),
    }


@cache
def code_digest() -> str:
    """Return a digest of the simulation's own code: what it computes depends on it."""
    here = Path(__file__).parent
    sources = [path.read_bytes() for path in sorted(here.rglob("*.py"))]
    return hashlib.blake2b(b"".join(sources), digest_size=6).hexdigest()


def processor_class() -> str:
    """Return the class of processor: within it, equal scenes give equal bytes."""
    simd = np.show_config(mode="dicts")["SIMD Extensions"]
    return class_of(simd.get("found", []), pipeline.HELD)


def _header(scene: Scene, key: str) -> Header:
    return Header(
        key=key,
        title=scene.title,
        rate=scene.rate,
        frames=scene.n_frames,
        samples=scene.samples,
        steps=scene.steps,
        seed=scene.seed,
        versions=versions(),
    )
