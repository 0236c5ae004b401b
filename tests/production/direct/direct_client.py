"""A small scene to direct, and clients of its session."""

from __future__ import annotations

import contextlib
import io
import json
import re
import socket
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from pipeline.production.direct.message_stream import MessageStream
from pipeline.production.direct.protocol import Protocol
from pipeline.production.direct.scene_recorder import RecordedScene, SceneRecorder
from pipeline.production.direct.server import direct, serve
from pipeline.production.direct.session import Session
from pipeline.production.direct.transport import LOOPBACK, Transport, transport_for
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.progress import Reporter
from pipeline.production.run.take_stage import take_key
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.simulation.take_store import read_take
from pipeline.spec import Scene, load_scene, read_scene

FRAMES = 48

STAGE = f"""\
pronk: 1
title: "Stage: two bugs"
frames: {FRAMES}
terrain: {{kind: flat, size: [12, 12], cells: [8, 8]}}
cast:
  - {{name: bug, figure: beetle, scale: 0.6, walk: {{gait: tripod, cycle: 0.3, speed: 0.6}}}}
  - {{name: roo, figure: hopper, at: [2, 2], pronk: {{distance: 0.4, height: 0.2}}}}
  - {{name: box, prop: {{shape: box, size: [0.2, 0.05, 0.4]}}, at: [0, 3]}}
script:
  - {{at: 0.1, who: bug, do: {{wait: 0.2}}}}
  - {{when: {{arrived: bug}}, who: roo, do: stop}}
golden: {{frames: [1, 24, 48]}}
"""

STILL = """\
pronk: 1
frames: 4
terrain: {kind: flat, size: [4, 4], cells: [2, 2]}
cast: [{name: box, prop: {shape: box, size: [1, 1, 1]}}]
"""

PARSE, INVALID, UNKNOWN, PARAMS = -32700, -32600, -32601, -32602
"""Codes of errors."""

Ask = Callable[..., Any]


def stage() -> Scene:
    """Return the scene."""
    return read_scene(STAGE)


def session_in(folder: Path, scene: Scene | None = None) -> Session:
    """Return a session that keeps its scene in `folder`."""
    return Session(scene or stage(), SceneRecorder("stage_directed", folder, Reporter()))


def asked(session: Session) -> Ask:
    """Return a function that sends a request to a session and returns its result or error."""
    protocol = Protocol(session.methods)

    def ask(method: str, **params: Any) -> Any:
        message = {"jsonrpc": "2.0", "id": 1, "method": method, "params": params}
        answer = protocol.answer(json.dumps(message).encode())
        assert answer is not None
        found = json.loads(answer)
        assert found.keys() in ({"jsonrpc", "id", "result"}, {"jsonrpc", "id", "error"})
        return found.get("result", found.get("error"))

    return ask


def served(session: Session, lines: Iterable[bytes]) -> list[Any]:
    """Send lines to a session that is served, and close; return all that came back."""
    out = io.BytesIO()
    serve(session, MessageStream(io.BytesIO(b"".join(line + b"\n" for line in lines)), out))
    return [json.loads(line) for line in out.getvalue().decode("ascii").splitlines()]


def request(method: str, number: int | str | None = 1, **params: Any) -> bytes:
    """Return a request as a line; one without number wants no answer."""
    message = {"jsonrpc": "2.0", "method": method, "params": params}
    return json.dumps(message if number is None else {**message, "id": number}).encode()


def replayed(file: str | Path) -> Take:
    """Simulate the scene that a session wrote."""
    scene = load_scene(Path(file))
    return simulate(scene, take_key(scene))


# --- over a transport -------------------------------------------------------------


@dataclass(slots=True)
class Entrance:
    """Where a session waits for its director.

    Attributes:
        address: of the port or of the local socket.
        token: of the port; empty for a local socket.
        file: that holds the token.
        notes: what the session has said so far.
    """

    address: str
    token: str
    file: Path
    notes: list[str]

    def connected(self) -> socket.socket:
        """Return a connection that has said nothing yet."""
        if not self.token:
            one = socket.socket(socket.AF_UNIX)
            try:
                one.connect(self.address)
            except OSError:
                one.close()
                raise
        else:
            host, _, number = self.address.rpartition(":")
            one = socket.create_connection((host, int(number)))
        one.settimeout(60)
        return one

    @property
    def hello(self) -> bytes:
        """The first line of a director."""
        return request("hello", 0, token=self.token) + b"\n"

    @contextmanager
    def director(self) -> Iterator[tuple[socket.socket, BinaryIO]]:
        """Connect as the director; yield the connection and what it answers."""
        with self.connected() as one, one.makefile("rb") as lines:
            one.sendall(self.hello)
            assert "result" in json.loads(lines.readline())
            yield one, lines


Client = Callable[[Entrance], None]


def port_in(folder: Path) -> Transport:
    """Return the transport over a free port, whose token is in `folder`."""
    return transport_for(None, 0, LOOPBACK, None, Outputs(folder, "stage_directed"))


def socket_at(path: Path) -> Transport:
    """Return the transport over a local socket."""
    return transport_for(path, None, LOOPBACK, None, Outputs(path.parent, "stage_directed"))


def directed(
    transport: Transport, folder: Path, client: Client, scene: Scene | None = None
) -> RecordedScene:
    """Serve the stage, or another scene, over a transport to a client in a thread of its own."""
    clients, notes = list[threading.Thread](), list[str]()

    def note(text: str, detail: bool = False) -> None:
        notes.append(text)
        if found := re.fullmatch("waiting at (.*)", text):
            said = re.search(r"^token (\S+) \(in (.*)\)$", "\n".join(notes), re.MULTILINE)
            token, file = said.groups() if said else ("", "")
            entrance = Entrance(found[1], token, Path(file), notes)
            clients.append(threading.Thread(target=_run, args=[client, entrance]))
            clients[0].start()

    recorder = SceneRecorder("stage_directed", folder, Reporter())
    recorder.reporter.note = note  # type: ignore[method-assign]
    kept = direct(scene or stage(), recorder, transport)
    for one in clients:
        one.join()
    return kept


def _run(client: Client, entrance: Entrance) -> None:
    try:
        client(entrance)
    finally:
        # A client that failed must not leave the session waiting.
        with contextlib.suppress(OSError), entrance.connected() as one:
            one.sendall(entrance.hello)


def assert_complete(kept: RecordedScene) -> None:
    """Check that the kept take reaches the scene's end and replays."""
    assert kept.frames == stage().n_frames
    assert read_take(kept.take).digest == kept.digest == replayed(kept.scene).digest
