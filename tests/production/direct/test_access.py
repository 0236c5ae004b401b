"""Access to a port: nobody directs without the token, and nobody keeps the director out."""

from __future__ import annotations

import json
import os
import socket
import stat
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import StoreError, UsageError
from pipeline.production.direct import admission
from pipeline.production.direct.access_token import is_hello, token_in
from pipeline.production.direct.admission import (
    LATE_HELLO,
    LONG_HELLO,
    MAX_CANDIDATES,
    MAX_HELLO_BYTES,
    OTHER_PROTOCOL,
    WRONG_HELLO,
)
from pipeline.production.direct.scene_recorder import RecordedScene
from pipeline.spec import read_scene
from tests.production.direct.direct_client import (
    STILL,
    Client,
    Entrance,
    directed,
    port_in,
    request,
)

ORDER = request("step", 1) + b"\n"
END = request("end", 2, at="now") + b"\n"


def _directed(folder: Path, client: Client) -> RecordedScene:
    """Serve a scene in which nothing moves at a port."""
    return directed(port_in(folder), folder, client, read_scene(STILL))


def _direct(entrance: Entrance) -> int:
    """Connect as the director, end the scene, and return the step at which it was."""
    with entrance.director() as (one, lines):
        one.sendall(request("query", 1, what=["time"]) + b"\n" + END)
        time = json.loads(lines.readline())["result"]["time"]
        assert "result" in json.loads(lines.readline())
    return int(time["step"])


def _all_of(one: socket.socket) -> bytes:
    """Return all that comes back until the connection is closed."""
    found = b""
    try:
        while data := one.recv(4096):
            found += data
    except ConnectionResetError:
        pass
    return found


def _refusal(reason: str) -> dict[str, Any]:
    error = {"code": -32003, "message": f"refused: {reason}"}
    return {"jsonrpc": "2.0", "id": None, "error": error}


def _http(start: bytes, *, host: bytes = b"127.0.0.1") -> bytes:
    return start + b" HTTP/1.1\r\nHost: " + host + b"\r\nContent-Length: 999\r\n\r\n"


OTHERS = {
    "a short path": _http(b"POST /"),
    "a path of 60 characters": _http(b"POST /" + b"a" * 60),
    "a path of 9000 characters": _http(b"GET /" + b"a" * 9000),
    "another host": _http(b"POST /", host=b"rebound.test"),
    "blank lines before": b"\r\n\n" + _http(b"POST /"),
    "an upgrade": _http(b"GET /") + b"Upgrade: websocket\r\n",
    "HTTP/2": b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    "TLS": bytes.fromhex("16030100c8010000c403") + bytes(195) + b"\n",
    "STUN": bytes.fromhex("000300082112a442") + bytes(20) + b"\n",
    "a byte order mark": b"\xef\xbb\xbf",
    "a blank": b" ",
    "a batch": b"[",
}


@pytest.mark.parametrize("first", [1, 3, 2**20], ids="{} bytes first".format)
def test_other_protocols_are_cut_off_whatever_follows(tmp_path: Path, first: int) -> None:
    steps: list[int] = []

    def client(entrance: Entrance) -> None:
        for name, start in OTHERS.items():
            text = start + b"\n".join([b"", entrance.hello, ORDER, END])
            with entrance.connected() as one:
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                one.sendall(text[:first])
                if first < len(text):
                    # Let the first bytes be heard alone.
                    time.sleep(0.01)
                try:
                    one.sendall(text[first:])
                except (BrokenPipeError, ConnectionResetError):
                    pass
                assert _all_of(one) == b"", name
        steps.append(_direct(entrance))
        said = [note for note in entrance.notes if OTHER_PROTOCOL in note]
        assert len(said) == 1

    _directed(tmp_path, client)
    assert steps == [0]


def test_a_wrong_first_line_is_answered_and_never_carried_out(tmp_path: Path) -> None:
    steps: list[int] = []

    def client(entrance: Entrance) -> None:
        token, hello = entrance.token, entrance.hello
        near = "".join("B" if letter == "A" else "A" for letter in token)
        wrong = {
            WRONG_HELLO: [
                ORDER,
                b"{}\n",
                b"{" * 3000 + b"\n",
                b'{"a": ' + b"[" * 3000 + b"\n",
                request("hello", 1) + b"\n",
                *(request("hello", 1, token=t) + b"\n" for t in ("", near, token[:-1], token * 2)),
                *(request("hello", 1, token=t) + b"\n" for t in (None, 1, [token], {token: token})),
                request("hello", 1, token="\ud800") + b"\n",
                request("Hello", 1, token=token) + b"\n",
                request("step", 1, token=token) + b"\n",
                hello.replace(b'"params"', b'"other"'),
            ],
            LONG_HELLO: [
                hello[:-1] + b" " * MAX_HELLO_BYTES + b"\n",
                b"{" + b" " * 2 * MAX_HELLO_BYTES,
            ],
        }
        for reason, lines in wrong.items():
            for line in lines:
                with entrance.connected() as one:
                    one.sendall(line)
                    assert json.loads(_all_of(one)) == _refusal(reason), line
        steps.append(_direct(entrance))

    _directed(tmp_path, client)
    assert steps == [0]


def test_silent_connections_keep_nobody_out(tmp_path: Path) -> None:
    steps: list[int] = []

    def client(entrance: Entrance) -> None:
        silent = [entrance.connected() for _ in range(MAX_CANDIDATES + 6)]
        silent[-1].sendall(b"{")
        entrance.connected().close()
        steps.append(_direct(entrance))
        for one in silent:
            with one:
                assert b"result" not in _all_of(one)

    _directed(tmp_path, client)
    assert steps == [0]


def test_a_connection_without_a_first_line_is_closed_and_the_next_one_heard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[int] = []
    monkeypatch.setattr(admission, "HELLO_TIMEOUT", 0.05)

    def client(entrance: Entrance) -> None:
        for start in (b"", b"{", entrance.hello[:-1]):
            with entrance.connected() as one:
                one.sendall(start)
                assert json.loads(_all_of(one)) == _refusal(LATE_HELLO)
        monkeypatch.setattr(admission, "HELLO_TIMEOUT", 60.0)
        steps.append(_direct(entrance))

    _directed(tmp_path, client)
    assert steps == [0]


def test_a_hello_in_pieces_is_heard_with_what_follows(tmp_path: Path) -> None:
    def client(entrance: Entrance) -> None:
        text = entrance.hello + END
        with entrance.connected() as one, one.makefile("rb") as lines:
            one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            for i in range(0, len(text), 7):
                one.sendall(text[i : i + 7])
            hello, end = (json.loads(lines.readline()) for _ in range(2))
        assert hello["result"]["step"] == 0
        assert end["result"]["frames"] == 1

    assert _directed(tmp_path, client).frames == 1


# --- the token --------------------------------------------------------------------


def test_the_token_is_in_a_file_while_the_port_waits(tmp_path: Path) -> None:
    seen: list[object] = []

    def client(entrance: Entrance) -> None:
        seen.append(entrance.file.read_text() == f"{entrance.token}\n")
        seen.append(stat.S_IMODE(entrance.file.stat().st_mode))
        with entrance.director():
            seen.append(entrance.file.exists())

    _directed(tmp_path, client)
    assert seen == [True, 0o600, False]


def test_a_token_file_is_private_from_its_first_moment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, modes, real = tmp_path / "deep" / "t", list[int](), os.open

    def watched(path: Any, flags: int, mode: int = 0o777, **more: Any) -> int:
        opened = real(path, flags, mode, **more)
        if flags & os.O_CREAT:
            modes.append(stat.S_IMODE(os.fstat(opened).st_mode))
        return opened

    file.parent.mkdir()
    file.write_text("x" * 43)
    file.chmod(0o644)
    before = os.umask(0)
    try:
        with monkeypatch.context() as patched:
            patched.setattr(os, "open", watched)
            with token_in(file) as token:
                pass
        with token_in(file) as token:
            assert stat.S_IMODE(file.stat().st_mode) == 0o600
            assert list(file.parent.iterdir()) == [file]
            assert len(token) == 43
    finally:
        os.umask(before)
    assert modes == [0o600]
    assert list(file.parent.iterdir()) == []


def test_tokens_differ(tmp_path: Path) -> None:
    tokens = set()
    for _ in range(50):
        with token_in(tmp_path / "t") as token:
            tokens.add(token)
    assert len(tokens) == 50


def test_only_a_token_is_replaced_or_removed(tmp_path: Path) -> None:
    file = tmp_path / "t"
    file.write_text("mine")
    for place in (file, tmp_path):
        with pytest.raises(UsageError, match="there is something else already"), token_in(place):
            pass
    assert file.read_text() == "mine"
    file.unlink()
    with token_in(file):
        file.write_text("of another session")
    assert file.read_text() == "of another session"
    with pytest.raises(UsageError, match="something else"), token_in(file / "below"):
        pass


def test_a_place_where_nothing_is_private_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = os.open
    monkeypatch.setattr(os, "open", lambda path, flags, mode: real(path, flags, 0o644))
    with pytest.raises(StoreError, match="other users could read it"), token_in(tmp_path / "t"):
        pass
    assert list(tmp_path.iterdir()) == []


TOKEN = "k" * 43
VALUES = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.text(), st.just(TOKEN[:-1])),
    lambda inner: st.one_of(st.lists(inner), st.dictionaries(st.text(), inner)),
    max_leaves=5,
)


@given(
    members=st.dictionaries(st.sampled_from(["jsonrpc", "id", "method", "token", "x"]), VALUES),
    params=st.one_of(VALUES, st.fixed_dictionaries({"token": VALUES})),
)
@settings(max_examples=40)
def test_no_mapping_without_the_token_is_a_hello(members: dict[str, Any], params: Any) -> None:
    content = {**members, "method": "hello", "params": params}
    assert not is_hello(json.dumps(content).encode(), TOKEN)
    assert is_hello(json.dumps({**content, "params": {"token": TOKEN}}).encode(), TOKEN)


@given(st.binary(max_size=200))
@settings(max_examples=200)
def test_no_bytes_without_the_token_are_a_hello(line: bytes) -> None:
    assert not is_hello(line, TOKEN)
