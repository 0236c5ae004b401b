"""Shot plan: when a film cuts, and to whom.

The film opens with an establishing shot of all. The weightiest events get shots of their own, which
begin before them and last beyond them; the time between is divided among those who act. Where
nothing happens any more, a wider shot closes the film.

Source: Katz 1991 (coverage from wide to close). Thompson and Bowen 2009.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.production.camera.director.editing_pace import (
    LEAST_CUT_FILM_S,
    LEAST_SHOT_S,
    EditingPace,
)
from pipeline.production.camera.director.performer_tracks import STILL, PerformerTracks
from pipeline.production.camera.director.planned_shot import PlannedShot, ShotSize
from pipeline.production.camera.director.story_event import StoryEvent

REPEATED = 0.7
"""Factor on the weight of an event for each earlier one of its kind and performers."""

TAIL_PAUSE_S = 0.4
"""Time between the last motion and the closing shot [s]."""

TRAVELLING = 0.2
"""Speed from which a performer travels, relative to its radius [1/s]."""

MOST_LARGER = 4.0
"""Radius of another performer, relative to the first, from which a shot leaves it out."""

MOST_APART = 3.0
"""Gap between two, relative to the sum of their radii, beyond which no shot is of both."""


@dataclass(slots=True)
class ShotPlan:
    """Plans the shots of a span of a film.

    Attributes:
        tracks: of all performers.
        actors: performers that act, in the order of the cast.
        follow: performers that the author asked for, None for all.
        pace: of the editing.
        rate: frames per second.
    """

    tracks: PerformerTracks
    actors: tuple[str, ...]
    follow: tuple[str, ...] | None
    pace: EditingPace
    rate: float
    _shown: dict[str, float] = field(default_factory=dict)

    def shots(self, first: int, end: int, story: Sequence[StoryEvent]) -> list[PlannedShot]:
        """Return the shots from a frame, counted from 0, to the frame before `end`."""
        start, stop = first / self.rate, end / self.rate
        if stop - start < LEAST_CUT_FILM_S or not self.actors:
            reason = "one shot of all" if self.actors else "one shot, because nobody acts"
            return [self._shot(start, stop, "wide", None, reason)]
        tail = self._tail(start, stop, story)
        chosen = self._chosen(start, tail, story)
        spans = [(self._window(event, start, tail), event) for event in chosen]
        shots: list[PlannedShot] = []
        opening = self._opening_end(start, tail, spans[0][0][0] if spans else tail)
        establishing = self._shot(start, opening, "wide", None, "establishing shot of all")
        shots.append(replace(establishing, is_opening=True))
        cursor = opening
        for (begin, close), event in spans:
            cursor = self._fill(shots, cursor, begin)
            shots.append(self._event_shot(begin, close, event, shots))
            cursor = close
        self._fill(shots, cursor, tail)
        if tail < stop:
            reason = "nothing more happens: wider closing shot"
            shots.append(self._shot(tail, stop, "wide", None, reason))
        return shots

    def _tail(self, start: float, stop: float, story: Sequence[StoryEvent]) -> float:
        """Return when the closing shot begins; the end where the action lasts to the end."""
        told = [event.until + self.pace.after for event in story if event.time < stop]
        still = self.tracks.still_from(self.actors) + TAIL_PAUSE_S
        dead = self._on_frame(max([still, *told, start]))
        least = max(LEAST_SHOT_S, self.pace.least)
        return dead if stop - dead >= least and dead - start >= 2.0 * least else stop

    def _opening_end(self, start: float, tail: float, next_cut: float) -> float:
        """Return when the establishing shot ends."""
        usual = min(start + self.pace.opening, tail)
        if next_cut - usual < self.pace.least:
            return next_cut
        return usual if tail - usual >= self.pace.least else tail

    def _window(self, event: StoryEvent, start: float, stop: float) -> tuple[float, float]:
        """Return when the shot of an event begins and ends [s]."""
        begin = event.time - self.pace.before
        until = min(event.until, begin + self.pace.longest - self.pace.after)
        close = max(max(until, event.time) + self.pace.after, begin + self.pace.least)
        # In frames, so that rounding makes no shot too short.
        first = self._frame(begin)
        close = max(self._frame(close), first + self._least_frames) / self.rate
        if stop - close < LEAST_SHOT_S:
            close = stop
        return first / self.rate, close

    def _chosen(self, start: float, stop: float, story: Sequence[StoryEvent]) -> list[StoryEvent]:
        """Return the events that get a shot of their own, in the order of time."""
        left = [event for event in story if set(event.who) & set(self.actors)]
        chosen: list[StoryEvent] = []
        most = max(1, int((stop - start) / (self.pace.least + 0.5 * self.pace.usual)))
        while left and len(chosen) < most:
            event = max(left, key=lambda e: (self._weight(e, chosen), -e.time))
            left.remove(event)
            begin, close = self._window(event, start, stop)
            fits = begin >= start + LEAST_SHOT_S and close <= stop + 1e-9
            fits &= event.time + self.pace.after <= stop
            for other in chosen:
                first, last = self._window(other, start, stop)
                fits &= close <= first or begin >= last
            if fits:
                chosen.append(event)
        return sorted(chosen, key=lambda event: event.time)

    def _weight(self, event: StoryEvent, chosen: Sequence[StoryEvent]) -> float:
        same = sum((e.kind, set(e.who)) == (event.kind, set(event.who)) for e in chosen)
        return float(event.weight * REPEATED**same)

    def _event_shot(
        self, begin: float, close: float, event: StoryEvent, before: Sequence[PlannedShot]
    ) -> PlannedShot:
        follow = self._together(event.who, event.time)
        size: ShotSize = "close"
        if event.kind == "break":
            # Its pieces fly too far for a frame: whoever breaks it stands for the place.
            told = [n for n in event.who if self.tracks.jointed[self.tracks.number(n)]]
            follow, size = (told[0] if told else event.who[0],), "medium"
        last = before[-1]
        if last.size == "close" and last.follow == follow:
            size = "medium"
        self._shown[follow[0]] = close
        reason = f"{event.text} at {event.time:.2f} s"
        shot = self._shot(begin, close, size, follow, reason)
        return replace(shot, is_event=True)

    def _fill(self, shots: list[PlannedShot], begin: float, end: float) -> float:
        """Fill the time from the last shot to `end`; return `end`."""
        last = shots[-1]
        length = end - begin
        if length < max(self.pace.least, LEAST_SHOT_S):
            shots[-1] = replace(last, end=self._frame(end))
            return end
        count = max(1, round(length / self.pace.usual))
        count = max(1, min(count, round(length * self.rate) // self._least_frames))
        edges = [self._on_frame(t) for t in np.linspace(begin, end, count + 1)]
        for a, b in itertools.pairwise(edges):
            shots.append(self._filler(a, b, shots[-1]))
        return end

    def _filler(self, begin: float, end: float, last: PlannedShot) -> PlannedShot:
        """Return a shot of those who act between two times."""
        lively = {name: self.tracks.activity(name, begin, end) for name in self.actors}
        moving = [name for name in self.actors if lively[name] > STILL] or list(self.actors)
        told = [n for n in moving if self.tracks.jointed[self.tracks.number(n)]] or moving
        # Whoever has not been seen for longest, the liveliest first.
        name = min(told, key=lambda n: (self._shown.get(n, -1.0), -round(lively[n], 3)))
        self._shown[name] = end
        size: ShotSize = "close" if last.size == "medium" else "medium"
        follow: tuple[str, ...] = (name,)
        if size == "medium":
            near = [n for n in told if n != name and self._is_near(name, n, 0.5 * (begin + end))]
            follow = self._together((name, *near[:1]), 0.5 * (begin + end))
        reason = f"{' and '.join(follow)}, {size}"
        return self._shot(begin, end, size, follow, reason)

    def _together(self, who: tuple[str, ...], time: float) -> tuple[str, ...]:
        """Return those of an event that one shot can show."""
        first = who[0]
        others = [
            name
            for name in who[1:]
            if self._radius(name) < MOST_LARGER * self._radius(first)
            and self._is_near(first, name, time)
        ]
        return (first, *others)

    def _is_near(self, one: str, other: str, time: float) -> bool:
        way = self.tracks.center(one, time) - self.tracks.center(other, time)
        gap = float(np.linalg.norm(way)) / (self._radius(one) + self._radius(other))
        return gap < 1.0 + MOST_APART

    def _radius(self, name: str) -> float:
        return float(self.tracks.radii[self.tracks.number(name)])

    def _line(self, follow: tuple[str, ...] | None, middle: float) -> tuple[str, ...]:
        """Return whose line of action a shot has."""
        if follow is not None and len(follow) > 1:
            return tuple(sorted(follow[:2]))
        names = follow or self.actors
        if len(names) == 1:
            return names
        told = [n for n in names if self.tracks.jointed[self.tracks.number(n)]]
        return tuple(sorted(told)) if len(told) == 2 else ()

    def _shot(
        self,
        begin: float,
        end: float,
        size: ShotSize,
        follow: tuple[str, ...] | None,
        reason: str,
    ) -> PlannedShot:
        wanted = self.follow if follow is None else follow
        line = self._line(wanted, 0.5 * (begin + end))
        return PlannedShot(self._frame(begin), self._frame(end), size, wanted, line, reason)

    @property
    def _least_frames(self) -> int:
        """Frames of the shortest shot."""
        return math.ceil(max(self.pace.least, LEAST_SHOT_S) * self.rate - 1e-6)

    def _frame(self, time: float) -> int:
        return round(time * self.rate)

    def _on_frame(self, time: float) -> float:
        return self._frame(time) / self.rate
