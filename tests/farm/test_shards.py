"""Machines that share a store make the film that one machine makes."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.errors import UsageError
from pipeline.farm.assembly import assemble
from pipeline.farm.film import film_of, read_film, scene_of, store_film
from pipeline.farm.frame_index import FrameIndex, FrameRecord, MixedClasses, class_of
from pipeline.farm.frame_worker import shard_frames
from pipeline.farm.shards import read_shard
from pipeline.farm.store import Store
from pipeline.farm.take_object import take_name
from pipeline.production.run.progress import Reporter
from pipeline.production.run.take_stage import take_key
from pipeline.spec import find_scene, load_scene, scene_digest, shipped_scenes
from pipeline.spec.scene import Scene
from tests.farm.conftest import Farmed
from tests.production.conftest import FRAMES, Studio
from tests.production.killed_runs import contents_of

pytestmark = pytest.mark.nightly

Pronk = Callable[..., tuple[int, str, str]]


def stable(manifest: Path) -> dict[str, object]:
    """Return a manifest without seconds and times of files."""
    members: dict[str, object] = json.loads(manifest.read_text())
    files = members.pop("files")
    assert isinstance(files, dict)
    for name in ("seconds", "seal"):
        members.pop(name)
    return {**members, "files": {n: {**f, "mtime_ns": 0} for n, f in files.items()}}


@pytest.mark.slow
def test_an_assembled_film_is_the_rendered_one(
    farmed: Farmed, film: Studio, tmp_path: Path
) -> None:
    order = film.order()
    there = Studio(tmp_path)
    shutil.copy(film.scene, there.scene)
    outputs = assemble(there.order(), farmed.store, farmed.film, Reporter())
    assert contents_of(outputs.folder) == film.contents()
    assert stable(outputs.manifest) == stable(film.made / "manifest.json")
    assert farmed.film.take == take_key(order.scene)
    # Rendering goes on from it, and has nothing to do.
    before = there.state()
    there.render()
    assert there.changes(before) <= {"manifest.json"}


def test_what_was_assembled_is_kept(farmed: Farmed, film: Studio, tmp_path: Path) -> None:
    there = film.copied(tmp_path / "studio")
    before = there.state()
    assemble(there.order(), farmed.store, farmed.film, Reporter())
    assert there.changes(before) <= {"manifest.json"}


def test_missing_frames_are_named_and_nothing_is_written(
    farmed: Farmed, unmade: Studio, tmp_path: Path, pronk: Pronk
) -> None:
    store = copied(farmed, tmp_path)
    folder = tmp_path / "store" / farmed.film.folder / "frames"
    for name in folder.iterdir():
        if name.name[:4] in ("0003", "0004", "0007"):
            name.unlink()
    FrameIndex(store, farmed.film).fail(7, "the renderer crashed", 3)
    code, _, err = pronk(
        *("farm", "assemble", unmade.scene, "--store", store.address, "--out", tmp_path / "out")
    )
    assert code == 4
    assert "3 frames are missing: 3-4,7; given up: 7" in err
    assert not (tmp_path / "out").exists()


@pytest.mark.nightly
def test_damaged_pictures_are_rendered_again(
    farmed: Farmed, unmade: Studio, film: Studio, tmp_path: Path, pronk: Pronk
) -> None:
    store = copied(farmed, tmp_path)
    index = FrameIndex(store, farmed.film)
    (record,) = index.records([5], None)
    store.put(farmed.film.frame_object(record.key), b"\x89PNG of another")
    arguments = (unmade.scene, "--store", store.address)
    code, _, err = pronk("farm", "assemble", *arguments, "--out", tmp_path / "out")
    assert (code, "1 frame is missing: 5" in err) == (4, True)
    assert pronk("farm", "frames", *arguments)[0] == 0
    assert pronk("farm", "assemble", *arguments, "--out", tmp_path / "out")[0] == 0
    assert contents_of(tmp_path / "out/tiny") == film.contents()


@pytest.mark.nightly
def test_a_damaged_take_is_told_and_made_again(
    farmed: Farmed, unmade: Studio, tmp_path: Path, pronk: Pronk
) -> None:
    store = copied(farmed, tmp_path)
    index = FrameIndex(store, farmed.film)
    (record,) = index.records([4], None)
    index.forget(record)
    name = take_name(farmed.film.take)
    data = store.get(name)
    store.put(name, data[: len(data) // 2])
    arguments = (unmade.scene, "--store", store.address)
    code, _, err = pronk("farm", "frames", *arguments)
    assert (code, f"{name} is damaged" in err) == (4, True)
    assert "'pronk farm simulate' makes it again" in err
    assert not store.has(name)
    assert [pronk("farm", verb, *arguments)[0] for verb in ("simulate", "frames")] == [0, 0]
    assert store.get(name) == data


def test_frames_without_a_take_are_refused(unmade: Studio, tmp_path: Path, pronk: Pronk) -> None:
    store = tmp_path / "store"
    code, _, err = pronk("farm", "frames", unmade.scene, "--store", store)
    assert code == 4
    assert "run 'pronk farm simulate' with the same scene and options first" in err
    code, _, err = pronk("farm", "frames", unmade.scene, "--store", store, "--take", "abc")
    assert (code, "has no take abc" in err) == (4, True)


@pytest.mark.slow
def test_the_commands_make_the_film(
    farmed: Farmed, film: Studio, tmp_path: Path, pronk: Pronk
) -> None:
    store = copied(farmed, tmp_path)
    arguments = (film.scene, "--store", store.address)
    code, out, _ = pronk("farm", "simulate", *arguments)
    assert (code, out) == (0, f"{farmed.film.take}\n")
    code, out, _ = pronk("farm", "frames", *arguments, "--shard", "2/4", "--json")
    result = json.loads(out.splitlines()[-1])
    assert (code, result["rendered"], result["kept"]) == (0, 0, 2)
    # Other settings are another film, of the same take.
    code, out, _ = pronk("farm", "simulate", *arguments, "--samples", "2")
    assert (code, out) == (0, f"{farmed.film.take}\n")
    code, _, err = pronk(
        *("farm", "assemble", *arguments, "--samples", "2", "--out", tmp_path / "out")
    )
    assert (code, f"{FRAMES} frames are missing: 1-{FRAMES}" in err) == (4, True)


def test_classes_of_renderers_are_not_mixed(farmed: Farmed, unmade: Studio, tmp_path: Path) -> None:
    store = copied(farmed, tmp_path)
    index = FrameIndex(store, farmed.film)
    index.begin_class(index.records([1], None)[0].renderer, mixed=False)
    with pytest.raises(MixedClasses, match="was begun by another class"):
        index.begin_class("cuda; another processor", mixed=False)
    index.begin_class("cuda; another processor", mixed=True)
    (record,) = index.records([2], None)
    index.forget(record)
    data = (record.key, record.digest, record.size)
    index.put(FrameRecord(2, *data, renderer="cuda; another processor"))
    order = Studio(tmp_path)
    shutil.copy(unmade.scene, order.scene)
    with pytest.raises(MixedClasses, match="2 classes of processors or versions"):
        assemble(order.order(), store, farmed.film, Reporter())
    assert not order.made.exists()
    assemble(order.order(), store, farmed.film, Reporter(), mixed=True)
    assert index.done()[2] == {class_of("cuda; another processor")}


def test_a_scene_comes_back_from_the_store_with_its_files(
    memory: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    cube = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    faces = ("1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6")
    mesh = cube + "".join(f"f {face}\n" for face in faces)
    body = "body: {shape: mesh, file: box.obj}"
    text = f"pronk: 1\nframes: 4\ncast:\n  - {{name: box, {body}, at: [0, 2, 0]}}\n"
    films = []
    for number in (1, 2):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "box.obj").write_text(mesh)
        (folder / "scene.yaml").write_text(text)
        scene = load_scene(folder / "scene.yaml")
        made, files = film_of(scene, "scene")
        films.append(made)
    # Wherever it stands, it is one film.
    assert films[0] == films[1]
    store_film(memory, made, files)
    shutil.rmtree(tmp_path / "1")
    shutil.rmtree(tmp_path / "2")
    again = scene_of(memory, read_film(memory, made.key))
    assert take_key(again) == made.take
    assert film_of(again, "scene")[0] == made


def test_shipped_scenes_come_back_from_their_text(memory: Store) -> None:
    for name in shipped_scenes()[::8]:
        scene = load_scene(find_scene(name))
        made, _ = film_of(scene, "scene", "take")
        again = scene_of(memory, made)
        parts = list(Scene.model_fields)
        assert scene_digest(again, parts) == scene_digest(scene, parts), name


@pytest.mark.parametrize("count", [1, 3, 8, 20])
def test_shards_are_all_frames_once(count: int) -> None:
    frames = tuple(range(1, 9))
    shards = [shard_frames(frames, number, count) for number in range(1, count + 1)]
    assert sum(shards, ()) == frames
    assert max(map(len, shards)) - min(map(len, shards)) <= 1


@pytest.mark.parametrize("text", ["", "0/8", "9/8", "1/0", "a/b", "1", "1/2/3", "-1/4"])
def test_what_is_no_shard_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="write part and number of parts"):
        read_shard(text)


def copied(farmed: Farmed, folder: Path) -> Store:
    """Return a copy of the store with the finished film."""
    shutil.copytree(farmed.store.address.removeprefix("file://"), folder / "store")
    return Store(str(folder / "store"))
