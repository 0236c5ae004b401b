"""Wire: messages to and from the other program, one a line."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

MOST_BYTES = 2**20
"""Longest message that is read."""

PIECE = 2**16
"""So much of a message that is too long is thrown away at once [bytes]."""


class Gone(Exception):
    """There is nobody at the other end any more."""


class TooLong:
    """Stands for a message that was too long to be read."""


class Wire:
    """Two streams of bytes, of which each line is a message."""

    def __init__(self, reader: BinaryIO, writer: BinaryIO) -> None:
        self._reader = reader
        self._writer = writer

    def messages(self) -> Iterator[bytes | TooLong]:
        """Yield what comes in until the other end closes; blank lines are none."""
        while line := self._line():
            if len(line) > MOST_BYTES:
                self._skip(line)
                yield TooLong()
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
            raise Gone from error

    def _line(self) -> bytes:
        try:
            return self._reader.readline(MOST_BYTES + 1)
        except (OSError, ValueError):
            return b""

    def _skip(self, line: bytes) -> None:
        """Throw away the rest of a line."""
        while line and not line.endswith(b"\n"):
            try:
                line = self._reader.readline(PIECE)
            except (OSError, ValueError):
                return
