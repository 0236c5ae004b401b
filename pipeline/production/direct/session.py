"""Session: a directed scene and its RPC methods."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

import pipeline
from pipeline.errors import Problem, PronkError, SceneError, SimulationError
from pipeline.production.direct.access_token import HELLO
from pipeline.production.direct.notification_queue import (
    EVENT_KINDS,
    Notification,
    NotificationQueue,
)
from pipeline.production.direct.protocol import Method, OutOfOrder
from pipeline.production.direct.request_params import (
    EndParams,
    HelloParams,
    QueryParams,
    StepParams,
    SubscribeParams,
    read_params,
)
from pipeline.production.direct.scene_recorder import RecordedScene, SceneRecorder
from pipeline.production.direct.state_queries import StateQueries
from pipeline.production.run.interrupts import held_back
from pipeline.simulation.simulate import COMMAND, Simulation
from pipeline.spec import Scene
from pipeline.spec.rpc_instruction import instruction_of
from pipeline.spec.scene import MAX_INSTRUCTIONS
from pipeline.spec.suggestions import hint

ALL_EVENTS = "*"

Params = Mapping[str, Any]
Notify = Callable[[Notification], None]


def without_beats(scene: Scene) -> Scene:
    """Return a scene whose story keeps its relations and goals alone: another program directs."""
    if scene.story is None or not scene.story.beats:
        return scene
    story = scene.story.model_copy(update={"beats": (), "tension": ()})
    return scene.model_copy(update={"story": story})


class Session:
    """A scene while it is directed.

    The beats of its story are not played: another program directs.

    Attributes:
        recorded: files of the scene, once it has ended.
        notify: receives the events of the subscription.
    """

    def __init__(self, scene: Scene, recorder: SceneRecorder) -> None:
        self.scene = scene = without_beats(scene)
        self.simulation = Simulation(scene, directed=True)
        self.recorded: RecordedScene | None = None
        self.notify: Notify = lambda event: None
        self._recorder = recorder
        self._queue = NotificationQueue(self.simulation)
        self._queries = StateQueries(scene, self.simulation)
        self._events: frozenset[str] = frozenset()
        self._who: frozenset[str] = frozenset()
        self._failure: PronkError | None = None

    @property
    def goes_on(self) -> bool:
        """Whether the scene has neither ended nor failed."""
        return self.recorded is None and self._failure is None

    @property
    def methods(self) -> Mapping[str, Method]:
        """The RPC methods by name."""
        return {
            HELLO: self.hello,
            "step": self.step,
            "command": self.command,
            "query": self.query,
            "subscribe": self.subscribe,
            "end": self.end,
        }

    # --- methods ------------------------------------------------------------------

    def hello(self, params: Params) -> object:
        """Return the version of pronk and the time; a port has checked the token before."""
        read_params(HelloParams, params)
        return {"pronk": pipeline.__version__, **self._queries.time()}

    def step(self, params: Params) -> object:
        """Step to a limit; return the time and the events that ended the step."""
        request = read_params(StepParams, params)
        kinds = self._kinds(request.event, "event")
        who = self._names(request.who)
        self._refuse_after_end()
        last, met = self._last_step(request), list[Notification]()
        while self.simulation.step_number < last and not met:
            met = [event for event in self._advance() if _matches(event, kinds, who)]
        return {**self._queries.time(), "happened": met}

    def command(self, params: Params) -> object:
        """Give an instruction and return the time."""
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
            raise SceneError(
                [Problem(p.path.removeprefix(f"{COMMAND}."), p.message) for p in error.problems]
            ) from None
        return self._queries.time()

    def query(self, params: Params) -> object:
        """Return the state of the simulation by topic."""
        request = read_params(QueryParams, params)
        return self._queries.state(request.what, self._names(request.who))

    def subscribe(self, params: Params) -> object:
        """Notify of some kinds of events from now on; return the kinds."""
        request = read_params(SubscribeParams, params)
        events, who = self._kinds(request.events, "events"), self._names(request.who)
        self._events, self._who = events, who
        return {"events": sorted(events)}

    def end(self, params: Params) -> object:
        """End the scene and return its files."""
        request = read_params(EndParams, params)
        self._refuse_after_end()
        recorded = self.finish(end_now=request.at == "now")
        return {
            "scene": str(recorded.scene),
            "take": str(recorded.take),
            "digest": recorded.digest,
            "frames": recorded.frames,
        }

    def finish(self, end_now: bool = False) -> RecordedScene:
        """Simulate to the end, unless it is now, and write scene and take.

        Raises:
            PronkError: the simulation failed, or something cannot be written.
        """
        if not end_now:
            # Early, so that the commands survive whatever happens until the end.
            self._recorder.write_scene(self.scene, self.simulation, end_now=False)
            while not self.simulation.finished:
                self._advance()
        if self._failure is not None:
            raise self._failure
        self.recorded = self._recorder.record(self.scene, self.simulation, end_now)
        return self.recorded

    # --- helpers ------------------------------------------------------------------

    def _advance(self) -> list[Notification]:
        """Take one step, notify of its events, and return them."""
        if self._failure is not None:
            raise self._failure
        try:
            with held_back():
                self.simulation.step()
        except PronkError as error:
            self._failure = error
            raise
        except Exception as error:
            # The simulation cannot go on from half a step.
            self._failure = SimulationError(f"the simulation failed: {error!r}")
            raise self._failure from error
        events = self._queue.since_last_call()
        for event in events:
            if _matches(event, self._events, self._who):
                self.notify(event)
        return events

    def _last_step(self, request: StepParams) -> int:
        """Return the last step that a request allows."""
        clock, now = self.simulation.world.clock, self.simulation.step_number
        limits = [clock.last_step]
        if request.until is not None:
            limits.append(clock.step_from(request.until))
            if limits[-1] < now:
                text = f"is over: the scene is at {float(clock.time_of(now)):.4g} s"
                raise SceneError([Problem("until", text)])
        if request.frames is not None:
            limits.append(now + request.frames * clock.steps)
        if request.steps is not None or (len(limits) == 1 and not request.event):
            limits.append(now + (request.steps or 1))
        return min(limits)

    def _refuse_after_end(self) -> None:
        if self.recorded is not None:
            raise OutOfOrder("the scene has ended, and its take is written")
        if self._failure is not None:
            raise self._failure

    def _kinds(self, kinds: Collection[str], path: str) -> frozenset[str]:
        if ALL_EVENTS in kinds:
            return frozenset(EVENT_KINDS)
        _refuse_unknown_names(kinds, EVENT_KINDS, path, "no kind of event is called")
        return frozenset(kinds)

    def _names(self, names: Collection[str]) -> frozenset[str]:
        _refuse_unknown_names(names, self._queries.names, "who", "nobody in the cast is called")
        return frozenset(names)


def _matches(event: Notification, kinds: Collection[str], who: Collection[str]) -> bool:
    return event["kind"] in kinds and (not who or event["who"] in who or event["other"] in who)


def _refuse_unknown_names(
    names: Iterable[str], known: Collection[str], path: str, message: str
) -> None:
    """Refuse unknown names.

    Raises:
        SceneError: with a problem for each of them.
    """
    problems = [
        Problem(f"{path}[{i}]", f"{message} '{name[:60]}', {hint(name, known)}")
        for i, name in enumerate(names)
        if name not in known
    ]
    if problems:
        raise SceneError(problems)
