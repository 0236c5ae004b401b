"""Breathing of creatures, faster when they run.

At rest the rate is 53.5 m^-0.26 a minute for a mass m [kg]; in motion it is one breath per number
of strides if that is faster.

Source: Sims 1987, 13.1.2; Stahl 1967 (rate by mass); Bramble and Carrier 1983 (by strides).
"""

from __future__ import annotations

from collections.abc import Iterator
from math import floor

from audio.names import matches_pattern
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.sound_detection.active_intervals import ActiveInterval
from pipeline.simulation.sound_detection.motion_sounds import detects
from pipeline.simulation.sound_detection.sound_events import interval_event
from pipeline.simulation.sound_detection.sound_sources import RigidPart, RowBatch, SoundSources
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Breath, Detect

EXHALATION_SHARE = 0.4
"""Share of a breath that is exhalation, which is audible."""

FLOW_AT_REST = 0.6
"""Speed of the air at rest [m/s]; it grows with the root of the rate."""


@detects("breath")
class BreathDetector:
    """Detects the breaths of creatures."""

    def __init__(self, sources: SoundSources, detect: Detect) -> None:
        self._clock = sources.clock
        self._breathers = [
            _Breather(sources, name, figure, detect.breath)
            for name, figure in sources.figures.items()
            if matches_pattern(name, detect.breath.who)
        ]
        self.is_idle = not self._breathers

    def detect(self, rows: RowBatch) -> list[SoundEvent]:
        """See `MotionDetector`."""
        return [
            interval_event(breath, "breath", breather.mouth, self._clock)
            for breather in self._breathers
            for breath in breather.update(rows)
        ]


class _Breather:
    """Breathing of one creature.

    Attributes:
        mouth: part that sounds: its head, or else its body.
    """

    def __init__(self, sources: SoundSources, name: str, figure: Figure, config: Breath) -> None:
        own = [part for part in sources.parts.values() if part.performer == name]
        heads = [part for part in own if part.part.startswith(f"{name}.head")]
        self.mouth: RigidPart = heads[-1] if heads else own[0]
        mass = FigureMass(figure).mass_of(range(len(figure.skeleton.links)))
        self._rate_at_rest = (config.per_minute or 53.5 * mass**-0.26) / 60.0
        self._strides_per_breath, self._dt = config.strides, sources.dt
        self._gait_channel = sources.channel(f"{name}.gait_phase")
        self._breaths, self._last_phase = 0.0, 0.0
        self._last_row = sources.clock.rows - 1
        # (start, end, values) of exhalations [rows].
        self._exhalations: list[tuple[float, float, list[list[float]]]] = []

    def update(self, rows: RowBatch) -> Iterator[ActiveInterval]:
        """Yield the exhalations that have ended."""
        channel = self._gait_channel
        for k in range(*rows.new.indices(len(rows.p))):
            row = rows.first + k
            rate = self._rate(0.0 if channel is None else float(rows.values[k, channel]))
            before = self._breaths
            if row > 0:
                self._breaths += rate * self._dt
            flow = FLOW_AT_REST * (rate / self._rate_at_rest) ** 0.5
            value = [flow, *rows.p[k, self.mouth.node].tolist()]
            for _, _, values in self._exhalations:
                values.append(value)
            if floor(self._breaths) > floor(before):
                since = (self._breaths - floor(self._breaths)) / (self._breaths - before)
                start = row - since
                values = [value] if start == row else [value, value]
                end = start + EXHALATION_SHARE / (rate * self._dt)
                self._exhalations.append((start, end, values))
            yield from self._ended(row)

    def _rate(self, phase: float) -> float:
        """Return the breaths a second at the next phase of the gait."""
        advance = (phase - self._last_phase) % 1.0
        self._last_phase = phase
        # More than half a cycle per row is a phase that was set back.
        strides = advance / self._dt if advance < 0.5 else 0.0
        return max(self._rate_at_rest, strides / self._strides_per_breath)

    def _ended(self, row: int) -> Iterator[ActiveInterval]:
        while self._exhalations and (self._exhalations[0][1] <= row or row == self._last_row):
            start, _, values = self._exhalations.pop(0)
            first = int(start)
            yield ActiveInterval(0, start, first, first + len(values) - 1, values[0][0], values)
