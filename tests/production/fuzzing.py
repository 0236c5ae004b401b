"""Fuzzing: processes that try many seeds, one after the other, and are watched while they do."""

from __future__ import annotations

import json
import os
import queue
import resource
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]

LIMIT = 120.0
"""Time after which a case counts as hung: far more than the slowest takes [s]."""

START = 300.0
"""Time for the start of a process, which may compile [s]."""

READY = {"kind": "ready"}
"""What a process prints once it has started."""

ENDED = object()


def hold_memory(allowed: int) -> None:
    """Limit the address space of this process to what it has now and some more [bytes]."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * os.sysconf("SC_PAGE_SIZE") + allowed
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def tried(module: str, folder: Path, first: int, last: int) -> Iterator[dict[str, Any]]:
    """Yield what became of seeds; where a process hangs or dies, go on behind that seed.

    Args:
        module: run with the folder, the first seed, and the one behind the last. It prints
            `READY`, and then a JSON object a line with `seed` and `kind`.
        folder: of its files.
        first: seed.
        last: seed, which is not tried any more.
    """
    while first < last:
        command = [sys.executable, "-m", module, str(folder), str(first), str(last)]
        for line in _lines(command, folder):
            first = line.setdefault("seed", first) + 1
            yield line


def _lines(command: Sequence[str], folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the lines of a process; of one that hangs or dies, a fault in place of the next."""
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    with (folder / "errors.txt").open("w+", encoding="utf-8", errors="replace") as errors:
        process = subprocess.Popen(
            command, env=env, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=errors, text=True,
        )  # fmt: skip
        lines: queue.Queue[Any] = queue.Queue()
        reader = threading.Thread(target=_read, args=(process, lines), daemon=True)
        reader.start()
        wait = START
        try:
            while True:
                line = lines.get(timeout=wait)
                if line is ENDED:
                    process.wait(LIMIT)
                    break
                wait, found = LIMIT, json.loads(line)
                if found != READY:
                    yield found
        except (queue.Empty, subprocess.TimeoutExpired):
            yield {"kind": "fault", "text": f"takes longer than {wait:g} s", "seconds": wait}
            return
        finally:
            process.kill()
            code = process.wait()
            reader.join(LIMIT)
        assert wait == LIMIT, f"{command} has not started: {errors.name}"
        if code:
            errors.seek(0)
            text = f"the process ended with {code}:\n{errors.read()[-6000:]}"
            yield {"kind": "fault", "text": text, "seconds": 0.0}


def _read(process: subprocess.Popen[str], lines: queue.Queue[Any]) -> None:
    assert process.stdout is not None
    with process.stdout:
        for line in process.stdout:
            lines.put(line)
    lines.put(ENDED)
