"""Commanding process: runs random command lines in itself and says what became of each.

    python -m tests.production.commanding_process FOLDER FIRST LAST

(One seed alone: its number and the next one.)

When it has started, it prints a JSON line for each seed from the FIRST on and before the LAST:
`seed`, `words`, `code`, `kind` ("right" for what obeys the laws below, else "fault"), `text` and
`seconds`. A command that is still at work after some time gets Ctrl-C, after which this process
ends.

The laws: no traceback, a documented exit code, a message where it is not 0 and none of an error
where it is, no control characters, and no file outside of the folder.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline import cli
from pipeline.commands import options
from pipeline.production.run.interrupts import heard, listen
from tests.production.fuzzing import READY, ROOT
from tests.production.random_commands import lay_out, random_command

DOCUMENTED = (ROOT / "docs/outputs.md").read_text("utf-8").partition("## Exit codes")[2]

CODES = {int(code) for code in re.findall(r"^\| (\d+) \|", DOCUMENTED, re.MULTILINE)}
"""Documented exit codes."""

DEADLINE = 12.0
"""Time after which a command gets Ctrl-C: some wait for ever, and some render for hours [s]."""

CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\udc80-\udcff]")

OPENED_TO_WRITE = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND

CHANGES = {
    **dict.fromkeys(("os.mkdir", "os.remove", "os.rmdir", "os.truncate", "os.chmod"), 1),
    **dict.fromkeys(("os.rename", "os.link", "os.symlink"), 2),
}
"""Audited calls that change files, with the number of their paths."""


@dataclass
class Watch:
    """Watch over the files that this process changes.

    Attributes:
        allowed: folders and files that it may.
        outside: others that it changed or tried to.
    """

    allowed: tuple[str, ...]
    outside: list[str] = field(default_factory=list)

    def hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Hear of a call; see `sys.addaudithook`."""
        if event == "open":
            path, _, flags = arguments
            if isinstance(flags, int) and flags & OPENED_TO_WRITE:
                self._note(path)
        elif event in CHANGES:
            for path in arguments[: CHANGES[event]]:
                self._note(path)

    def _note(self, path: Any) -> None:
        if isinstance(path, str | bytes | os.PathLike):
            try:
                whole = os.path.realpath(os.fsdecode(path))
            except ValueError:
                # No file can be called so.
                return
            if not any(whole == one or whole.startswith(f"{one}/") for one in self.allowed):
                self.outside.append(whole)


def main() -> None:
    """Run the command lines that the arguments ask for."""
    folder, first, last = Path(sys.argv[1]).resolve(), int(sys.argv[2]), int(sys.argv[3])
    result = os.fdopen(os.dup(1), "w")
    watch = _prepare(folder)
    listen()
    cli.listen = lambda: None  # type: ignore[assignment]
    result.write(f"{json.dumps(READY)}\n")
    for seed in range(first, last):
        words = random_command(seed)
        case = folder / "case"
        shutil.rmtree(case, ignore_errors=True)
        work = case / "some" / "where"
        work.mkdir(parents=True)
        lay_out(work)
        os.chdir(work)
        watch.outside.clear()
        began = time.monotonic()
        code, out, err = _run(words)
        faults = [*_faults(code, out, err), *(f"wrote to {path}" for path in watch.outside[:3])]
        line = {
            "seed": seed, "words": words, "code": code, "kind": "fault" if faults else "right",
            "text": "; ".join(faults) + f"\n{out[-1500:]}\n{err[-4000:]}" if faults else err[:200],
            "seconds": round(time.monotonic() - began, 3),
        }  # fmt: skip
        result.write(f"{json.dumps(line)}\n")
        result.flush()
        if heard():
            # What waited was stopped; this process takes no more Ctrl-C.
            os._exit(0)
    os._exit(0)


def _prepare(folder: Path) -> Watch:
    """Give this process a home and temporary files in the folder, and watch what it writes."""
    home = folder / "home"
    (home / "tmp").mkdir(parents=True, exist_ok=True)
    code = Path(os.environ.get("NUMBA_CACHE_DIR", Path.home() / ".cache/pronk/compiled"))
    os.environ |= {
        "HOME": str(home), "XDG_CACHE_HOME": str(home / "cache"), "TMPDIR": str(home / "tmp"),
        "NUMBA_CACHE_DIR": str(code), "COLUMNS": "100",
    }  # fmt: skip
    tempfile.tempdir = None
    watch = Watch((str(folder), str(code.resolve()), "/dev/null", "/dev/shm", "/dev/tty"))
    sys.addaudithook(watch.hear)
    return watch


def _run(words: list[str]) -> tuple[Any, str, str]:
    """Run a command line; return the exit code and what it printed."""
    sys.argv = ["pronk", *words]
    options.CURRENT.options = options.Verbosity()
    timer = threading.Timer(DEADLINE, os.kill, (os.getpid(), signal.SIGINT))
    timer.daemon = True
    with _captured() as texts:
        timer.start()
        try:
            cli.main()
        except SystemExit as end:
            code: Any = 0 if end.code is None else end.code
        except BaseException as error:
            code = repr(error)
        timer.cancel()
    return code, *texts


@contextmanager
def _captured() -> Iterator[list[str]]:
    """Capture what this process prints, also below Python: yields output and errors at the end."""
    texts: list[str] = []
    files = [tempfile.TemporaryFile(prefix=name) for name in ("out", "err")]
    before = [os.dup(1), os.dup(2)]
    for number, file in enumerate(files, start=1):
        os.dup2(file.fileno(), number)
    try:
        yield texts
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        for number, (file, old) in enumerate(zip(files, before, strict=True), start=1):
            os.dup2(old, number)
            os.close(old)
            file.seek(0)
            texts.append(file.read().decode("utf-8", "surrogateescape"))
            file.close()


def _faults(code: Any, out: str, err: str) -> Iterator[str]:
    """Yield which laws a command line broke."""
    if code not in CODES:
        yield f"ends with {code!r}"
    if "Traceback (most" in out + err or "a defect of pronk" in out + err:
        yield "prints a traceback"
    if "Warning:" in err:
        yield "prints a warning of Python"
    if code and not (out + err).strip():
        yield "says nothing"
    if code == 0 and re.search("^error: ", err, re.MULTILINE):
        yield "ends with 0 after an error"
    if CONTROL.search(out + err):
        yield "prints control characters"


if __name__ == "__main__":
    main()
