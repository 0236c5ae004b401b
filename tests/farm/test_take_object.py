"""Archives and takes of a store, of which parts are read."""

from __future__ import annotations

import tarfile
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import StoreError
from pipeline.farm.archive import Archive, read_arrays, write_archive, write_arrays
from pipeline.farm.store import ObjectDamaged, ObjectMissing, Store
from pipeline.farm.take_object import TakeRows, fetch_take, store_take, take_name
from pipeline.production.shots.film_tracks import FilmTracks
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.simulation.take_store import read_take
from pipeline.spec import Scene, read_scene

# Everything of a shot that rows or the whole take decide: footprints, a lens, a shutter, a cut,
# a lamp that is carried, skin over joints.
SCENE = """\
pronk: 1
fps: 24
frames: 72
seed: 3
terrain: {kind: flat, size: [8, 8], cells: [8, 8], material: ground, footprints: true}
cast:
  - name: bug
    figure: beetle
    scale: 0.6
    walk: {gait: tripod, cycle: 0.3, speed: 0.6}
materials:
  ground: {preset: snow}
camera:
  - {follow: bug, aperture: 2.8}
  - {follow: bug, start: 1.5, view: side}
light: {preset: studio, lamps: [{at: [0, 0.5, 0], parent: bug}]}
film: {size: [64, 36], samples: 1, depth: 2, denoise: "off", shutter_deg: 180}
"""


@pytest.fixture(scope="module")
def long_take() -> tuple[Scene, Take]:
    """Return a scene with all that shots depend on, and its take of three chunks."""
    scene = read_scene(SCENE)
    return scene, simulate(scene, "k" * 40)


def test_members_of_an_archive_are_read_one_by_one(store: Store, tmp_path: Path) -> None:
    members: dict[str, bytes | Path] = {f"c/{n}": bytes([n]) * (n * 700) for n in range(9)}
    place = tmp_path / "made.tar"
    write_archive(place, members)
    store.put("a.tar", place)
    archive = Archive(store, "a.tar")
    assert set(archive.names) == set(members)
    assert archive.read(["c/7", "c/0", "c/3"]) == {n: members[n] for n in ("c/0", "c/3", "c/7")}
    # Other programs read it as well.
    with tarfile.open(place) as tar:
        for name, data in members.items():
            file = tar.extractfile(name)
            assert file is not None
            assert file.read() == data


def test_equal_members_are_equal_archives(tmp_path: Path) -> None:
    one, two = tmp_path / "one.tar", tmp_path / "two.tar"
    write_archive(one, {"a": b"1", "b": b"2"})
    write_archive(two, {"b": b"2", "a": b"1"})
    assert one.read_bytes() == two.read_bytes()


def test_a_changed_byte_of_an_archive_is_told(memory: Store, tmp_path: Path) -> None:
    place = tmp_path / "made.tar"
    write_archive(place, {"a": b"a" * 100, "b": b"b" * 100})
    data = place.read_bytes()
    told = 0
    for byte in range(0, len(data), 13):
        memory.put("x.tar", data[:byte] + bytes([data[byte] ^ 1]) + data[byte + 1 :])
        try:
            archive = Archive(memory, "x.tar")
            assert archive.read(["a", "b"]) == {"a": b"a" * 100, "b": b"b" * 100}
        except ObjectDamaged:
            told += 1
    assert told > 10


@pytest.mark.parametrize("data", [b"", b"short", b"x" * 2000])
def test_what_is_no_archive_is_told(memory: Store, data: bytes) -> None:
    memory.put("x.tar", data)
    with pytest.raises(ObjectDamaged, match=r"x\.tar is damaged"):
        Archive(memory, "x.tar")


def test_arrays_are_read_back(store: Store, tmp_path: Path) -> None:
    arrays = {"one": np.arange(6.0).reshape(2, 3), "none": np.zeros((0, 4), np.uint32)}
    write_arrays(tmp_path / "made.tar", arrays)
    store.put("arrays.tar", tmp_path / "made.tar")
    read = read_arrays(store, "arrays.tar")
    assert all((read[name] == arrays[name]).all() for name in arrays)
    assert read["none"].dtype == np.uint32


@pytest.mark.nightly
def test_shots_of_some_rows_are_those_of_the_whole_take(
    long_take: tuple[Scene, Take], memory: Store, tmp_path: Path
) -> None:
    scene, take = long_take
    store_take(memory, take)
    whole = ShotBuilder(scene, take)
    write_arrays(tmp_path / "tracks.tar", whole.tracks.arrays())
    memory.put("tracks.tar", tmp_path / "tracks.tar")
    tracks = FilmTracks.of_arrays(read_arrays(memory, "tracks.tar"))
    assert tracks.footprints is not None
    assert any(pose.lens for pose in tracks.poses)
    rows = TakeRows(memory, take.header.key)
    part = ShotBuilder(scene, rows.take, tracks)
    before = rows.bytes_read
    for frame in (33, 32, 72, 1):
        rows.require(frame, frame)
        assert part.shot(frame).digest == whole.shot(frame).digest
    rows.require(1, 72)
    assert rows.bytes_read > before


@pytest.mark.slow
def test_only_the_rows_of_the_frames_are_read(long_take: tuple[Scene, Take], memory: Store) -> None:
    scene, take = long_take
    store_take(memory, take)
    rows = TakeRows(memory, take.header.key)
    static = rows.bytes_read
    rows.require(70, 71)
    some = rows.bytes_read - static
    rows.require(70, 71)
    assert rows.bytes_read - static == some
    rows.require(1, 72)
    assert 0 < some < 0.5 * (rows.bytes_read - static)
    # Rows that were not read are zeros, so a shot of them is another one.
    other = TakeRows(memory, take.header.key)
    other.require(70, 71)
    whole = ShotBuilder(scene, take)
    assert ShotBuilder(scene, other.take, whole.tracks).shot(5).digest != whole.shot(5).digest


@pytest.mark.slow
def test_a_fetched_take_is_the_stored_one(
    long_take: tuple[Scene, Take], store: Store, tmp_path: Path
) -> None:
    _, take = long_take
    store_take(store, take)
    fetch_take(store, take.header.key, tmp_path / "take.zarr")
    assert read_take(tmp_path / "take.zarr").digest == take.digest
    with pytest.raises(ObjectMissing):
        fetch_take(store, "none", tmp_path / "other.zarr")


def test_a_member_outside_of_a_take_is_refused(memory: Store, tmp_path: Path) -> None:
    write_archive(tmp_path / "made.tar", {"../outside": b"x"})
    memory.put(take_name("k"), tmp_path / "made.tar")
    with pytest.raises(StoreError, match=r"is no take: has \.\./outside"):
        fetch_take(memory, "k", tmp_path / "folder" / "take.zarr")
    assert not (tmp_path / "folder" / "outside").exists()


def test_tracks_that_are_none_are_refused() -> None:
    with pytest.raises(StoreError, match="the tracks of the film cannot be read"):
        FilmTracks.of_arrays({"poses": np.zeros((2, 11))})
