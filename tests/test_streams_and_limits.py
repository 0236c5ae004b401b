"""Odd surroundings of a command: closed streams, full disks, little memory, odd file names."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.errors import UsageError
from pipeline.production.run.starter_scene import write_starter
from pipeline.spec import find_scene
from pipeline.unexpected_error import Defect, MemoryShort, memory_limit, told_error

POSIX = pytest.mark.skipif(os.name != "posix", reason="descriptors and limits are those of POSIX")
SCENE = "pronk: 1\nduration: 0.2\ncast: [{prop: {shape: ball}}]\n"


def run(
    *arguments: str | bytes, cwd: Path, prepare: Callable[[], None] | None = None, out: str = ""
) -> tuple[int, str]:
    """Run a command in a process of its own; return exit code and standard error."""
    command = [sys.executable, "-c", "from pipeline.cli import main; main()", *arguments]
    root = str(Path(__file__).parents[1])
    with open(out or os.devnull, "w", encoding="utf-8") as stream:
        done = subprocess.run(
            command,
            cwd=cwd,
            env={**os.environ, "PYTHONPATH": root},
            stdout=stream,
            stderr=subprocess.PIPE,
            preexec_fn=prepare,
            check=False,
        )
    return done.returncode, done.stderr.decode()


@POSIX
def test_a_closed_standard_output_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(SCENE, encoding="utf-8")
    code, said = run("check", "a", cwd=tmp_path, prepare=lambda: os.close(1))
    assert code == 2
    assert said == ("error: standard output is closed; write > /dev/null where it is not wanted\n")


@POSIX
@pytest.mark.slow
def test_closed_input_and_errors_change_nothing(tmp_path: Path) -> None:
    def close() -> None:
        os.close(0)
        os.close(2)

    # A file that takes the place of a stream would be written to.
    assert run("check", "none", cwd=tmp_path, prepare=close)[0] == 2


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no full device")
def test_a_full_disk_under_standard_output_is_one_message(tmp_path: Path) -> None:
    code, said = run("list", "gaits", cwd=tmp_path, out="/dev/full")
    message = "error: standard output cannot be written to: No space left on device\n"
    assert (code, said) == (4, message)


@POSIX
def test_too_little_memory_to_begin_is_one_message(tmp_path: Path) -> None:
    import resource

    limit = 200 * 2**20
    code, said = run(
        "check",
        "first_steps",
        cwd=tmp_path,
        prepare=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )
    assert code == 4
    assert said.startswith("error: this process is limited to 200 MiB of memory (ulimit -v); ")
    assert said.count("\n") == 1


def raised(error: Exception, cause: Exception | None = None) -> Exception:
    try:
        raise error from cause
    except type(error) as caught:
        return caught


@pytest.mark.parametrize(
    "error",
    [
        MemoryError(),
        MemoryError("Unable to allocate 23.7 MiB"),
        OSError(errno.ENOMEM, "Cannot allocate memory"),
        raised(ValueError("wrapped"), MemoryError("within")),
    ],
)
def test_short_memory_is_no_defect(error: Exception) -> None:
    told = told_error(error)
    assert isinstance(told, MemoryShort)
    assert told.exit_code == 4
    assert str(told).startswith("memory ran out")
    assert "\n" not in str(told)


def test_other_exceptions_are_defects_and_errors_stay_themselves() -> None:
    loading = ImportError("a.so: failed to map segment from shared object")
    assert isinstance(told_error(KeyError("x")), Defect)
    # Without a limit that is a damaged installation.
    assert isinstance(told_error(loading), Defect) == (memory_limit() is None)
    error = UsageError("wrong")
    assert told_error(error) is error


ODD_NAMES = {
    "..": "begins with a dot",
    ".hidden": "begins with a dot",
    "a.": "ends with a dot",
    "a ": "begins or ends with a blank",
    " a": "begins or ends with a blank",
    "a\nb": "cannot be printed",
    "a\x1b[31m": "cannot be printed",
    "a\u202eb": "cannot be printed",
    "\udcff": "cannot be printed",
    "x" * 201: "longer than 200 bytes",
    "ü" * 101: "longer than 200 bytes",
}


@POSIX
@pytest.mark.parametrize("name", ODD_NAMES)
def test_scenes_whose_names_no_folder_should_have_are_refused(tmp_path: Path, name: str) -> None:
    file = tmp_path / f"{name}.yaml"
    file.write_text(SCENE, encoding="utf-8")
    with pytest.raises(UsageError, match=rf"{ODD_NAMES[name]}; rename the file$") as refused:
        find_scene(str(file))
    assert str(refused.value).isprintable()
    with pytest.raises(UsageError):
        write_starter(name, tmp_path / "new")


@pytest.mark.nightly
def test_a_scene_called_dots_writes_nothing_outside_its_folder(tmp_path: Path) -> None:
    (tmp_path / "work").mkdir()
    (tmp_path / "work" / "...yaml").write_text(SCENE, encoding="utf-8")
    code, said = run("simulate", "...yaml", "--out", "out/films", cwd=tmp_path / "work")
    assert code == 2
    assert said == (
        "error: '...yaml': a scene's file names its outputs, and '..' begins with a dot; "
        "rename the file\n"
    )
    assert [path.name for path in tmp_path.rglob("*")] == ["work", "...yaml"]


def test_names_of_any_script_are_fine(tmp_path: Path) -> None:
    for name in ("Käfer", "虫\u3000虫", "a.b", "x" * 200, "-a", "a b"):
        path = tmp_path / f"{name}.yaml"
        path.write_text(SCENE, encoding="utf-8")
        assert find_scene(str(path)) == path
