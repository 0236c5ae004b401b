"""Reader child: the side of `reader_process` that runs in the child and calls the readers.

A request is one line of JSON on standard input, and its answer one line of JSON on standard output,
followed by as many bytes as it says. Imports of this module add to the time of every reading.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from pipeline.foreign_files.safe_file import ForeignFileError

try:
    import resource
except ImportError:  # Windows bounds the time alone, which the parent measures.
    resource = None  # type: ignore[assignment]


@dataclass(frozen=True, slots=True)
class Reply:
    """What a reader returns.

    Attributes:
        facts: as JSON has them.
        size: of the content [bytes].
        content: in parts, which may be made while they are sent.
    """

    facts: dict[str, Any] = field(default_factory=dict)
    size: int = 0
    content: Iterable[bytes | memoryview] = ()


Reader = Callable[[Path, dict[str, Any]], Reply]
"""Reads a file by settings; raises `ForeignFileError` where the file is wrong."""


def serve() -> None:
    """Answer requests until standard input ends."""
    requests, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    # What libraries print is no answer.
    for descriptor in (0, 1, 2):
        os.dup2(os.open(os.devnull, os.O_RDWR), descriptor)
    with requests, answers:
        for line in requests:
            _answer(json.loads(line), answers)


def _answer(request: dict[str, Any], answers: BinaryIO) -> None:
    """Call the reader of one request and write its answer."""
    try:
        reply = _reply(request)
        head: dict[str, Any] = {"facts": reply.facts, "size": reply.size}
    except ForeignFileError as error:
        reply, head = Reply(), {"refused": str(error)}
    except ImportError as error:
        reply, head = Reply(), {"missing": str(error)}
    except MemoryError:
        limit = f"{request['memory'] // 2**20} MiB"
        reply, head = Reply(), {"refused": f"needs more than {limit} of memory to be read"}
    except Exception as error:
        # Compiled libraries raise anything on content that they do not understand.
        reply, head = Reply(), {"refused": f"cannot be read: {error or type(error).__name__}"}
    answers.write(json.dumps(head).encode() + b"\n")
    for part in reply.content:
        answers.write(part)
    answers.flush()


def _reply(request: dict[str, Any]) -> Reply:
    module, _, name = request["reader"].partition(":")
    reader: Reader = getattr(importlib.import_module(module), name)
    if resource is not None:
        _limit(request["memory"], request["seconds"])
    return reader(Path(request["file"]), request["settings"])


def _limit(memory: int, seconds: float) -> None:
    """Limit this process in what it takes beyond the present.

    Args:
        memory: address space [bytes].
        seconds: processor time.
    """
    used = resource.getrusage(resource.RUSAGE_SELF)
    _lower(resource.RLIMIT_CPU, int(used.ru_utime + used.ru_stime + seconds) + 1)
    _lower(resource.RLIMIT_FSIZE, 0)
    _lower(resource.RLIMIT_CORE, 0)
    # Elsewhere the present size is not known, or the limit is not kept.
    with suppress(OSError):
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        _lower(resource.RLIMIT_AS, pages * resource.getpagesize() + memory)


def _lower(kind: int, limit: int) -> None:
    """Set a soft limit, within the hard one."""
    _, hard = resource.getrlimit(kind)
    soft = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    with suppress(OSError, ValueError):
        resource.setrlimit(kind, (soft, hard))


def start(path: list[str]) -> None:
    """Serve with the import path of the parent."""
    sys.path[:] = path
    serve()
