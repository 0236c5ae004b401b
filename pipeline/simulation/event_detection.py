"""Event detection: contacts, signals and motions of a simulation become sound events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipeline.simulation.clock import Clock
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.scheduler import Batch
from pipeline.simulation.signals import Signal
from pipeline.simulation.sound_detection.contact_sounds import ContactSounds
from pipeline.simulation.sound_detection.motion_sounds import MotionSounds
from pipeline.simulation.sound_detection.sound_sources import SoundSources, rigid_parts
from pipeline.simulation.sound_detection.vocal_sounds import VocalSounds
from pipeline.simulation.take import Contact, SoundEvent
from pipeline.spec.group import Group
from pipeline.spec.scene import Scene


class EventDetection:
    """All detectors of a scene."""

    def __init__(
        self, scene: Scene, clock: Clock, recorder: Recorder, figures: Mapping[str, Figure]
    ) -> None:
        detect = scene.sound.detect
        self._recorder = recorder
        self._contacts = ContactSounds(detect, clock)
        self._voices = VocalSounds(detect, clock)
        self._motions = MotionSounds(detect, sound_sources(scene, clock, recorder, figures))

    def of_step(
        self, contacts: Sequence[Contact], signals: Sequence[Signal], step: int
    ) -> list[SoundEvent]:
        """Returns the events of the contacts and signals with which `step` was reached."""
        events = self._contacts.events(contacts)
        voices = self._voices.events(signals, step)
        self._motions.add_contacts(contacts)
        return [*events, *voices]

    def of_batch_contacts(self, batch: Batch) -> list[SoundEvent]:
        """Returns the events of contacts that became known when rows were written."""
        return self._contacts.events(batch.contacts)

    def of_batch_motion(self, batch: Batch) -> list[SoundEvent]:
        """Returns the events of motion in finished rows."""
        alive, values = self._recorder.alive[batch.rows], self._recorder.values[batch.rows]
        return self._motions.events(batch.rows, batch.p, batch.R, alive, values)


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
    )
