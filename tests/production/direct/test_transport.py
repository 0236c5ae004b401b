"""Transports: every connection, however it ends, leaves a finished take."""

from __future__ import annotations

import contextlib
import io
import json
import os
import socket
import stat
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from pipeline.errors import StoreError, UsageError
from pipeline.production.direct import message_stream, session
from pipeline.production.direct.message_stream import Disconnected, MessageStream, pipe_writer
from pipeline.production.direct.scene_recorder import SceneRecorder, recorder_for
from pipeline.production.direct.server import direct
from pipeline.production.direct.transport import LOOPBACK, Announce, transport_for
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.progress import Reporter
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take_store import read_take
from pipeline.spec import read_scene
from tests.production.direct.direct_client import (
    STILL,
    Entrance,
    assert_complete,
    directed,
    port_in,
    request,
    socket_at,
    stage,
)

OUTPUTS = Outputs(Path("out/stage"), "stage")


def test_a_port_is_open_to_this_machine_alone_and_to_one_program(tmp_path: Path) -> None:
    seen: list[object] = []

    def client(entrance: Entrance) -> None:
        with entrance.director() as (one, lines):
            one.sendall(request("step", frames=2) + b"\n")
            seen.append(json.loads(lines.readline())["result"]["step"])
            try:
                entrance.connected().close()
            except ConnectionRefusedError:
                seen.append("shut")
            one.sendall(request("end", at="now") + b"\n")
            seen.append(json.loads(lines.readline())["result"]["frames"])
        seen.append(entrance.address.partition(":")[0])

    kept = directed(port_in(tmp_path), tmp_path, client)
    assert seen == [8, "shut", 2, LOOPBACK]
    assert kept.frames == 2


@pytest.mark.parametrize(("number", "told"), [(0, ["waiting at 127.0.0.1:"]), (None, [])])
def test_a_quiet_session_tells_the_address_of_a_free_port_alone(
    number: int | None, told: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.create_server((LOOPBACK, 0)) as free:
        known = free.getsockname()[1]
    errors, token = io.StringIO(), tmp_path / "token"
    monkeypatch.setattr(sys, "stderr", errors)
    said: list[str] = []
    port = known if number is None else number
    transport = transport_for(None, port, LOOPBACK, token, OUTPUTS, quiet=True)

    def direct_it() -> None:
        while not token.exists() or (number == 0 and "\n" not in errors.getvalue()):
            time.sleep(0.005)
        address = errors.getvalue().strip().rpartition(":")[2] or str(known)
        # Whoever finds the token is let in.
        one = socket.create_connection((LOOPBACK, int(address)))
        one.sendall(request("hello", 0, token=token.read_text().strip()) + b"\n")
        one.close()

    client = threading.Thread(target=direct_it)
    client.start()
    with transport(said.append):
        client.join()
    assert [line.rstrip("0123456789") for line in errors.getvalue().splitlines()] == told


@pytest.mark.nightly
@pytest.mark.parametrize("reset", [False, True])
def test_a_lost_connection_leaves_a_finished_take(reset: bool, tmp_path: Path) -> None:
    def client(entrance: Entrance) -> None:
        with entrance.connected() as one:
            one.sendall(entrance.hello + request("subscribe", events=["*"]) + b"\n")
            one.sendall(request("command", who="bug", do={"turn_deg": 90}) + b"\n")
            one.sendall(request("step", until=1.0) + b'\n{"jsonrpc": "2.0", "meth')
            if reset:
                one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
                # A connection that is reset before it was heard is none.
                one.recv(1)
            else:
                # The system drops what was not heard if answers are left unread.
                one.shutdown(socket.SHUT_WR)
                while one.recv(4096):
                    pass

    kept = directed(port_in(tmp_path), tmp_path, client)
    assert_complete(kept)
    assert reset or read_take(kept.take).orders[0].text == "turn_deg 90"


@pytest.mark.slow
def test_a_local_socket_is_private_at_once_and_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, modes = tmp_path / "s", list[int]()

    class Watched(socket.socket):
        def bind(self, address: object) -> None:
            super().bind(address)  # type: ignore[arg-type]
            modes.append(stat.S_IMODE(place.stat().st_mode))

    def client(entrance: Entrance) -> None:
        with pytest.raises(UsageError, match="another run waits there"):
            socket_at(place)
        # The probe of the other run has come and gone; neither it nor silence keeps the
        # director out.
        with entrance.connected(), entrance.director() as (one, lines):
            modes.append(stat.S_IMODE(place.stat().st_mode) if place.exists() else 0)
            one.sendall(request("step", frames=2) + b"\n")
            modes.append(json.loads(lines.readline())["result"]["step"])

    monkeypatch.setattr(socket, "socket", Watched)
    before = os.umask(0)
    try:
        kept = directed(socket_at(place), tmp_path, client)
    finally:
        os.umask(before)
    assert modes == [0o600, 0, 8]
    assert not place.exists()
    assert_complete(kept)


def test_only_a_stale_socket_is_removed(tmp_path: Path) -> None:
    left, other = tmp_path / "left", tmp_path / "other"
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(left))
    socket_at(left)
    assert not left.exists()
    other.write_text("mine")
    with pytest.raises(UsageError, match="there is something else already"):
        socket_at(other)
    assert other.read_text() == "mine"


@pytest.mark.parametrize(
    ("path", "number", "host", "token", "right"),
    [
        (Path("s"), 7000, LOOPBACK, None, "give one of them"),
        (None, None, "0.0.0.0", None, "give --port as well"),
        (Path("s"), None, LOOPBACK, Path("t"), "give --port as well"),
    ],
)
def test_conflicting_transports_are_refused(
    path: Path | None, number: int | None, host: str, token: Path | None, right: str
) -> None:
    with pytest.raises(UsageError, match=right):
        transport_for(path, number, host, token, OUTPUTS)


@pytest.mark.parametrize("host", ["no such host", "192.0.2.1"])
def test_foreign_addresses_are_refused(host: str, tmp_path: Path) -> None:
    outputs = Outputs(tmp_path, "stage")
    with (
        pytest.raises((UsageError, StoreError), match=host),
        transport_for(None, 0, host, None, outputs)(lambda text: None),
    ):
        pass
    assert not outputs.token.exists()


@pytest.mark.parametrize("name", ["", "a/b", "..", ".hidden"])
def test_invalid_names_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="is no name"):
        recorder_for(Path("stage.yaml"), name, tmp_path, True, False)


def test_an_unwritable_folder_is_refused_before_a_connection(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("in the way")

    @contextmanager
    def transport(say: Announce) -> Iterator[MessageStream]:
        raise AssertionError("nobody may come in")
        yield

    with pytest.raises(StoreError, match="cannot be written to"):
        direct(stage(), SceneRecorder("stage_directed", tmp_path / "out", Reporter()), transport)


@pytest.mark.nightly
@pytest.mark.parametrize("presses", [[10], [10, 20]])
def test_a_second_ctrl_c_drops_the_take(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, presses: list[int]
) -> None:
    class Pressed(Simulation):
        def step(self) -> None:
            super().step()
            if self.step_number in presses:
                raise KeyboardInterrupt

    @contextmanager
    def gone(say: Announce) -> Iterator[MessageStream]:
        yield MessageStream(io.BytesIO(), io.BytesIO())

    monkeypatch.setattr(session, "Simulation", Pressed)
    notes = list[str]()
    place = SceneRecorder("stage_directed", tmp_path, Reporter())
    monkeypatch.setattr(Reporter, "note", lambda self, text, detail=False: notes.append(text))
    if len(presses) == 1:
        assert_complete(direct(stage(), place, gone))
    else:
        with pytest.raises(KeyboardInterrupt):
            direct(stage(), place, gone)
    assert notes == [
        "the other program has disconnected; the scene goes to its end",
        "stopped; the scene goes to its end, unless it is stopped again",
    ]


# --- a director that does not read ------------------------------------------------


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wait for nobody."""
    monkeypatch.setattr(message_stream, "STALL_LIMIT", 0.05)


@pytest.mark.usefixtures("impatient")
def test_a_director_that_does_not_read_is_given_up(tmp_path: Path) -> None:
    given_up, notes = threading.Event(), list[str]()

    def client(entrance: Entrance) -> None:
        with entrance.connected() as one:
            # More answers than the system holds, and then an order that comes too late.
            queries = 400 * (request("query", "x" * 1000) + b"\n")
            with contextlib.suppress(BrokenPipeError):
                one.sendall(queries + request("end", at="now") + b"\n")
            assert given_up.wait(60)
        notes.extend(entrance.notes)

    transport = socket_at(tmp_path / "s")

    @contextmanager
    def told(say: Announce) -> Iterator[MessageStream]:
        with transport(say) as stream:
            yield stream
        given_up.set()

    kept = directed(told, tmp_path, client, read_scene(STILL))
    assert kept.frames == 4
    assert "the other program has read nothing for 0.05 s; the scene goes to its end" in notes


@pytest.mark.usefixtures("impatient")
def test_sending_fails_at_once_after_a_stall() -> None:
    inward, outward = os.pipe()
    stream = MessageStream(io.BytesIO(b"more\n"), pipe_writer(outward))
    try:
        with pytest.raises(Disconnected, match="has read nothing for"):
            # More than a pipe holds.
            stream.send("x" * 2**20)
        os.read(inward, 2**20)
        with pytest.raises(Disconnected):
            stream.send("late")
        assert list(stream.messages()) == []
    finally:
        os.close(inward)
        os.close(outward)


def test_a_slow_reader_gets_every_byte() -> None:
    inward, outward = os.pipe()
    text, found = "0123456789" * 100_000, bytearray()

    def read() -> None:
        while data := os.read(inward, 1000):
            found.extend(data)

    reader = threading.Thread(target=read)
    reader.start()
    MessageStream(io.BytesIO(), pipe_writer(outward)).send(text)
    os.close(outward)
    reader.join()
    os.close(inward)
    assert found.decode() == f"{text}\n"
