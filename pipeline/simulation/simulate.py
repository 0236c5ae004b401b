"""Simulate: Scene -> Take, step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from pipeline.errors import Problem, SceneError
from pipeline.simulation.assembly import assemble
from pipeline.simulation.collapse_notes import collapse_notes
from pipeline.simulation.event_monitor import reported_events
from pipeline.simulation.ground_notes import ground_notes
from pipeline.simulation.mechanism import Leg
from pipeline.simulation.order_log import OrderLog
from pipeline.simulation.pass_through import pass_through_notes
from pipeline.simulation.recorder import NoteLog
from pipeline.simulation.script import Event, Orders
from pipeline.simulation.signals import Signal
from pipeline.simulation.start_overlaps import overlap_notes
from pipeline.simulation.story.director import StoryDirector
from pipeline.simulation.story.scene_stage import SceneStage
from pipeline.simulation.sunk_notes import sunk_notes
from pipeline.simulation.take import Take, TakeNote
from pipeline.simulation.thing_notes import thing_notes
from pipeline.simulation.troupe import Facts, pushed_troupe
from pipeline.spec.handled_members import refusal_of_handling
from pipeline.spec.order_support import performer_kind
from pipeline.spec.scene import Scene
from pipeline.spec.script import Instruction
from pipeline.spec.story import Story

COMMAND = "command"
"""Path of an instruction from outside, in error messages."""


class Simulation:
    """The world of one scene, one step at a time.

    Args:
        scene: the scene.
        key: key of the take.
        directed: whether instructions may arrive while it runs, by `add_instruction`.

    Attributes:
        step_number: number of steps taken.
        aliases: names of drawing nodes for the nodes of creatures.
        order_log: orders given so far, and their outcomes.

    Raises:
        SceneError: if the scene asks for something impossible.
        SimulationError: if it diverges.
    """

    def __init__(self, scene: Scene, key: str = "", directed: bool = False) -> None:
        try:
            parts = assemble(scene, key, directed)
            parts.scheduler.buffer_step(0)
        except SceneError as error:
            raise scene.source_map.with_locations(error) from None
        self.world, self.troupes, self.recorder = parts.world, parts.troupes, parts.recorder
        self.script, self.coupling, self.scheduler = parts.script, parts.coupling, parts.scheduler
        self.aliases = parts.aliases
        self._members, self._monitor = parts.members, parts.monitor
        self._ground_places = parts.ground_places
        self._detection = parts.detection
        kinds = {member.name: performer_kind(member) for member in scene.cast}
        self.order_log = OrderLog({name: kind for name, kind in kinds.items() if kind})
        self._director = StoryDirector(
            scene.story or Story(),
            *(self.world.clock, scene.seed, self.script, self.order_log.is_open),
            SceneStage(self._members, self.troupes, self.last_row),
        )
        self._scene, self.step_number = scene, 0
        self._collect_facts()
        self.recorder.add_facts(self._facts.contacts, (), self._facts.notes)

    @property
    def signals(self) -> tuple[Signal, ...]:
        """Signals of the last step."""
        return self._facts.signals

    @property
    def finished(self) -> bool:
        """Whether the last step is taken."""
        return self.step_number >= self.world.clock.last_step

    def step(self) -> None:
        """Advances the world by one step."""
        self._change_grips()
        orders = self._give_orders()
        self._show_members(orders)
        self._update_obstacles()
        self._read(orders)
        self._advance()
        self.scheduler.buffer_step(self.step_number)
        self._collect_facts()
        self._detection.record_step(self._facts, self.step_number)
        self.order_log.end(self.step_number, self._facts)

    def add_instruction(self, instruction: Instruction) -> None:
        """Adds an instruction from outside; one without delay is given in the next step.

        Raises:
            SceneError: if its performer cannot carry it out, or it leads off the terrain; the
                state is unchanged.
        """
        self._ground_places.refuse_order(instruction, COMMAND)
        problems = self._members.problems(instruction, COMMAND)
        refusal = refusal_of_handling(instruction.do, self._scene, self.world.directed)
        if refusal is not None:
            problems.append(Problem(COMMAND, refusal))
        if problems:
            raise SceneError(problems)
        for troupe in self.troupes:
            troupe.prepare(instruction, COMMAND)
        self.script.tell(instruction, self.step_number)

    def foreseen_notes(self) -> list[TakeNote]:
        """Returns notes of rows to come that are known without taking steps."""
        log = NoteLog()
        for troupe in self.troupes:
            log.add(troupe.foreseen_notes())
        return log.notes

    def last_row(self) -> int:
        """Returns the number of the last row, after writing all up to it."""
        self.scheduler.flush()
        return self.scheduler.last_row

    def run(self, each_step: Callable[[Simulation], None]) -> Take:
        """Takes all steps that are left; returns the take.

        Args:
            each_step: called after each; what it raises ends the run.
        """
        while not self.finished:
            self.step()
            each_step(self)
        return self.take()

    def take_so_far(self) -> Take | None:
        """Returns a take of the whole frames so far, None before the first is whole.

        It has no notes, orders, legs or mechanisms.
        """
        samples = self.recorder.clock.samples
        frames = self.last_row() // samples
        if frames < 1:
            return None
        whole = self.recorder.take()
        rows = slice(0, frames * samples + 1)
        return replace(
            whole,
            header=replace(whole.header, frames=frames),
            positions=whole.positions[rows],
            rotations=whole.rotations[rows],
            alive=whole.alive[rows],
            scales=whole.scales[rows],
            values=whole.values[rows],
            expressions=whole.expressions[rows],
            notes=(),
            aliases=self.aliases,
        )

    def take(self) -> Take:
        """Returns the take of a finished simulation."""
        self._members.update(0)
        notes = overlap_notes(self._scene.cast, self._members, self.recorder)
        pushed = pushed_troupe(self.troupes)
        meeting = {n.performer for n in pushed.inventory.nodes} if pushed is not None else set()
        notes += pass_through_notes(
            self._scene.cast, self._members, self.recorder, self.world.clock, meeting
        )
        place = self.recorder, self.world.clock, self.world.ground
        notes += ground_notes(self._scene.cast, *place)
        notes += sunk_notes(self._scene.cast, self._members, *place)
        notes += thing_notes(
            self._scene.cast, self._members, self.recorder, self.world.clock, notes
        )
        notes += collapse_notes(self._scene.cast, *place)
        self.recorder.add_facts((), (), notes)
        mechanisms = tuple(m for troupe in self.troupes for m in troupe.mechanisms())
        self.order_log.finish(self.step_number, self.script)
        self._director.finish(self.step_number)
        return replace(
            self.recorder.take(),
            mechanisms=mechanisms,
            legs=tuple(self.legs()),
            aliases=self.aliases,
            orders=tuple(self.order_log.records),
            beats=tuple(self._director.records),
        )

    def legs(self) -> list[Leg]:
        """Returns the legs of all walkers, with the stances planned so far."""
        return [leg for troupe in self.troupes for leg in troupe.legs()]

    # --- the passes of the step -------------------------------------------------------

    def _change_grips(self) -> None:
        """Passes what hands took and released in the last step to the troupe of the things."""
        changes = self._facts.grips
        if changes and (pushed := pushed_troupe(self.troupes)) is not None:
            self.scheduler.flush()
            hands = [tuple(map(self._members.node, change.hands)) for change in changes]
            pushed.change_grips(changes, hands)

    def _give_orders(self) -> Orders:
        events = self._events()
        self._director.advance(self.step_number, events)
        orders = self.script.orders(self.step_number, events)
        self.order_log.give(self.step_number, orders)
        return orders

    def _events(self) -> set[Event]:
        """Returns the events of the last step that instructions may wait for."""
        events = reported_events(self._facts)
        awaited = self.script.awaited | self._director.awaited
        if self._monitor.needs_members(awaited):
            self._members.update(self.last_row())
            events |= self._monitor.events(awaited, self._facts.contacts)
        return events

    def _show_members(self, orders: Orders) -> None:
        for troupe in self.troupes:
            if needed := troupe.members_needed(orders):
                self._members.update(self.last_row())
                troupe.see_members({name: self._members.state(name) for name in needed})

    def _update_obstacles(self) -> None:
        if self.coupling is not None:
            self.coupling.update(self.scheduler.last_row)

    def _read(self, orders: Orders) -> None:
        for troupe in self.troupes:
            troupe.read(orders)

    def _advance(self) -> None:
        for troupe in self.troupes:
            troupe.advance(self.step_number)
        self.step_number += 1

    def _collect_facts(self) -> None:
        self._facts = Facts.merged([troupe.facts() for troupe in self.troupes])


def simulate(
    scene: Scene, key: str = "", progress: Callable[[int, int], None] | None = None
) -> Take:
    """Simulates the whole of `scene`.

    Args:
        scene: the scene.
        key: digest of all that the take depends on, stored in it.
        progress: called every eighth frame with (frames done, all frames).
    """
    simulation = Simulation(scene, key)
    clock = simulation.world.clock

    def report(current: Simulation) -> None:
        if progress and current.step_number % (8 * clock.steps) == 0:
            progress(current.step_number // clock.steps, clock.frames)

    return simulation.run(report)
