"""Browsers: no page, whatever it tries, reaches a scene that waits at a port.

Chromium opens a page that was made for it. The same requests go to a port that writes down what it
is sent, which shows that they arrive.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import shutil
import signal
import socket
import socketserver
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import pytest

from pipeline.production.direct.admission import OTHER_PROTOCOL
from pipeline.spec import read_scene
from tests.production.direct.direct_client import STILL, Entrance, directed, port_in, request

PAGE = Path(__file__).with_name("attack_page.html")
BROWSER = "PRONK_BROWSER"
"""Environment variable: the browser to use, which then has to be there."""

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
REBOUND = "rebound.test"
"""Name that leads first to the attacker and then to this machine."""

ATTACKER = "127.0.0.2"
"""Address of the attacker, who has every port that this machine has."""

WITH_LINES = (b"fetch", b"request", b"beacon", b"form")
KINDS = (*WITH_LINES, b"put", b"image", b"script", b"frame", b"websocket", b"events")
"""Requests that have to arrive; those of the first kinds hold JSON-RPC lines."""


@pytest.fixture
def browser() -> str:
    """Return the path of a browser."""
    wanted = os.environ.get(BROWSER)
    found = next(filter(None, map(shutil.which, [wanted] if wanted else NAMES)), None)
    if found is None and wanted:
        pytest.fail(f"{BROWSER}={wanted} is no program")
    if found is None:
        pytest.skip(f"no Chromium here ({', '.join(NAMES)}); {BROWSER} names another")
    return found


Handler = type[socketserver.BaseRequestHandler]


class _Server(socketserver.ThreadingTCPServer):
    """A server whose threads end with it."""

    allow_reuse_address = True
    daemon_threads = True
    request_queue_size = 64


@contextmanager
def _serving(address: tuple[str, int], handler: Handler) -> Iterator[int]:
    """Serve at an address; yield the port."""
    with _Server(address, handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield int(server.server_address[1])
        server.shutdown()


def _received(connection: socket.socket) -> bytes:
    """Return what a connection sends until it pauses."""
    data = b""
    connection.settimeout(0.3)
    with contextlib.suppress(OSError):
        while more := connection.recv(65536):
            data += more
    return data


def _answer(body: bytes) -> bytes:
    head = b"HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nConnection: close\r\n"
    return head + b"Content-Length: %d\r\n\r\n" % len(body) + body


def _page_handler(reports: queue.Queue[Any]) -> Handler:
    """Return the handler of the page's own server, which also takes its reports."""

    class Answering(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            data = _received(self.request)
            if data.startswith(b"POST /report"):
                reports.put(json.loads(data.partition(b"\r\n\r\n")[2]))
            is_page = data.startswith(b"GET /?")
            self.request.sendall(_answer(PAGE.read_bytes() if is_page else b""))

    return Answering


def _control_handler(heard: list[bytes]) -> Handler:
    """Return the handler of a server that writes down what it is sent."""

    class Answering(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            heard.append(_received(self.request))

    return Answering


def _rebinding_handler(target: tuple[str, int]) -> Handler:
    """Return the handler of the attacker's address: a page, and then all that `target` is."""
    is_rebound = threading.Event()

    class Answering(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            data = _received(self.request)
            if not is_rebound.is_set():
                if data.startswith(b"GET /rebind"):
                    is_rebound.set()
                self.request.sendall(_answer(PAGE.read_bytes()))
                return
            with contextlib.suppress(OSError), socket.create_connection(target) as onward:
                onward.sendall(data)
                self.request.sendall(_received(onward))

    return Answering


@contextmanager
def _opened(browser: str, page: str, folder: Path) -> Iterator[None]:
    """Open a page in a browser."""
    options = [
        *("--headless=new", "--disable-gpu", "--no-first-run", "--disable-background-networking"),
        *([] if os.geteuid() else ["--no-sandbox"]),
        # New versions ask the user before a page reaches this machine; old ones do not.
        "--disable-features=LocalNetworkAccessChecks,BlockInsecurePrivateNetworkRequests",
        f"--host-resolver-rules=MAP {REBOUND} {ATTACKER}",
        f"--user-data-dir={folder / 'profile'}",
    ]
    process = subprocess.Popen(
        [browser, *options, page],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        yield
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.mark.nightly
def test_no_page_of_a_browser_reaches_the_scene(browser: str, tmp_path: Path) -> None:
    reports, heard = queue.Queue[Any](), list[bytes]()
    found: dict[str, Any] = {}

    def client(entrance: Entrance) -> None:
        host, _, number = entrance.address.rpartition(":")
        target = (host, int(number))
        with (
            _serving(("127.0.0.1", 0), _page_handler(reports)) as page,
            _serving(("127.0.0.1", 0), _control_handler(heard)) as control,
            _serving((ATTACKER, target[1]), _rebinding_handler(target)),
        ):
            hosts = [("host", f"127.0.0.1:{port}") for port in (target[1], control)]
            rebound = f"{REBOUND}:{target[1]}"
            same = urlencode([("report", page), ("rebind", 1), ("host", rebound)])
            also = ("also", f"http://{rebound}/?{same}")
            foreign = urlencode([("report", page), *hosts, also])
            with _opened(browser, f"http://127.0.0.1:{page}/?{foreign}", tmp_path):
                for _ in range(2):
                    report = reports.get(timeout=240)
                    found[report["from"].partition(":")[0]] = report["found"]
        with entrance.director() as (one, lines):
            one.sendall(request("query", what=["time"]) + b"\n")
            found["step"] = json.loads(lines.readline())["result"]["time"]["step"]
            found["notes"] = list(entrance.notes)

    kept = directed(port_in(tmp_path), tmp_path, client, read_scene(STILL))
    assert kept.frames == 4
    assert found["step"] == 0
    assert sum(OTHER_PROTOCOL in note for note in found["notes"]) == 1
    for page, attacks in (("127.0.0.1", 24), (REBOUND, 12)):
        assert len(found[page]) == attacks
        assert "jsonrpc" not in json.dumps(found[page])
    # The requests were made, and carried the orders where a request can.
    for kind in KINDS:
        assert any(b"/" + kind + b"/a" in text for text in heard), kind
    for kind in WITH_LINES:
        assert any(b"/" + kind + b"/a" in t and b'"method": "end"' in t for t in heard), kind
    assert any(text.startswith(b"\x16\x03") for text in heard)
