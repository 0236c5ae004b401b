"""Verification: every kind of damage is found and told, and the next run makes it good."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from render.image_files import read_key, read_png, write_png

if TYPE_CHECKING:
    from tests.production.conftest import Studio

Pronk = Callable[..., tuple[int, str, str]]

Harm = Callable[[Path], None]

NIGHTLY = pytest.mark.nightly

CHANGED = "is not as it was written"


def flip(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x10
    path.write_bytes(data)


def flip_in_secret(path: Path) -> None:
    """Flip a bit as a failing disk does: size and time of the file stay."""
    before = path.stat()
    flip(path)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def delete(path: Path) -> None:
    path.unlink()


def empty(path: Path) -> None:
    path.write_bytes(b"")


def rewrite_with_key(path: Path) -> None:
    write_png(path, read_png(path)[::-1].copy(), read_key(path) or "")


def faults_of(out: str) -> dict[str, str]:
    """Return the faults that JSON lines tell, by file."""
    events = [json.loads(line) for line in out.splitlines()]
    (error,) = [event for event in events if event["event"] == "error"]
    assert error["exit_code"] == 1
    return {fault["file"]: fault["text"] for fault in error["faults"]}


@pytest.mark.parametrize(
    "target", ["tiny", *(pytest.param(t, marks=NIGHTLY) for t in ("tiny.yaml", "out/tiny"))]
)
def test_outputs_as_they_were_written_are_right(film: Studio, pronk: Pronk, target: str) -> None:
    before = film.state()
    code, out, err = pronk("verify", target, cwd=film.folder)
    assert code == 0, err
    # Seven files of the score, the take, eight frames, the film and the manifest.
    assert out == "out/tiny: 17 files as they were written, tiny.mp4 as its frames and its sound\n"
    assert film.changes(before) == set()


@pytest.mark.parametrize(
    ("name", "harm", "text"),
    [
        ("frames/0003.png", flip_in_secret, CHANGED),
        pytest.param("frames/0003.png", rewrite_with_key, CHANGED, marks=NIGHTLY),
        pytest.param("frames/0003.png", delete, "is missing", marks=NIGHTLY),
        pytest.param("tiny.mp4", flip_in_secret, CHANGED, marks=NIGHTLY),
        pytest.param("tiny.wav", flip_in_secret, CHANGED, marks=NIGHTLY),
        pytest.param("tiny.mid", empty, CHANGED, marks=NIGHTLY),
        pytest.param("events.csv", flip, CHANGED, marks=NIGHTLY),
        pytest.param("events.jsonl", delete, "is missing", marks=NIGHTLY),
        pytest.param("tiny.edl", flip_in_secret, CHANGED, marks=NIGHTLY),
        pytest.param("tiny_labels.txt", flip, CHANGED, marks=NIGHTLY),
    ],
)
def test_damage_is_found_and_made_good(
    studio: Studio, film: Studio, pronk: Pronk, name: str, harm: Harm, text: str
) -> None:
    before = studio.state()
    harm(studio.made / name)
    code, out, err = pronk("verify", "tiny", cwd=studio.folder)
    assert (code, out) == (1, "")
    assert err.splitlines()[-2:] == [
        "error: out/tiny: 1 of 17 files are damaged or missing; pronk render tiny makes them again",
        f"  {name}: {text}",
    ]
    studio.render()
    assert studio.changes(before) - {"manifest.json"} == {name}
    assert studio.contents() == film.contents()
    assert pronk("verify", "tiny", cwd=studio.folder)[0] == 0


def _flip_chunk(take: Path) -> None:
    flip_in_secret(max(take.glob("positions/c/**/*"), key=lambda path: path.is_file()))


def _drop_array(take: Path) -> None:
    shutil.rmtree(take / "rotations")


def _add_file(take: Path) -> None:
    (take / "another").write_text("")


@NIGHTLY
@pytest.mark.parametrize("harm", [_flip_chunk, _drop_array, _add_file])
def test_a_damaged_take_is_found_and_made_good(
    studio: Studio, film: Studio, pronk: Pronk, harm: Harm
) -> None:
    harm(studio.made / "take.zarr")
    code, out, _ = pronk("verify", "tiny", "--json", cwd=studio.folder)
    assert code == 1
    assert faults_of(out).keys() == {"take.zarr"}
    studio.render()
    assert studio.contents() == film.contents()
    assert pronk("verify", "tiny", cwd=studio.folder)[0] == 0


def test_all_damage_is_told_at_once(studio: Studio, film: Studio, pronk: Pronk) -> None:
    names = ["frames/0001.png", "frames/0008.png", "take.zarr", "tiny.mid", "tiny.mp4", "tiny.wav"]
    for name in names:
        (_flip_chunk if name == "take.zarr" else flip_in_secret)(studio.made / name)
    shutil.copytree(studio.made, studio.made.parent / "other")
    code, out, _ = pronk("verify", "tiny", "out/other", "--json", cwd=studio.folder)
    events = [json.loads(line) for line in out.splitlines()]
    assert code == 1
    for target in ("tiny", "out/other"):
        (error,) = [e for e in events if e["event"] == "error" and e["scene"] == target]
        assert [fault["file"] for fault in error["faults"]] == names
    assert events[-1]["event"] == "table"
    before = studio.state()
    studio.render()
    assert studio.changes(before) == {*names, "manifest.json"}
    assert studio.contents() == film.contents()


@NIGHTLY
def test_a_damaged_manifest_is_found_and_made_good(
    studio: Studio, film: Studio, pronk: Pronk
) -> None:
    place = studio.made / "manifest.json"
    text = place.read_text(encoding="utf-8")
    for damaged in (text.replace('"seed": 3', '"seed": 7'), text[:-40], ""):
        assert damaged != text
        place.write_text(damaged, encoding="utf-8")
        code, out, _ = pronk("verify", "tiny", "--json", cwd=studio.folder)
        assert (code, faults_of(out)) == (1, {"manifest.json": "is not as it was written"})
        studio.render()
        assert studio.contents() == film.contents()
        assert pronk("verify", "tiny", cwd=studio.folder)[0] == 0


@NIGHTLY
def test_a_film_of_other_pictures_is_found_though_it_is_as_it_was_written(
    studio: Studio, film: Studio, pronk: Pronk, monkeypatch: pytest.MonkeyPatch
) -> None:
    from pipeline.production.run import film_stage
    from render.film_encoder import join_film

    def mistaken(path: Path, segments: object, *rest: object) -> int:
        (pictures,) = [list(segment) for segment in segments]  # type: ignore[attr-defined]
        pictures[4] = 255 - pictures[4]
        return join_film(path, [pictures], *rest)  # type: ignore[arg-type]

    (studio.made / "tiny.mp4").unlink()
    with monkeypatch.context() as patch:
        patch.setattr(film_stage, "join_film", mistaken)
        studio.render()
    code, out, _ = pronk("verify", "tiny", "--json", cwd=studio.folder)
    (text,) = faults_of(out).values()
    assert code == 1
    assert text.startswith("picture 5 is unlike the frame, by up to ")
    studio.render()
    assert studio.contents() == film.contents()


@NIGHTLY
def test_parts_of_a_film_and_plots_are_checked_too(studio: Studio, pronk: Pronk) -> None:
    studio.render(frames="2-4")
    assert pronk("plot", "gait", "tiny", cwd=studio.folder)[0] == 0
    assert pronk("verify", "tiny", cwd=studio.folder)[0] == 0
    for name in ("tiny_2-4.mp4", "tiny_gait.svg", "tiny_gait.png"):
        flip_in_secret(studio.made / name)
    code, _, err = pronk("verify", "tiny", cwd=studio.folder)
    assert code == 1
    again = "its own command writes it again"
    assert err.splitlines()[-4:] == [
        "error: out/tiny: 3 of 20 files are damaged or missing",
        "  tiny_2-4.mp4: is not as it was written (pronk render tiny --frames 2-4)",
        f"  tiny_gait.png: is not as it was written ({again})",
        f"  tiny_gait.svg: is not as it was written ({again})",
    ]
    studio.render(frames="2-4")
    assert pronk("plot", "gait", "tiny", cwd=studio.folder)[0] == 0
    assert pronk("verify", "tiny", cwd=studio.folder)[0] == 0


@NIGHTLY
def test_an_older_film_is_no_damage(studio: Studio, pronk: Pronk) -> None:
    studio.render("camera.distance=9", frames="1-2")
    code, out, err = pronk("verify", "tiny", cwd=studio.folder)
    assert code == 0
    assert "tiny.mp4: older than its frames or sound, and not compared" in err
    assert out.endswith(", tiny_1-2.mp4 as its frames and its sound\n")


@NIGHTLY
def test_a_run_that_was_killed_leaves_no_damage(studio: Studio, film: Studio, pronk: Pronk) -> None:
    """Frames and take of the killed run are newer than the manifest."""
    manifest = (studio.made / "manifest.json").read_bytes()
    studio.render("cast.bug.walk.cycle=0.4", sound=False, frames="5-6")
    (studio.made / "tiny_5-6.mp4").unlink()
    (studio.made / "events.jsonl").write_bytes((film.made / "events.jsonl").read_bytes())
    (studio.made / "events.csv").write_bytes((film.made / "events.csv").read_bytes())
    (studio.made / "manifest.json").write_bytes(manifest)
    assert pronk("verify", "tiny", cwd=studio.folder)[0] == 0
    (studio.made / "manifest.json").unlink()
    flip(studio.frame(6))
    flip_in_secret(studio.frame(7))
    code, out, _ = pronk("verify", "tiny", "--json", cwd=studio.folder)
    assert code == 1
    assert faults_of(out).keys() == {"manifest.json", "frames/0006.png", "frames/0007.png"}
    studio.render()
    assert studio.contents() == film.contents()


def test_outputs_of_an_earlier_version_are_told(studio: Studio, pronk: Pronk) -> None:
    place = studio.made / "manifest.json"
    manifest = json.loads(place.read_text(encoding="utf-8"))
    for name in ("files", "films", "seal"):
        del manifest[name]
    place.write_text(json.dumps(manifest), encoding="utf-8")
    code, _, err = pronk("verify", "tiny", cwd=studio.folder)
    assert code == 0
    assert "manifest.json: an earlier version wrote it, which recorded no files" in err


@pytest.mark.parametrize("name", ["out", "nothing", "empty"])
def test_what_holds_no_outputs_is_refused(film: Studio, pronk: Pronk, name: str) -> None:
    (film.folder / "empty").mkdir(exist_ok=True)
    code, out, err = pronk("verify", name, cwd=film.folder)
    assert (code, out) == (2, "")
    expected = {
        "out": "out: holds no outputs of a scene; its folders do: out/tiny",
        "nothing": "no scene is called 'nothing'",
        "empty": "empty: holds no outputs of a scene",
    }
    assert err.startswith(f"error: {expected[name]}")


def test_a_scene_that_was_never_rendered_is_refused(unmade: Studio, pronk: Pronk) -> None:
    code, _, err = pronk("verify", "tiny", cwd=unmade.folder)
    assert (code, err) == (
        2,
        "error: out/tiny: holds no outputs; make them with pronk render\n",
    )
    long = "x" * 300
    code, _, err = pronk("verify", "tiny", "--out", long, cwd=unmade.folder)
    assert (code, err) == (
        2,
        f"error: {long}/tiny: holds no outputs; make them with pronk render\n",
    )
    assert pronk("verify", long, cwd=unmade.folder)[0] == 2
