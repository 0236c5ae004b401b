"""JSON-RPC 2.0: every message gets a valid answer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import pipeline
from pipeline.production.direct import protocol
from pipeline.production.direct.messages import MAX_MESSAGE_BYTES
from pipeline.production.direct.protocol import MAX_BATCH, Protocol
from tests.production.direct.direct_client import (
    INVALID,
    PARAMS,
    PARSE,
    UNKNOWN,
    request,
    served,
    session_in,
)


def _answer(message: bytes) -> Any:
    """Return what a server of two methods answers, None for nothing."""
    answer = Protocol({"echo": dict, "fail": _fail}).answer(message)
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


def test_a_batch_is_refused_from_where_its_answers_are_too_large(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(protocol, "MAX_ANSWER_BYTES", 150)
    requests = [request("echo", n, x="y" * 60) for n in range(3)]
    answer = _answer(b"[" + b", ".join([*requests, request("echo", None), b"1"]) + b"]")
    assert [one["id"] for one in answer] == [0, 1, 2, None, None]
    codes = [one.get("error", {}).get("code") for one in answer]
    assert codes == [None, None, INVALID, INVALID, INVALID]
    assert "150 bytes" in answer[2]["error"]["data"]


def test_hello_is_answered_without_a_port(tmp_path: Path) -> None:
    (line,) = served(session_in(tmp_path), [request("hello", 3)])
    assert line["id"] == 3
    assert line["result"].items() >= {"pronk": pipeline.__version__, "step": 0}.items()


def test_topics_are_not_repeated_without_limit(tmp_path: Path) -> None:
    (line,) = served(session_in(tmp_path), [request("query", what=["poses"] * 7)])
    assert line["error"]["code"] == PARAMS
