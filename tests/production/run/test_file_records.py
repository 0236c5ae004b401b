"""File records and the manifest that lists them."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from pipeline.production.run.file_records import FileRecord, FileRecords, content_digest
from pipeline.production.run.manifest import Manifest


@pytest.fixture
def records(tmp_path: Path) -> FileRecords:
    """Return the records of a file and a folder."""
    (tmp_path / "a").write_bytes(b"content")
    (tmp_path / "take" / "inner").mkdir(parents=True)
    (tmp_path / "take" / "inner" / "one").write_bytes(b"1")
    (tmp_path / "take" / "two").write_bytes(b"22")
    records = FileRecords(tmp_path, {})
    records.add(tmp_path / "a", "key")
    records.add(tmp_path / "take")
    return records


def test_a_file_is_intact_under_its_key_alone(tmp_path: Path, records: FileRecords) -> None:
    assert records.is_intact(tmp_path / "a", "key")
    assert not records.is_intact(tmp_path / "a", "other")
    assert not records.is_intact(tmp_path / "b", "key")
    assert records.is_intact(tmp_path / "take")


def test_an_equal_file_of_another_time_is_intact(tmp_path: Path, records: FileRecords) -> None:
    os.utime(tmp_path / "a", ns=(5, 5))
    assert records.is_intact(tmp_path / "a", "key")
    assert records["a"].mtime_ns == 5


@pytest.mark.parametrize("content", [b"", b"other", b"contenT", b"content+"])
def test_another_content_is_not_intact(
    tmp_path: Path, records: FileRecords, content: bytes
) -> None:
    (tmp_path / "a").write_bytes(content)
    os.utime(tmp_path / "a", ns=(5, 5))
    assert not records.is_intact(tmp_path / "a", "key")


def test_a_missing_file_is_not_intact_and_can_be_forgotten(
    tmp_path: Path, records: FileRecords
) -> None:
    (tmp_path / "a").unlink()
    assert not records.is_intact(tmp_path / "a", "key")
    records.forget_missing()
    assert list(records) == ["take"]


def test_a_file_that_is_not_trusted_is_read(tmp_path: Path, records: FileRecords) -> None:
    before = (tmp_path / "a").stat()
    (tmp_path / "a").write_bytes(b"CONTENT")
    os.utime(tmp_path / "a", ns=(before.st_atime_ns, before.st_mtime_ns))
    assert records.is_intact(tmp_path / "a", "key")
    records.distrust(tmp_path / "a")
    assert not records.is_intact(tmp_path / "a", "key")
    (tmp_path / "a").write_bytes(b"content")
    assert records.is_intact(tmp_path / "a", "key")


def test_any_change_in_a_folder_is_seen(tmp_path: Path, records: FileRecords) -> None:
    take = tmp_path / "take"
    digest = content_digest(take)
    (take / "two").rename(take / "three")
    assert content_digest(take) != digest
    (take / "three").rename(take / "two")
    assert content_digest(take) == digest
    (take / "two").write_bytes(b"2")
    (take / "inner" / "one").write_bytes(b"12")
    assert not records.is_intact(take)


def test_updates_follow_files(tmp_path: Path, records: FileRecords) -> None:
    (tmp_path / "b").write_bytes(b"b")
    records.update(tmp_path / "b", tmp_path / "c")
    assert records.is_intact(tmp_path / "b")
    assert "c" not in records
    (tmp_path / "b").write_bytes(b"bb")
    records.update(tmp_path / "b")
    assert records["b"].size == 2
    (tmp_path / "b").unlink()
    records.update(tmp_path / "b")
    assert "b" not in records


def test_a_manifest_gives_its_records_back(tmp_path: Path, records: FileRecords) -> None:
    manifest = Manifest({"scene": "käfer", "notes": []}, {"render": 0.25}, records)
    place = tmp_path / "manifest.json"
    place.write_bytes(manifest.encoded())
    read = Manifest.read(place)
    assert read == Manifest(manifest.entries, manifest.seconds, dict(records))
    assert Manifest.read(tmp_path / "none") == Manifest()
    # One line a file, so that a film of hours has a manifest that can be read.
    assert len(place.read_text(encoding="utf-8").splitlines()) == 13
    # Another layout is no other content.
    place.write_text(json.dumps(json.loads(place.read_text(encoding="utf-8"))))
    assert Manifest.read(place) == read


@pytest.mark.parametrize(
    "harm",
    [
        ('"scene": "a"', '"scene": "b"'),
        ('"size": 7', '"size": 8'),
        ('"seal": "', '"seal": "0'),
        ('"seal"', '"sael"'),
    ],
)
def test_records_of_a_manifest_that_was_changed_count_for_nothing(
    tmp_path: Path, records: FileRecords, harm: tuple[str, str]
) -> None:
    text = Manifest({"scene": "a"}, {}, records).encoded().decode()
    place = tmp_path / "manifest.json"
    assert harm[0] in text
    place.write_text(text.replace(*harm))
    read = Manifest.read(place)
    assert (dict(read.files), read.is_sealed) == ({}, False)
    assert read.entries["scene"] in ("a", "b")


@pytest.mark.parametrize("entry", [None, 3, [], "x", {"digest": 3}, {"digest": "x", "size": "1"}])
def test_what_is_no_record_is_left_out(entry: object) -> None:
    assert FileRecord.read(entry) is None


def test_manifests_of_earlier_versions_have_no_records(tmp_path: Path) -> None:
    place = tmp_path / "manifest.json"
    place.write_text('{"manifest": 1, "scene": "a", "seconds": {}}')
    assert Manifest.read(place) == Manifest({"scene": "a"}, {}, {})
