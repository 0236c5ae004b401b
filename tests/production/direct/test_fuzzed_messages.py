"""Fuzzed messages: each gets the answer that the specification demands, and a take is left."""

from __future__ import annotations

import json
import tempfile
import threading
from collections import Counter
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeline.spec import read_scene
from tests.production.direct.direct_client import (
    INVALID,
    PARAMS,
    PARSE,
    STAGE,
    UNKNOWN,
    replayed,
    request,
    served,
    session_in,
)

ENDED = -32001

ODD = st.one_of(
    st.sampled_from([None, True, -1, 0, 1, 2**63, 10**400, 0.5, -1e308, "", "bug", "\ud800", "*"]),
    st.sampled_from(
        [[], {}, [[]], [1, 2], {"go_to": [1, 1]}, {"jump": {}}, {"": 0}, "stop", "now"]
    ),
    st.recursive(
        st.one_of(st.none(), st.integers(), st.floats(allow_nan=False), st.text(max_size=9)),
        lambda inner: st.one_of(
            st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=5), inner, max_size=3)
        ),
        max_leaves=6,
    ),
)
KEYS = st.one_of(
    st.sampled_from(["steps", "frames", "until", "event", "who", "what", "events", "do", "at"]),
    st.sampled_from(["when", "token", "jsonrpc", "id", "method", "params", "", "x"]),
)
DO = st.sampled_from(
    [
        *("stop", "walk", "hop", {"go_to": [1, 2]}, {"turn_deg": 30}, {"speed": 0.4}),
        *({"wait": 0.1}, {"gait": "wave"}, {"mood": "happy"}, {"look_at": "roo"}),
        *({"hop_over": "box"}, {"jump": {}}),
    ]
)
RIGHT = st.one_of(
    st.tuples(st.just("hello"), st.just({})),
    st.tuples(st.just("step"), st.fixed_dictionaries({"steps": st.integers(1, 3)})),
    st.tuples(st.just("step"), st.just({"event": ["footfall"], "who": ["bug"], "frames": 1})),
    st.tuples(
        st.just("command"),
        st.fixed_dictionaries({"who": st.sampled_from(["bug", "roo", "box"]), "do": DO}),
    ),
    st.tuples(st.just("query"), st.just({"what": ["time", "poses"]})),
    st.tuples(st.just("subscribe"), st.just({"events": ["footfall", "told"]})),
    st.tuples(st.sampled_from(["stepp", "rpc.x", ""]), st.just({})),
)
CHANGES = st.lists(st.tuples(st.booleans(), KEYS, ODD, st.booleans()), max_size=2)


@st.composite
def contents(draw: st.DrawFn) -> Any:
    """Return a request that is right but for a few members."""
    method, params = draw(RIGHT)
    content: Any = {"jsonrpc": "2.0", "id": draw(st.integers(0, 9)), "method": method}
    content["params"] = deepcopy(params)
    for is_inside, key, value, is_removed in draw(CHANGES):
        place = content.get("params") if is_inside else content
        if isinstance(place, dict):
            if is_removed:
                place.pop(key, None)
            else:
                place[key] = deepcopy(value)
    return content


@st.composite
def lines(draw: st.DrawFn) -> bytes:
    """Return a message: right, nearly right, torn, or any bytes."""
    kind = draw(st.integers(0, 19))
    if kind == 19:
        return _bytes(draw, 200)
    content = draw(st.lists(contents(), max_size=4)) if kind == 18 else draw(contents())
    text = json.dumps(content).encode()
    if kind in range(12, 18):
        at, length = draw(st.integers(0, len(text))), draw(st.integers(0, 3))
        text = text[:at] + _bytes(draw, 3) + text[at + length :]
    return text


def _bytes(draw: st.DrawFn, size: int) -> bytes:
    return draw(st.binary(max_size=size)).translate(None, b"\r\n")


def _expected(line: bytes) -> Any:
    """Return the ids of the answers, as a list for a batch; () for no answer."""
    if not line.strip():
        return ()
    try:
        content = json.loads(line.decode(), parse_constant=_refuse)
    except (ValueError, RecursionError):
        return None
    if not isinstance(content, list):
        return _expected_id(content)
    ids = [number for one in content if (number := _expected_id(one)) != ()]
    return None if not content else ids or ()


def _expected_id(content: Any) -> Any:
    """Return the id of the answer to a request, () for no answer."""
    if (
        not isinstance(content, dict)
        or content.get("jsonrpc") != "2.0"
        or not isinstance(content.get("method"), str)
        or not isinstance(content.get("params", {}), dict | list)
    ):
        return None
    number = content.get("id", ())
    return number if number == () or type(number) in (int, str) else None


def _refuse(name: str) -> Any:
    raise ValueError(name)


def _check_answer(answer: Any, number: Any) -> int:
    """Check one answer, and return the code of its error, 0 without one.

    Args:
        answer: to one request.
        number: the id it should have.
    """
    assert answer.keys() in ({"jsonrpc", "id", "result"}, {"jsonrpc", "id", "error"})
    assert (answer["jsonrpc"], answer["id"]) == ("2.0", number)
    if "error" in answer:
        code = answer["error"]["code"]
        # Nothing failed inside: no -32000 and no -32603.
        assert code in ((PARSE, INVALID) if number is None else (UNKNOWN, PARAMS, ENDED))
        assert answer["error"]["message"]
        return int(code)
    assert number is not None
    assert isinstance(answer["result"], dict)
    return 0


def _check_session(messages: list[bytes], folder: Path) -> Counter[int]:
    """Send messages to a session; check every answer, and the take that it leaves.

    Returns:
        How often each code came; 0 stands for results.
    """
    scene = read_scene(STAGE, overrides=["frames=12", "golden.frames=[1]"])
    session, answers = session_in(folder, scene), list[Any]()

    def serve() -> None:
        answers.extend(served(session, [*messages, request("end", "last", at="now")]))

    server = threading.Thread(target=serve, daemon=True)
    server.start()
    # Far more than it takes: a message that stalls the session fails here.
    server.join(300)
    assert not server.is_alive()
    answered = [one for one in answers if isinstance(one, list) or "method" not in one]
    expected = [ids for message in messages if (ids := _expected(message)) != ()]
    assert len(answered) == len(expected) + 1
    codes, end = Counter[int](), answered.pop()
    for answer, ids in zip(answered, expected, strict=True):
        is_batch = isinstance(ids, list)
        assert is_batch == isinstance(answer, list)
        pairs = zip(answer, ids, strict=True) if is_batch else [(answer, ids)]
        codes.update(_check_answer(one, number) for one, number in pairs)
    assert end["id"] == "last"
    assert replayed(end["result"]["scene"]).digest == end["result"]["digest"]
    return codes


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("sessions", "length"),
    [
        pytest.param(2, 60, marks=pytest.mark.slow),
        pytest.param(100, 20, marks=pytest.mark.nightly),
    ],
)
def test_every_fuzzed_message_is_answered(
    sessions: int, length: int, capfd: pytest.CaptureFixture[str]
) -> None:
    codes = Counter[int]()

    @settings(max_examples=sessions, suppress_health_check=list(HealthCheck))
    @given(st.lists(lines(), min_size=length, max_size=length))
    def law(messages: list[bytes]) -> None:
        with tempfile.TemporaryDirectory() as folder:
            codes.update(_check_session(messages, Path(folder)))

    law()
    assert codes.keys() >= {0, PARSE, INVALID, UNKNOWN, PARAMS}
    assert codes[0] > codes.total() / 5
    captured = capfd.readouterr()
    assert "Traceback" not in captured.out + captured.err
