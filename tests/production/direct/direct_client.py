"""A small scene to direct, and a client of its session."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from pipeline.production.direct.protocol import Protocol
from pipeline.production.direct.scene_recorder import SceneRecorder
from pipeline.production.direct.server import serve
from pipeline.production.direct.session import Session
from pipeline.production.direct.transport import MessageStream
from pipeline.production.run.progress import Reporter
from pipeline.production.run.take_stage import take_key
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
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
