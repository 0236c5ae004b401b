"""Rendering process: renders a tiny scene with the disk shim, once or with every call failing.

    python -m tests.disk.rendering_process record FOLDER LOG SETS...
    python -m tests.disk.rendering_process fail FOLDER CODE NUMBERS SETS...

`record` renders in a folder of a studio and logs all calls. `fail` renders again and again from the
same state; each time another call fails: `all` of them in turn, or those of the NUMBERS, such as
1,4,9. It prints a JSON line for each: the call, exit code, errors, and what the outputs are
afterwards; the first time that they are so, also what the next run makes of them.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pipeline import cli
from pipeline.production.run.order import Order
from pipeline.production.run.production import render
from pipeline.production.run.progress import Reporter
from pipeline.spec import load_scene
from tests.disk.shim import Shim

ALL = "all"
"""Numbers of all calls."""


def main() -> None:
    """Do what the arguments ask."""
    how, folder, *rest = sys.argv[1:]
    studio = Path(folder).resolve()
    if how == "record":
        log, *sets = rest
        record(studio, Path(log), sets)
    else:
        code, numbers, *sets = rest
        fail(studio, int(code), [] if numbers == ALL else [*map(int, numbers.split(","))], sets)


def record(studio: Path, log: Path, sets: list[str]) -> None:
    """Render and log all calls below the folder `out` of a studio."""
    _warm_up(studio, sets)
    shim = Shim()
    shim.start(studio / "out", log)
    render(Order(load_scene(studio / "tiny.yaml", sets), "tiny", studio / "out"), Reporter())
    shim.stop()


def fail(studio: Path, code: int, numbers: list[int], sets: list[str]) -> None:
    """Render from the same state with another call failing each time, and once more after that.

    Args:
        studio: that is rendered in.
        code: number of the error.
        numbers: of the calls that fail; none for all in turn.
        sets: values of the scene that are changed.
    """
    _warm_up(studio, sets)
    shim, seen = Shim(), list[dict[str, str]]()
    arguments = ["render", "tiny", *(word for text in sets for word in ("--set", text))]
    before = studio.parent / f"{studio.name}.before"
    if not before.exists():
        shutil.copytree(studio / "out", before)
    os.chdir(studio)
    for number in numbers or itertools.count(1):
        shutil.rmtree(studio / "out")
        shutil.copytree(before, studio / "out")
        with _captured() as err:
            shim.start(studio / "out", None, number, code)
            end = _command(arguments)
            shim.stop()
        if not shim.failed:
            break
        state = contents(studio / "out")
        line: dict[str, Any] = {
            "number": number,
            "call": shim.failed.replace(str(studio), ""),
            "code": end,
            "err": err.getvalue(),
            "state": state,
        }
        if state not in seen:
            seen.append(state)
            with _captured() as next_err:
                line["next_code"] = _command(arguments)
            line |= {"next_err": next_err.getvalue(), "next_state": contents(studio / "out")}
        print(json.dumps(line), flush=True)  # noqa: T201 (the result)


def contents(folder: Path) -> dict[str, str]:
    """Return the contents of outputs but for times, as hexadecimal digits of a digest."""
    from pipeline.production.run.file_records import content_digest

    return {
        path.relative_to(folder).as_posix(): content_digest(path)
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "manifest.json"
    }


def _warm_up(studio: Path, sets: list[str]) -> None:
    """Load and compile what a first render does, elsewhere."""
    with tempfile.TemporaryDirectory() as folder:
        render(Order(load_scene(studio / "tiny.yaml", sets), "tiny", Path(folder)), Reporter())


def _command(arguments: list[str]) -> int:
    """Run a command and return its exit code; a traceback goes to standard error."""
    import traceback

    sys.argv = ["pronk", *arguments]
    cli.listen = lambda: None  # type: ignore[assignment]
    try:
        cli.main()
    except SystemExit as end:
        return int(end.code or 0)
    except BaseException:
        traceback.print_exc()
        return -1


@contextlib.contextmanager
def _captured() -> Iterator[io.StringIO]:
    """Capture what a command prints: yields its errors."""
    err = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(err):
        yield err


if __name__ == "__main__":
    main()
