"""Story: the events of a take, from its contacts, sounds, orders, notes and motion."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.production.camera.director.performer_tracks import PerformerTracks
from pipeline.production.camera.director.story_event import StoryEvent, StoryKind
from pipeline.simulation.take import Contact, Take
from pipeline.spec.verbs import VERBS

LEAST_STRIKE = 0.3
"""Speed from which a hit between performers is a strike [m/s]."""

STRIKE_PAUSE_S = 1.0
"""Pause after which two strike each other anew [s]."""

BREAK_HITS, BREAK_S = 8, 0.6
"""Collisions among the bodies of one performer within some seconds that make it break [s]."""

BREAK_SPEED = 0.3
"""Speed of these collisions, above that of bodies that settle [m/s]."""

BREAK_PAUSE_S = 2.5
"""Pause without collisions after which a performer may break again [s]."""

FALL_NOTES = frozenset({"toppled", "dropped", "tripped"})
"""Kinds of notes on falls."""

FALLEN_HEIGHT = 0.55
"""Height of a jointed performer that lies, relative to its usual height."""

FLIGHT_SOUNDS = frozenset({"boing", "push off"})
"""Causes of sounds with which a flight begins."""

LONGEST_FLIGHT_S = 2.5
"""Time after its start in which a flight lands [s]."""

ARRIVAL_SPEED, ARRIVED_SPEED = 0.25, 0.06
"""Speeds of one that travels and of one that stands, relative to its radius [1/s]."""

ARRIVAL_S = 0.7
"""Time that one stands where it has arrived [s]."""

ARRIVAL_WAY = 2.0
"""Way of one that arrives, relative to its radius."""

MEETING_GAP, PARTING_GAP = 0.5, 1.2
"""Gaps between two who meet, and between two who have parted, relative to the sum of radii."""

SAME_S = 1.5
"""Time within which one event of the same performers is told, the weightiest [s]."""

TELLING_ORDERS = frozenset(
    name
    for name, verb in VERBS.items()
    if verb.ends and verb.targets and not verb.is_aside and name not in ("go_to", "look_at")
)
"""Orders about a member of the cast whose end is an event."""


def story_of(take: Take, tracks: PerformerTracks, cast: Collection[str]) -> tuple[StoryEvent, ...]:
    """Return the events of a take in the order of time.

    Args:
        take: that is filmed.
        tracks: of its performers.
        cast: performers whose events are told.
    """
    teller = _Teller(take, tracks, frozenset(cast))
    found = [
        event
        for events in (
            teller.hugs(),
            teller.cries(),
            teller.strikes(),
            teller.breaks(),
            teller.falls(),
            teller.orders(),
            teller.landings(),
            teller.arrivals(),
            teller.meetings(),
        )
        for event in events
        if event.who and event.who[0] in teller.cast
    ]
    return tuple(sorted(_distinct(found), key=lambda event: (event.time, event.who, event.kind)))


def _distinct(events: Iterable[StoryEvent]) -> list[StoryEvent]:
    """Leave out events of the same performers that a weightier one tells as well."""
    kept: list[StoryEvent] = []
    for event in sorted(events, key=lambda e: (-e.weight, e.time, e.who, e.kind)):
        told = any(
            abs(event.time - other.time) < SAME_S and set(event.who) & set(other.who)
            for other in kept
        )
        if not told:
            kept.append(event)
    return kept


@dataclass(frozen=True, eq=False)
class _Teller:
    """Finds the events of one take."""

    take: Take
    tracks: PerformerTracks
    cast: frozenset[str]

    def hugs(self) -> Iterator[StoryEvent]:
        last: dict[frozenset[str], float] = {}
        for sound in self.take.events:
            if sound.cause != "hug":
                continue
            other = self._owner(sound.other)
            if not other:
                continue
            time, pair = self._time(sound.step, sound.fraction), frozenset((sound.who, other))
            if time - last.get(pair, -10.0) > 2.0 * SAME_S:
                yield self._event("hug", time, time + 1.0, (sound.who, other), "hugs {}")
            last[pair] = time

    def cries(self) -> Iterator[StoryEvent]:
        for sound in self.take.events:
            if sound.cause == "cry":
                time = self._time(sound.step, sound.fraction)
                yield self._event("cry", time, time, (sound.who,), "cries")

    def strikes(self) -> Iterator[StoryEvent]:
        last: dict[frozenset[str], float] = {}
        for contact in self.take.contacts:
            other = self._owner(contact.other)
            if contact.kind != "hit" or contact.speed < LEAST_STRIKE or not other:
                continue
            if other == contact.performer:
                continue
            time, pair = self._time_of(contact), frozenset((contact.performer, other))
            if time - last.get(pair, -10.0) > STRIKE_PAUSE_S:
                who = self._actor_first(contact.performer, other, time)
                yield self._event("strike", time, time, who, "strikes {}")
            last[pair] = time

    def breaks(self) -> Iterator[StoryEvent]:
        """Yield when the bodies of one performer, such as a wall, begin to go to pieces."""
        hits: dict[str, list[float]] = {}
        for sound in self.take.events:
            is_hard = sound.cause == "collision" and sound.strength >= BREAK_SPEED
            if is_hard and self._owner(sound.other) in (sound.who, ""):
                hits.setdefault(sound.who, []).append(self._time(sound.step, sound.fraction))
        for name, times in hits.items():
            k = self.tracks.names.index(name) if name in self.tracks.names else -1
            if k < 0 or self.tracks.jointed[k] or self.tracks.counts[k] < BREAK_HITS:
                continue
            last = -BREAK_PAUSE_S
            for time, later in zip(times, times[BREAK_HITS - 1 :], strict=False):
                if later - time < BREAK_S:
                    if time - last >= BREAK_PAUSE_S:
                        who = (name, *self._breakers(name, time))
                        yield self._event("break", time, time + BREAK_S, who, "breaks")
                    last = time

    def _breakers(self, name: str, time: float) -> list[str]:
        """Return who struck a performer last before its bodies broke apart."""
        struck = [
            other
            for contact in self.take.contacts
            if -SAME_S < self._time_of(contact) - time < BREAK_S
            for one, other in itertools.permutations(
                (contact.performer, self._owner(contact.other))
            )
            if one == name and other not in ("", name)
        ]
        return struck[-1:]

    def falls(self) -> Iterator[StoryEvent]:
        for note in self.take.notes:
            name = self._owner(note.part)
            if note.kind in FALL_NOTES and name:
                time = self._time(note.step, 0.0)
                yield self._event("fall", time, time + 0.5, (name,), "falls")
        for k, name in enumerate(self.tracks.names):
            heights = self.tracks.heights[:, k]
            usual = float(np.median(heights))
            if not self.tracks.jointed[k] or usual <= 0.0:
                continue
            low = heights < FALLEN_HEIGHT * max(usual, float(heights[0]))
            for i in np.flatnonzero(low[1:] & ~low[:-1]) + 1:
                time = float(self.tracks.times[i])
                yield self._event("fall", time - 0.3, time + 0.3, (name,), "falls")

    def orders(self) -> Iterator[StoryEvent]:
        for order in self.take.orders:
            verb, _, target = order.text.partition(" ")
            if order.outcome != "done" or order.end < 0 or order.who not in self.tracks.names:
                continue
            other = self._owner(target.split(" ")[0].strip(",")) if target else ""
            time = self._time(order.end, 0.0)
            if verb == "go_to":
                yield self._event("arrival", time, time, (order.who,), "arrives")
            elif verb in TELLING_ORDERS:
                who = (order.who, other) if other and other != order.who else (order.who,)
                text = f"{verb.replace('_', ' ')} done"
                yield self._event("order", time, time, who, text)

    def landings(self) -> Iterator[StoryEvent]:
        flying: dict[str, float] = {}
        for sound in self.take.events:
            time = self._time(sound.step, sound.fraction)
            if sound.cause in FLIGHT_SOUNDS:
                flying[sound.who] = time
            elif sound.cause in ("footfall", "collision") and sound.who in flying:
                began = flying.pop(sound.who)
                if 0.15 < time - began < LONGEST_FLIGHT_S:
                    yield self._event("landing", time, time, (sound.who,), "lands")

    def arrivals(self) -> Iterator[StoryEvent]:
        least = max(1, round(ARRIVAL_S / self._step))
        for k, name in enumerate(self.tracks.names):
            speed = np.linalg.norm(self.tracks.velocities[:, k], axis=-1) / self.tracks.radii[k]
            start = -1
            for i, value in enumerate(speed):
                if value > ARRIVAL_SPEED:
                    start = i if start < 0 else start
                elif start >= 0 and (speed[i : i + least] < ARRIVED_SPEED).all():
                    way = self.tracks.centers[i, k] - self.tracks.centers[start, k]
                    start = -1
                    is_far = np.linalg.norm(way) > ARRIVAL_WAY * self.tracks.radii[k]
                    if is_far and i + least <= len(speed):
                        time = float(self.tracks.times[i])
                        yield self._event("arrival", time, time, (name,), "arrives")

    def meetings(self) -> Iterator[StoryEvent]:
        jointed = [n for n in self.tracks.names if self.tracks.jointed[self.tracks.number(n)]]
        for one, other in itertools.combinations(jointed, 2):
            a, b = self.tracks.number(one), self.tracks.number(other)
            gap = self.tracks.distance(one, other) / (self.tracks.radii[a] + self.tracks.radii[b])
            apart = bool(gap[0] > PARTING_GAP)
            for i, value in enumerate(gap):
                if value > PARTING_GAP:
                    apart = True
                elif apart and value < MEETING_GAP:
                    apart = False
                    time = float(self.tracks.times[i])
                    who = self._actor_first(one, other, time)
                    yield self._event("meeting", time, time + 0.5, who, "meets {}")

    @property
    def _step(self) -> float:
        times = self.tracks.times
        return float(times[1] - times[0]) if len(times) > 1 else 1.0

    def _time(self, step: int, fraction: float) -> float:
        header = self.take.header
        return float((step + fraction) / (header.rate * header.steps))

    def _time_of(self, contact: Contact) -> float:
        return self._time(contact.step, contact.fraction)

    def _owner(self, name: str) -> str:
        """Return the performer that something is a part of, "" for the ground."""
        return self._owners.get(name) or self._owners.get(name.partition(".")[0], "")

    @cached_property
    def _owners(self) -> Mapping[str, str]:
        """Performer of each part and of each performer's own name."""
        own = {name: name for name in self.tracks.names}
        return {**own, **{part.name: part.performer for part in self.take.parts}}

    def _actor_first(self, one: str, other: str, time: float) -> tuple[str, str]:
        """Return two performers, the one with joints first, or the quicker one."""

        def rank(name: str) -> tuple[bool, float]:
            k = self.tracks.number(name)
            speed = float(np.linalg.norm(self.tracks.velocity(name, time)))
            return bool(self.tracks.jointed[k]), round(speed / self.tracks.radii[k], 3)

        return (one, other) if rank(one) >= rank(other) else (other, one)

    def _event(
        self, kind: StoryKind, time: float, until: float, who: tuple[str, ...], text: str
    ) -> StoryEvent:
        told = f"{who[0]} {text.format(who[-1])}"
        return StoryEvent(kind, round(time, 4), round(until, 4), who, told)
