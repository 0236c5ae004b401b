"""Watch: a picture per change, reported errors, and no film overwritten."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import PronkError
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.production.run.watch import Stamps, changes_of, files_of, stamps, watch
from pipeline.spec import library, load_scene
from tests.audio.soundfont_writer import sf2

SCENE = "pronk: 1\nframes: 4\ncast: [{figure: beetle, walk: {}}]\n"


class Results(Reporter):
    """A reporter that keeps the results."""

    def __init__(self) -> None:
        self.results: list[str] = []

    def result(self, text: str) -> None:
        """Keep it."""
        self.results.append(text)


def test_every_change_makes_a_picture_and_errors_are_reported(tmp_path: Path) -> None:
    file = tmp_path / "play.yaml"
    file.write_text(SCENE)
    edits = iter([SCENE.replace("walk", "wlak"), SCENE.replace("4", "6"), None])
    asked: list[Stamps] = []
    errors: list[PronkError] = []
    made: list[Order] = []

    def changes(files: Stamps) -> Iterator[object]:
        asked.append(files)
        text = next(edits)
        if text is not None:
            file.write_text(text)
            yield text

    def order_of() -> Order:
        return Order(load_scene(file), "play", tmp_path / "out")

    def make(order: Order) -> Path:
        made.append(order)
        return tmp_path / f"{len(made)}.png"

    report = Results()
    watch(file, order_of, make, report, errors.append, changes)
    assert [order.scene.n_frames for order in made] == [4, 6]
    assert report.results == [str(tmp_path / "1.png"), str(tmp_path / "2.png")]
    (mistake,) = errors
    assert "did you mean 'walk'" in str(mistake)
    assert all(file in files for files in asked)
    assert len(asked) == 3


def test_files_of_a_scene_are_watched(tmp_path: Path) -> None:
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    (tmp_path / "thing.obj").write_text(corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    (tmp_path / "heights.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf 1 2 3\n")
    (tmp_path / "my.sf2").write_bytes(sf2(np.sin(np.arange(400))))
    figure = (library() / "figures" / "tripod.yaml").read_text("utf-8")
    for folder, name in (("drawings", "g3"), ("figures", "g4"), (".", "g5")):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / f"{name}.yaml").write_text(figure)
    file = tmp_path / "play.yaml"
    members = (
        "{name: a, body: {shape: mesh, file: thing.obj}, at: [0, 2, 0]}",
        "{figure: beetle}, {figure: ./drawings/g3.yaml}, {figure: g4}, {figure: g5}",
    )
    file.write_text(
        f"pronk: 1\nframes: 2\ncast: [{', '.join(members)}]\n"
        "terrain: {kind: mesh, file: heights.obj}\nsound: {soundfont: my.sf2}\n"
    )
    names = {str(path.relative_to(tmp_path)) for path in files_of(load_scene(file))}
    figures = {"drawings/g3.yaml", "figures/g4.yaml", "g5.yaml"}
    assert names == {"play.yaml", "thing.obj", "heights.obj", "my.sf2", *figures}


def test_a_folder_of_figures_that_comes_later_is_noticed(tmp_path: Path) -> None:
    file = tmp_path / "play.yaml"
    file.write_text(SCENE)
    later = threading.Timer(0.5, (tmp_path / "figures").mkdir)
    later.start()
    seen = next(changes_of(stamps({file})))
    later.join()
    assert {Path(name).name for _, name in seen} == {"figures"}  # type: ignore[attr-defined]


def test_changes_before_watching_are_not_missed(tmp_path: Path) -> None:
    file = tmp_path / "play.yaml"
    file.write_text(SCENE)
    seen = stamps({file})
    file.write_text(SCENE + "# more\n")
    assert next(changes_of(seen), None) is not None
    file.unlink()
    assert stamps({file}) == {file: None}


def test_a_replaced_file_is_noticed(tmp_path: Path) -> None:
    """As editors save: a new file is renamed into the old one's place."""
    file = tmp_path / "play.yaml"
    file.write_text(SCENE)
    (tmp_path / "notes.txt").write_text("")

    def save() -> None:
        (tmp_path / "notes.txt").write_text("not of the scene")
        time.sleep(0.4)
        new = tmp_path / ".play.yaml.new"
        new.write_text(SCENE + "# more\n")
        os.replace(new, file)

    edit = threading.Timer(0.5, save)
    edit.start()
    seen = next(changes_of(stamps({file})))
    edit.join()
    assert {Path(name).name for _, name in seen} == {"play.yaml"}  # type: ignore[attr-defined]


@pytest.mark.nightly
def test_the_command_follows_a_scene_until_it_is_stopped(unmade, tmp_path, start) -> None:
    studio = unmade.copied(tmp_path / "studio")
    running = start("watch", "tiny.yaml", "--frame", "2", cwd=studio.folder)
    picture = studio.folder / "out" / "watch" / "tiny" / "frames" / "0002.png"
    first = _awaited(picture, None)
    time.sleep(0.5)
    text = studio.scene.read_text()
    studio.scene.write_text(text.replace("studio", "noon"))
    _awaited(picture, first)
    studio.scene.write_text(text.replace("tripod", "tripodd"))
    time.sleep(3.0)
    running.interrupt()
    code, out, err = running.end()
    assert code == 130
    assert out.count("0002.png") == 2
    assert "did you mean 'tripod'" in err
    assert "Traceback" not in err
    # The take is the same under another light.
    assert "take is up to date" in err
    assert not studio.made.exists()


def _awaited(picture: Path, before: bytes | None) -> bytes:
    """Wait for a picture that differs; return its bytes."""
    for _ in range(1200):
        if picture.exists() and (now := picture.read_bytes()) != before:
            return now
        time.sleep(0.1)
    raise AssertionError(f"{picture} did not come")
