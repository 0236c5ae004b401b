"""Renders on a disk that loses power at any moment, or fails at any call."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pipeline.atomic_file import PARTIAL
from tests.disk.disk_log import SURVIVALS, Call, Disk, Found, place, read_log
from tests.disk.rendering_process import ALL, contents
from tests.disk.shim import ROOT, built, environment

if TYPE_CHECKING:
    from tests.production.conftest import Studio

pytestmark = pytest.mark.nightly

SHORT = ("frames=6",)

OTHERWISE = (*SHORT, "title=Other", "cast.bug.walk.cycle=0.4", "sound.volume_db=-12")
"""Changes every output."""


@pytest.fixture(scope="module")
def shim(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("shim"))


@pytest.fixture(params=["first", "second"])
def begun(request: pytest.FixtureRequest, unmade: Studio, tmp_path: Path) -> Studio:
    """Return a studio before its first render, and one with other outputs of an earlier one."""
    studio = unmade.copied(tmp_path / "begun")
    if request.param == "second":
        studio.render(*SHORT)
    studio.made.parent.mkdir(exist_ok=True)
    return studio


def rendering_process(shim: Path, *arguments: object) -> str:
    """Run a rendering process with the shim and return what it prints."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.disk.rendering_process", *map(str, arguments)],
        env=environment(shim),
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def losses(folder: Path, calls: list[Call]) -> Iterator[tuple[str, Found]]:
    """Yield what is found after a loss of power before each call and after the last."""
    disk = Disk(folder)
    for number in range(len(calls) + 1):
        for survival in SURVIVALS:
            yield f"{survival} before call {number}", disk.after_loss(survival, number)
        if number < len(calls):
            disk.apply(calls[number])


def named(found: Found) -> dict[str, bytes]:
    """Return the files that have their names."""
    return {n: e[0] for n, e in found.items() if e is not None and PARTIAL not in n}


def state_of(found: Found) -> str:
    """Return a digest of all but unfinished files, of which the next run asks only if any is."""
    facts = sorted((n, e) for n, e in found.items() if PARTIAL not in n)
    return hashlib.blake2b(repr((facts, len(facts) < len(found))).encode()).hexdigest()


def test_the_next_run_makes_all_good_after_a_loss_of_power_at_any_moment(
    shim: Path, begun: Studio, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = begun.copied(tmp_path / "whole")
    whole.render(*OTHERWISE)
    recorded = begun.copied(tmp_path / "recorded")
    rendering_process(shim, "record", recorded.folder, tmp_path / "log", *OTHERWISE)
    assert recorded.contents() == whole.contents()
    calls = read_log(tmp_path / "log", (recorded.folder / "out").resolve())
    before, after = (_files(studio.folder / "out") for studio in (begun, recorded))
    studio = begun.copied(tmp_path / "studio")
    seen, points = set[str](), 0
    for moment, found in losses(begun.folder / "out", calls):
        points += 1
        for name, content in named(found).items():
            # The lock is empty.
            assert content in (before.get(name), after.get(name), b""), (moment, name)
            assert content or name.endswith(".lock"), (moment, name)
        state = state_of(found)
        if state in seen:
            continue
        seen.add(state)
        place(found, studio.folder / "out")
        studio.render(*OTHERWISE)
        assert studio.contents() == whole.contents(), moment
    with capsys.disabled():
        sys.stdout.write(f"\n{len(calls)} calls, {points} losses, {len(seen)} states rendered\n")
    assert len(calls) > 100
    assert len(seen) > 20


def _files(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_an_error_at_any_call_is_one_message_and_harms_nothing(
    shim: Path, begun: Studio, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = begun.copied(tmp_path / "whole")
    whole.render(*OTHERWISE)
    before, after = (contents(studio.folder / "out") for studio in (begun, whole))

    def failed(code: int, numbers: str) -> list[dict[str, Any]]:
        out = rendering_process(shim, "fail", begun.folder, code, numbers, *OTHERWISE)
        lines: list[dict[str, Any]] = [json.loads(line) for line in out.splitlines()]
        kept, again = _check_failures(lines, code, before, after)
        with capsys.disabled():
            counts = f"{kept} to no purpose, {again} states rendered"
            sys.stdout.write(f"\n{len(lines)} calls failed: {os.strerror(code)}; {counts}\n")
        if numbers == ALL:
            assert len(lines) > 100
            assert kept < len(lines) / 2
            assert again > 10
        return lines

    lines = failed(errno.ENOSPC, ALL)
    # What is done about an error does not depend on its number: of the others one call of each
    # kind fails first, and one last.
    ends = {kind_of(line["call"]): line["number"] for line in reversed(lines)}
    last = {kind_of(line["call"]): line["number"] for line in lines}
    numbers = sorted({*ends.values(), *last.values()})
    for code in (errno.EIO, errno.EACCES):
        failed(code, ",".join(map(str, numbers)))


def kind_of(call: str) -> str:
    """Return the kind of a call: what it does, to what sort of file."""
    plain = re.sub(r"[0-9a-f]{32}|[0-9]+", "#", call)
    # The arrays of a take are written alike.
    return re.sub(r"(take\.zarr[^/]*/)\S*?([^/\s]+)(?=\s|$)", r"\1\2", plain)


def _check_failures(
    lines: list[dict[str, Any]], code: int, before: dict[str, str], after: dict[str, str]
) -> tuple[int, int]:
    """Check runs in which a call failed; return how many calls were to no purpose, and new states.

    Args:
        lines: of the rendering process.
        code: number of the error.
        before: outputs of the run before.
        after: outputs of a run without an error.
    """
    kept = again = 0
    for line in lines:
        told = (line["number"], line["call"], line["err"])
        assert "Traceback" not in line["err"], told
        errors = [text for text in line["err"].splitlines() if text.startswith("error: ")]
        assert (line["code"], len(errors)) in [(4, 1), (0, 0)], told
        if line["code"] == 0:
            # The call was to no purpose, such as removing what was renamed.
            kept += 1
            assert _outputs_of(line["state"]) == after, told
        else:
            assert os.strerror(code) in errors[0], told
        for name, digest in _outputs_of(line["state"]).items():
            assert digest in (before.get(name), after.get(name)), (*told, name)
        if "next_code" in line:
            again += 1
            assert (line["next_code"], line["next_state"]) == (0, after), (*told, line["next_err"])
    return kept, again


def _outputs_of(state: dict[str, str]) -> dict[str, str]:
    """Return the files of a state without unfinished ones, and a lock that nobody holds."""
    return {
        name: digest
        for name, digest in state.items()
        if PARTIAL not in name and not name.endswith("/.lock")
    }
