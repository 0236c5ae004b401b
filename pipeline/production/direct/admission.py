"""Admission: the first connection that proves to be the director gets the scene.

All connections are heard at once, so that one that says nothing keeps nobody out.
"""

from __future__ import annotations

import contextlib
import selectors
import socket
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from pipeline.errors import StoreError
from pipeline.production.direct.access_token import HELLO, is_hello
from pipeline.production.direct.messages import refusal

HELLO_TIMEOUT = 5.0
"""Time in which a connection has to send its first line [s]."""

MAX_HELLO_BYTES = 4096
"""Longest first line [bytes]."""

MAX_CANDIDATES = 64
"""Most connections that are heard at once; the oldest gives way to a new one."""

OTHER_PROTOCOL = "it speaks another protocol, as browsers do"
WRONG_HELLO = f"its first line is no `{HELLO}` with the token of this session"
LONG_HELLO = f"its first line is longer than {MAX_HELLO_BYTES} bytes"
LATE_HELLO = "its first line was not there in time"
CROWDED_OUT = f"{MAX_CANDIDATES} others connected after it"

REFUSED = -32003
"""Code of the error that a refused connection gets before it is closed."""

Note = Callable[[str], None]


@dataclass(slots=True)
class Candidate:
    """A connection that may become the director's.

    Attributes:
        connection: that does not wait.
        peer: its address.
        since: when it was accepted, by the monotonic clock [s].
        received: what it has sent so far.
    """

    connection: socket.socket
    peer: str
    since: float
    received: bytearray = field(default_factory=bytearray)


class Admission:
    """Hears the connections of a listener until one of them is the director's.

    Args:
        listener: that listens.
        token: that the first line has to hold; None where the system lets in the owner alone: then
            the first connection that sends anything directs.
        note: reports refused connections, once per reason.
    """

    def __init__(self, listener: socket.socket, token: str | None, note: Note) -> None:
        self._listener = listener
        self._token = token
        self._note = note
        self._noted = set[str]()
        self._selector = selectors.DefaultSelector()
        self._candidates: list[Candidate] = []

    def director(self) -> tuple[socket.socket, bytes]:
        """Return the director's connection and what it has sent; all others are closed.

        Raises:
            StoreError: the system accepts no connection.
        """
        self._listener.setblocking(False)
        self._selector.register(self._listener, selectors.EVENT_READ)
        try:
            while True:
                for candidate in self._ready():
                    if self._is_director(candidate):
                        self._candidates.remove(candidate)
                        candidate.connection.setblocking(True)
                        return candidate.connection, bytes(candidate.received)
                self._refuse_late()
        finally:
            self._selector.close()
            for candidate in self._candidates:
                candidate.connection.close()

    def _ready(self) -> Iterator[Candidate]:
        """Yield the candidates that have sent something, and then a new one."""
        keys = [key for key, _ in self._selector.select(self._remaining())]
        yield from (key.data for key in keys if key.data is not None)
        if any(key.data is None for key in keys) and (candidate := self._accepted()):
            yield candidate

    def _accepted(self) -> Candidate | None:
        """Accept a connection; the oldest gives way if there are too many."""
        try:
            connection, address = self._listener.accept()
        except (BlockingIOError, ConnectionError):
            return None
        except OSError as error:
            raise StoreError(f"no connection can be accepted ({error.strerror})") from error
        if len(self._candidates) >= MAX_CANDIDATES:
            self._refuse(self._candidates[0], CROWDED_OUT)
        connection.setblocking(False)
        peer = "{}:{}".format(*address[:2]) if isinstance(address, tuple) else "a local program"
        candidate = Candidate(connection, peer, time.monotonic())
        self._candidates.append(candidate)
        self._selector.register(connection, selectors.EVENT_READ, candidate)
        return candidate

    def _is_director(self, candidate: Candidate) -> bool:
        """Read what a candidate has sent, and judge it; close it if it is refused."""
        try:
            data = candidate.connection.recv(MAX_HELLO_BYTES)
        except BlockingIOError:
            return False
        except OSError:
            data = b""
        if not data:
            self._close(candidate)
            return False
        candidate.received += data
        reason = "" if self._token is None else _fault(bytes(candidate.received), self._token)
        if reason:
            self._refuse(candidate, reason)
        return reason == ""

    def _remaining(self) -> float | None:
        """Return the time until the oldest candidate is late [s], None if none can be."""
        if self._token is None or not self._candidates:
            return None
        return max(self._candidates[0].since + HELLO_TIMEOUT - time.monotonic(), 0.0)

    def _refuse_late(self) -> None:
        while self._remaining() == 0.0:
            self._refuse(self._candidates[0], LATE_HELLO)

    def _refuse(self, candidate: Candidate, reason: str) -> None:
        """Close a connection, and say why."""
        if reason not in self._noted:
            self._noted.add(reason)
            self._note(f"refused a connection from {candidate.peer}: {reason}")
        if reason != OTHER_PROTOCOL:
            text = refusal({"code": REFUSED, "message": f"refused: {reason}"})
            with contextlib.suppress(OSError):
                candidate.connection.send(f"{text}\n".encode())
        self._close(candidate)

    def _close(self, candidate: Candidate) -> None:
        self._selector.unregister(candidate.connection)
        self._candidates.remove(candidate)
        candidate.connection.close()


def _fault(received: bytes, token: str) -> str | None:
    """Return what is wrong with what a connection has sent, empty if it is the director's.

    Args:
        received: from its first byte on.
        token: of the session.

    Returns:
        None while the first line is not complete: nothing but that line decides.
    """
    if not received.startswith(b"{"):
        return OTHER_PROTOCOL
    line, newline, _ = received.partition(b"\n")
    if len(line) > MAX_HELLO_BYTES:
        return LONG_HELLO
    if not newline:
        return None
    return "" if is_hello(line, token) else WRONG_HELLO
