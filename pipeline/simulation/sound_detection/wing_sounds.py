"""Wing sounds: flocks and swarms in flight, each heard as one where its middle is."""

from __future__ import annotations

import numpy as np

from audio.names import matches_pattern
from pipeline.simulation.sound_detection.active_intervals import IntervalTracker
from pipeline.simulation.sound_detection.motion_sounds import detects
from pipeline.simulation.sound_detection.sound_events import interval_event
from pipeline.simulation.sound_detection.sound_sources import RowBatch, SoundingPart, SoundSources
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Detect


@detects("wings")
class WingDetector:
    """Detects the flight of birds and insects."""

    def __init__(self, sources: SoundSources, detect: Detect) -> None:
        config = detect.wings
        self._clock, self._dt = sources.clock, sources.dt
        flying = {
            who: size for who, size in sources.wings.items() if matches_pattern(who, config.who)
        }
        self._members = [np.array(sources.nodes_by_performer[who]) for who in flying]
        self._groups = [
            SoundingPart(sources.root(who), who, f"{who}.wings", "", size)
            for who, size in flying.items()
        ]
        self.is_idle = not self._groups
        count = len(self._groups)
        self._tracker = IntervalTracker(
            np.full(count, config.ends), np.full(count, config.above), config, sources.dt
        )

    def detect(self, rows: RowBatch) -> list[SoundEvent]:
        """See `MotionDetector`."""
        speeds, places = [], []
        for members in self._members:
            p, alive = rows.p[:, members], rows.alive[:, members]
            steps = np.sqrt(((p[1:] - p[:-1]) ** 2).sum(axis=-1)) * (alive[1:] & alive[:-1])
            flown = steps.sum(axis=1) / np.maximum((alive[1:] & alive[:-1]).sum(axis=1), 1)
            speeds.append(rows.at_rows(flown / self._dt))
            middle = (p * alive[..., None]).sum(axis=1) / np.maximum(alive.sum(axis=1), 1)[:, None]
            places.append(middle[rows.new])
        speed = np.stack(speeds, axis=1)
        values = np.concatenate([speed[..., None], np.stack(places, axis=1)], axis=-1)
        intervals = self._tracker.update(rows.first_new, speed, values, rows.is_final)
        return [interval_event(i, "wings", self._groups[i.index], self._clock) for i in intervals]
