"""Incremental rendering: valid outputs are kept, and only invalid ones are remade."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pipeline.production.run.production import score_only, simulate_only
from pipeline.production.run.progress import Reporter
from pipeline.production.run.take_stage import take_key
from pipeline.production.shots.frame_rendering import frame_key
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.take import Take
from pipeline.simulation.take_store import read_take

if TYPE_CHECKING:
    from tests.production.conftest import Studio

SLOW = pytest.mark.slow
"""Nightly cases."""

ALL = {f"frames/{f:04d}.png" for f in range(1, 9)}
FILM = {"tiny.mp4", "manifest.json"}


def test_all_outputs_exist(film: Studio) -> None:
    assert {path.name for path in film.made.iterdir()} == {
        *("frames", "take.zarr", "events.jsonl", "manifest.json"),
        *("tiny.mp4", "tiny.mid", "tiny.wav", "tiny.edl", "tiny_labels.txt", "events.csv"),
    }
    assert {path.name for path in (film.made / "frames").iterdir()} == {
        f"{f:04d}.png" for f in range(1, 9)
    }
    manifest = json.loads((film.made / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["digests"]["take"] == read_take(film.made / "take.zarr").digest
    assert manifest["events"] == {"written": 6, "after_the_last_frame": 0}
    assert manifest["midi"]["notes"] + manifest["midi"]["merged"] == 6


def test_a_second_run_changes_nothing(studio: Studio) -> None:
    before = studio.state()
    studio.render()
    assert studio.changes(before) == set()


def test_scoring_and_simulating_again_change_nothing(studio: Studio) -> None:
    before = studio.state()
    score_only(studio.order(), Reporter())
    simulate_only(studio.order(), Reporter())
    assert studio.changes(before) == set()


def test_a_new_take_leaves_no_cues_of_the_one_before(studio: Studio) -> None:
    simulate_only(studio.order("cast.bug.walk.cycle=0.4"), Reporter())
    left = {path.name for path in studio.made.iterdir()}
    assert "events.csv" in left
    assert not {"tiny_labels.txt", "tiny.edl"} & left


@pytest.mark.sample(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("word", "due"),
    [
        ("sound.voices=[{pitch: C4}]", {"tiny.mid", "tiny.wav", *FILM}),
        # The steps of the scale are for the score alone.
        ("sound.scale=A dorian", {"tiny.mid", "manifest.json"}),
        ("sound.volume_db=-12", {"tiny.mid", "tiny.wav", *FILM}),
        # The listener moves with the camera, so the score changes too.
        pytest.param(
            "camera.distance=9", {*ALL, "tiny.mid", "tiny.wav", *FILM}, marks=pytest.mark.nightly
        ),
        pytest.param("materials.ground.color='#804020'", {*ALL, *FILM}, marks=pytest.mark.nightly),
        pytest.param("light.preset=noon", {*ALL, *FILM}, marks=SLOW),
        pytest.param("film.exposure=1", {*ALL, *FILM}, marks=SLOW),
    ],
)
def test_a_changed_key_remakes_its_dependent_outputs(
    studio: Studio, word: str, due: set[str]
) -> None:
    before = studio.state()
    studio.render(word)
    assert studio.changes(before) == due


@pytest.mark.nightly
@SLOW
def test_reverted_changes_give_the_same_film(studio: Studio, film: Studio) -> None:
    studio.render("camera.distance=9")
    assert studio.contents() != film.contents()
    studio.render()
    assert studio.contents() == film.contents()


@pytest.mark.nightly
def test_a_changed_walk_is_simulated_again(studio: Studio) -> None:
    before = studio.state()
    studio.render("cast.bug.walk.cycle=0.4")
    changes = studio.changes(before)
    assert {"take.zarr", "events.jsonl", "events.csv", "tiny.mid", "tiny.wav"} <= changes
    assert {"tiny.edl", "tiny_labels.txt"} <= changes
    # The first frame may be equal: no performer has moved yet.
    assert {f"frames/{f:04d}.png" for f in range(2, 9)} <= changes


def test_only_keys_of_the_simulation_simulate_again(unmade: Studio) -> None:
    same = ["camera.view=top", "sound.volume_db=3", "light.preset=noon", "film.samples=4"]
    same += ["materials.ground.color='#804020'"]
    other = ["seed=4", "fps=25", "terrain.cells=[9,9]", "cast.bug.walk.speed=0.8", "steps=8"]
    key = take_key(unmade.load())
    assert [word for word in same if take_key(unmade.load(word)) != key] == []
    assert [word for word in other if take_key(unmade.load(word)) == key] == []


def test_a_frames_key_follows_its_shot(unmade: Studio, take: Take) -> None:
    def keys(*sets: str, extra: str = "llvm") -> list[str]:
        shooting = ShotBuilder(unmade.load(*sets), take)
        return [frame_key(shooting, frame, extra) for frame in range(1, 9)]

    own = keys()
    assert len(set(own)) == 8
    assert keys("sound.volume_db=3", "title=Other") == own
    # An unused material is invisible.
    assert keys("materials.unused={preset: brass}") == own
    for other in (
        keys("camera.fov_deg=36"),
        keys("film.depth=3"),
        keys("materials.ground.roughness=0.123"),
        keys("light.studio.fill=0.31"),
        keys(extra="scalar"),
    ):
        assert set(own).isdisjoint(other)


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "harm", ["truncated", *(pytest.param(h, marks=SLOW) for h in ("deleted", "emptied", "torn"))]
)
def test_only_a_damaged_frame_is_rendered_again(studio: Studio, film: Studio, harm: str) -> None:
    before = studio.state()
    frame = studio.frame(4)
    data = frame.read_bytes()
    if harm == "deleted":
        frame.unlink()
    else:
        left = {"truncated": data[: len(data) // 2], "emptied": b"", "torn": b"\xff" * 999}
        frame.write_bytes(left[harm])
    studio.render()
    # Its pixels are the same, and so is the film.
    assert studio.changes(before) == {"frames/0004.png", "manifest.json"}
    assert studio.contents() == film.contents()


@pytest.mark.parametrize(
    "name",
    [
        "tiny.mp4",
        *(
            pytest.param(n, marks=SLOW)
            for n in ("tiny.mid", "tiny.wav", "events.jsonl", "tiny.edl")
        ),
    ],
)
def test_only_a_deleted_output_is_made_again(studio: Studio, film: Studio, name: str) -> None:
    before = studio.state()
    (studio.made / name).unlink()
    studio.render()
    # The manifest tells how long it took, which may be as long as before.
    assert studio.changes(before) - {"manifest.json"} == {name}
    assert studio.contents() == film.contents()


@pytest.mark.nightly
@pytest.mark.parametrize("text", ["{", '{"seconds": 3}'])
def test_an_unreadable_manifest_is_rewritten(studio: Studio, text: str) -> None:
    before = json.loads((studio.made / "manifest.json").read_text(encoding="utf-8"))
    (studio.made / "manifest.json").write_text(text, encoding="utf-8")
    content = studio.contents()
    studio.render()
    after = json.loads((studio.made / "manifest.json").read_text(encoding="utf-8"))
    # Nothing vouches for the film, so it is made again, alike; the rest vouches for itself.
    assert list(after.pop("seconds")) == ["film"]
    for manifest in (before, after):
        del manifest["files"]["tiny.mp4"]["mtime_ns"], manifest["seal"]
    assert {name: entry for name, entry in before.items() if name != "seconds"} == after
    assert studio.contents() == content


def _chunk(take: Path) -> Path:
    return max(take.glob("positions/c/**/*"), key=lambda path: path.is_file())


def _delete_chunk(take: Path) -> None:
    _chunk(take).unlink()


def _truncate_chunk(take: Path) -> None:
    chunk = _chunk(take)
    chunk.write_bytes(chunk.read_bytes()[:-9])


def _garbage_chunk(take: Path) -> None:
    _chunk(take).write_bytes(b"\xff" * 500)


def _delete_array(take: Path) -> None:
    (take / "rotations" / "zarr.json").unlink()


def _change_attribute(take: Path) -> None:
    metadata = json.loads((take / "zarr.json").read_text(encoding="utf-8"))
    metadata["attributes"]["tables"]["events"].pop()
    (take / "zarr.json").write_text(json.dumps(metadata), encoding="utf-8")


def _attributes(value: object) -> Callable[[Path], None]:
    def harm(take: Path) -> None:
        metadata = json.loads((take / "zarr.json").read_text(encoding="utf-8"))
        for name in metadata["attributes"]:
            if name != "header":
                metadata["attributes"][name] = value
        (take / "zarr.json").write_text(json.dumps(metadata), encoding="utf-8")

    return harm


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "harm",
    [
        _delete_chunk,
        _truncate_chunk,
        pytest.param(_garbage_chunk, marks=SLOW),
        pytest.param(_delete_array, marks=SLOW),
        _change_attribute,
        *(pytest.param(_attributes(value), marks=SLOW) for value in (None, "x", [[1]])),
    ],
)
def test_a_damaged_take_is_simulated_again_with_a_note(
    studio: Studio,
    film: Studio,
    pronk: Callable[..., tuple[int, str, str]],
    harm: Callable[[Path], None],
) -> None:
    harm(studio.made / "take.zarr")
    code, _, err = pronk("simulate", studio.scene, "--out", studio.made.parent)
    assert code == 0
    assert "take.zarr" in err
    assert "made again" in err
    assert studio.contents() == film.contents()


def _file_for_folder(take: Path) -> None:
    for path in sorted(take.rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()
    take.rmdir()
    take.write_text("no take", encoding="utf-8")


def _empty(take: Path) -> None:
    (take / "zarr.json").write_text("", encoding="utf-8")


def _no_json(take: Path) -> None:
    (take / "zarr.json").write_text("\x00\xff{", encoding="utf-8")


def _header(text: str) -> Callable[[Path], None]:
    def harm(take: Path) -> None:
        metadata = json.loads((take / "zarr.json").read_text(encoding="utf-8"))
        metadata["attributes"]["header"] = json.loads(text)
        (take / "zarr.json").write_text(json.dumps(metadata), encoding="utf-8")

    return harm


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "harm",
    [
        _file_for_folder,
        pytest.param(_empty, marks=SLOW),
        pytest.param(_no_json, marks=SLOW),
        _header("null"),
        *(pytest.param(_header(t), marks=SLOW) for t in ("3", '"x"', "[1]", '{"rate": 0}')),
    ],
)
def test_a_file_that_is_no_take_is_replaced(
    studio: Studio, film: Studio, harm: Callable[[Path], None]
) -> None:
    harm(studio.made / "take.zarr")
    simulate_only(studio.order(), Reporter())
    assert studio.contents() == film.contents()
    assert not list(studio.made.rglob("*.partial*"))
