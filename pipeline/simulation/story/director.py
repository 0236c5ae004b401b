"""Director: plays the beats of a story one after the other, each picked by the state of the scene.

Source: Mateas and Stern 2003, "Façade: an experiment in building a fully-realized interactive
    drama"; 2005, "Structuring content in the Façade interactive drama architecture".
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

from pipeline.simulation.clock import Clock
from pipeline.simulation.script import Event, Script, event_of
from pipeline.simulation.seeds import generator
from pipeline.simulation.story.beat_selection import (
    FAR_TENSION,
    Candidate,
    draw,
    highest,
    shares,
    tension_gap,
)
from pipeline.simulation.story.situation import Progress, Stage, event_text, met, unmet
from pipeline.simulation.story.tension import RESPONSE_TIME, wanted_tension
from pipeline.simulation.take import BeatRecord
from pipeline.spec.behaviour import FORMS
from pipeline.spec.script import Do, SetUrges, Wait, When
from pipeline.spec.story import Beat, BeatOrder, Choice, Situation, Story, StoryGoal

MOST_TIME = 12.0
"""Time after which a beat is over whose end does not come by itself [s]."""

NO_URGE = -2.0
"""Added to a behaviour whose goal is reached, so that it is not chosen any more."""


@dataclass(eq=False)
class Playing:
    """The present beat.

    Attributes:
        beat: the beat.
        orders: of it and of its choice.
        begun: step at which it began.
        number: of its record.
    """

    beat: Beat
    orders: Sequence[BeatOrder]
    begun: int
    number: int


class StoryDirector:
    """Sequences the beats of a story.

    Args:
        story: of the scene.
        clock: of the scene.
        seed: of the scene.
        script: that gives the orders of beats.
        is_open: tells whether an order to a performer has not ended.
        stage: the state of the simulation.

    Attributes:
        records: of the beats and goals so far.
    """

    def __init__(
        self,
        story: Story,
        clock: Clock,
        seed: int,
        script: Script,
        is_open: Callable[[str, Do], bool],
        stage: Stage,
    ) -> None:
        self._story, self._clock, self._script = story, clock, script
        self._is_open, self._stage = is_open, stage
        self._rng = generator(seed, "story.beats")
        self._progress = Progress()
        self._playing: Playing | None = None
        # Step since which beats wait for their tension, -1 while none does.
        self._waiting_since = -1
        self.records: list[BeatRecord] = []

    @property
    def awaited(self) -> set[Event]:
        """Events that conditions, goals and the present beat wait for."""
        found = set(map(event_of, self._awaited_by_conditions()))
        found.update(event_of(goal.until) for goal in self._open_goals())
        if self._playing is not None:
            found.update(map(event_of, self._playing.beat.until))
        return found

    def _awaited_by_conditions(self) -> Iterator[When]:
        for beat in self._story.beats:
            if self._may_come(beat):
                for situation in (beat.when, *(choice.when for choice in beat.choices)):
                    yield from situation.happened
                    yield from situation.not_happened

    def _open_goals(self) -> list[StoryGoal]:
        return [goal for goal in self._story.goals if goal.name not in self._progress.reached]

    def _may_come(self, beat: Beat) -> bool:
        return beat.repeat or not any(record.name == beat.name for record in self.records)

    def advance(self, step: int, events: Collection[Event]) -> None:
        """Ends the present beat if it is over, and begins the next, before a step is taken."""
        self._progress.happened.update(events)
        self._reach_goals(step, events)
        if self._playing is not None and (reason := self._end_reason(step, events)):
            self._end(step, reason)
        # Conditions on distances need rows, which are cheaper to compute in batches.
        if self._playing is None and step % self._clock.steps == 0:
            self._begin_next(step)

    # --- goals ------------------------------------------------------------------------

    def _reach_goals(self, step: int, events: Collection[Event]) -> None:
        for goal in self._open_goals():
            if event_of(goal.until) not in events:
                continue
            self._progress.reached.add(goal.name)
            kind = next(key for key, form in FORMS.items() if isinstance(goal.wants, form))
            order = SetUrges(urge={kind: NO_URGE})
            self._script.add([BeatOrder(who=goal.who, do=order)], step)
            reason = event_text(goal.until)
            self.records.append(BeatRecord(goal.name, "", step, step, "reached", reason))

    # --- the end of a beat ------------------------------------------------------------

    def _end_reason(self, step: int, events: Collection[Event]) -> str:
        """Returns why the present beat is over, "" while it is not."""
        assert self._playing is not None
        beat, played = self._playing.beat, step - self._playing.begun
        for when in beat.until:
            if played and event_of(when) in events:
                return event_text(when)
        most = beat.lasts if beat.lasts is not None else MOST_TIME
        if played >= self._clock.step_from(most):
            return f"{most:g} s are over"
        waits = beat.until or beat.lasts is not None
        return "" if waits or not self._is_done(played) else "all is done"

    def _is_done(self, played: int) -> bool:
        """Returns whether all orders of the present beat are given and have ended."""
        assert self._playing is not None
        orders = self._playing.orders
        if self._script.is_pending(orders):
            return False
        times = (
            self._clock.step_from((order.at or 0.0) + order.do.wait)
            for order in orders
            if isinstance(order.do, Wait)
        )
        is_open = any(self._is_open(order.who, order.do) for order in orders)
        return played > max(times, default=0) and not is_open

    def _end(self, step: int, reason: str) -> None:
        assert self._playing is not None
        playing, self._playing = self._playing, None
        self._script.withdraw(playing.orders)
        record = self.records[playing.number]
        self.records[playing.number] = record.ended(step, "played", reason)
        self._progress.played.add(record.name)
        if record.choice:
            self._progress.played.add(f"{record.name}.{record.choice}")

    # --- the next beat ----------------------------------------------------------------

    def _begin_next(self, step: int) -> None:
        time = float(self._clock.time_of(step))
        able = highest(list(self._candidates(time)))
        if not able:
            self._waiting_since = -1
            return
        wanted = wanted_tension(self._story.tension, time + RESPONSE_TIME)
        if self._waits(able, time, step):
            return
        self._waiting_since = -1
        chance = float(self._rng.random())
        picked = able[draw(able, wanted, chance)]
        beat = next(beat for beat in self._story.beats if beat.name == picked.name)
        choice, chosen = self._choice(beat, time, wanted)
        tension = beat.tension if choice is None or choice.tension is None else choice.tension
        orders = (*beat.do, *(choice.do if choice is not None else ()))
        reason = "; ".join(filter(None, (_reason(picked, able, wanted), chosen)))
        name = choice.name if choice is not None else ""
        record = BeatRecord(beat.name, name, step, -1, "playing", reason, tension)
        self.records.append(record)
        self._playing = Playing(beat, orders, step, len(self.records) - 1)
        self._script.add(orders, step)

    def _candidates(self, time: float) -> Iterator[Candidate]:
        """Yields the beats whose conditions hold."""
        for beat in self._story.beats:
            if not self._may_come(beat) or self._unmet(beat.when, time):
                continue
            tension = beat.tension
            if beat.choices:
                fitting = [one for one in beat.choices if not self._unmet(one.when, time)]
                if not fitting:
                    continue
                levels = [one.tension for one in fitting if one.tension is not None]
                tension = sum(levels) / len(levels) if levels else tension
            reason = met(beat.when, time, self._progress, self._stage)
            yield Candidate(beat.name, beat.weight, tension, beat.priority, reason)

    def _choice(self, beat: Beat, time: float, wanted: float | None) -> tuple[Choice | None, str]:
        """Returns the way in which a beat is played, None for its only one, and why."""
        fitting = [one for one in beat.choices if not self._unmet(one.when, time)]
        if not fitting:
            return None, ""
        able = [
            Candidate(
                one.name,
                one.weight,
                beat.tension if one.tension is None else one.tension,
                reason=met(one.when, time, self._progress, self._stage),
            )
            for one in fitting
        ]
        k = draw(able, wanted, float(self._rng.random()))
        return fitting[k], f"by {_reason(able[k], able, None)}"

    def _unmet(self, situation: Situation, time: float) -> str:
        return unmet(situation, time, self._progress, self._stage)

    def _waits(self, able: Sequence[Candidate], time: float, step: int) -> bool:
        """Returns whether all candidates are put off, for the wanted tension comes nearer."""
        if self._waiting_since < 0:
            self._waiting_since = step
        left = self._story.patience - float(self._clock.time_of(step - self._waiting_since))
        if left <= 0.0:
            return False
        now = self._gap(able, time)
        # A second at a time, for a curve may come near and leave again.
        later = [self._gap(able, time + min(ahead, left)) for ahead in (0.5, 1.0, 2.0, left)]
        return now > FAR_TENSION and min(later) < now

    def _gap(self, able: Iterable[Candidate], time: float) -> float:
        wanted = wanted_tension(self._story.tension, time + RESPONSE_TIME)
        return min(tension_gap(one, wanted) for one in able)

    # --- the end of the film ----------------------------------------------------------

    def finish(self, step: int) -> None:
        """Records what the end of the film cuts off, and what was never played or reached."""
        time = float(self._clock.time_of(step))
        played = {record.name for record in self.records}
        if self._playing is not None:
            number = self._playing.number
            self.records[number] = self.records[number].ended(step, "cut off", "")
        for beat in self._story.beats:
            if beat.name not in played:
                reason = self._unmet(beat.when, time) or self._unfit(beat, time)
                record = BeatRecord(beat.name, "", step, step, "never played", reason)
                self.records.append(record)
        for goal in self._open_goals():
            reason = f"{event_text(goal.until)} has not happened"
            self.records.append(BeatRecord(goal.name, "", step, step, "never reached", reason))

    def _unfit(self, beat: Beat, time: float) -> str:
        """Returns why a beat was not played whose conditions hold at the end of the film."""
        if beat.choices and all(self._unmet(one.when, time) for one in beat.choices):
            first = beat.choices[0]
            return f"none of its choices fits: {self._unmet(first.when, time)}"
        return "other beats were picked until the film ended"


def _reason(picked: Candidate, able: Sequence[Candidate], wanted: float | None) -> str:
    """Returns why a candidate was picked, such as `after quarrel; tension 0.8 for 0.7`."""
    texts = [picked.reason]
    if wanted is not None:
        texts.append(f"tension {picked.tension:g} where {wanted:.2f} is wanted")
    if len(able) > 1:
        odds = shares(able, wanted)
        each = [f"{one.name} {share:.0%}" for one, share in zip(able, odds, strict=True)]
        texts.append(f"drawn from {', '.join(each)}")
    return "; ".join(filter(None, texts)) or "nothing else can be played"
