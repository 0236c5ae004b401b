"""Vocal sounds: cries and hugs of people, from the signals of their behaviour.

Every cause with a `VocalCause` configuration is detected from the signals of the same name.

Source: Horswill 2008, "Example application".
"""

from __future__ import annotations

from collections.abc import Iterable
from math import inf

from audio.names import matches_pattern
from pipeline.simulation.clock import Clock
from pipeline.simulation.signals import Signal
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Detect, VocalCause

SKIN = "skin"
"""Material of people."""


class VocalSounds:
    """Detects the causes that are signals.

    Args:
        detect: thresholds.
        clock: grid of steps, rows and frames.
    """

    def __init__(self, detect: Detect, clock: Clock) -> None:
        self._configs = {
            cause: config
            for cause, config in detect
            if isinstance(config, VocalCause) and config.heard
        }
        self._clock = clock
        self._last_times: dict[tuple[str, str], float] = {}

    def events(self, signals: Iterable[Signal], step: int) -> list[SoundEvent]:
        """Return the sound events of the signals of a step."""
        return [self._event(s, step) for s in signals if self._is_audible(s, step)]

    def _is_audible(self, signal: Signal, step: int) -> bool:
        config = self._configs.get(signal.kind)
        if config is None or signal.strength < config.above:
            return False
        if not matches_pattern(signal.who, config.who):
            return False
        now = step * self._clock.dt
        if now - self._last_times.get((signal.kind, signal.who), -inf) < config.pause:
            return False
        self._last_times[signal.kind, signal.who] = now
        return True

    def _event(self, signal: Signal, step: int) -> SoundEvent:
        row = step * self._clock.samples // self._clock.steps
        return SoundEvent(
            step=step,
            fraction=0.0,
            frame=self._clock.frame_of(step, 0.0),
            cause=signal.kind,
            who=signal.who,
            part=signal.part,
            other=signal.other,
            place=signal.place,
            strength=signal.strength,
            energy=0.0,
            size=signal.size,
            material=SKIN,
            surface=SKIN if signal.other else "",
            track=(row, row),
        )
