"""Directing by another program: queries, commands, and takes that replay."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pipeline.production.direct.notification_queue import EVENT_KINDS
from pipeline.production.direct.session import Session
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import NEVER_GIVEN
from pipeline.simulation.take_store import read_take
from pipeline.spec import load_scene, read_scene
from tests.production.direct.direct_client import (
    FRAMES,
    asked,
    replayed,
    request,
    served,
    session_in,
    stage,
)

PLAN: list[tuple[int, dict[str, Any]]] = [
    (0, {"who": "bug", "do": {"turn_deg": 40}}),
    (20, {"who": "bug", "do": {"go_to": [1, 0.5]}}),
    (28, {"who": "bug", "do": {"wait": 0.1}}),
    (28, {"who": "bug", "do": {"speed": 0.9}}),
    (30, {"who": "roo", "do": {"hop_over": "box"}, "when": {"arrived": "bug"}}),
    (33, {"who": "roo", "do": {"jump": {"height": 0.15}}, "at": 0.5}),
    (90, {"who": "bug", "do": {"jump": {}}}),
    (120, {"who": "bug", "do": {"gait": "wave", "speed": 0.3}}),
]


def _directed(folder: Path, every: int, end: str = "end", until: int = 10**6) -> Any:
    """Carry out the plan with queries in between; return the answer to `end`."""
    ask = asked(session_in(folder))
    now = 0
    for step, command in PLAN:
        if step > until:
            break
        while now < step:
            now = ask("step")["step"]
            if every and now % every == 0:
                ask("query", what=["poses", "channels", "places", "notes"])
        assert "code" not in ask("command", **command)
    return ask("end", at=end)


@pytest.mark.nightly
def test_commands_replay_to_the_same_bytes_whatever_is_queried(
    tmp_path: Path,
) -> None:
    kept = [_directed(tmp_path / str(every), every) for every in (0, 1)]
    assert len({one["digest"] for one in kept}) == 1
    again = replayed(kept[0]["scene"])
    assert again.digest == kept[0]["digest"] == read_take(Path(kept[0]["take"])).digest
    given = [order for order in again.orders if order.outcome != NEVER_GIVEN]
    # Two wait for an event in vain, and two waits are followed by a walk.
    assert len(given) == len(PLAN) + len(stage().script)
    assert again.digest != simulate(stage()).digest


@pytest.mark.nightly
def test_a_scene_that_ends_now_has_the_simulated_length_and_replays(tmp_path: Path) -> None:
    kept = _directed(tmp_path, 5, "now", until=33)
    scene, again = load_scene(kept["scene"]), replayed(kept["scene"])
    assert again.digest == kept["digest"]
    assert kept["frames"] == scene.n_frames == -(-33 // 4)
    assert scene.golden.frames == (1,)
    live = asked(session := session_in(tmp_path / "live"))
    for step, command in PLAN[:6]:
        live("step", until=step / 96)
        live("command", **command)
    live("step", frames=1)
    row = session.simulation.last_row()
    rows = slice(0, min(row, len(again.positions) - 1))
    assert (session.simulation.recorder.positions[rows] == again.positions[rows]).all()


@pytest.mark.nightly
def test_without_commands_the_take_is_that_of_the_scene(tmp_path: Path) -> None:
    plain = stage()
    kept = asked(session_in(tmp_path, plain))("end")
    assert load_scene(kept["scene"]) == plain
    assert read_take(Path(kept["take"])).positions.tobytes() == simulate(plain).positions.tobytes()


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Return a session after two steps, which no test advances."""
    session = session_in(tmp_path_factory.mktemp("begun"))
    asked(session)("step", steps=2)
    return session


@pytest.mark.parametrize(
    ("command", "path", "right"),
    [
        ({"who": "bgu", "do": "stop"}, "who", "did you mean 'bug'?"),
        ({"who": "bug", "do": "stpo"}, "do", "did you mean 'stop'?"),
        ({"who": "bug"}, "do", "is missing"),
        ({"who": "bug", "do": {"go_to": [1]}}, "do.go_to", "must hold 2 values, holds 1"),
        ({"who": "bug", "do": {"go_too": [1, 1]}}, "do.go_too", "did you mean 'go_to'?"),
        (
            {"who": "bug", "do": {"gait": "canter"}},
            "do.gait",
            "take auto, trot, wave, tripod or ripple",
        ),
        ({"who": "bug", "do": {"hop_over": "bug"}}, "do.hop_over", "cannot do that to itself"),
        (
            {"who": "roo", "do": {"gait": "trot"}},
            "do.gait",
            "hops, for which gait is no order",
        ),
        (
            {"who": "roo", "do": {"jump": {"speed": 1, "height": 3}}},
            "do.jump.speed",
            "take speed: ",
        ),
        ({"who": "box", "do": "stop"}, "who", "is a prop, which no script moves"),
        ({"who": "bug", "do": "stop", "at": 0.01}, "at", "is over: the scene is at 0.02083 s"),
        ({"who": "bug", "do": "stop", "at": 2.0}, "at", "never comes: the scene ends at 2 s"),
        ({"who": "bug", "do": "stop", "at": 1, "when": {"arrived": "bug"}}, "", "either at or"),
        ({"who": "bug", "do": "stop", "when": {"arrived": "x"}}, "when.arrived", "known: "),
    ],
)
def test_a_wrong_command_is_refused_with_path_and_suggestion(
    command: dict[str, Any], path: str, right: str, begun: Session
) -> None:
    error = asked(begun)("command", **command)
    assert error["code"] == -32602
    assert right in {one["path"]: one["message"] for one in error["data"]}[path]
    assert right in error["message"]
    script = begun.simulation.script
    assert not script.due_from_outside


def test_steps_end_at_their_limit(tmp_path: Path) -> None:
    ask = asked(session_in(tmp_path))
    assert ask("step")["step"] == 1
    assert ask("step", frames=2)["step"] == 9
    assert ask("step", until=0.25)["step"] == 24
    assert ask("step", until=0.25)["step"] == 24
    assert ask("step", steps=1, frames=1, until=1.0)["step"] == 25
    assert "is over" in ask("step", until=0.1)["message"]
    found = ask("step", event=["footfall", "told"], who=["bug"])
    assert [one["who"] for one in found["happened"]] == ["bug"] * len(found["happened"])
    assert {one["kind"] for one in found["happened"]} <= {"footfall", "told"}
    assert found["happened"]
    assert 25 < found["step"] < 4 * FRAMES
    assert ask("step", until=99)["finished"]
    assert ask("step")["step"] == 4 * FRAMES


@pytest.mark.slow
def test_queries_agree_with_the_take(tmp_path: Path) -> None:
    session = session_in(tmp_path)
    ask = asked(session)
    ask("step", steps=50)
    about = ["time", "performers", "places", "poses", "channels", "notes"]
    found = ask("query", what=about, who=["roo"])
    assert found["time"]["time"] == 50 / 96
    assert found["performers"] == {"roo": {"is": "creature", "called": "hopper"}}
    kept = read_take(Path(ask("end")["take"]))
    numbers = {node.name: i for i, node in enumerate(kept.nodes)}
    assert found["poses"].keys() == {n.name for n in kept.nodes if n.performer == "roo"}
    for name, pose in found["poses"].items():
        assert pose["position"] == kept.positions[50, numbers[name]].tolist()
        assert pose["rotation"] == kept.rotations[50, numbers[name]].tolist()
    for i, channel in enumerate(kept.channels):
        if channel.name.startswith("roo."):
            assert found["channels"][channel.name] == kept.values[50, i]


def test_a_subscription_notifies_of_its_events_only(tmp_path: Path) -> None:
    session = session_in(tmp_path)
    lines = served(
        session,
        [
            request("subscribe", events=["footfall", "told"], who=["bug"]),
            request("step", 2, until=1.5),
            request("subscribe", 3, events=[]),
            request("step", 4, until=1.9),
        ],
    )
    told = [line["params"] for line in lines if "method" in line]
    assert all(line["method"] == "happened" for line in lines if "id" not in line)
    assert [line["id"] for line in lines if "id" in line] == [1, 2, 3, 4]
    assert lines[-2]["id"] == 3
    take = session.simulation.recorder
    heard = [e for e in take.events if e.who == "bug" and e.cause == "footfall" and e.step < 144]
    assert [one["step"] for one in told if one["kind"] == "footfall"] == [e.step for e in heard]
    assert [one["text"] for one in told if one["kind"] == "told"] == ["wait 0.2", "walk"]


def test_unknown_kinds_and_names_are_refused_with_the_nearest(tmp_path: Path) -> None:
    ask = asked(session_in(tmp_path))
    assert "did you mean 'footfall'?" in ask("subscribe", events=["footfal"])["message"]
    assert "did you mean 'bug'?" in ask("query", who=["bgu"])["message"]
    assert "did you mean 'bug'?" in ask("step", who=["bgu"])["message"]
    assert ask("subscribe", events=["*"])["events"] == sorted(EVENT_KINDS)


def test_after_the_end_only_queries_are_answered(tmp_path: Path) -> None:
    ask = asked(session_in(tmp_path, read_scene(STAGE_OF_ONE_FRAME)))
    ask("end")
    for method, params in {"step": {}, "end": {}, "command": {"who": "bug", "do": "stop"}}.items():
        assert ask(method, **params)["code"] == -32001
    assert ask("query", what=["time"])["time"]["finished"]


STAGE_OF_ONE_FRAME = "pronk: 1\nframes: 1\ncast: [{name: bug, figure: beetle, walk: {}}]\n"
