"""Readers that misbehave, for the child process of `reader_process`."""

from __future__ import annotations

import ctypes
import os
import time
from pathlib import Path
from typing import Any

from pipeline.foreign_files.reader_child import Reply
from pipeline.foreign_files.safe_file import BODY_MESH, ForeignFileError, read_file


def echo(path: Path, settings: dict[str, Any]) -> Reply:
    """Return the content of the file and its length, after printing where answers are written."""
    print("no answer", flush=True)  # noqa: T201 - libraries do
    os.write(1, b"no answer either\n")
    content = read_file(path, BODY_MESH)
    return Reply({"length": len(content), **settings}, len(content), [content])


def crash(path: Path, settings: dict[str, Any]) -> Reply:
    """Read at an address that is not there."""
    return Reply({"read": ctypes.string_at(8)})


def loop(path: Path, settings: dict[str, Any]) -> Reply:
    """Never end, and use the processor."""
    while True:
        pass


def sleep(path: Path, settings: dict[str, Any]) -> Reply:
    """Never end, and use nothing."""
    time.sleep(1e6)
    return Reply()


def swell(path: Path, settings: dict[str, Any]) -> Reply:
    """Take more memory than anybody has."""
    return Reply({"length": len(bytes(2**40))})


def write(path: Path, settings: dict[str, Any]) -> Reply:
    """Write a file."""
    path.with_name("written").write_bytes(bytes(1000))
    return Reply()


def refuse(path: Path, settings: dict[str, Any]) -> Reply:
    """Refuse the file."""
    raise ForeignFileError("is no good")


def fail(path: Path, settings: dict[str, Any]) -> Reply:
    """Raise what no reader should."""
    raise KeyError("size")


def stop_halfway(path: Path, settings: dict[str, Any]) -> Reply:
    """Promise more than is sent."""
    return Reply(size=1000, content=iter((bytes(10), bytes(ctypes.string_at(8)))))


def need_library(path: Path, settings: dict[str, Any]) -> Reply:
    """Import what is not installed."""
    import no_such_library  # type: ignore[import-not-found]

    return Reply({"library": str(no_such_library)})
