"""Killed runs: the same command, killed at many moments, leaves whole files or none."""

from __future__ import annotations

import hashlib
import random
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.production.conftest import Running

POLLING_INTERVAL = 0.002
"""Time between two looks at the files of a run [s]."""


MANIFEST = "manifest.json"


def contents_of(folder: Path) -> dict[str, str]:
    """Return the digest of every file but the manifests, whose seconds never repeat."""
    return {
        str(path.relative_to(folder)): hashlib.blake2b(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != MANIFEST
    }


def kill_repeatedly(run: Callable[[], Running], out: Path, times: int, seed: int) -> None:
    """Kill runs of one command, then let one finish; check what they leave.

    A run is killed at a random moment of its length, the next one when a random number of files is
    there. Each leaves only whole files beside hidden ones, and the last one all of them.

    Args:
        run: starts the command.
        out: folder of its outputs, which nothing else is in.
        times: number of kills; runs that end before theirs are not counted.
        seed: of the moments.
    """
    began = time.monotonic()
    code, _, err = run().end()
    assert code == 0, err
    length, wanted = time.monotonic() - began, contents_of(out)
    shutil.rmtree(out)
    killed = 0
    for i, moment in enumerate(_moments(times, length, len(wanted), seed)):
        if killed == times:
            break
        running = run()
        moment(running, out)
        killed += running.process.poll() is None
        running.kill()
        running.end()
        left = contents_of(out) if out.exists() else {}
        whole = {name: left[name] for name in left if not _is_hidden(name)}
        assert whole.items() <= wanted.items()
        if i % 3 == 2:
            # Else the later moments would find nothing left to do.
            shutil.rmtree(out, ignore_errors=True)
    assert killed == times
    code, _, err = run().end()
    assert (code, "Traceback" in err) == (0, False)
    assert contents_of(out) == wanted


Moment = Callable[["Running", Path], None]


def _moments(times: int, length: float, files: int, seed: int) -> Iterator[Moment]:
    """Yield functions that wait for random moments of a run, twice as many as there are kills.

    Args:
        times: number of kills, which are spread over a run.
        length: of a run [s].
        files: that a run leaves.
        seed: of the moments.
    """
    chance = random.Random(seed)
    for i in range(2 * times):
        part = (i % times + chance.random()) / times
        yield _after(part * length) if i % 2 else _when_there_are(round(part * files))


def _after(delay: float) -> Moment:
    return lambda running, out: time.sleep(delay)


def _when_there_are(files: int) -> Moment:
    """Return a function that waits for a number of files more than there are."""

    def wait(running: Running, out: Path) -> None:
        before = _count(out)
        while running.process.poll() is None and _count(out) - before < files:
            time.sleep(POLLING_INTERVAL)

    return wait


def _count(folder: Path) -> int:
    """Return how many files there are while others come and go."""
    try:
        return sum(path.is_file() for path in folder.rglob("*"))
    except OSError:
        return 0


def _is_hidden(name: str) -> bool:
    return any(part.startswith(".") for part in Path(name).parts)
