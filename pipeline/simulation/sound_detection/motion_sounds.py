"""Motion sounds: causes detected in the rows of all nodes.

Rows come in batches. Results do not depend on where a batch ends, since every batch starts with
the last two rows of the one before.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.sound_detection.sound_sources import RowBatch, SoundSources
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, SoundEvent
from pipeline.spec.sound_thresholds import Detect

OVERLAP = 2
"""Rows repeated in the next batch: the last complete one, and one that lacks its successor."""


class MotionDetector(Protocol):
    """Detects one cause."""

    is_idle: bool
    """Whether no source can make its sound."""

    def detect(self, rows: RowBatch) -> list[SoundEvent]:
        """Add rows; return the sound events that are known now."""


DetectorFactory = Callable[[SoundSources, Detect], MotionDetector]

MOTION_CAUSES: dict[str, DetectorFactory] = {}
"""Cause -> factory of its detector, filled by `detects`."""


def detects(cause: str) -> Callable[[DetectorFactory], DetectorFactory]:
    """Register the decorated factory for a cause."""

    def register(factory: DetectorFactory) -> DetectorFactory:
        MOTION_CAUSES[cause] = factory
        return factory

    return register


class MotionSounds:
    """Detects the causes that are motions.

    Args:
        detect: thresholds.
        sources: nodes and parts of the scene.
    """

    def __init__(self, detect: Detect, sources: SoundSources) -> None:
        # In the order of the configuration, whatever the order of imports.
        causes = [cause for cause in Detect.model_fields if cause in MOTION_CAUSES]
        detectors = [
            MOTION_CAUSES[cause](sources, detect)
            for cause in causes
            if getattr(detect, cause).heard
        ]
        self._detectors = [detector for detector in detectors if not detector.is_idle]
        self._clock = sources.clock
        self._lifts: dict[str, list[float]] = {}
        self._overlap: tuple[Array, Array, NDArray[np.bool_], Array] | None = None
        self._has_started = False

    def add_contacts(self, contacts: Iterable[Contact]) -> None:
        """Record when feet leave the ground, more exactly than rows show it."""
        clock = self._clock
        for contact in contacts:
            if contact.kind == "lift":
                row = (contact.step + contact.fraction) * clock.samples / clock.steps
                self._lifts.setdefault(contact.performer, []).append(row)

    def events(
        self, rows: slice, p: Array, R: Array, alive: NDArray[np.bool_], values: Array
    ) -> list[SoundEvent]:
        """Add rows; return the sound events that are known now.

        Args:
            rows: indices, following the last ones.
            p: (n, J, 3) positions of all nodes [m].
            R: (n, J, 3, 3) rotations.
            alive: (n, J).
            values: (n, C) of all channels.
        """
        if not self._detectors:
            return []
        if self._overlap is not None:
            last_p, last_R, last_alive, last_values = self._overlap
            p, R = np.concatenate([last_p, p]), np.concatenate([last_R, R])
            alive = np.concatenate([last_alive, alive])
            values = np.concatenate([last_values, values])
        is_final = rows.stop == self._clock.rows
        # The very first row has no predecessor; the last one waits for its successor.
        new = slice(1 if self._has_started else 0, len(p) - (not is_final))
        self._has_started = self._has_started or new.stop > new.start
        last = slice(-OVERLAP, None)
        # Copies: the arrays of rows are reused.
        self._overlap = p[last].copy(), R[last].copy(), alive[last].copy(), values[last].copy()
        first = rows.stop - len(p)
        batch = RowBatch(first, new, p, R, alive, values, is_final, self._lifts)
        return [event for detector in self._detectors for event in detector.detect(batch)]
