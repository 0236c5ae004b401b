"""Safe files: regular files of bounded size and nothing else, whatever leads to them."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.foreign_files.safe_file import (
    CHUNK_BYTES,
    FileKind,
    ForeignFileError,
    content_digest,
    read_file,
    require_file,
)

KIND = FileKind("a test", 3 * CHUNK_BYTES)
POSIX = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes")


def test_a_file_is_read_through_links(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"abc" * 10)
    (tmp_path / "b").symlink_to("a")
    require_file(tmp_path / "b", KIND)
    assert read_file(tmp_path / "b", KIND) == b"abc" * 10
    assert content_digest(tmp_path / "b", KIND) == content_digest(tmp_path / "a", KIND)


def test_the_limit_of_its_kind_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(bytes(KIND.max_bytes))
    assert len(read_file(path, KIND)) == KIND.max_bytes
    with path.open("ab") as file:
        file.write(b"1")
    for use in (require_file, read_file, content_digest):
        with pytest.raises(ForeignFileError, match=r"^is larger than 3 MiB, the limit of a test$"):
            use(path, KIND)


@POSIX
@pytest.mark.parametrize("use", [require_file, read_file, content_digest])
def test_what_is_no_regular_file_is_refused_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, use: Callable[[Path, FileKind], object]
) -> None:
    # The names of sockets are short.
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "zero").symlink_to("/dev/zero")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "gone").symlink_to("nowhere")
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind("socket")
        for name, said in {
            "pipe": "is a named pipe, not a file",
            "zero": "is a device, not a file",
            "socket": "is a socket, not a file",
            ".": "is a folder, not a file",
            "loop": "cannot be read: Too many levels of symbolic links",
            "gone": f"is no file in {tmp_path}",
            "none": f"is no file in {tmp_path}",
            "x" * 300: "cannot be read: File name too long",
            "a\0b": "cannot be the name of a file: it holds a zero byte",
        }.items():
            with pytest.raises(ForeignFileError) as refused:
                use(tmp_path / name, KIND)
            assert str(refused.value) == said


def test_a_file_that_grows_while_it_is_read_stays_within_the_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a"
    path.write_bytes(bytes(KIND.max_bytes))
    measure = os.fstat

    def measure_and_grow(descriptor: int) -> os.stat_result:
        found = measure(descriptor)
        with path.open("ab") as file:
            file.write(b"1")
        return found

    monkeypatch.setattr(os, "fstat", measure_and_grow)
    with pytest.raises(ForeignFileError, match="is larger than 3 MiB"):
        read_file(path, KIND)
