"""Calls of creatures, each in the voice of its mood, at times of its own.

The voice is that of a body of the creature's mass.

Source: Morton 1977, for moods.
"""

from __future__ import annotations

from dataclasses import replace

from audio.names import matches_pattern
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.seeds import generator
from pipeline.simulation.sound_detection.active_intervals import ActiveInterval
from pipeline.simulation.sound_detection.motion_sounds import detects
from pipeline.simulation.sound_detection.sound_events import interval_event
from pipeline.simulation.sound_detection.sound_sources import RigidPart, RowBatch, SoundSources
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Detect

VOICES = {
    **dict.fromkeys(("angry", "impatient"), "growl"),
    **dict.fromkeys(("sad", "tired", "frightened"), "whine"),
}
"""Causes by mood; of all others a call."""

STRENGTH = {"call": 1.5, "growl": 1.2, "whine": 0.8}
"""Loudness of each, as the speed of a blow [m/s]."""

SHORTEST = 0.3
"""Least time between calls, as a share of the average."""

WATER = 1000.0
"""Density of a creature's body [kg/m³]."""


@detects("call")
class CallDetector:
    """Finds the times at which creatures call."""

    def __init__(self, sources: SoundSources, detect: Detect) -> None:
        self._clock, self._dt, self._moods = sources.clock, sources.dt, sources.moods
        self._callers = [
            _Caller(sources, name, detect.call.every)
            for name in sources.figures
            if matches_pattern(name, detect.call.who)
        ]
        self.is_idle = not self._callers

    def detect(self, rows: RowBatch) -> list[SoundEvent]:
        """See `MotionDetector`."""
        events = []
        for k in range(*rows.new.indices(len(rows.p))):
            row = rows.first + k
            for caller in self._callers:
                if row * self._dt >= caller.due and rows.alive[k, caller.mouth.node]:
                    place = rows.p[k, caller.mouth.node].tolist()
                    events.append(self._event(caller, row, place))
        return events

    def _event(self, caller: _Caller, row: int, place: list[float]) -> SoundEvent:
        moods = self._moods.get(caller.mouth.performer, ())
        now = [mood for since, mood in moods if since <= row * self._dt]
        cause = VOICES.get(now[-1] if now else "", "call")
        caller.wait(row * self._dt)
        values = [[STRENGTH[cause], *place]]
        call = ActiveInterval(0, float(row), row, row, STRENGTH[cause], values)
        return replace(interval_event(call, cause, caller.mouth, self._clock), size=caller.size)


class _Caller:
    """The voice of one creature.

    Attributes:
        mouth: part that sounds: its head, or else its body.
        size: of a cube of its mass [m].
        due: time of the next call [s].
    """

    def __init__(self, sources: SoundSources, name: str, every: float) -> None:
        own = [part for part in sources.parts.values() if part.performer == name]
        heads = [part for part in own if part.part.startswith(f"{name}.head")]
        self.mouth: RigidPart = heads[-1] if heads else own[0]
        figure = sources.figures[name]
        mass = FigureMass(figure).mass_of(range(len(figure.skeleton.links)))
        self.size = float(mass / WATER) ** (1.0 / 3.0)
        self._rng, self._every = generator(sources.seed, f"{name}.calls"), every
        self.due = every * float(self._rng.random())

    def wait(self, now: float) -> None:
        """Choose the time of the next call."""
        share = SHORTEST + 2.0 * (1.0 - SHORTEST) * float(self._rng.random())
        self.due = now + self._every * share
