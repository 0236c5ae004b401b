"""Event detection: contacts, signals and motions of a simulation become sound events."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pipeline.simulation.clock import Clock
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.scheduler import Batch
from pipeline.simulation.sound_detection.contact_sounds import ContactSounds
from pipeline.simulation.sound_detection.motion_sounds import MotionSounds
from pipeline.simulation.sound_detection.sound_sources import (
    SoundSources,
    garments,
    rigid_parts,
)
from pipeline.simulation.sound_detection.vocal_sounds import VocalSounds
from pipeline.simulation.troupe import Facts
from pipeline.spec.character import Character
from pipeline.spec.creature import Creature
from pipeline.spec.group import Flock, Group, Swarm
from pipeline.spec.scene import Scene
from pipeline.spec.script import ChangeMood


class EventDetection:
    """All detectors of a scene; events and the contacts they follow from go to the recorder."""

    def __init__(
        self, scene: Scene, clock: Clock, recorder: Recorder, figures: Mapping[str, Figure]
    ) -> None:
        detect = scene.sound.detect
        self._recorder = recorder
        self._contacts = ContactSounds(detect, clock)
        self._voices = VocalSounds(detect, clock)
        self._motions = MotionSounds(detect, sound_sources(scene, clock, recorder, figures))

    def record_step(self, facts: Facts, step: int) -> None:
        """Records the facts with which `step` was reached, and the events that follow from them."""
        contacts = facts.contacts
        events = self._contacts.events(contacts)
        voices = self._voices.events(facts.signals, step)
        self._motions.add_contacts(contacts)
        self._recorder.add_facts(contacts, [*events, *voices], facts.notes)

    def record_batch(self, batch: Batch) -> None:
        """Records contacts that became known when rows were written, and the events of the rows."""
        recorder, rows = self._recorder, batch.rows
        recorder.add_facts(batch.contacts, self._contacts.events(batch.contacts), ())
        alive, values = recorder.alive[rows], recorder.values[rows]
        recorder.add_facts((), self._motions.events(rows, batch.p, batch.R, alive, values), ())


def sound_sources(
    scene: Scene, clock: Clock, recorder: Recorder, figures: Mapping[str, Figure]
) -> SoundSources:
    """Returns the constants of a scene that detectors of motion read."""
    return SoundSources(
        clock=clock,
        nodes=recorder.nodes,
        parts=rigid_parts(recorder.parts, recorder.meshes),
        channels=recorder.channels,
        figures=figures,
        groups=frozenset(m.name for m in scene.cast if isinstance(m, Group)),
        people=frozenset(m.name for m in scene.cast if isinstance(m, Character)),
        garments=garments(recorder.parts, recorder.nodes),
        wings=dict(_wings(scene)),
        moods=moods_in_time(scene),
        seed=scene.seed,
    )


def _wings(scene: Scene) -> Iterator[tuple[str, float]]:
    """Yields the groups that fly, with the length of a wing [m]."""
    for member in scene.cast:
        rule = member.group if isinstance(member, Group) else None
        if isinstance(rule, Flock):
            yield member.name, 0.5 * rule.size
        elif isinstance(rule, Swarm):
            yield member.name, rule.size


def moods_in_time(scene: Scene) -> dict[str, list[tuple[float, str]]]:
    """Returns the strongest mood of each creature, with the times of scripted changes [s]."""
    found = {
        member.name: [(0.0, _strongest(member.mood))]
        for member in scene.cast
        if isinstance(member, Creature) and member.name is not None
    }
    timed = [order for order in scene.script if order.at is not None]
    for order in sorted(timed, key=lambda order: order.at or 0.0):
        if isinstance(order.do, ChangeMood):
            moods = found.setdefault(order.who, [])
            moods.append((order.at or 0.0, _strongest(order.do.mood)))
    return found


def _strongest(mood: Mapping[str, float]) -> str:
    return max(mood, key=mood.__getitem__, default="")
