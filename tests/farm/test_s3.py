"""A store in an object store: a local S3."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from pipeline.errors import StoreError
from pipeline.farm.store import ObjectMissing, Store
from tests.production.conftest import FRAMES, Studio
from tests.production.killed_runs import contents_of

pytestmark = [
    pytest.mark.nightly,
    pytest.mark.skipif(
        (find_spec("moto") is None or find_spec("s3fs") is None)
        and not os.environ.get("PRONK_FARM"),
        reason="needs moto and s3fs, which `make test-all` installs",
    ),
    # Of the libraries that talk to S3, not of pronk.
    pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]

SECRET = "a-secret-that-nobody-sees"

Pronk = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def endpoint() -> Iterator[str]:
    """Return the address of a local S3."""
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    host, port = server.get_host_and_port()
    yield f"http://{host}:{port}"
    server.stop()


@pytest.fixture
def bucket(endpoint: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the address of an empty bucket; what is needed to be let in is in the environment."""
    import uuid

    import s3fs
    from fsspec.config import conf, set_conf_env

    name = f"films-{uuid.uuid4().hex[:8]}"
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "somebody")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", SECRET)
    monkeypatch.setenv("AWS_DEFAULT_REGION", "us-east-1")
    monkeypatch.setenv("FSSPEC_S3_ENDPOINT_URL", endpoint)
    # Read once, when fsspec is imported.
    set_conf_env(conf)
    s3fs.S3FileSystem.clear_instance_cache()
    s3fs.S3FileSystem().mkdir(name)
    return f"s3://{name}/films"


def test_objects_are_written_whole_and_created_once(bucket: str, tmp_path: Path) -> None:
    store = Store(bucket)
    store.put("a/b", b"0123456789")
    assert store.get("a/b", 3, 6) == b"345"
    assert store.create("a/class.json", b"first")
    assert not store.create("a/class.json", b"second")
    assert store.get("a/class.json") == b"first"
    # Two that look at the same time: the condition of the request decides.
    store.has = lambda name: False  # type: ignore[method-assign]
    assert not store.create("a/class.json", b"third")
    assert Store(bucket).get("a/class.json") == b"first"
    file = tmp_path / "file"
    file.write_bytes(b"x" * 100_000)
    store.put("a/file", file)
    entries = store.names("a")
    assert {name: entry.size for name, entry in entries.items()} == {
        "b": 10,
        "class.json": 5,
        "file": 100_000,
    }
    assert all(entry.time > 0.0 for entry in entries.values())
    assert store.folders("") == ["a"]
    store.remove("a/b")
    with pytest.raises(ObjectMissing):
        store.get("a/b")


def test_a_missing_bucket_is_told(bucket: str) -> None:
    store = Store(bucket.replace("films-", "none-"))
    with pytest.raises(StoreError, match=r"s3://none-.*cannot be written to .*make it first"):
        store.put("a", b"1")


def test_a_film_through_s3_is_the_rendered_one(
    bucket: str, film: Studio, tmp_path: Path, pronk: Pronk
) -> None:
    arguments = (film.scene, "--store", bucket)
    told = [
        pronk("farm", "simulate", *arguments),
        *(pronk("farm", "frames", *arguments, "--shard", f"{n}/2", "--json") for n in (1, 2)),
        pronk("farm", "status", "--store", bucket),
        pronk("farm", "assemble", *arguments, "--out", tmp_path / "out"),
    ]
    assert [code for code, _, _ in told] == [0] * 5, told
    assert f"{FRAMES} of {FRAMES}" in told[3][1]
    assert contents_of(tmp_path / "out/tiny") == film.contents()
    # Credentials stand nowhere: not in messages, not in outputs, not in the store.
    assert not any(SECRET in text for _, out, err in told for text in (out, err))
    assert SECRET.encode() not in (tmp_path / "out/tiny/manifest.json").read_bytes()
    store = Store(bucket)
    for key in store.folders("films"):
        for name in store.names(f"films/{key}"):
            assert SECRET.encode() not in store.get(f"films/{key}/{name}")


def test_wrong_credentials_are_told_without_them(
    bucket: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.farm.store.time.sleep", lambda seconds: None)
    store = Store(bucket)

    def refused(*_: object, **__: object) -> None:
        raise PermissionError("Access Denied")

    monkeypatch.setattr(store._files, "cat_file", refused)
    with pytest.raises(StoreError, match=r"a is read, and that failed: .*Access Denied") as told:
        store.get("a")
    assert SECRET not in str(told.value)
