"""Breathing of creatures and people, faster when they run and when they are excited.

At rest the rate is 53.5 m^-0.26 a minute for a mass m [kg]. A creature in motion takes one breath
in a number of strides if that is faster; a person breathes faster by its speed, after some seconds,
and by its anxiety.

Source: Sims 1987, 13.1.2; Stahl 1967 (rate by mass); Bramble and Carrier 1983 (by strides); Boiten,
Frijda and Wientjes 1994 (by emotion).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import floor

import numpy as np

from audio.names import matches_pattern
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.sound_detection.active_intervals import ActiveInterval
from pipeline.simulation.sound_detection.motion_sounds import detects
from pipeline.simulation.sound_detection.sound_events import interval_event
from pipeline.simulation.sound_detection.sound_sources import RowBatch, SoundingPart, SoundSources
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Breath, Detect

EXHALATION_SHARE = 0.4
"""Share of a breath that is exhalation, which is audible."""

RATE_BY_MOOD = {"frightened": 1.6, "angry": 1.4, "excited": 1.4, "happy": 1.15, "tired": 1.25}
"""Rate of breathing of a creature's strongest mood, relative to that at rest."""

RATE_BY_SPEED, EFFORT_LAG = 0.45, 5.0
"""By how much a metre a second raises a person's rate, relative to rest, and time in which it does
so [s]: walking takes 1.6 breaths for one at rest, running 2.8."""

BODY_MASS_INDEX, HEAD_HEIGHT = 22.0, 0.93
"""Mass of a person over the square of its height [kg/m²], and height of the head's middle in it."""

PERSON_MOUTH = 0.12
"""Size of the mouth's resonance, in a person's height of 1.75 m [m]."""

FLOW_AT_REST = 0.6
"""Speed of the air at rest [m/s]; it grows with the root of the rate."""


@detects("breath")
class BreathDetector:
    """Detects the breaths of creatures."""

    def __init__(self, sources: SoundSources, detect: Detect) -> None:
        self._clock = sources.clock
        config = detect.breath
        self._breathers: list[_Breather] = [
            _Creature(sources, name, figure, config)
            for name, figure in sources.figures.items()
            if matches_pattern(name, config.who)
        ]
        self._breathers += [
            _Person(sources, name, config)
            for name in sorted(sources.people)
            if matches_pattern(name, config.who) and f"{name}.head" in sources.node_numbers
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
    """Breathing of one performer.

    Args:
        sources: of the scene.
        mouth: part that sounds.

    Attributes:
        mouth: part that sounds.
    """

    def __init__(self, sources: SoundSources, mouth: SoundingPart) -> None:
        self.mouth, self._dt = mouth, sources.dt
        self._breaths = 0.0
        self._last_row = sources.clock.rows - 1
        # (start, end, values) of exhalations [rows].
        self._exhalations: list[tuple[float, float, list[list[float]]]] = []

    def _rates(self, rows: RowBatch, k: int) -> tuple[float, float]:
        """Return the breaths a second at the next row of a batch, and those at rest."""
        raise NotImplementedError

    def update(self, rows: RowBatch) -> Iterator[ActiveInterval]:
        """Yield the exhalations that have ended."""
        for k in range(*rows.new.indices(len(rows.p))):
            row = rows.first + k
            rate, at_rest = self._rates(rows, k)
            before = self._breaths
            if row > 0:
                self._breaths += rate * self._dt
            flow = FLOW_AT_REST * (rate / at_rest) ** 0.5
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

    def _ended(self, row: int) -> Iterator[ActiveInterval]:
        while self._exhalations and (self._exhalations[0][1] <= row or row == self._last_row):
            start, _, values = self._exhalations.pop(0)
            first = int(start)
            yield ActiveInterval(0, start, first, first + len(values) - 1, values[0][0], values)


def rate_at_rest(mass: float, config: Breath) -> float:
    """Return the breaths a second of a body of a mass [kg] at rest."""
    return (config.per_minute or 53.5 * mass**-0.26) / 60.0


class _Creature(_Breather):
    """Breathing of a creature: by its strides and its mood."""

    def __init__(self, sources: SoundSources, name: str, figure: Figure, config: Breath) -> None:
        own = [part for part in sources.parts.values() if part.performer == name]
        # Its head, or else its body.
        heads = [part for part in own if part.part.startswith(f"{name}.head")]
        super().__init__(sources, heads[-1] if heads else own[0])
        mass = FigureMass(figure).mass_of(range(len(figure.skeleton.links)))
        self._rate_at_rest = rate_at_rest(mass, config)
        self._strides_per_breath = config.strides
        self._gait_channel = sources.channel(f"{name}.gait_phase")
        self._moods = sources.moods.get(name, ())
        self._last_phase = 0.0

    def _rates(self, rows: RowBatch, k: int) -> tuple[float, float]:
        channel = self._gait_channel
        phase = 0.0 if channel is None else float(rows.values[k, channel])
        advance = (phase - self._last_phase) % 1.0
        self._last_phase = phase
        # More than half a cycle per row is a phase that was set back.
        strides = advance / self._dt if advance < 0.5 else 0.0
        now = (rows.first + k) * self._dt
        moods = [mood for since, mood in self._moods if since <= now]
        excited = self._rate_at_rest * RATE_BY_MOOD.get(moods[-1] if moods else "", 1.0)
        return max(excited, strides / self._strides_per_breath), self._rate_at_rest


class _Person(_Breather):
    """Breathing of a person: by its effort and its anxiety."""

    def __init__(self, sources: SoundSources, name: str, config: Breath) -> None:
        head = sources.node_numbers[f"{name}.head"]
        super().__init__(sources, SoundingPart(head, name, f"{name}.head", "skin", PERSON_MOUTH))
        self._config, self._effort, self._rate_at_rest = config, 0.0, 0.0
        self._nodes = np.array(sources.nodes_by_performer[name])
        self._anxiety = sources.channel(f"{name}.anxiety")

    def _rates(self, rows: RowBatch, k: int) -> tuple[float, float]:
        if not self._rate_at_rest:
            y = rows.p[k, self._nodes, 1]
            # One that lies at the start is as long as it is high otherwise, or nearly so.
            extent = np.ptp(rows.p[k, self._nodes], axis=0).max()
            height = max(float(np.ptp(y)), float(extent)) / HEAD_HEIGHT
            self.mouth = replace(self.mouth, size=PERSON_MOUTH * height / 1.75)
            self._rate_at_rest = rate_at_rest(BODY_MASS_INDEX * height**2, self._config)
        speed = 0.0
        if k > 0:
            moved = rows.p[k, self.mouth.node] - rows.p[k - 1, self.mouth.node]
            speed = float(np.hypot(moved[0], moved[2])) / self._dt
        self._effort += (RATE_BY_SPEED * speed - self._effort) * min(self._dt / EFFORT_LAG, 1.0)
        anxiety = 0.0 if self._anxiety is None else float(rows.values[k, self._anxiety])
        rate = self._rate_at_rest * (1.0 + self._effort) * (1.0 + min(max(anxiety, 0.0), 1.0))
        return rate, self._rate_at_rest
