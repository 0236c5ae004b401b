"""Session: one scene that is directed, and the methods by which that is done."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from pipeline.errors import Problem, PronkError, SceneError, SimulationError
from pipeline.production.direct.notifications import ALL_KINDS, Item, News
from pipeline.production.direct.protocol import Method, OutOfOrder
from pipeline.production.direct.queries import Answers
from pipeline.production.direct.recording import Kept, Place
from pipeline.production.direct.requests import (
    EndWords,
    QueryWords,
    StepWords,
    SubscribeWords,
    read,
)
from pipeline.production.run.interrupts import held_back
from pipeline.simulation.simulate import COMMAND, Simulation
from pipeline.spec import Scene
from pipeline.spec.rpc_instruction import instruction_of
from pipeline.spec.scene import MAX_INSTRUCTIONS
from pipeline.spec.suggestions import hint

EVERYTHING = "*"

Params = Mapping[str, Any]
Tell = Callable[[Item], None]


class Session:
    """A scene while it is directed.

    Attributes:
        kept: what was written, once it has ended.
        tell: takes what was subscribed to, as it happens.
    """

    def __init__(self, scene: Scene, place: Place) -> None:
        self.scene = scene
        self.simulation = Simulation(scene, directed=True)
        self.kept: Kept | None = None
        self.tell: Tell = _nobody
        self._place = place
        self._news = News(self.simulation)
        self._answers = Answers(scene, self.simulation)
        self._events: frozenset[str] = frozenset()
        self._who: frozenset[str] = frozenset()
        self._broken: PronkError | None = None

    @property
    def methods(self) -> Mapping[str, Method]:
        """What can be asked of it."""
        return {
            "step": self.step,
            "command": self.command,
            "query": self.query,
            "subscribe": self.subscribe,
            "end": self.end,
        }

    # --- methods ------------------------------------------------------------------

    def step(self, params: Params) -> object:
        """Go on; return where it is then, and what it was to go on until."""
        said = read(StepWords, params)
        kinds = self._kinds(said.event, "event")
        who = self._names(said.who)
        self._refuse_after_end()
        last, met = self._last(said), list[Item]()
        while self.simulation.step_number < last and not met:
            met = [one for one in self._advance() if _is_of(one, kinds, who)]
        return {**self._answers.time(), "happened": met}

    def command(self, params: Params) -> object:
        """Let somebody do something, now or when the words say so."""
        self._refuse_after_end()
        clock, step = self.simulation.world.clock, self.simulation.step_number
        instruction = instruction_of(params, self.scene, float(clock.time_of(step)))
        script = self.simulation.script
        given = len(self.scene.script) + len(script.told) + script.due_from_outside
        if given >= MAX_INSTRUCTIONS:
            text = f"a scene holds at most {MAX_INSTRUCTIONS} instructions"
            raise SceneError([Problem("", text)])
        try:
            self.simulation.add_instruction(instruction)
        except SceneError as error:
            problems = error.problems
            raise SceneError(
                [Problem(one.path.removeprefix(f"{COMMAND}."), one.message) for one in problems]
            ) from None
        return self._answers.time()

    def query(self, params: Params) -> object:
        """Tell about the scene as it is now."""
        said = read(QueryWords, params)
        return self._answers.about(said.what, self._names(said.who))

    def subscribe(self, params: Params) -> object:
        """Tell of some kinds of things from now on, when they happen."""
        said = read(SubscribeWords, params)
        events, who = self._kinds(said.events, "events"), self._names(said.who)
        self._events, self._who = events, who
        return {"events": sorted(events)}

    def end(self, params: Params) -> object:
        """End the scene, now or when it ends, and write what became of it."""
        said = read(EndWords, params)
        self._refuse_after_end()
        kept = self.finish(now=said.at == "now")
        return {
            "scene": str(kept.scene),
            "take": str(kept.take),
            "digest": kept.digest,
            "frames": kept.frames,
        }

    def finish(self, now: bool = False) -> Kept:
        """Go on to the end, unless it is `now`, and write what became of the scene.

        Raises:
            PronkError: the simulation failed, or something cannot be written.
        """
        if not now:
            # Whatever happens until the end, what was told is not lost.
            self._place.write(self.scene, self.simulation, now=False)
            while not self.simulation.finished:
                self._advance()
        if self._broken is not None:
            raise self._broken
        self.kept = self._place.keep(self.scene, self.simulation, now)
        return self.kept

    # --- how ----------------------------------------------------------------------

    def _advance(self) -> list[Item]:
        """Go on by a step, tell of it, and return what has happened."""
        if self._broken is not None:
            raise self._broken
        try:
            with held_back():
                self.simulation.step()
        except PronkError as error:
            self._broken = error
            raise
        except Exception as error:
            # Half a step is no state to go on from.
            self._broken = SimulationError(f"the simulation failed: {error!r}")
            raise self._broken from error
        news = self._news.since()
        for one in news:
            if _is_of(one, self._events, self._who):
                self.tell(one)
        return news

    def _last(self, said: StepWords) -> int:
        """Return the step to go on to at most."""
        clock, now = self.simulation.world.clock, self.simulation.step_number
        limits = [clock.last_step]
        if said.until is not None:
            limits.append(clock.step_from(said.until))
            if limits[-1] < now:
                text = f"is over: the scene is at {float(clock.time_of(now)):.4g} s"
                raise SceneError([Problem("until", text)])
        if said.frames is not None:
            limits.append(now + said.frames * clock.steps)
        if said.steps is not None or (len(limits) == 1 and not said.event):
            limits.append(now + (said.steps or 1))
        return min(limits)

    def _refuse_after_end(self) -> None:
        if self.kept is not None:
            raise OutOfOrder("the scene has ended, and its take is written")
        if self._broken is not None:
            raise self._broken

    def _kinds(self, said: Collection[str], where: str) -> frozenset[str]:
        if EVERYTHING in said:
            return frozenset(ALL_KINDS)
        _refuse_unknown(said, ALL_KINDS, where, "nothing that happens is called")
        return frozenset(said)

    def _names(self, said: Collection[str]) -> frozenset[str]:
        _refuse_unknown(said, self._answers.names, "who", "nobody in the cast is called")
        return frozenset(said)


def _nobody(item: Item) -> None:
    """Tell nobody."""


def _is_of(one: Item, kinds: Collection[str], who: Collection[str]) -> bool:
    return one["kind"] in kinds and (not who or one["who"] in who or one["other"] in who)


def _refuse_unknown(said: Iterable[str], known: Collection[str], where: str, message: str) -> None:
    """Refuse names of what there is none.

    Raises:
        SceneError: for those that are unknown.
    """
    problems = [
        Problem(f"{where}[{i}]", f"{message} '{name[:60]}', {hint(name, known)}")
        for i, name in enumerate(said)
        if name not in known
    ]
    if problems:
        raise SceneError(problems)
