"""Voices: what people are heard of that no contact or motion tells: cries, and hugs.

Source: Horswill 2008, "Example application".
"""

from __future__ import annotations

from collections.abc import Iterable
from math import inf

from pipeline.simulation.clock import Clock
from pipeline.simulation.detect.hearing import fits
from pipeline.simulation.signals import Signal
from pipeline.simulation.take import SoundEvent
from pipeline.spec.detect import Detect, Voiced

SKIN = "skin"
"""What people sound like, where the voice does not say."""


class Voices:
    """All causes that are happenings.

    Args:
        causes: cause -> kind of happening that makes it.
        detect: the author's thresholds.
        clock: the grid of steps, rows and frames.
    """

    def __init__(self, causes: dict[str, str], detect: Detect, clock: Clock) -> None:
        words: dict[str, Voiced] = {cause: getattr(detect, cause) for cause in causes}
        self._causes = {kind: (c, words[c]) for c, kind in causes.items() if words[c].heard}
        self.clock = clock
        self._last: dict[tuple[str, str], float] = {}

    def hear(self, happened: Iterable[Signal], step: int) -> list[SoundEvent]:
        """Return the sound events of what had happened when a step was reached."""
        found = list[SoundEvent]()
        for one in happened:
            cause, words = self._causes.get(one.kind, ("", None))
            if words is not None and self._is_heard(one, cause, words, step):
                found.append(self._event(one, cause, step))
        return found

    def _is_heard(self, one: Signal, cause: str, words: Voiced, step: int) -> bool:
        """Tell whether somebody is meant, and was not heard just before."""
        if one.strength < words.above or not fits(one.who, words.who):
            return False
        now = step * self.clock.dt
        if now - self._last.get((cause, one.who), -inf) < words.pause:
            return False
        self._last[cause, one.who] = now
        return True

    def _event(self, one: Signal, cause: str, step: int) -> SoundEvent:
        row = step * self.clock.samples // self.clock.steps
        return SoundEvent(
            step=step,
            fraction=0.0,
            frame=self.clock.frame_of(step, 0.0),
            cause=cause,
            who=one.who,
            part=one.part,
            other=one.other,
            place=one.place,
            strength=one.strength,
            energy=0.0,
            size=one.size,
            material=SKIN,
            surface=SKIN if one.other else "",
            track=(row, row),
        )
