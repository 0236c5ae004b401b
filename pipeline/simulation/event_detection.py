"""Event detection: contacts, signals and motions of a simulation become sound events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipeline.simulation.clock import Clock
from pipeline.simulation.detect import OF_CONTACTS, OF_HAPPENINGS, OF_MOTIONS
from pipeline.simulation.detect.contacts import Contacts
from pipeline.simulation.detect.motions import Motions
from pipeline.simulation.detect.scenery import Scenery, solids_of
from pipeline.simulation.detect.voices import Voices
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.scheduler import Batch
from pipeline.simulation.signals import Signal
from pipeline.simulation.take import Contact, SoundEvent
from pipeline.spec.cast import Group
from pipeline.spec.scene import Scene


class EventDetection:
    """All detectors of a scene."""

    def __init__(
        self, scene: Scene, clock: Clock, recorder: Recorder, figures: Mapping[str, Figure]
    ) -> None:
        detect = scene.sound.detect
        self._recorder = recorder
        self._contacts = Contacts(OF_CONTACTS, detect, clock)
        self._voices = Voices(OF_HAPPENINGS, detect, clock)
        self._motions = Motions(OF_MOTIONS, detect, scenery_of(scene, clock, recorder, figures))

    def of_step(
        self, contacts: Sequence[Contact], signals: Sequence[Signal], step: int
    ) -> list[SoundEvent]:
        """Returns the events of the contacts and signals with which `step` was reached."""
        events = self._contacts.hear(contacts)
        voices = self._voices.hear(signals, step)
        self._motions.met(contacts)
        return [*events, *voices]

    def of_batch_contacts(self, batch: Batch) -> list[SoundEvent]:
        """Returns the events of contacts that became known when rows were written."""
        return self._contacts.hear(batch.contacts)

    def of_batch_motion(self, batch: Batch) -> list[SoundEvent]:
        """Returns the events of motion in finished rows."""
        alive, values = self._recorder.alive[batch.rows], self._recorder.values[batch.rows]
        return self._motions.look(batch.rows, batch.p, batch.R, alive, values)


def scenery_of(
    scene: Scene, clock: Clock, recorder: Recorder, figures: Mapping[str, Figure]
) -> Scenery:
    """Returns the constants of a scene that detectors of motion read."""
    return Scenery(
        clock=clock,
        nodes=recorder.nodes,
        solids=solids_of(recorder.parts, recorder.meshes),
        channels=recorder.channels,
        figures=figures,
        groups=frozenset(m.name for m in scene.cast if isinstance(m, Group)),
    )
