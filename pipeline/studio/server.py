"""Server: the studio on a port of this machine, until Ctrl-C."""

from __future__ import annotations

import socket
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.errors import StoreError, UsageError
from pipeline.production.run.interrupts import answered
from pipeline.studio.access import new_token
from pipeline.studio.project import Project

if TYPE_CHECKING:
    import uvicorn

HOST = "127.0.0.1"

STOP_TIMEOUT = 2
"""Time that open requests have to end after Ctrl-C [s]."""

WAKE_INTERVAL = 0.5
"""Time after which the main thread looks whether the server still runs [s]."""

MISSING = "the studio needs more packages: pip install 'pronk[studio]'"


def serve(
    document: Path | None, port: int, opens_browser: bool, note: Callable[[str], None]
) -> None:
    """Serve the studio of the current folder until Ctrl-C.

    Args:
        document: the figure or scene that is shown first, None for a new figure.
        port: 0 for a free one.
        opens_browser: whether to open the page.
        note: told the address.

    Raises:
        UsageError: packages are missing, the document is of another folder, or the port is taken.
        StoreError: the system lets nobody listen.
    """
    try:
        import uvicorn

        from pipeline.studio.app import Studio, application
    except ImportError as error:
        if (error.name or "").split(".")[0] not in ("uvicorn", "starlette"):
            raise
        raise UsageError(MISSING) from None
    project = Project.at(Path.cwd())
    first = project.name_of(document) if document else None
    with listener(port) as bound:
        own_port = bound.getsockname()[1]
        studio = Studio(project, first, new_token())
        settings = uvicorn.Config(
            application(studio, own_port),
            log_level="warning",
            access_log=False,
            lifespan="off",
            server_header=False,
            ws="none",
            timeout_graceful_shutdown=STOP_TIMEOUT,
        )
        address = f"http://{HOST}:{own_port}/?token={studio.token}"
        note(address)
        if opens_browser:
            webbrowser.open(address)
        _run(uvicorn.Server(settings), bound, studio.stop)


def _run(server: uvicorn.Server, bound: socket.socket, stop: Callable[[], None]) -> None:
    """Serve in a thread until Ctrl-C, which reaches the main thread alone."""
    thread = threading.Thread(target=server.run, args=([bound],), name="studio", daemon=True)
    thread.start()
    try:
        while thread.is_alive():
            thread.join(WAKE_INTERVAL)
    except KeyboardInterrupt:
        answered()
    finally:
        stop()
        server.should_exit = True
        thread.join(2 * STOP_TIMEOUT)


def listener(port: int) -> socket.socket:
    """Return a socket that listens on a port of this machine alone.

    Raises:
        UsageError: the port is taken or not allowed.
    """
    # With its protocol named, asyncio sends at once; otherwise the page waits 40 ms for an answer.
    bound = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        bound.bind((HOST, port))
        bound.listen(64)
    except OSError as error:
        bound.close()
        reason = error.strerror or str(error)
        message = f"--port {port}: {reason.lower()}; choose another one, or 0 for any that is free"
        raise (UsageError if port else StoreError)(message) from None
    return bound
