"""Reader process: whatever a reader does, its file is read or refused, and the next one is read."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from pipeline.foreign_files import reader_process
from pipeline.foreign_files.reader_process import (
    ReaderMissing,
    ReaderProcess,
    ReaderProcessError,
    Reading,
    read_confined,
    shared_process,
)
from pipeline.foreign_files.safe_file import CHUNK_BYTES, ForeignFileError

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="the limit is known on Linux alone")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "größer – 1.bin"
    path.write_bytes(b"content")
    return path


def reading(reader: str, file: Path, **more: object) -> Reading:
    bounds: dict[str, object] = {"memory": 2**28, "seconds": 20.0, "max_bytes": 2**24, **more}
    return Reading(f"tests.foreign_files.odd_readers:{reader}", file, **bounds)  # type: ignore[arg-type]


def test_content_and_facts_come_back_whatever_is_printed(file: Path) -> None:
    file.write_bytes(bytes(range(256)) * 10_000)
    parts: list[bytes] = []
    facts = read_confined(reading("echo", file, settings={"name": "ü"}), parts.append)
    assert facts == {"length": 2_560_000, "name": "ü"}
    assert b"".join(parts) == file.read_bytes()
    assert {len(part) for part in parts[:-1]} == {CHUNK_BYTES}


@pytest.mark.parametrize(
    ("reader", "said"),
    [
        ("crash", r"^crashes its reader \(SIGSEGV\)"),
        ("refuse", "^is no good$"),
        ("fail", "^cannot be read: 'size'$"),
        ("stop_halfway", r"^crashes its reader \(SIGSEGV\)"),
        pytest.param("swell", "^needs more than 256 MiB of memory to be read$", marks=LINUX),
        ("write", "^cannot be read: "),
    ],
)
def test_a_reader_that_fails_is_a_message_and_the_next_file_is_read(
    file: Path, reader: str, said: str
) -> None:
    with ReaderProcess() as process:
        for _ in range(2):
            with pytest.raises(ForeignFileError, match=said):
                process.read(reading(reader, file))
            assert process.read(reading("echo", file)) == {"length": 7}
    written = file.with_name("written")
    assert not written.exists() or not written.stat().st_size


def test_a_reader_that_computes_forever_is_ended(file: Path) -> None:
    with pytest.raises(ForeignFileError, match=r"^takes longer than 0\.1 s to be read$"):
        read_confined(reading("loop", file, seconds=0.1))


def test_a_reader_that_waits_forever_is_ended(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader_process, "WALL_MARGIN", 0.5)
    with pytest.raises(ForeignFileError, match=r"^takes longer than 0\.01 s to be read$"):
        read_confined(reading("sleep", file, seconds=0.01))


def test_more_content_than_is_asked_for_is_not_taken(file: Path) -> None:
    parts: list[bytes] = []
    with pytest.raises(ReaderProcessError):
        read_confined(reading("echo", file, max_bytes=6), parts.append)
    assert not parts


def test_a_missing_library_is_told_apart_from_a_wrong_file(file: Path) -> None:
    with pytest.raises(ReaderMissing, match="no_such_library"):
        read_confined(reading("need_library", file))


def test_no_process_is_an_error_of_its_own(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", str(file.with_name("none")))
    with pytest.raises(ReaderProcessError, match="no process can be started"):
        read_confined(reading("echo", file))
    monkeypatch.undo()
    monkeypatch.setattr(reader_process, "_PROGRAM", "raise SystemExit('no start')")
    with pytest.raises(ReaderProcessError, match="no start"):
        read_confined(reading("echo", file))


def test_an_interrupt_leaves_no_answer_for_the_next_file(file: Path) -> None:
    def interrupt(part: bytes) -> None:
        raise KeyboardInterrupt

    with shared_process():
        with pytest.raises(KeyboardInterrupt):
            read_confined(reading("echo", file), interrupt)
        assert read_confined(reading("echo", file)) == {"length": 7}
