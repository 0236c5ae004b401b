"""Atomic files: whole after an error or a loss of power at any moment, with the disk as a fake."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline import atomic_file
from pipeline.atomic_file import (
    make_folder,
    read_sealed,
    remove,
    replace_folder,
    replaced_when_complete,
    write_if_changed,
    write_sealed,
)

Tree = dict[str, bytes | None]
"""Files of a folder with their content, and its folders with None."""


def tree(folder: Path) -> Tree:
    return {
        str(path.relative_to(folder)): None if path.is_dir() else path.read_bytes()
        for path in folder.rglob("*")
    }


class Disk:
    """Records what is synced and renamed, and fails one such call if asked to.

    Attributes:
        calls: such as "sync a/b" and "rename a", with paths from the folder.
        failing: number of the call that fails, from 0; None for none.
        code: number of the error.
    """

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.calls: list[str] = []
        self.failing: int | None = None
        self.code = errno.EIO
        self._folder = folder
        sync, rename, swap = os.fsync, os.replace, atomic_file.exchange

        def fsync(descriptor: int) -> None:
            self._record("sync", Path(os.readlink(f"/proc/self/fd/{descriptor}")))
            sync(descriptor)

        def replace(source: Path, place: Path) -> None:
            self._record("rename", Path(place))
            rename(source, place)

        def exchange(one: Path, two: Path) -> bool:
            self._record("exchange", two)
            return swap(one, two)

        monkeypatch.setattr(os, "fsync", fsync)
        monkeypatch.setattr(os, "replace", replace)
        monkeypatch.setattr(atomic_file, "exchange", exchange)

    def _record(self, call: str, path: Path) -> None:
        number = len(self.calls)
        name = str(path.relative_to(self._folder))
        self.calls.append(f"{call} {name.replace(f'.{os.getpid()}', '')}")
        if number == self.failing:
            raise OSError(self.code, os.strerror(self.code))


@pytest.fixture
def disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Disk:
    if not Path("/proc/self/fd").is_dir():
        pytest.skip("the system does not tell the files of a process")
    return Disk(tmp_path, monkeypatch)


def write_text(folder: Path) -> None:
    with replaced_when_complete(folder / "a.txt") as temporary:
        temporary.write_text("new")


def write_bytes(folder: Path) -> None:
    write_if_changed(folder / "a.txt", b"new")


def write_folder(folder: Path) -> None:
    new = folder / "new"
    make_folder(new / "inner")
    (new / "one").write_text("1")
    (new / "inner" / "two").write_text("2")
    replace_folder(new, folder / "place")


@pytest.mark.parametrize("write", [write_text, write_bytes])
def test_content_is_synced_before_its_name_and_its_name_before_the_end(
    tmp_path: Path, disk: Disk, write: Callable[[Path], None]
) -> None:
    write(tmp_path)
    assert disk.calls == ["sync .a.partial.txt", "rename a.txt", "sync ."]
    assert tree(tmp_path) == {"a.txt": b"new"}


@pytest.mark.parametrize("earlier", [False, True])
def test_all_of_a_folder_is_synced_before_it_gets_its_name(
    tmp_path: Path, disk: Disk, earlier: bool
) -> None:
    if earlier:
        (tmp_path / "place" / "old").mkdir(parents=True)
    write_folder(tmp_path)
    made, moved = disk.calls[:2], disk.calls[2:]
    assert made == ["sync new", "sync ."] or made == ["sync .", "sync new"]
    move = "exchange place" if earlier else "rename place"
    assert set(moved[:-2]) == {"sync new", "sync new/one", "sync new/inner", "sync new/inner/two"}
    assert moved[-2:] == [move, "sync ."]
    assert tree(tmp_path) == {
        "place": None,
        "place/one": b"1",
        "place/inner": None,
        "place/inner/two": b"2",
    }


@pytest.mark.parametrize("write", [write_text, write_bytes, write_folder])
@pytest.mark.parametrize("code", [errno.EIO, errno.ENOSPC, errno.EACCES])
def test_an_error_at_any_call_leaves_the_old_or_the_new(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    write: Callable[[Path], None],
    code: int,
) -> None:
    def start(name: str) -> Path:
        folder = tmp_path / name
        (folder / "place").mkdir(parents=True)
        (folder / "place" / "one").write_text("old")
        (folder / "a.txt").write_text("old")
        return folder

    whole, first = start("whole"), start("first")
    write(whole)
    allowed = [tree(first), tree(whole)]
    with monkeypatch.context() as patch:
        disk = Disk(start("counted"), patch)
        write(tmp_path / "counted")
    assert len(disk.calls) >= 3
    for failing in range(len(disk.calls)):
        folder = start(f"failing{failing}")
        with monkeypatch.context() as patch:
            disk = Disk(folder, patch)
            disk.failing, disk.code = failing, code
            with pytest.raises(OSError, match=os.strerror(code)) as caught:
                write(folder)
        assert caught.value.errno == code
        remove(folder / "new")
        assert tree(folder) in allowed, disk.calls[failing]


def test_an_error_names_the_file_and_not_its_temporary_one(tmp_path: Path) -> None:
    with (
        pytest.raises(FileNotFoundError) as caught,
        replaced_when_complete(tmp_path / "a.txt") as temporary,
    ):
        temporary.open("rb")
    assert caught.value.filename == str(tmp_path / "a.txt")
    with pytest.raises(OSError, match="full") as other, replaced_when_complete(tmp_path / "a.txt"):
        raise OSError(errno.ENOSPC, "full")
    assert other.value.filename == str(tmp_path / "a.txt")


def test_folders_that_cannot_be_exchanged_are_replaced_in_two_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(atomic_file, "exchange", lambda one, two: False)
    # Of a run that stopped between the two.
    (tmp_path / ".place.old.partial" / "older").mkdir(parents=True)
    for _ in range(2):
        write_folder(tmp_path)
        assert (tmp_path / "place" / "inner" / "two").read_text() == "2"
    assert [path.name for path in tmp_path.iterdir()] == ["place"]


def test_a_file_in_the_way_of_a_folder_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "place").write_text("a file")
    write_folder(tmp_path)
    assert (tmp_path / "place" / "one").read_text() == "1"
    assert [path.name for path in tmp_path.iterdir()] == ["place"]


def test_a_sealed_file_counts_only_whole_and_under_its_name(tmp_path: Path) -> None:
    place, data = tmp_path / "a", bytes(range(100))
    write_sealed(place, data)
    assert read_sealed(place) == data
    whole = place.read_bytes()
    for at in range(len(whole)):
        place.write_bytes(whole[:at] + bytes([whole[at] ^ 1 << at % 8]) + whole[at + 1 :])
        assert read_sealed(place) is None, at
        place.write_bytes(whole[:at])
        assert read_sealed(place) is None, at
    place.write_bytes(whole + b"\0")
    assert read_sealed(place) is None
    # The code of another function.
    place.write_bytes(whole)
    place.rename(tmp_path / "b")
    assert read_sealed(tmp_path / "b") is None
    assert read_sealed(tmp_path / "c") is None
    (tmp_path / "d").mkdir()
    assert read_sealed(tmp_path / "d") is None


def test_equal_content_is_not_written_again(tmp_path: Path, disk: Disk) -> None:
    assert write_if_changed(tmp_path / "a", b"x")
    before, calls = (tmp_path / "a").stat(), len(disk.calls)
    assert not write_if_changed(tmp_path / "a", b"x")
    after = (tmp_path / "a").stat()
    # Reading it may change the time of its last access.
    assert (after.st_ino, after.st_mtime_ns) == (before.st_ino, before.st_mtime_ns)
    assert len(disk.calls) == calls


class _FixedName(OSError):
    """An error whose name nobody can set, as those of PyAV."""

    @property
    def filename(self) -> str | None:
        return None


def test_an_error_without_a_name_gets_that_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    with pytest.raises(OSError, match="No space") as caught, replaced_when_complete(path):
        raise _FixedName(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, str(path))
    assert list(tmp_path.iterdir()) == []
