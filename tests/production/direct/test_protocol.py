"""JSON-RPC 2.0: every message gets a valid answer."""

from __future__ import annotations

import json
import random
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from pipeline.production.direct.protocol import MAX_BATCH, Protocol
from pipeline.production.direct.transport import MAX_MESSAGE_BYTES
from pipeline.spec import read_scene
from tests.production.direct.direct_client import STAGE, replayed, request, served, session_in

PARSE, INVALID, UNKNOWN, PARAMS = -32700, -32600, -32601, -32602


def _answer(message: bytes) -> Any:
    """Return what a server of two methods answers, None for nothing."""
    protocol = Protocol({"echo": dict, "fail": _fail})
    answer = protocol.answer(message)
    return None if answer is None else json.loads(answer)


def _fail(params: Any) -> object:
    raise ZeroDivisionError("inside")


@pytest.mark.parametrize(
    ("message", "code"),
    [
        (b"", PARSE),
        (b"{", PARSE),
        (b"\xff\xfe", PARSE),
        (b'{"jsonrpc": "2.0", "method": "echo", "id": 1, "params": {"x": NaN}}', PARSE),
        (b'{"jsonrpc": "2.0", "method": "echo", "id": ' + b"9" * 5000 + b"}", PARSE),
        (b"[" * 100_000, PARSE),
        (b"[" * 100 + b"]" * 100, PARSE),
        (b"1", INVALID),
        (b'"step"', INVALID),
        (b"null", INVALID),
        (b"{}", INVALID),
        (b"[]", INVALID),
        (json.dumps([1] * (MAX_BATCH + 1)).encode(), INVALID),
        (b'{"jsonrpc": "1.0", "method": "echo", "id": 1}', INVALID),
        (b'{"jsonrpc": "2.0", "method": 1, "id": 1}', INVALID),
        (b'{"jsonrpc": "2.0", "method": "echo", "params": "bar", "id": 1}', INVALID),
        (b'{"jsonrpc": "2.0", "method": "echo", "id": null}', INVALID),
        (b'{"jsonrpc": "2.0", "method": "echo", "id": true}', INVALID),
        (b'{"jsonrpc": "2.0", "method": "echo", "id": {}}', INVALID),
    ],
)
def test_invalid_requests_are_answered_without_an_id(message: bytes, code: int) -> None:
    answer = _answer(message)
    assert (answer["jsonrpc"], answer["id"], answer["error"]["code"]) == ("2.0", None, code)


def test_requests_are_answered_under_their_ids() -> None:
    assert _answer(request("echo", 7, x=[1])) == {"jsonrpc": "2.0", "id": 7, "result": {"x": [1]}}
    assert _answer(request("echo", "a"))["id"] == "a"
    assert _answer(request("nothing", 7))["error"]["code"] == UNKNOWN
    listed = b'{"jsonrpc": "2.0", "method": "echo", "id": 1, "params": [1, 2]}'
    assert _answer(listed)["error"]["code"] == PARAMS
    assert _answer(b'{"jsonrpc": "2.0", "method": "echo", "id": 1, "params": []}')["result"] == {}


def test_notifications_are_not_answered() -> None:
    for method in ("echo", "nothing", "fail"):
        assert _answer(request(method, None)) is None
    assert _answer(b"[" + request("echo", None) + b"]") is None


def test_a_batch_is_answered_request_by_request() -> None:
    answer = _answer(b"[" + b", ".join([request("echo"), b"1", request("echo", None)]) + b", []]")
    assert [one["id"] for one in answer] == [1, None, None]
    assert [one.get("error", {}).get("code") for one in answer] == [None, INVALID, INVALID]


def test_a_defect_is_an_internal_error_without_traceback() -> None:
    error = _answer(request("fail"))["error"]
    assert error == {"code": -32000, "message": "Server error"}


def test_an_oversized_message_is_discarded_to_its_end(tmp_path: Path) -> None:
    long = b'{"x": "' + b"y" * (3 * MAX_MESSAGE_BYTES) + b'"}'
    lines = served(session_in(tmp_path), [long, b"", b"  ", request("step", 5)])
    assert [line["id"] for line in lines] == [None, 5]
    assert lines[0]["error"]["code"] == INVALID
    assert str(MAX_MESSAGE_BYTES) in lines[0]["error"]["data"]
    exact = request("step", 6) + b" " * (MAX_MESSAGE_BYTES - len(request("step", 6)) - 1)
    assert [line["id"] for line in served(session_in(tmp_path), [exact])] == [6]


# --- fuzz -------------------------------------------------------------------------

ODD: list[Any] = [
    *(None, True, -1, 0, 1, 2**63, 10**400, 0.5, -1e308, "", "bug", "\ud800", "stop", "*"),
    *([], {}, [[]], [1, 2], {"go_to": [1, 1]}, {"jump": {}}, {"": 0}, ["nothing"], "end", "now"),
]
METHODS = ("step", "command", "query", "subscribe", "stepp", "rpc.x", "")
KEYS = (
    *("steps", "frames", "until", "event", "who", "what", "events", "do", "at", "when", "x", ""),
    *("jsonrpc", "id", "method", "params"),
)
DO: list[Any] = [
    *("stop", "walk", "hop", {"go_to": [1, 2]}, {"turn_deg": 30}, {"speed": 0.4}, {"wait": 0.1}),
    *({"gait": "wave"}, {"mood": "happy"}, {"look_at": "roo"}, {"hop_over": "box"}, {"jump": {}}),
]


def _fuzzed(rng: random.Random) -> bytes:
    """Return a random message: valid, nearly valid or arbitrary."""
    content: Any = {"jsonrpc": "2.0", "id": rng.randrange(9), "method": rng.choice(METHODS)}
    params = rng.choice(
        [
            {"steps": rng.randrange(1, 4)},
            {"event": ["footfall"], "who": ["bug"], "frames": 1},
            {"who": rng.choice(("bug", "roo", "box")), "do": rng.choice(DO)},
            {"what": ["time", "poses"]},
            {"events": ["footfall", "told"]},
        ]
    )
    content["params"] = deepcopy(params)
    for _ in range(rng.choice((0, 0, 1, 2))):
        place = content if rng.random() < 0.4 else content["params"]
        if isinstance(place, dict):
            place[rng.choice(KEYS)] = deepcopy(rng.choice(ODD))
        content.setdefault("params", {})
    if rng.random() < 0.05:
        content = [content, deepcopy(rng.choice(ODD)), content]
    text = json.dumps(content).encode()
    if rng.random() < 0.2:
        at = rng.randrange(len(text))
        text = text[:at] + bytes(rng.randrange(256) for _ in range(rng.randrange(4)))
        text += json.dumps(content).encode()[at + rng.randrange(3) :]
    if rng.random() < 0.02:
        text = bytes(rng.randrange(256) for _ in range(rng.randrange(200)))
    return text.replace(b"\n", b" ").replace(b"\r", b" ")


@pytest.mark.parametrize(
    ("count", "seed"),
    [
        pytest.param(1000, 1, marks=pytest.mark.slow),
        pytest.param(10_000, 2, marks=pytest.mark.nightly),
    ],
)
def test_fuzzed_messages_leave_a_take_that_replays(
    count: int, seed: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    rng = random.Random(seed)
    # The scene lasts longer than the messages.
    session = session_in(tmp_path, read_scene(STAGE, overrides=[f"frames={count // 6}"]))
    lines = served(session, [*(_fuzzed(rng) for _ in range(count)), request("end", "last")])
    answers = [one for line in lines for one in (line if isinstance(line, list) else [line])]
    for one in answers:
        assert one["jsonrpc"] == "2.0"
        assert ("result" in one) + ("error" in one) + ("method" in one) == 1
    codes = {one["error"]["code"] for one in answers if "error" in one}
    # Nothing failed inside: no -32000 and no -32603.
    assert codes == {PARSE, INVALID, UNKNOWN, PARAMS}
    assert "Traceback" not in json.dumps(lines)
    assert capfd.readouterr().err == ""
    end = answers[-1]
    assert end["id"] == "last"
    assert len(session.simulation.script.told) > count // 200
    assert replayed(end["result"]["scene"]).digest == end["result"]["digest"]
