"""Text streams: lines to standard output and standard error, with control characters escaped."""

from __future__ import annotations

import logging
import os
from contextlib import suppress
from typing import Any, TextIO

from pipeline.errors import StoreError
from pipeline.terminal_text import escaped, json_line


class EscapingFormatter(logging.Formatter):
    """Formats the records of a log, with control characters escaped."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the text of a record."""
        return escaped(super().format(record))


def print_text(stream: TextIO, text: str) -> None:
    """Write one or more lines at once.

    Raises:
        StoreError: the stream cannot be written to, such as a file on a full disk.
        BrokenPipeError: nobody reads it any more.
    """
    _print(stream, escaped(text))


def print_json(stream: TextIO, members: Any) -> None:
    """Write one line of JSON at once.

    Raises:
        StoreError: the stream cannot be written to.
        BrokenPipeError: nobody reads it any more.
    """
    _print(stream, json_line(members))


def _print(stream: TextIO, text: str) -> None:
    try:
        stream.write(f"{text}\n")
        stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        # What is left in the stream would fail again when Python ends.
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        name = {"<stdout>": "standard output", "<stderr>": "standard error"}.get(stream.name)
        message = f"{name or stream.name} cannot be written to: {error.strerror or error}"
        raise StoreError(message) from error
