"""Transports: every connection, however it ends, leaves a finished take."""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import signal
import socket
import stat
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from pipeline.errors import StoreError, UsageError
from pipeline.production.direct import session
from pipeline.production.direct.scene_recorder import RecordedScene, SceneRecorder, recorder_for
from pipeline.production.direct.server import direct
from pipeline.production.direct.transport import (
    LOOPBACK,
    Announce,
    MessageStream,
    Transport,
    transport_for,
)
from pipeline.production.run.progress import Reporter
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take_store import read_take
from tests.production.direct.direct_client import STAGE, replayed, request, stage

ROOT = Path(__file__).parents[3]
PRONK = [sys.executable, "-c", "from pipeline.cli import main; main()"]

Client = Callable[[str], None]


def _directed(transport: Transport, folder: Path, client: Client) -> RecordedScene:
    """Serve the stage over a transport to a client, which gets the address."""
    clients = []

    def say(text: str) -> None:
        if found := re.fullmatch("waiting at (.*)", text):
            clients.append(threading.Thread(target=client, args=[found[1]]))
            clients[0].start()

    place = SceneRecorder("stage_directed", folder, Reporter())
    place.reporter.note = lambda text, detail=False: say(text)  # type: ignore[method-assign]
    kept = direct(stage(), place, transport)
    for one in clients:
        one.join()
    return kept


def _assert_complete(kept: RecordedScene) -> None:
    """Check that the kept take reaches the scene's end and replays."""
    assert kept.frames == stage().n_frames
    assert read_take(kept.take).digest == kept.digest == replayed(kept.scene).digest


def _connect_and_direct(place: str) -> socket.socket:
    host, _, number = place.rpartition(":")
    return socket.create_connection((host, int(number)))


def test_a_port_is_open_to_this_machine_alone_and_to_one_program(tmp_path: Path) -> None:
    seen: list[object] = []

    def client(place: str) -> None:
        with _connect_and_direct(place) as one, one.makefile("rb") as lines:
            one.sendall(request("step", frames=2) + b"\n")
            seen.append(json.loads(lines.readline())["result"]["step"])
            try:
                _connect_and_direct(place).close()
            except ConnectionRefusedError:
                seen.append("shut")
            one.sendall(request("end", at="now") + b"\n")
            seen.append(json.loads(lines.readline())["result"]["frames"])
        seen.append(place.partition(":")[0])

    kept = _directed(transport_for(None, 0, LOOPBACK), tmp_path, client)
    assert seen == [8, "shut", 2, LOOPBACK]
    assert kept.frames == 2


@pytest.mark.slow
@pytest.mark.parametrize("reset", [False, True])
def test_a_lost_connection_leaves_a_finished_take(reset: bool, tmp_path: Path) -> None:
    def client(place: str) -> None:
        with _connect_and_direct(place) as one:
            one.sendall(request("subscribe", events=["*"]) + b"\n")
            one.sendall(request("command", who="bug", do={"turn_deg": 90}) + b"\n")
            one.sendall(request("step", until=1.0) + b'\n{"jsonrpc": "2.0", "meth')
            if reset:
                one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")

    kept = _directed(transport_for(None, 0, LOOPBACK), tmp_path, client)
    _assert_complete(kept)
    assert reset or read_take(kept.take).orders[0].text == "turn_deg 90"


def test_browsers_are_refused(tmp_path: Path) -> None:
    seen: list[object] = []
    order = request("end", at="now") + b"\n"

    def client(place: str) -> None:
        with _connect_and_direct(place) as browser:
            browser.sendall(b"POST / HTTP/1.1\r\nHost: here\r\n\r\n" + order)
            with contextlib.suppress(ConnectionResetError):
                seen.append(browser.recv(100))
        with _connect_and_direct(place) as one, one.makefile("rb") as lines:
            one.sendall(request("query", what=["time"]) + b"\n")
            seen.append(json.loads(lines.readline())["result"]["time"]["finished"])
            one.sendall(order)
            lines.readline()

    _directed(transport_for(None, 0, LOOPBACK), tmp_path, client)
    assert seen[-1] is False
    assert seen[:-1] in ([b""], [])


@pytest.mark.slow
def test_a_local_socket_is_private_and_removed_at_the_end(tmp_path: Path) -> None:
    place = tmp_path / "s"
    seen: list[object] = []

    def client(path: str) -> None:
        seen.append(stat.S_IMODE(os.stat(path).st_mode))
        with pytest.raises(UsageError, match="another run waits there"):
            transport_for(place, None, LOOPBACK)
        # The probe of the other run was let in and has gone again.

    kept = _directed(transport_for(place, None, LOOPBACK), tmp_path, client)
    assert seen == [0o600]
    assert not place.exists()
    _assert_complete(kept)


def test_only_a_stale_socket_is_removed(tmp_path: Path) -> None:
    left, other = tmp_path / "left", tmp_path / "other"
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(left))
    transport_for(left, None, LOOPBACK)
    assert not left.exists()
    other.write_text("mine")
    with pytest.raises(UsageError, match="there is something else already"):
        transport_for(other, None, LOOPBACK)
    assert other.read_text() == "mine"


@pytest.mark.parametrize(
    ("path", "number", "host", "right"),
    [
        (Path("s"), 7000, LOOPBACK, "give one of them"),
        (None, None, "0.0.0.0", "give --port as well"),
    ],
)
def test_conflicting_transports_are_refused(
    path: Path | None, number: int | None, host: str, right: str
) -> None:
    with pytest.raises(UsageError, match=right):
        transport_for(path, number, host)


@pytest.mark.parametrize("host", ["no such host", "192.0.2.1"])
def test_foreign_addresses_are_refused(host: str, tmp_path: Path) -> None:
    with (
        pytest.raises((UsageError, StoreError), match=host),
        transport_for(None, 0, host)(lambda text: None),
    ):
        pass


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


# --- the command ------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with the stage scene."""
    (tmp_path / "stage.yaml").write_text(STAGE, encoding="utf-8")
    return tmp_path


def _started(folder: Path, *arguments: str) -> subprocess.Popen[bytes]:
    paths = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return subprocess.Popen(
        [*PRONK, "direct", "stage.yaml", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def _ended(folder: Path, run: subprocess.Popen[bytes], text: bytes = b"") -> tuple[int, str, str]:
    out, err = run.communicate(text, timeout=120)
    return run.returncode, out.decode("ascii"), err.decode()


@pytest.mark.slow
def test_standard_output_has_only_messages(folder: Path) -> None:
    text = b"\n".join([b"nonsense", request("step", 1, frames=3), request("end", 2)])
    code, out, err = _ended(folder, _started(folder, "--name", "other", "-v"), text)
    assert code == 0, err
    answers = [json.loads(line) for line in out.splitlines()]
    assert [one["id"] for one in answers] == [None, 1, 2]
    assert answers[-1]["result"]["take"] == str(Path("out/other/take.zarr"))
    assert "Traceback" not in err
    assert replayed(folder / "out/other/other.yaml").digest == answers[-1]["result"]["digest"]


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
        _assert_complete(direct(stage(), place, gone))
    else:
        with pytest.raises(KeyboardInterrupt):
            direct(stage(), place, gone)
    assert notes == ["stopped; the scene goes to its end, unless it is stopped again"]


@pytest.mark.slow
def test_ctrl_c_leaves_a_finished_take(folder: Path) -> None:
    run = _started(folder)
    assert run.stdin is not None
    assert run.stdout is not None
    run.stdin.write(request("command", 1, who="bug", do="stop") + b"\n")
    run.stdin.write(request("step", 2, frames=3) + b"\n")
    run.stdin.flush()
    for _ in range(2):
        assert run.stdout.readline()
    run.send_signal(signal.SIGINT)
    code, _, err = _ended(folder, run)
    assert (code, "Traceback" in err) == (0, False), err
    take = read_take(folder / "out/stage_directed/take.zarr")
    assert take.digest == replayed(folder / "out/stage_directed/stage_directed.yaml").digest
    assert take.orders[0].text == "stop"


@pytest.mark.slow
def test_the_drama_manager_brings_a_cast_together(folder: Path) -> None:
    scene = """\
pronk: 1
duration: 5
terrain: {kind: flat, size: [12, 12], cells: [8, 8]}
cast:
  - {name: ann, figure: beetle, scale: 0.5, walk: {speed: 0.8}}
  - {name: bob, figure: beetle, scale: 0.5, at: [0, 1.6], walk: {speed: 0.8}}
  - {name: box, prop: {shape: box, size: [0.2, 0.2, 0.2]}, at: [3, 3]}
"""
    (folder / "two.yaml").write_text(scene)
    arguments = [str(ROOT / "docs/examples/drama_manager.py"), "two.yaml", "--pronk"]
    quoted = f"'{PRONK[0]}' -c '{PRONK[2]}'"
    paths = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    end = subprocess.run(
        [sys.executable, *arguments, quoted],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
    )
    assert end.returncode == 0, end.stderr
    assert "ann has come to bob" in end.stdout
    take = read_take(folder / "out/two_directed/take.zarr")
    assert take.digest == replayed(folder / "out/two_directed/two_directed.yaml").digest
    # Where they met they are within reach, which they were not at first.
    first = {node.performer: i for i, node in reversed(list(enumerate(take.nodes)))}
    way = take.positions[:, first["ann"]] - take.positions[:, first["bob"]]
    gap = (way[:, [0, 2]] ** 2).sum(axis=1) ** 0.5
    assert gap[0] > 1.5
    assert gap.min() < 1.0
