"""Beat sequence: which beats of a story come after which, and which can never come."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pipeline.spec.model_base import Fault
from pipeline.spec.partial_scene import Path, items_of, items_or_itself, value_at
from pipeline.spec.suggestions import hint


@dataclass(frozen=True, slots=True)
class Link:
    """A beat or choice that a condition names, and where."""

    name: str
    path: Path

    @property
    def beat(self) -> str:
        """The beat, of which it may name a choice."""
        return self.name.partition(".")[0]


@dataclass(frozen=True, slots=True)
class Step:
    """A beat in the sequence.

    Attributes:
        path: of the beat.
        after: what must be over before it.
        without: what must not have been played.
        begins: earliest and latest time at which it may begin by itself [s].
        choices: names of its choices.
        repeats: whether it can be played again.
    """

    path: Path
    after: Sequence[Link]
    without: Sequence[Link]
    begins: tuple[float, float]
    choices: frozenset[str]
    repeats: bool


@dataclass(frozen=True)
class BeatSequence:
    """All beats of a story by name.

    Attributes:
        steps: the beats.
        length: of the film [s], infinite if unknown.
        choice_links: what the conditions of choices name.
        faults: names that are used twice.
    """

    steps: Mapping[str, Step]
    length: float
    choice_links: Sequence[Link] = ()
    faults: Sequence[Fault] = field(default_factory=list)

    @staticmethod
    def of(scene: object) -> BeatSequence:
        """Return the sequence of a scene."""
        steps, links, faults = dict[str, Step](), list[Link](), list[Fault]()
        for b, beat in items_of(value_at(value_at(scene, "story"), "beats")):
            path: Path = ("story", "beats", b)
            when = value_at(beat, "when")
            choices = dict[str, int]()
            for c, choice in items_of(value_at(beat, "choices")):
                place = (*path, "choices", c)
                own = value_at(choice, "name")
                if isinstance(own, str) and own in choices:
                    message = f"the name '{own}' is taken by choices[{choices[own]}] of this beat"
                    faults.append(Fault((*place, "name"), message))
                if isinstance(own, str):
                    choices.setdefault(own, c)
                for key in ("after", "without"):
                    links += _links(value_at(choice, "when"), (*place, "when"), key)
            name = value_at(beat, "name")
            if not isinstance(name, str):
                continue
            if name in steps:
                message = f"the name '{name}' is taken by {_text(steps[name].path)}"
                faults.append(Fault((*path, "name"), message))
                continue
            steps[name] = Step(
                path,
                _links(when, (*path, "when"), "after"),
                _links(when, (*path, "when"), "without"),
                _times(value_at(when, "time")),
                frozenset(choices),
                value_at(beat, "repeat") is True,
            )
        return BeatSequence(steps, _film_length(scene), links, faults)

    # --- names ------------------------------------------------------------------------

    def faults_of_names(self) -> Iterator[Fault]:
        """Find names that are used twice, and conditions that name no beat."""
        yield from self.faults
        links = [link for step in self.steps.values() for link in (*step.after, *step.without)]
        for link in (*links, *self.choice_links):
            beat, _, choice = link.name.partition(".")
            if beat not in self.steps:
                message = f"no beat is called '{beat}', {hint(beat, self.steps)}"
                yield Fault(link.path, message)
            elif choice and choice not in self.steps[beat].choices:
                known = self.steps[beat].choices
                message = f"no choice of '{beat}' is called '{choice}', {hint(choice, known)}"
                yield Fault(link.path, message)

    # --- order ------------------------------------------------------------------------

    def faults_of_order(self) -> Iterator[Fault]:
        """Find beats that can never come: by a circle, by one another, or by time."""
        circles = list(self._circles())
        yield from (fault for fault, _ in circles)
        lost = {name for _, names in circles for name in names}
        for name, step in self.steps.items():
            needed = self._needed(name)
            if lost & {name, *(link.beat for link in needed)}:
                continue
            yield from self._faults_of_exclusion(name, step, needed)
            yield from self._faults_of_time(name, step)

    def _circles(self) -> Iterator[tuple[Fault, Sequence[str]]]:
        """Yield each circle of beats that come after one another, with its beats."""
        done = set[str]()
        for name in self.steps:
            way: list[str] = []
            if name not in done and (circle := self._circle_from(name, way, done)):
                first, link = circle[0], self._link(circle[0], circle[1 % len(circle)])
                texts = [f"'{beat}'" for beat in (*circle, first)]
                message = f"goes round in a circle: {' after '.join(texts)}; remove one"
                yield Fault(link.path, message), circle

    def _circle_from(self, name: str, way: list[str], done: set[str]) -> list[str]:
        if name in way:
            return way[way.index(name) :]
        if name in done or name not in self.steps:
            return []
        for link in self.steps[name].after:
            if circle := self._circle_from(link.beat, [*way, name], done):
                done.add(name)
                return circle
        done.add(name)
        return []

    def _link(self, name: str, before: str) -> Link:
        return next(link for link in self.steps[name].after if link.beat == before)

    def _needed(self, name: str) -> list[Link]:
        """Return all that must be over before a beat, with the conditions that say so."""
        found = dict[str, Link]()
        waiting = [*self.steps[name].after]
        while waiting:
            link = waiting.pop(0)
            if link.name not in found:
                found[link.name] = link
                if link.beat in self.steps:
                    waiting += self.steps[link.beat].after
        return list(found.values())

    def _faults_of_exclusion(
        self, name: str, step: Step, needed: Sequence[Link]
    ) -> Iterator[Fault]:
        for link in step.without:
            if link.name == name:
                yield Fault(link.path, f"'{name}' excludes itself; remove this")
                continue
            found = next((n for n in needed if link.name in (n.name, n.beat)), None)
            if found is not None:
                message = f"'{name}' never comes: it needs '{found.name}', and excludes it"
                yield Fault(link.path, f"{message}; remove one")
        picked = dict[str, Link]()
        for link in needed:
            other = picked.setdefault(link.beat, link) if "." in link.name else link
            known = link.beat in self.steps and not self.steps[link.beat].repeats
            if other.name != link.name and known:
                message = (
                    f"'{name}' never comes: it needs '{other.name}' and '{link.name}', and "
                    f"'{link.beat}' is played once; remove one, or let it repeat"
                )
                yield Fault(step.path, message)

    def _faults_of_time(self, name: str, step: Step) -> Iterator[Fault]:
        first, last = step.begins
        path = (*step.path, "when", "time")
        if first > last:
            yield Fault(path, f"holds no time; write [{last:g}, {first:g}]")
            return
        if first >= self.length:
            message = f"'{name}' never comes: the film ends at {self.length:g} s"
            yield Fault(path, message)
            return
        for link in self._needed(name):
            if link.beat in self.steps and (begin := self.steps[link.beat].begins[0]) > last:
                message = (
                    f"'{name}' never comes: it begins by {last:g} s, but comes after "
                    f"'{link.beat}', which begins at {begin:g} s or later"
                )
                yield Fault(path, message)
                return


def _links(when: object, path: Path, key: str) -> list[Link]:
    return [
        Link(name, (*path, key, *place))
        for place, name in items_or_itself(value_at(when, key))
        if isinstance(name, str)
    ]


def _text(path: Path) -> str:
    return f"story.beats[{path[2]}]"


def _times(window: object) -> tuple[float, float]:
    if isinstance(window, list | tuple) and len(window) == 2:
        first, last = window
        if _is_number(first) and _is_number(last):
            return float(first), float(last)
    return 0.0, float("inf")


def _film_length(scene: object) -> float:
    """Return the length of the film [s], infinite where no seconds are written."""
    duration: Any = value_at(scene, "duration")
    return float(duration) if _is_number(duration) and duration > 0 else float("inf")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
