"""Films of several segments, encoded by workers of a farm, are those of `pronk render`."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest

from pipeline.farm.assembly import assemble
from pipeline.farm.frame_index import FrameIndex
from pipeline.farm.segments import SegmentIndex, due_segments, encode_segment
from pipeline.farm.shards import encode_shard
from pipeline.farm.store import Store
from pipeline.farm.stored_frames import FramesMissing
from pipeline.farm.tasks import Encoding, TaskRunner, WorkerSettings
from pipeline.production.run.progress import Reporter
from render import film_encoder, film_segments
from tests.farm.conftest import Farmed
from tests.production.conftest import FRAMES, Studio
from tests.production.killed_runs import contents_of

pytestmark = pytest.mark.nightly

Pronk = Callable[..., tuple[int, str, str]]

SEGMENTS = [(1, 2, 3), (4, 5, 6), (7, 8)]


@pytest.fixture(autouse=True)
def _short_segments(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(film_segments, "SEGMENT_SECONDS", Fraction(3, 24))


@pytest.fixture
def store(farmed: Farmed, tmp_path: Path) -> Store:
    """Return a copy of the store with all frames of the tiny film."""
    shutil.copytree(farmed.store._root, tmp_path / "store")
    return Store(str(tmp_path / "store"))


@pytest.fixture
def there(film: Studio, tmp_path: Path) -> Studio:
    """Return a studio with all outputs of the tiny film but the film."""
    studio = film.copied(tmp_path / "there")
    (studio.made / "tiny.mp4").unlink()
    return studio


@pytest.fixture
def encoded_here(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return the first frames of the segments that films are encoded with."""
    numbers: list[int] = []
    real = film_encoder.write_segment

    def counted(path: Path, pictures: object, fps: object, codec: object, first: int = 1) -> None:
        numbers.append(first)
        real(path, pictures, fps, codec, first)  # type: ignore[arg-type]

    monkeypatch.setattr(film_encoder, "write_segment", counted)
    return numbers


def objects(store: Store) -> list[Path]:
    return sorted(Path(store._root, "segments").glob("*.mp4"))


@pytest.mark.nightly
def test_a_film_of_workers_segments_is_the_one_of_one_process(
    farmed: Farmed, store: Store, there: Studio, encoded_here: list[int], tmp_path: Path
) -> None:
    alone = there.copied(tmp_path / "alone")
    alone.render()
    assert encoded_here == [1, 4, 7]
    encoded_here.clear()
    for shard in ("2/2", "1/2"):
        encode_shard(there.order(), store, Reporter(), shard=shard)
    assert len(objects(store)) == 3
    assemble(there.order(), store, farmed.film, Reporter())
    assert encoded_here == []
    assert there.contents() == alone.contents()
    assert not list(there.made.glob(".*"))


@pytest.mark.nightly
@pytest.mark.slow
def test_segments_that_are_damaged_or_missing_are_encoded_by_the_assembly(
    farmed: Farmed, store: Store, there: Studio, encoded_here: list[int]
) -> None:
    runner = TaskRunner(WorkerSettings(store.address))
    for frames in SEGMENTS:
        assert runner.run(Encoding(farmed.film.key, frames)).error is None
    assert due_segments(store, farmed.film, tuple(range(1, FRAMES + 1))) == []
    whole = {path: path.read_bytes() for path in objects(store)}
    index = SegmentIndex(store, farmed.film)
    keys = [store.get_json(index._name(frames))["key"] for frames in SEGMENTS]
    damaged, unsealed, gone = (Path(store._root, "segments", f"{key}.mp4") for key in keys)
    unsealed.with_suffix(".json").write_text("{}")
    damaged.write_bytes(damaged.read_bytes()[:-1] + b"x")
    gone.unlink()
    assemble(there.order(), store, farmed.film, Reporter())
    assert encoded_here == [1, 4, 7]
    film = (there.made / "tiny.mp4").read_bytes()
    # The damaged one is gone, and made again by whoever is asked to.
    assert not damaged.exists()
    assert objects(store) == []
    assert due_segments(store, farmed.film, tuple(range(1, 9))) == SEGMENTS
    done = encode_shard(there.order(), store, Reporter())
    assert (done.encoded, done.kept) == (3, 0)
    assert encode_shard(there.order(), store, Reporter()).kept == 3
    assert {path: path.read_bytes() for path in objects(store)} == whole
    (there.made / "tiny.mp4").unlink()
    encoded_here.clear()
    assemble(there.order(), store, farmed.film, Reporter())
    assert (encoded_here, (there.made / "tiny.mp4").read_bytes()) == ([], film)


def test_a_segment_of_lost_frames_names_them(farmed: Farmed, store: Store) -> None:
    index = FrameIndex(store, farmed.film)
    five, seven = index.records([5, 7], None)
    store.put(farmed.film.frame_object(five.key), b"\x89PNG of another")
    index.forget(seven)
    runner = TaskRunner(WorkerSettings(store.address))
    for frames, missing in ((SEGMENTS[1], "5"), (SEGMENTS[2], "7")):
        error = runner.run(Encoding(farmed.film.key, frames)).error
        assert error is not None
        assert (error.fault, error.facts) == ("missing", {"missing": missing})
    assert sorted(index.done()) == [1, 2, 3, 4, 6, 8]
    assert not Path(store._root, "segments").exists()
    with pytest.raises(FramesMissing, match="1 frame is missing: 5"):
        encode_segment(store, farmed.film, SEGMENTS[1])


@pytest.mark.nightly
def test_a_film_of_other_frames_or_settings_takes_no_segment_of_this(
    farmed: Farmed, store: Store, there: Studio, encoded_here: list[int]
) -> None:
    for frames in SEGMENTS:
        encode_segment(store, farmed.film, frames)
    assemble(there.order(frames="2-8"), store, farmed.film, Reporter())
    assert encoded_here == [1, 4, 7]  # counted from the first frame of the part
    encoded_here.clear()
    # A part of the same frames takes them.
    assemble(there.order(frames="1-6"), store, farmed.film, Reporter())
    assert encoded_here == []


def test_the_command_encodes_a_part_and_says_what_is_wrong(
    farmed: Farmed, store: Store, unmade: Studio, pronk: Pronk, monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = ("farm", "encode", unmade.scene, "--store", store.address)
    code, out, _ = pronk(*arguments, "--shard", "1/3")
    assert (code, out) == (0, "tiny: 1 segment encoded\n")
    code, out, _ = pronk(*arguments, "--json")
    assert (code, json.loads(out.splitlines()[-1])["encoded"]) == (0, 2)
    assert pronk(*arguments, "--shard", "4/3")[0] == 2
    monkeypatch.setattr(film_segments, "SEGMENT_SECONDS", 10)
    assert pronk(*arguments)[:2] == (0, "tiny: 0 segments encoded\n")
    index = FrameIndex(store, farmed.film)
    index.forget(index.records([4], None)[0])
    monkeypatch.undo()
    monkeypatch.setattr(film_segments, "SEGMENT_SECONDS", Fraction(1, 24))
    code, _, err = pronk(*arguments)
    assert (code, "1 frame is missing: 4" in err) == (4, True)


@pytest.mark.nightly
def test_a_farm_of_processes_encodes_and_joins(
    unmade: Studio, tmp_path: Path, pronk: Pronk, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Processes of their own have segments of full length.
    monkeypatch.setattr(film_segments, "SEGMENT_SECONDS", 10)
    scene = ("--set", "frames=500", "--set", "film.size=[32,32]", "--set", "terrain.size=[60,60]")
    folder, arguments = tmp_path / "store", (unmade.scene, *scene)
    assert pronk("render", *arguments, "--out", tmp_path / "alone")[0] == 0
    out = ("--store", folder, "--out", tmp_path / "out", "--jobs", "2")
    code, _, err = pronk("farm", "render", *arguments, *out)
    assert code == 0, err
    assert len(objects(Store(str(folder)))) == 3
    assert contents_of(tmp_path / "out/tiny") == contents_of(tmp_path / "alone/tiny")
