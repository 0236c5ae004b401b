"""Takes on disk: written takes are read again, damaged ones are refused."""

from __future__ import annotations

import errno
import json
import os
import shutil
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
import zarr

from pipeline.errors import StoreError
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Header, Take
from pipeline.simulation.take_store import read_key, read_take, write_take

if TYPE_CHECKING:
    from pipeline.spec import Scene


@pytest.fixture(scope="module")
def take(scene_of: Callable[..., Scene]) -> Take:
    member = "{figure: beetle, scale: 0.5, walk: {gait: tripod}}"
    scene = scene_of(member, terrain="{kind: hills, cells: [40, 40]}", more="fps: '30000/1001'")
    return simulate(scene, key="a key")


@pytest.fixture(scope="module")
def written(take: Take, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("takes") / "take"
    write_take(take, path)
    return path


@pytest.fixture
def stored(written: Path, tmp_path: Path) -> Path:
    shutil.copytree(written, tmp_path / "take")
    return tmp_path / "take"


def test_a_written_take_is_read_again(take: Take, stored: Path) -> None:
    read = read_take(stored)
    assert read.digest == take.digest
    assert read.header == take.header
    assert read.header.rate == take.header.rate
    for name in ("nodes", "channels", "parts", "contacts", "events", "notes"):
        assert getattr(read, name) == getattr(take, name)
    for (name, one), (other_name, two) in zip(take.arrays(), read.arrays(), strict=True):
        assert name == other_name
        assert one.dtype == two.dtype
        assert one.tobytes() == two.tobytes()
    assert read_key(stored) == "a key"


def test_nothing_is_written_any_more_after_a_write_failed(
    take: Take, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Zarr writes several files at once, and goes on with the others when one fails."""
    replace, link = Path.replace, os.link
    failed, late = threading.Event(), list[object]()

    def replace_or_fail(path: Path, target: Path) -> Path:
        if target.parent.name == "positions":
            raise OSError(errno.ENOSPC, "No space left on device")
        return replace(path, target)

    def link_slowly(path: Path, target: Path) -> None:
        time.sleep(0.1)
        if failed.is_set():
            late.append(target)
        link(path, target)

    monkeypatch.setattr(Path, "replace", replace_or_fail)
    monkeypatch.setattr(os, "link", link_slowly)
    with pytest.raises(StoreError, match="could not be written: No space left"):
        write_take(take, tmp_path / "take")
    failed.set()
    time.sleep(0.2)
    assert not late


def test_the_digest_depends_on_every_part(take: Take) -> None:
    positions = take.positions.copy()
    positions[3, 2, 1] = np.nextafter(positions[3, 2, 1], 9.0)
    others = [
        replace(take, positions=positions),
        replace(take, events=take.events[:-1]),
        replace(take, header=replace(take.header, seed=99)),
        replace(take, terrain=replace(take.terrain, material="grass")),
        replace(take, alive=~take.alive),
    ]
    digests = {take.digest, *(other.digest for other in others)}
    assert len(digests) == 1 + len(others)


def test_headers_survive_json(take: Take) -> None:
    assert Header.from_dict(json.loads(json.dumps(take.header.as_dict()))) == take.header


def test_a_new_take_replaces_an_old_one(take: Take, stored: Path) -> None:
    other = replace(take, header=replace(take.header, key="another"))
    write_take(other, stored)
    assert read_key(stored) == "another"
    assert read_take(stored).digest == other.digest


def _chunks(stored: Path, array: str) -> list[Path]:
    return sorted(p for p in (stored / array / "c").rglob("*") if p.is_file())


@pytest.mark.parametrize("array", ["positions", "rotations", "terrain/vertices", "meshes/faces"])
def test_a_missing_chunk_is_refused(stored: Path, array: str) -> None:
    _chunks(stored, array)[-1].unlink()
    with pytest.raises(StoreError, match="take"):
        read_take(stored)


@pytest.mark.parametrize("keep", [0, 0.5])
def test_a_truncated_chunk_is_refused(stored: Path, keep: float) -> None:
    chunk = _chunks(stored, "positions")[0]
    content = chunk.read_bytes()
    chunk.write_bytes(content[: int(len(content) * keep)])
    with pytest.raises(StoreError, match=str(stored)):
        read_take(stored)


def test_a_changed_byte_is_refused(stored: Path) -> None:
    chunk = _chunks(stored, "positions")[0]
    content = bytearray(chunk.read_bytes())
    content[len(content) // 2] ^= 0x10
    chunk.write_bytes(bytes(content))
    with pytest.raises(StoreError):
        read_take(stored)


def test_a_missing_array_is_refused(stored: Path) -> None:
    shutil.rmtree(stored / "values")
    with pytest.raises(StoreError):
        read_take(stored)


def test_an_interrupted_write_leaves_no_take(
    take: Take, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every array is there and the attributes are not yet."""

    class Killed(BaseException):
        pass

    def kill(self: object, header: object) -> None:
        raise Killed

    monkeypatch.setattr(type(zarr.open_group(tmp_path / "x").attrs), "update", kill)
    with pytest.raises(Killed):
        write_take(take, tmp_path / "take")
    assert read_key(tmp_path / "take") is None
    with pytest.raises(StoreError):
        read_take(tmp_path / "take")


def test_a_take_of_another_format_has_no_key(take: Take, stored: Path) -> None:
    attributes = zarr.open_group(stored).attrs
    attributes["header"] = {**take.header.as_dict(), "format": 999}
    assert read_key(stored) is None


@pytest.mark.parametrize("kind", ["nothing", "empty", "file", "garbage", "list"])
def test_another_folder_has_no_key(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "take"
    if kind in ("empty", "garbage", "list"):
        path.mkdir()
    if kind == "file":
        path.write_text("no take")
    if kind == "garbage":
        (path / "zarr.json").write_text("{ no json")
    if kind == "list":
        (path / "zarr.json").write_text("[]")
    assert read_key(path) is None
    with pytest.raises(StoreError):
        read_take(path)


def test_an_unwritable_folder_is_an_error(take: Take, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StoreError):
        write_take(take, tmp_path / "file" / "take")
