"""Reader process: a child process in which compiled libraries read foreign files.

Whatever a file does to its reader, the parent gets an answer or an error within bounded time.
A child costs 20 ms and the imports of its reader; one child can read many files.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Self

from pipeline.foreign_files.safe_file import CHUNK_BYTES, ForeignFileError

_PROGRAM = """\
import json, sys
sys.path.insert(0, sys.argv[1])
from pipeline.foreign_files.reader_child import start
start(json.loads(sys.argv[2]))
"""

# One thread each: their stacks count as memory, and none of the readers is faster with more.
_ENVIRONMENT = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

WALL_FACTOR, WALL_MARGIN = 4.0, 20.0
"""Time that a reading may take, as a multiple of its processor time, and beyond it [s]."""

_MAX_HEAD_BYTES = 2**20


class ReaderMissing(Exception):
    """The library that reads a kind of files is not installed."""


class ReaderProcessError(Exception):
    """The child process could not do its work, whatever the file holds."""


@dataclass(frozen=True, slots=True)
class Reading:
    """One file to be read.

    Attributes:
        reader: the function, as `module:name`; see `reader_child.Reader`.
        file: its path.
        memory: that the reader may take [bytes].
        seconds: processor time that it may take.
        settings: for the reader, as JSON has them.
        max_bytes: size of the largest content that is taken.
    """

    reader: str
    file: Path
    memory: int
    seconds: float
    settings: dict[str, Any] = field(default_factory=dict)
    max_bytes: int = 0

    def line(self) -> bytes:
        """Return the request for the child."""
        members = {
            "reader": self.reader,
            "file": os.fspath(self.file.absolute()),
            "memory": self.memory,
            "seconds": self.seconds,
            "settings": self.settings,
        }
        return json.dumps(members).encode() + b"\n"


class ReaderProcess:
    """A child process that reads files one after the other; after a crash another takes over."""

    def __init__(self) -> None:
        self._child: subprocess.Popen[bytes] | None = None
        self._timed_out = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the child."""
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            child.communicate()

    def read(self, reading: Reading, receive: Callable[[bytes], object] | None = None) -> Any:
        """Read one file and return the facts that its reader found.

        Args:
            reading: the file and its bounds.
            receive: called with each part of the content, all but the last of `CHUNK_BYTES`.

        Raises:
            ForeignFileError: the file is wrong, or its reader crashed or reached its limits.
            ReaderMissing: the library of the reader is not installed.
            ReaderProcessError: no child could be started.
        """
        child = self._child = self._child or _started()
        limit = WALL_FACTOR * reading.seconds + WALL_MARGIN
        self._timed_out = False
        timer = threading.Timer(limit, self._end_in_time, (child,))
        timer.daemon = True
        timer.start()
        try:
            return _exchange(child, reading, receive or (lambda part: None))
        except (EOFError, BrokenPipeError):
            error = self._error_of_death(child, reading)
            self.close()
            raise error from None
        except BaseException as error:
            # What is left of an answer that was not taken would be taken for the next.
            if not isinstance(error, ForeignFileError | ReaderMissing):
                self.close()
            raise
        finally:
            timer.cancel()

    def _end_in_time(self, child: subprocess.Popen[bytes]) -> None:
        self._timed_out = True
        child.kill()

    def _error_of_death(self, child: subprocess.Popen[bytes], reading: Reading) -> Exception:
        """Return the error of a child that has ended before its answer."""
        _, said = child.communicate()
        code = child.returncode
        if self._timed_out or code == -getattr(signal, "SIGXCPU", 0):
            return ForeignFileError(f"takes longer than {reading.seconds:g} s to be read")
        if code < 0:
            return ForeignFileError(f"crashes its reader ({_signal_name(-code)}); it is damaged")
        last = (said.decode(errors="replace").strip().splitlines() or [f"exit code {code}"])[-1]
        return ReaderProcessError(
            f"{reading.file}: the process that reads it ended too early: {last}"
        )


def read_confined(reading: Reading, receive: Callable[[bytes], object] | None = None) -> Any:
    """Read one file in a child of its own, or in the shared one; see `ReaderProcess.read`."""
    if _shared:
        return _shared[-1].read(reading, receive)
    with ReaderProcess() as process:
        return process.read(reading, receive)


_shared: list[ReaderProcess] = []


@contextmanager
def shared_process() -> Iterator[None]:
    """Let one child read all files inside the block."""
    with ReaderProcess() as process:
        _shared.append(process)
        try:
            yield
        finally:
            _shared.remove(process)


def _started() -> subprocess.Popen[bytes]:
    """Start a child that has the imports of this process and nothing else of its start.

    Raises:
        ReaderProcessError: it does not start.
    """
    house = str(Path(__file__).parents[2])
    path = [house, *(entry for entry in sys.path if entry)]
    # Without `site`, which costs more than the rest of the start.
    command = [sys.executable, "-I", "-S", "-c", _PROGRAM, house, json.dumps(path)]
    try:
        return subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**os.environ, **_ENVIRONMENT},
        )
    except (OSError, ValueError) as error:
        raise ReaderProcessError(f"no process can be started to read files: {error}") from error


def _exchange(
    child: subprocess.Popen[bytes], reading: Reading, receive: Callable[[bytes], object]
) -> Any:
    """Send a request and take its answer.

    Raises:
        EOFError, BrokenPipeError: the child has ended.
        ForeignFileError: the file is wrong.
        ReaderMissing: the library of the reader is not installed.
    """
    assert child.stdin is not None
    assert child.stdout is not None
    child.stdin.write(reading.line())
    child.stdin.flush()
    head = _head(child.stdout)
    if "missing" in head:
        raise ReaderMissing(head["missing"])
    if "refused" in head:
        raise ForeignFileError(head["refused"])
    left = head["size"]
    if left > reading.max_bytes:
        raise EOFError
    while left:
        part = child.stdout.read(min(left, CHUNK_BYTES))
        if not part:
            raise EOFError
        left -= len(part)
        receive(part)
    return head["facts"]


def _head(answers: IO[bytes]) -> Any:
    line = answers.readline(_MAX_HEAD_BYTES)
    if not line.endswith(b"\n"):
        raise EOFError
    return json.loads(line)


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
