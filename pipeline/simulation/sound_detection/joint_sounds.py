"""Joint sounds: joints that squeak when they bend and squawk when they jerk.

The sound of a limb is that of its fastest joint: the surfaces of a joint rub at its rate times its
radius. A sliding joint rubs at its speed.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from audio.acoustic_materials import family_name
from audio.names import matches_pattern
from pipeline.simulation.sound_detection.active_intervals import ActiveInterval, IntervalTracker
from pipeline.simulation.sound_detection.motion_sounds import detects
from pipeline.simulation.sound_detection.sound_events import interval_event
from pipeline.simulation.sound_detection.sound_sources import RigidPart, RowBatch, SoundSources
from pipeline.simulation.spatial import Array, turn_inverse
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Detect, JointMotionCause


class JointDetector:
    """Detects the sounds of joints, limb by limb.

    Args:
        sources: nodes and parts of the scene.
        config: thresholds of the cause.
        cause: name.
        max_rate: rate above which it is another cause [rad/s].
    """

    def __init__(
        self,
        sources: SoundSources,
        config: JointMotionCause,
        cause: str,
        max_rate: float = math.inf,
    ) -> None:
        self._sources, self._cause = sources, cause
        parts = [part for part in sources.parts.values() if _is_audible(sources, part, config)]
        self.is_idle = not parts
        limbs: dict[str, list[int]] = {}
        for i, part in enumerate(parts):
            limbs.setdefault(_limb_name(sources.nodes[part.node].name), []).append(i)
        self._parts, self._limbs = parts, list(limbs.values())
        self._nodes = np.array([part.node for part in parts], dtype=np.int64)
        self._parents = np.array([sources.nodes[n].parent for n in self._nodes], dtype=np.int64)
        self._radius = np.array([0.5 * part.thickness for part in parts])
        self._factor = np.array([config.materials[family_name(part.material)] for part in parts])
        upper, lower = math.radians(config.above_deg_s), math.radians(config.ends_deg_s)
        ones = np.ones(len(self._limbs))
        self._tracker = IntervalTracker(lower * ones, upper * ones, config, sources.dt)
        self._max_rate = max_rate

    def detect(self, rows: RowBatch) -> list[SoundEvent]:
        """See `MotionDetector`."""
        rate = self._rates(rows)
        rub = rate * self._radius
        level = rate / self._factor
        p = rows.p[rows.new][:, self._nodes]
        levels, values = list[Array](), list[Array]()
        for joints in self._limbs:
            fastest = level[:, joints].argmax(axis=1)
            row, joint = np.arange(len(level)), np.array(joints)[fastest]
            levels.append(level[row, joint])
            index = joint[:, None].astype(float)
            values.append(np.concatenate([rub[row, joint, None], p[row, joint], index], axis=1))
        intervals = self._tracker.update(
            rows.first_new, np.stack(levels, axis=1), np.stack(values, axis=1), rows.is_final
        )
        return [self._event(interval) for interval in intervals if interval.peak <= self._max_rate]

    def _event(self, interval: ActiveInterval) -> SoundEvent:
        """Return the sound of a limb, named after the joint that rubs fastest."""
        loudest = max(interval.values, key=lambda row: row[0])
        part = self._parts[int(loudest[4])]
        motion = replace(interval, values=[row[:4] for row in interval.values])
        return interval_event(motion, self._cause, part, self._sources.clock)

    def _rates(self, rows: RowBatch) -> Array:
        """Return the rates of joints at the new rows (m, N) [rad/s]."""
        R_WP, R_WC = rows.R[:, self._parents], rows.R[:, self._nodes]
        R_PC = np.swapaxes(R_WP, -1, -2) @ R_WC
        p_PC = turn_inverse(R_WP, rows.p[:, self._nodes] - rows.p[:, self._parents])
        dR, dp = R_PC[1:] - R_PC[:-1], p_PC[1:] - p_PC[:-1]
        # The difference of two rotations θ apart has a Frobenius norm of 2√2 sin(θ / 2).
        chord = np.sqrt((dR * dR).sum(axis=(-1, -2)))
        angle = 2.0 * np.arcsin(np.minimum(chord / math.sqrt(8.0), 1.0))
        slide = np.sqrt((dp * dp).sum(axis=-1)) / self._radius
        alive = rows.alive[1:, self._nodes] & rows.alive[:-1, self._nodes]
        return rows.at_rows(alive * (angle + slide) / self._sources.dt)


@detects("squeak")
def squeaks(sources: SoundSources, detect: Detect) -> JointDetector:
    """Return the detector of joints that bend more slowly than a squawk."""
    max_rate = detect.squawk.above_deg_s if detect.squawk.heard else math.inf
    return JointDetector(sources, detect.squeak, "squeak", math.radians(max_rate))


@detects("squawk")
def squawks(sources: SoundSources, detect: Detect) -> JointDetector:
    """Return the detector of joints that jerk."""
    return JointDetector(sources, detect.squawk, "squawk")


def _is_audible(sources: SoundSources, part: RigidPart, config: JointMotionCause) -> bool:
    node = sources.nodes[part.node]
    has_joint = node.parent >= 0 and sources.nodes[node.parent].performer == node.performer
    return (
        has_joint
        and matches_pattern(node.performer, config.who)
        and family_name(part.material) in config.materials
    )


def _limb_name(name: str) -> str:
    """Return the limb of a link, such as "bug.l1" of "bug.l1.2"."""
    limb, _, link = name.rpartition(".")
    return limb if link.isdecimal() else name
