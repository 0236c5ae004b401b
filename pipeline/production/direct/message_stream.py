"""Message stream: one message per line over two byte streams, with limits in both directions."""

from __future__ import annotations

import io
import os
import select
import socket
import time
from collections.abc import Callable, Iterator
from typing import BinaryIO, cast

from pipeline.production.direct.messages import MAX_MESSAGE_BYTES, OversizedMessage

DISCARD_BYTES = 2**16
"""Block size when a longer message is discarded [bytes]."""

STALL_LIMIT = 60.0
"""Time that sending waits for the other program to read anything at all [s]."""


class Disconnected(Exception):
    """The other program has disconnected, or reads nothing."""


class MessageStream:
    """Two byte streams with one message per line.

    Attributes:
        end: why nothing can be sent any more; empty while something can.
    """

    def __init__(self, reader: BinaryIO, writer: BinaryIO) -> None:
        self.end = ""
        self._reader = reader
        self._writer = writer

    def messages(self) -> Iterator[bytes | OversizedMessage]:
        """Yield messages until either end closes; blank lines are skipped."""
        while not self.end and (line := self._line()):
            if len(line) > MAX_MESSAGE_BYTES:
                self._skip(line)
                yield OversizedMessage()
            elif line.strip():
                yield line

    def send(self, text: str) -> None:
        """Send a message.

        Raises:
            Disconnected: nobody takes it, or nobody took an earlier one.
        """
        if self.end:
            raise Disconnected(self.end)
        try:
            self._writer.write(text.encode("ascii") + b"\n")
            self._writer.flush()
        except (OSError, ValueError) as error:
            is_stalled = isinstance(error, TimeoutError)
            self.end = str(error) if is_stalled else "has disconnected"
            raise Disconnected(self.end) from error

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


class StallLimitedWriter(io.RawIOBase):
    """Writes as fast as the other end reads, which may pause for `STALL_LIMIT` at most.

    Where the system cannot wait for a descriptor with a limit (Windows), writing waits without one.

    Args:
        descriptor: to wait for.
        write_some: writes the start of some bytes without waiting and returns their number.
    """

    def __init__(self, descriptor: int, write_some: Callable[[memoryview], int]) -> None:
        self._descriptor = descriptor
        self._write_some = write_some

    def writable(self) -> bool:
        """Return whether there is anything to write to."""
        return not self.closed

    def write(self, data: object) -> int:
        """Write all of it.

        Raises:
            TimeoutError: the other end reads nothing; the text says so.
            OSError: it has disconnected.
        """
        left = memoryview(cast(bytes, data))
        size, deadline = len(left), time.monotonic() + STALL_LIMIT
        while left:
            self._wait(deadline)
            try:
                written = self._write_some(left)
            except BlockingIOError:
                continue
            left, deadline = left[written:], time.monotonic() + STALL_LIMIT
        return size

    def _wait(self, deadline: float) -> None:
        """Wait until something can be written, to a deadline of the monotonic clock [s]."""
        if not hasattr(select, "poll"):
            return
        poll = select.poll()
        poll.register(self._descriptor, select.POLLOUT)
        remaining = deadline - time.monotonic()
        if remaining <= 0 or not poll.poll(remaining * 1e3):
            raise TimeoutError(f"has read nothing for {STALL_LIMIT:g} s")


def pipe_writer(descriptor: int) -> BinaryIO:
    """Return a writer to a pipe, a file or a terminal, which stays open when the writer closes."""
    # A pipe that is ready takes this much without waiting.
    size = getattr(select, "PIPE_BUF", 2**16)
    writer = StallLimitedWriter(descriptor, lambda data: os.write(descriptor, data[:size]))
    return cast(BinaryIO, writer)


def socket_writer(connection: socket.socket) -> BinaryIO:
    """Return a writer to a connection, which stays open when the writer closes."""
    flags = getattr(socket, "MSG_DONTWAIT", 0)
    writer = StallLimitedWriter(connection.fileno(), lambda data: connection.send(data, flags))
    return cast(BinaryIO, writer)


def socket_reader(connection: socket.socket, received: bytes) -> BinaryIO:
    """Return a reader of a connection of which something was received already."""
    return cast(BinaryIO, io.BufferedReader(_SocketReader(connection, received)))


class _SocketReader(io.RawIOBase):
    """Reads what was received already, then the connection."""

    def __init__(self, connection: socket.socket, received: bytes) -> None:
        self._connection = connection
        self._received = received

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: object) -> int:
        target = cast(memoryview, buffer)
        if not self._received:
            return self._connection.recv_into(target)
        part = self._received[: len(target)]
        target[: len(part)] = part
        self._received = self._received[len(part) :]
        return len(part)
