"""Cloth sounds: garments that rustle as the limbs in them move.

What rubs is the cloth between limbs and trunk, so that only their motion against each other counts.

Source: Farnell 2010, for noise that follows the speed of cloth.
"""

from __future__ import annotations

import numpy as np

from audio.names import matches_pattern
from pipeline.simulation.sound_detection.active_intervals import IntervalTracker
from pipeline.simulation.sound_detection.motion_sounds import detects
from pipeline.simulation.sound_detection.sound_events import interval_event
from pipeline.simulation.sound_detection.sound_sources import RowBatch, SoundSources
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Detect


@detects("rustle")
class RustleDetector:
    """Detects the limbs that move fast in their clothes."""

    def __init__(self, sources: SoundSources, detect: Detect) -> None:
        config = detect.rustle
        self._clock, self._dt = sources.clock, sources.dt
        worn = sources.garments.items()
        self._garments = [part for who, part in worn if matches_pattern(who, config.who)]
        self._limbs = [
            np.array(
                [node for node in sources.nodes_by_performer[part.performer] if node != part.node]
            )
            for part in self._garments
        ]
        self.is_idle = not self._garments
        count = len(self._garments)
        self._tracker = IntervalTracker(
            np.full(count, config.ends), np.full(count, config.above), config, sources.dt
        )

    def detect(self, rows: RowBatch) -> list[SoundEvent]:
        """See `MotionDetector`."""
        speeds, places = [], []
        for garment, limbs in zip(self._garments, self._limbs, strict=True):
            trunk, turn = rows.p[:, garment.node], rows.R[:, garment.node]
            # As the trunk sees them; the mean square, because every sleeve and leg rubs.
            offset = rows.p[:, limbs] - trunk[:, None]
            seen = (offset[..., None] * turn[:, None]).sum(axis=-2)
            moved = ((seen[1:] - seen[:-1]) ** 2).sum(axis=-1)
            speeds.append(rows.at_rows(np.sqrt(moved.mean(axis=-1)) / self._dt))
            places.append(trunk[rows.new])
        speed = np.stack(speeds, axis=1)
        values = np.concatenate([speed[..., None], np.stack(places, axis=1)], axis=-1)
        intervals = self._tracker.update(rows.first_new, speed, values, rows.is_final)
        return [
            interval_event(i, "rustle", self._garments[i.index], self._clock) for i in intervals
        ]
