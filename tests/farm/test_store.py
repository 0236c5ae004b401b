"""Objects of a store are whole or missing, whatever the store answers."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import pytest

from pipeline.errors import StoreError, UsageError
from pipeline.farm.seals import digest_of, sealed, unsealed
from pipeline.farm.store import MAX_TRIES, STALE_AGE, TEMPORARY, ObjectDamaged, ObjectMissing, Store


def test_objects_are_read_as_they_were_written(store: Store, tmp_path: Path) -> None:
    assert not store.has("a/b.png")
    store.put("a/b.png", b"0123456789")
    assert store.has("a/b.png")
    assert store.get("a/b.png") == b"0123456789"
    assert store.get("a/b.png", 2, 5) == b"234"
    store.put("a/b.png", b"another")
    assert store.get("a/b.png") == b"another"
    file = tmp_path / "file"
    file.write_bytes(b"of a file")
    store.put("c/d", file)
    assert store.get("c/d") == b"of a file"
    assert {name: entry.size for name, entry in store.names("a").items()} == {"b.png": 7}
    assert set(store.folders("")) - {TEMPORARY} == {"a", "c"}
    store.remove("a/b.png")
    store.remove("a/b.png")
    assert not store.has("a/b.png")
    assert store.names("a") == store.names("nowhere") == {}


def test_a_missing_object_is_told_at_once(store: Store, pauses: list[float]) -> None:
    with pytest.raises(ObjectMissing, match=r"has no takes/none\.tar"):
        store.get("takes/none.tar")
    assert pauses == []


def test_of_many_that_create_an_object_one_succeeds(store: Store) -> None:
    if store._renames and not store.is_local:
        pytest.skip("servers that rename have no condition for it: the last one counts")
    together = threading.Barrier(8)
    won: list[int] = []

    def create(number: int) -> None:
        together.wait()
        if store.create("class.json", sealed({"number": number})):
            won.append(number)

    threads = [threading.Thread(target=create, args=(n,)) for n in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(won) == 1
    assert store.get_json("class.json") == {"number": won[0]}


class Failing:
    """A file system that fails some of its calls.

    Args:
        files: that do the work.
        errors: one for each call, None for one that succeeds; without any more, all do.
    """

    def __init__(self, files: Any, errors: list[Exception | None]) -> None:
        self._files, self._errors = files, errors

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._files, name)
        if not callable(found) or name in ("makedirs", "invalidate_cache"):
            return found

        def call(*arguments: Any, **options: Any) -> Any:
            error = self._errors.pop(0) if self._errors else None
            if error is not None:
                raise error
            return found(*arguments, **options)

        return call


def test_calls_that_fail_for_a_while_are_repeated(store: Store, pauses: list[float]) -> None:
    store.put("a", b"content")
    errors: list[Exception | None] = [OSError(5, "I/O error"), TimeoutError("slow"), None]
    store._files = Failing(store._files, errors)
    assert store.get("a") == b"content"
    assert len(pauses) == 2
    assert errors == []


def test_pauses_grow_and_end(store: Store, pauses: list[float]) -> None:
    store._files = Failing(store._files, [OSError(5, "503 Slow Down")] * 99)
    with pytest.raises(StoreError, match=rf"a is read, and that failed {MAX_TRIES} times: .*503"):
        store.get("a")
    assert len(pauses) == MAX_TRIES - 1
    assert pauses[-1] > pauses[0]


def test_what_another_call_would_meet_again_is_not_repeated(
    store: Store, pauses: list[float]
) -> None:
    store._files = Failing(store._files, [PermissionError(13, "Access Denied")])
    with pytest.raises(StoreError, match="Access Denied"):
        store.get("a")
    assert pauses == []


def test_a_writer_that_is_stopped_leaves_no_part(tmp_path: Path) -> None:
    store = Store(str(tmp_path / "store"))
    store.put("frames/x.png", b"old")

    class Killed(BaseException):
        pass

    store._files = Failing(store._files, [])
    whole = store._files._files.mv
    store._move = lambda temporary, name: (_ for _ in ()).throw(Killed())  # type: ignore[method-assign]
    with pytest.raises(Killed):
        store.put("frames/x.png", b"a new one")
    assert whole is not None
    assert (tmp_path / "store/frames/x.png").read_bytes() == b"old"
    assert [path.name for path in (tmp_path / "store/frames").iterdir()] == ["x.png"]


def test_unfinished_objects_of_yesterday_are_removed(tmp_path: Path) -> None:
    import os
    import time

    store = Store(str(tmp_path))
    folder = tmp_path / TEMPORARY
    folder.mkdir()
    for name, age in (("new", 60.0), ("old", STALE_AGE + 60.0)):
        (folder / name).write_bytes(b"part")
        os.utime(folder / name, (time.time() - age,) * 2)
    store.remove_stale()
    assert [path.name for path in folder.iterdir()] == ["new"]


def test_damaged_objects_are_told(store: Store) -> None:
    store.put("frame", b"as written")
    digest = digest_of(b"as written")
    assert store.get_checked("frame", digest) == b"as written"
    store.put("frame", b"as_written")
    with pytest.raises(ObjectDamaged, match="frame is damaged"):
        store.get_checked("frame", digest)
    store.put_json("facts.json", {"rate": "24", "size": [64, 36]})
    assert store.get_json("facts.json") == {"rate": "24", "size": [64, 36]}
    store.put("facts.json", store.get("facts.json").replace(b"64", b"65"))
    with pytest.raises(ObjectDamaged, match=r"facts\.json is damaged"):
        store.get_json("facts.json")


@pytest.mark.parametrize("data", [b"", b"{}", b"[1]", b"null", b"\xff", sealed({"a": 1})[:-4]])
def test_what_has_no_seal_is_no_members(data: bytes) -> None:
    assert unsealed(data) is None


@pytest.mark.parametrize(
    "address",
    [
        "sftp://somebody:s3cret@host/films",
        "s3://key:s3cret@bucket/films",
        "simplecache::sftp://somebody:s3cret@host/films",
    ],
)
def test_passwords_in_addresses_are_refused_and_not_repeated(address: str) -> None:
    with pytest.raises(UsageError, match="the address holds a password") as refused:
        Store(address)
    assert "s3cret" not in str(refused.value)


def test_unknown_protocols_are_refused() -> None:
    with pytest.raises(UsageError, match="--store nowhere://films"):
        Store("nowhere://films")


def test_a_folder_has_the_same_address_from_everywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    here = Store("films")
    here.put("a", b"1")
    monkeypatch.chdir("/")
    assert Store(here.address).get("a") == b"1"
