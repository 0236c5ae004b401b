"""Transport: messages over standard input and output, a local socket, or a TCP port.

Each line is a message. A socket is open to this machine alone unless its host is given, and is
closed once a program has connected, because a scene has one director.
"""

from __future__ import annotations

import contextlib
import io
import ipaddress
import os
import re
import socket
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import BinaryIO

from pipeline.errors import StoreError, UsageError

MAX_MESSAGE_BYTES = 2**20
"""Longest message that is read [bytes]."""

DISCARD_BYTES = 2**16
"""Block size when a longer message is discarded [bytes]."""


class Disconnected(Exception):
    """The other program has disconnected."""


class OversizedMessage:
    """Stands for a message that is too long."""


class MessageStream:
    """Two byte streams with one message per line."""

    def __init__(self, reader: BinaryIO, writer: BinaryIO) -> None:
        self._reader = reader
        self._writer = writer

    def messages(self) -> Iterator[bytes | OversizedMessage]:
        """Yield messages until the other end closes; blank lines are skipped."""
        while line := self._line():
            if len(line) > MAX_MESSAGE_BYTES:
                self._skip(line)
                yield OversizedMessage()
            elif line.strip():
                yield line

    def send(self, text: str) -> None:
        """Send a message.

        Raises:
            Gone: nobody takes it.
        """
        try:
            self._writer.write(text.encode("ascii") + b"\n")
            self._writer.flush()
        except (OSError, ValueError) as error:
            raise Disconnected from error

    def _line(self) -> bytes:
        try:
            return self._reader.readline(MAX_MESSAGE_BYTES + 1)
        except (OSError, ValueError):
            return b""

    def _skip(self, line: bytes) -> None:
        """Discard the rest of a line."""
        while line and not line.endswith(b"\n"):
            try:
                line = self._reader.readline(DISCARD_BYTES)
            except (OSError, ValueError):
                return


Announce = Callable[[str], None]
Transport = Callable[[Announce], AbstractContextManager[MessageStream]]
"""Opens a message stream and announces its address."""

LOOPBACK = "127.0.0.1"

HTTP_REQUEST = re.compile(rb"[A-Z]+ \S+ HTTP/")
"""Start of a browser's request, which any web page can cause."""


def transport_for(path: Path | None, number: int | None, host: str) -> Transport:
    """Return the transport for these options, by default standard input and output.

    Raises:
        UsageError: the options contradict each other, or the socket is occupied.
    """
    if path is not None and number is not None:
        raise UsageError("--socket and --port conflict; give one of them")
    if number is None and host != LOOPBACK:
        raise UsageError("--host is the address of a port; give --port as well")
    if path is not None:
        return local_socket(path)
    return standard_streams if number is None else tcp_port(number, host)


@contextmanager
def standard_streams(announce: Announce) -> Iterator[MessageStream]:
    """Open standard input and output; other prints go to standard error."""
    del announce
    sys.stdout.flush()
    out = os.dup(1)
    os.dup2(2, 1)
    try:
        with (
            _closing(open(0, "rb", closefd=False)) as reader,
            _closing(open(out, "wb", closefd=False)) as writer,
        ):
            yield MessageStream(reader, writer)
    finally:
        sys.stdout.flush()
        os.dup2(out, 1)
        os.close(out)


def local_socket(path: Path) -> Transport:
    """Return the transport over a local socket at `path`, for its owner alone.

    Raises:
        UsageError: the path is occupied.
    """
    _refuse_occupied(path)

    @contextmanager
    def transport(announce: Announce) -> Iterator[MessageStream]:
        with contextlib.closing(socket.socket(socket.AF_UNIX)) as listener:
            before = os.umask(0o177)
            try:
                listener.bind(str(path))
            except OSError as error:
                reason = error.strerror or str(error)
                raise StoreError(f"{path}: no socket can be made there ({reason})") from error
            finally:
                os.umask(before)
            try:
                listener.listen(1)
                announce(f"waiting at {path}")
                with _accepted(listener) as stream:
                    yield stream
            finally:
                path.unlink(missing_ok=True)

    return transport


def tcp_port(number: int, host: str) -> Transport:
    """Return the transport over a TCP port; 0 takes a free one and announces it."""

    @contextmanager
    def transport(announce: Announce) -> Iterator[MessageStream]:
        family, address = _address(host, number)
        with contextlib.closing(socket.socket(family)) as listener:
            try:
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                listener.bind(address)
            except OSError as error:
                reason = error.strerror or str(error)
                raise StoreError(f"{host}:{number}: cannot be listened at ({reason})") from error
            listener.listen(1)
            place = "{}:{}".format(*listener.getsockname()[:2])
            if not ipaddress.ip_address(listener.getsockname()[0]).is_loopback:
                announce(f"note: whoever can reach {place} can direct this scene")
            announce(f"waiting at {place}")
            with _accepted(listener) as stream:
                yield stream

    return transport


def _address(host: str, number: int) -> tuple[socket.AddressFamily, tuple[str, int]]:
    try:
        found = socket.getaddrinfo(host, number, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        raise UsageError(f"--host {host!r} is no address of this machine") from error
    return found[0], (str(found[4][0]), number)


@contextmanager
def _accepted(listener: socket.socket) -> Iterator[MessageStream]:
    """Wait for a program to connect and stop listening; browsers are refused."""
    while True:
        connection, _ = listener.accept()
        reader = connection.makefile("rb")
        first = _first_bytes(reader)
        if HTTP_REQUEST.match(first) is None:
            break
        reader.close()
        connection.close()
    listener.close()
    with connection, _closing(reader), _closing(connection.makefile("wb")) as writer:
        yield MessageStream(reader, writer)


@contextmanager
def _closing(stream: BinaryIO) -> Iterator[BinaryIO]:
    """Close a stream at the end; unsent data of a lost connection is dropped."""
    try:
        yield stream
    finally:
        with contextlib.suppress(OSError):
            stream.close()


def _first_bytes(reader: io.BufferedReader) -> bytes:
    """Return the first bytes without consuming them."""
    try:
        return reader.peek(64)[:64]
    except OSError:
        return b""


def _refuse_occupied(path: Path) -> None:
    """Remove the socket of a run that was killed; refuse anything else at `path`."""
    if not hasattr(socket, "AF_UNIX"):
        raise UsageError("there are no local sockets on this system; give --port")
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return
    except OSError as error:
        raise UsageError(f"{path}: no socket can be made there ({error.strerror})") from error
    if not stat.S_ISSOCK(mode):
        raise UsageError(f"{path}: there is something else already; choose another place")
    with socket.socket(socket.AF_UNIX) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            path.unlink(missing_ok=True)
            return
    raise UsageError(f"{path}: another run waits there already; choose another place")
