"""Atomic writers on a disk that loses power at any moment, or fails at any call."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from pipeline.atomic_file import PARTIAL
from tests.disk.disk_log import SURVIVALS, Call, Disk, Found, read_log
from tests.disk.shim import built, run_with

WRITE = """
import sys
from pathlib import Path
from pipeline.atomic_file import *
from pipeline.atomic_file import replaced_when_complete
from tests.disk.shim import Shim

folder, log, how = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]

def write_all():
    with replaced_when_complete(folder / "picture.png") as temporary:
        with temporary.open("wb") as file:
            for part in (b"new ", b"picture"):
                file.write(part)
                file.flush()
    write_if_changed(folder / "score.mid", b"new score")
    new = folder / ".take.partial"
    make_folder(new / "inner")
    (new / "one").write_bytes(b"new one")
    (new / "inner" / "two").write_bytes(b"new two")
    replace_folder(new, folder / "take")

def write_in_place():
    (folder / "score.mid").write_bytes(b"new score")

def rename_without_sync():
    (folder / ".score.mid").write_bytes(b"new score")
    (folder / ".score.mid").rename(folder / "score.mid")

shim = Shim()
shim.start(folder, log)
globals()[how]()
shim.stop()
"""

OLD = {"picture.png": b"old picture", "score.mid": b"old score", "take/one": b"old"}
NEW = {
    "picture.png": b"new picture",
    "score.mid": b"new score",
    "take/one": b"new one",
    "take/inner/two": b"new two",
}


@pytest.fixture(scope="module")
def shim(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("shim"))


def old_folder(place: Path) -> Path:
    for name, content in OLD.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_bytes(content)
    return place.resolve()


def losses(folder: Path, calls: list[Call]) -> Iterator[tuple[int, str, Found]]:
    """Yield what is found after a loss of power before each call and after the last."""
    disk = Disk(folder)
    for number in range(len(calls) + 1):
        for survival in SURVIVALS:
            yield number, survival, disk.after_loss(survival, number)
        if number < len(calls):
            disk.apply(calls[number])


def contents(found: Found) -> dict[str, bytes]:
    """Return the files that have their names."""
    return {n: e[0] for n, e in found.items() if e is not None and PARTIAL not in n}


def outputs_of(found: Found) -> set[str]:
    """Return for each output whether it is old or new; fail for anything else."""
    files = contents(found)
    states = set()
    for output in ("picture.png", "score.mid", "take"):
        present = {n: c for n, c in files.items() if n.split("/")[0] == output}
        expected = [{n: c for n, c in s.items() if n.split("/")[0] == output} for s in (OLD, NEW)]
        assert present in expected, present
        states.add(f"{'new' if present == expected[1] else 'old'} {output}")
    return states


def recorded(shim: Path, folder: Path, log: Path, how: str) -> list[Call]:
    """Return what a process did to a folder of old outputs, and put these back."""
    run_with(shim, WRITE, folder, log, how)
    return read_log(log, folder)


def test_every_output_is_old_or_new_after_a_loss_of_power_at_any_moment(
    shim: Path, tmp_path: Path
) -> None:
    folder = old_folder(tmp_path / "written")
    calls = recorded(shim, folder, tmp_path / "log", "write_all")
    assert len(calls) > 10
    seen = set[str]()
    for number, survival, found in losses(old_folder(tmp_path / "before"), calls):
        try:
            seen |= outputs_of(found)
        except AssertionError as error:
            last = calls[:number][-1:]
            raise AssertionError(f"{survival} at {number}, {last}: {error}") from error
        if number == len(calls):
            # What a writer has returned from is there to stay.
            assert contents(found) == NEW, survival
    assert len(seen) == 6


@pytest.mark.parametrize("how", ["write_in_place", "rename_without_sync"])
def test_the_disk_finds_writers_that_are_not_atomic(shim: Path, tmp_path: Path, how: str) -> None:
    folder = old_folder(tmp_path / "written")
    calls = recorded(shim, folder, tmp_path / "log", how)
    before = old_folder(tmp_path / "before")
    found = [contents(f)["score.mid"] for _, _, f in losses(before, calls)]
    assert {b"old score", b"new score"} < set(found)
    assert b"" in found
    assert bytes(9) in found
