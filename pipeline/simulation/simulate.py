"""Simulate: Scene -> Take, step by step."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

import pipeline
from pipeline.errors import Problem, SceneError, SimulationError
from pipeline.simulation.attaching import Bond, bonds_of, split
from pipeline.simulation.bodies.colliders import Colliders
from pipeline.simulation.bodies.groups.groups import Groups
from pipeline.simulation.bodies.props import Props
from pipeline.simulation.clock import Clock
from pipeline.simulation.detect import DETECTORS
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.locomotion.inching.chain import is_chain
from pipeline.simulation.locomotion.inching.worms import Inchworms
from pipeline.simulation.locomotion.walking import Walkers
from pipeline.simulation.obstacles import obstacles_of
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.script import Script
from pipeline.simulation.take import Contact, Header, Note, SoundEvent, Take
from pipeline.simulation.terrain import build_ground, level_ground
from pipeline.simulation.troupe import Troupe, World
from pipeline.spec.cast import Body, Creature, Group, Many, Prop
from pipeline.spec.scene import VERSION, Scene

Performer = tuple[int, Creature, Figure]
"""Place in the cast, words and figure."""

SKIN, THING = "brown chitin", "wood"
"""Materials of creatures and of props that name none, neither themselves nor in their figures."""

ROWS_AT_ONCE = 96
"""Rows are worked out and written together: as arrays they cost a tenth."""

ROWS_BEFORE_BODIES = 24
"""Likewise where bodies follow, which go from row to row."""

POSES_AT_ONCE = 65_536
"""Nodes times rows that are, about: so many stay in memory that is at hand."""


class Simulation:
    """The world of one scene, one step at a time.

    Raises:
        SceneError: if a figure is none, or cannot do what it is asked to.
        SimulationError: if the scene cannot begin, or diverges.
    """

    def __init__(self, scene: Scene, key: str = "") -> None:
        clock = Clock(scene.rate, scene.n_frames, scene.steps, scene.samples)
        try:
            ground = build_ground(scene.terrain, scene.seed)
            self.world = World(ground, clock, scene.seed, scene.script, scene.all_moods)
            figures = _figures(scene)
            self.troupes: list[Troupe] = _troupes(scene, figures, self.world)
            self._groups = [troupe for troupe in self.troupes if isinstance(troupe, Groups)]
            self.recorder = Recorder(
                _header(scene, key), clock, self.world.ground, [t.inventory for t in self.troupes]
            )
            self.bonds = bonds_of(scene.cast, figures, self.recorder.nodes, clock)
            for groups in self._groups:
                groups.meet(self.recorder.nodes, self.recorder.meshes, figures)
        except SceneError as error:
            raise scene.places.located(error) from None
        self.recorder.hang(self.bonds)
        self.script = Script(scene.script, clock)
        _refuse_to_direct(scene, self.troupes)
        self._arrived: tuple[str, ...] = ()
        self.step_number = 0
        self._kept = self._written = 0
        room = POSES_AT_ONCE // max(len(self.recorder.nodes), 1)
        self._at_once = min(max(room, ROWS_AT_ONCE // 6), ROWS_AT_ONCE)
        self.colliders = next((t for t in self.troupes if isinstance(t, Colliders)), None)
        self._early: list[Bond] = []
        self._late = self.bonds
        if self.colliders is not None:
            # Their nodes are the last ones. What they meet should not be told much later.
            self._at_once = min(self._at_once, ROWS_BEFORE_BODIES)
            nodes = len(self.recorder.nodes)
            own = range(nodes - len(self.colliders.inventory.nodes), nodes)
            self._early, self._late = split(self.bonds, own)
        try:
            self._keep()
        except SceneError as error:
            raise scene.places.located(error) from None
        contacts, notes = self._facts()
        self.recorder.happened(contacts, [], notes)

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
        events = self._detect(contacts)
        self.recorder.happened(contacts, events, notes)

    def take(self) -> Take:
        """Return what has happened, once finished."""
        return self.recorder.take()

    def _read(self) -> None:
        """Show everybody what the script asks of them, and let them see the step before."""
        orders = self.script.orders(self.step_number, self._arrived)
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
        begins = self._kept == 1 and self.colliders is not None
        if begins or self._kept - self._written == self._at_once or self.finished:
            self._write(slice(self._written, self._kept))
            self._written = self._kept

    def _write(self, which: slice) -> None:
        for troupe, rows in zip(self.troupes, self.recorder.rows(which), strict=True):
            if troupe is self.colliders:
                R, p = self.recorder.attached(which, self._early)
                for k, row in enumerate(range(which.start, which.stop)):
                    step = row * self.world.clock.steps // self.world.clock.samples
                    self.colliders.meet(step, p[k], R[k])
            troupe.write(rows)
        R, p = self.recorder.attached(which, self._late)
        for groups in self._groups:
            # Nobody depends on them, so they see everybody in place.
            contacts = groups.follow(R, p)
            self.recorder.happened(contacts, self._detect(contacts), ())
        wrong = self.recorder.keep(which)
        if wrong is not None:
            row, node = wrong
            step = row * self.world.clock.steps // self.world.clock.samples
            raise SimulationError(
                f"the simulation diverged at step {step} "
                f"({float(self.world.clock.time_of(step)):.3f} s): "
                f"the pose of {node} is no longer finite"
            )

    def _facts(self) -> tuple[list[Contact], list[Note]]:
        facts = [troupe.facts() for troupe in self.troupes]
        contacts = [contact for fact in facts for contact in fact.contacts]
        notes = [note for fact in facts for note in fact.notes]
        self._arrived = tuple(name for fact in facts for name in fact.arrived)
        return sorted(contacts, key=lambda c: (c.step, c.fraction, c.part)), notes

    def _detect(self, contacts: list[Contact]) -> list[SoundEvent]:
        clock = self.world.clock
        return [event for detector in DETECTORS for event in detector(contacts, clock)]


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


def _figures(scene: Scene) -> dict[str, Figure]:
    """Return the figure of each creature by its name; those alike at one scale share theirs."""
    built = cache(lambda name, scale: build_figure(name, scene.figures[name], scale))
    return {member.name: built(member.figure, member.scale) for _, member in scene.creatures}


def _troupes(scene: Scene, figures: dict[str, Figure], world: World) -> list[Troupe]:
    """Sort the cast into troupes; who goes along with a parent stands on level ground there."""
    troupes = list[Troupe]()
    for level in dict.fromkeys(_level(member) for _, member in scene.creatures):
        here = [(i, m, figures[m.name]) for i, m in scene.creatures if _level(m) == level]
        worms = [one for one in here if _inches(one)]
        walkers = [one for one in here if not _inches(one)]
        ground = world.ground if level is None else level_ground(level, world.ground)
        there = replace(world, ground=ground)
        if walkers:
            troupes.append(Walkers(walkers, there, _materials(walkers)))
        if worms:
            troupes.append(Inchworms(worms, there, _materials(worms)))
    props = [member for member in scene.cast if isinstance(member, Prop)]
    if props:
        troupes.append(Props(props, world, [member.material or THING for member in props]))
    bodies = [(i, member) for i, member in enumerate(scene.cast) if isinstance(member, Body)]
    alone = [one for one in bodies if one[1].body.collide == "terrain"]
    if alone:
        # Bodies need a compiler, whose loading others need not wait for.
        from pipeline.simulation.bodies.tumblers import Tumblers

        troupes.append(Tumblers(alone, world, [member.material or THING for _, member in alone]))
    meeting = [
        (i, member)
        for i, member in enumerate(scene.cast)
        if isinstance(member, Many) or (isinstance(member, Body) and member.body.collide == "all")
    ]
    if meeting:
        # Bodies that meet nobody push nobody.
        solids = [t.inventory for t in troupes]
        pushing = [o for o in obstacles_of(solids) if o.performer not in {m.name for _, m in alone}]
        made_of = [member.material or THING for _, member in meeting]
        troupes.append(Colliders(meeting, world, made_of, pushing))
    groups = [(i, member) for i, member in enumerate(scene.cast) if isinstance(member, Group)]
    if groups:
        troupes.append(Groups(groups, world))
    return troupes


def _refuse_to_direct(scene: Scene, troupes: Sequence[Troupe]) -> None:
    """Refuse instructions to those who follow none, and looks of those who have none.

    Raises:
        SceneError: if there are any.
    """
    worms = {w.name for troupe in troupes if isinstance(troupe, Inchworms) for w in troupe.worms}
    problems = [
        Problem(f"script[{i}].who", f"'{one.who}' is an inchworm, which follows no script")
        for i, one in enumerate(scene.script)
        if one.who in worms
    ]
    problems += [
        Problem(f"cast[{i}].look_at", f"'{member.name}' is an inchworm, which looks nowhere")
        for i, member in scene.creatures
        if member.name in worms and member.look_at is not None
    ]
    if problems:
        raise scene.places.located(SceneError(problems))


def _inches(performer: Performer) -> bool:
    """Tell whether a creature moves as an inchworm; one that is posed is its author's to move."""
    _, member, figure = performer
    return is_chain(figure) and not member.pose


def _level(member: Creature) -> float | None:
    """Return the height in its parent's frame that a creature stands at; None for the ground."""
    if member.parent is None:
        return None
    return member.at[1] if len(member.at) == 3 else 0.0


def _materials(performers: Sequence[Performer]) -> list[str]:
    """Return what performers are made of where their figures do not say."""
    return [m.material or figure.material or SKIN for _, m, figure in performers]


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
    """Return the class of processor: within it, equal scenes give equal bytes.

    Numpy's exp, BLAS and decompositions choose their code by the vector units found.
    """
    simd = np.show_config(mode="dicts")["SIMD Extensions"]
    return "-".join([platform.machine(), *simd.get("found", [])])


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
