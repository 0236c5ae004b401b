"""Flight sounds: props and bodies that swoosh or whistle through the air.

A swoosh needs a number of its own lengths a second, so a large body must be faster. Behind a body
of thickness d vortices are shed at f = 0.2 v / d; a whistle needs a minimum tone.

Source: Sims 1987, 13.1.2; Strouhal 1878 (the tone of a wire in the wind).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from audio.names import matches_pattern
from pipeline.simulation.sound_detection.active_intervals import IntervalTracker
from pipeline.simulation.sound_detection.motion_sounds import detects
from pipeline.simulation.sound_detection.sound_events import interval_event
from pipeline.simulation.sound_detection.sound_sources import (
    RigidPart,
    RowBatch,
    SoundSources,
)
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Detect, MotionCause

STROUHAL_NUMBER = 0.2
"""Of long round bodies, at audible speeds."""


class FlightDetector:
    """Detects fast parts of props and bodies.

    Args:
        sources: nodes and parts of the scene.
        config: thresholds of the cause.
        cause: name.
        min_speed: part -> speed below which it is silent whatever the thresholds [m/s].
    """

    def __init__(
        self,
        sources: SoundSources,
        config: MotionCause,
        cause: str,
        min_speed: Callable[[RigidPart], float],
    ) -> None:
        self._sources, self._cause = sources, cause
        parts = [part for part in sources.flying if matches_pattern(part.performer, config.who)]
        self._parts, self.is_idle = parts, not parts
        self._nodes = np.array([part.node for part in parts], dtype=np.int64)
        upper = np.maximum(config.above, np.array([min_speed(part) for part in parts]))
        # Raised thresholds keep their ratio.
        lower = upper * (config.ends / config.above if config.above else 1.0)
        self._tracker = IntervalTracker(lower, upper, config, sources.dt)

    def detect(self, rows: RowBatch) -> list[SoundEvent]:
        """See `MotionDetector`."""
        p = rows.p[:, self._nodes]
        dp = p[1:] - p[:-1]
        alive = rows.alive[1:, self._nodes] & rows.alive[:-1, self._nodes]
        between = alive * np.sqrt((dp * dp).sum(axis=-1)) / self._sources.dt
        speed = rows.at_rows(between)
        values = np.concatenate([speed[..., None], p[rows.new]], axis=-1)
        intervals = self._tracker.update(rows.first_new, speed, values, rows.is_final)
        return [
            interval_event(i, self._cause, self._parts[i.index], self._sources.clock)
            for i in intervals
        ]


@detects("swoosh")
def swooshes(sources: SoundSources, detect: Detect) -> FlightDetector:
    """Return the detector of parts that are fast for their size."""
    config = detect.swoosh
    return FlightDetector(sources, config, "swoosh", lambda part: config.sizes_s * part.size)


@detects("whistle")
def whistles(sources: SoundSources, detect: Detect) -> FlightDetector:
    """Return the detector of parts that are fast for their thickness."""
    config = detect.whistle
    return FlightDetector(
        *(sources, config, "whistle"),
        lambda part: config.least_hz * part.thickness / STROUHAL_NUMBER,
    )
