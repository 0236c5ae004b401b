"""A studio in a folder of its own, served in this process on a free port."""

from __future__ import annotations

import http.client
import json
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from pipeline.studio.app import Studio, application
from pipeline.studio.project import Project
from pipeline.studio.server import listener

SCENE = """\
pronk: 1
frames: 8
terrain: {kind: flat, size: [8, 8], cells: [8, 8]}
cast:
  - {name: bug, figure: beetle, walk: {}}
"""


@dataclass
class Served:
    """A studio that runs, and a client of it.

    Attributes:
        folder: the project.
        studio: what is served.
        port: of this machine.
    """

    folder: Path
    studio: Studio
    port: int

    @property
    def address(self) -> str:
        """The address of the page."""
        return f"http://127.0.0.1:{self.port}/?token={self.studio.token}"

    def request(
        self,
        method: str,
        path: str,
        body: bytes | None = None,
        headers: dict[str, str] | None = None,
        with_token: bool = True,
    ) -> tuple[int, bytes]:
        """Send one request; return status and body."""
        client = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        token = {"X-Studio-Token": self.studio.token} if with_token else {}
        try:
            client.request(method, path, body, {**token, **(headers or {})})
            answer = client.getresponse()
            return answer.status, answer.read()
        finally:
            client.close()

    def ask(self, name: str, /, **message: Any) -> tuple[int, Any]:
        """Ask as the page does; return status and JSON."""
        status, body = self.request("POST", f"/api/{name}", json.dumps(message).encode())
        return status, json.loads(body)


@pytest.fixture(scope="session")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Studio, int]]:
    """A studio that is served on a port as long as there are tests."""
    import uvicorn

    studio = Studio(Project.at(tmp_path_factory.mktemp("empty")), None, "t0ken")
    with listener(0) as bound:
        port = bound.getsockname()[1]
        app = application(studio, port)
        config = uvicorn.Config(app, log_level="error", lifespan="off", ws="none")
        server = uvicorn.Server(config)
        thread = threading.Thread(target=server.run, args=([bound],), daemon=True)
        thread.start()
        while not server.started:
            time.sleep(0.01)
        yield studio, port
        studio.stop()
        server.should_exit = True
        thread.join(10)


@pytest.fixture
def served(running: tuple[Studio, int], tmp_path: Path) -> Served:
    """A studio whose project is a new folder that holds one scene."""
    studio, port = running
    (tmp_path / "project").mkdir()
    (tmp_path / "secret.yaml").write_text("pronk: 1\ncast: []\n")
    studio.project, studio.first = Project.at(tmp_path / "project"), None
    (studio.project.folder / "walk.yaml").write_text(SCENE)
    return Served(studio.project.folder, studio, port)
