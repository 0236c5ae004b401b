"""Picture notes: black and blown-out pictures, also those of earlier runs, and the camera's."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from pipeline.production.run.notes import Note, NotesRefused
from pipeline.production.run.picture_notes import level_notes
from pipeline.production.run.production import render
from pipeline.production.run.progress import Reporter
from pipeline.production.run.scene_check import check_scene
from render.development import Development
from render.image_files import read_key, read_levels, read_png, write_exr, write_png
from render.picture_levels import PictureLevels

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.production.conftest import Studio

FINE, BLACK, WHITE = PictureLevels(0.6, 0.0), PictureLevels(0.02, 0.0), PictureLevels(0.99, 0.7)


class Recording(Reporter):
    """Keeps the notes of the last run."""

    told: tuple[Note, ...] = ()

    def notes(self, scene: str, notes: Sequence[Note], manifest: Path | None) -> None:
        """Keep them."""
        self.told = tuple(notes)


def told(studio: Studio, *sets: str, **more: object) -> list[tuple[str, str, int | None]]:
    """Render the film and return kind, source and frame of its notes."""
    reporter = Recording()
    render(studio.order(*sets, **more), reporter)
    return [(note.kind, note.source, note.frame) for note in reporter.told]


# --- levels -----------------------------------------------------------------------


def test_levels_are_the_bright_percentile_and_the_share_of_white() -> None:
    picture = np.zeros((100, 100, 3), np.uint8)
    picture[:30] = 255
    assert PictureLevels.of_srgb8(picture) == PictureLevels(1.0, 0.3)
    assert PictureLevels.of_srgb8(np.full((8, 8, 3), 51, np.uint8)) == PictureLevels(0.2, 0.0)


def test_levels_of_a_large_picture_are_those_of_a_grid_of_it() -> None:
    light = np.random.default_rng(2).uniform(0.0, 0.5, (1080, 1920, 3)).astype(np.float32)
    light[:540] = 50.0
    large, small = (PictureLevels.of(part, Development()) for part in (light, light[::2, ::2]))
    assert large.white == pytest.approx(0.5, abs=0.01)
    assert small.bright == pytest.approx(large.bright, abs=0.01)


def test_levels_stand_in_the_files_of_frames(tmp_path: Path) -> None:
    png, exr = tmp_path / "a.png", tmp_path / "a.exr"
    write_png(png, np.zeros((4, 4, 3), np.uint8), "key", levels=WHITE)
    write_exr(exr, np.zeros((4, 4, 3), np.float32), "key", WHITE)
    assert read_levels(png) == read_levels(exr) == WHITE
    write_png(png, np.zeros((4, 4, 3), np.uint8), "key")
    assert read_levels(png) is None
    assert read_levels(tmp_path / "none.exr") is None


@pytest.mark.parametrize(
    ("levels", "kinds"),
    [
        ([FINE, BLACK, BLACK, FINE, BLACK, FINE], []),
        ([FINE, BLACK, BLACK, BLACK, FINE, FINE], ["picture_black"]),
        ([BLACK, BLACK, BLACK, WHITE, WHITE, WHITE], ["picture_black", "picture_blown_out"]),
        ([BLACK], ["picture_black"]),
    ],
)
def test_three_pictures_in_a_row_make_a_note_or_the_only_one(
    studio: Studio, levels: list[PictureLevels], kinds: list[str]
) -> None:
    notes = level_notes(studio.load(), range(1, len(levels) + 1), levels)
    assert [note.kind for note in notes] == kinds


def test_a_note_names_the_runs_of_frames(studio: Studio) -> None:
    levels = [BLACK] * 3 + [FINE] + [BLACK] * 4
    (note,) = level_notes(studio.load(), range(1, 9), levels)
    assert note.frame == 1
    assert note.text.endswith("in frames 1-3, 5-8")


# --- runs -------------------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("exposure", "kind"), [(-12, "picture_black"), (0, ""), (9, "picture_blown_out")]
)
def test_a_run_tells_its_pictures_again_when_they_come_from_the_cache(
    studio: Studio, exposure: int, kind: str
) -> None:
    sets = f"film.exposure={exposure}"
    expected = [(kind, "picture", 1)] if kind else []
    assert told(studio, sets) == expected
    assert told(studio, sets) == expected
    entries = json.loads((studio.made / "manifest.json").read_text())
    assert [note["kind"] for note in entries["notes"]] == ([kind] if kind else [])


@pytest.mark.nightly
def test_frames_without_levels_are_measured(studio: Studio) -> None:
    sets = "film.exposure=-12"
    told(studio, sets)
    for frame in range(1, 9):
        path = studio.frame(frame)
        write_png(path, read_png(path), read_key(path) or "")
    assert told(studio, sets) == [("picture_black", "picture", 1)]


@pytest.mark.nightly
def test_a_night_with_a_moon_is_not_black(studio: Studio) -> None:
    assert told(studio, "light=night", frames="1-3") == []


def test_strict_refuses_a_camera_before_it_renders(studio: Studio) -> None:
    before = studio.state()
    sets = ("camera={at: [0, 1, 30], look_at: [0, 1, 60]}",)
    with pytest.raises(NotesRefused) as refused:
        render(studio.order(*sets, strict=True), Reporter())
    (note,) = refused.value.notes
    assert (note.kind, note.source, note.part) == ("subject_out_of_frame", "camera", "bug")
    assert studio.changes(before) == set()


def test_a_check_that_simulates_tells_of_the_camera(studio: Studio) -> None:
    scene = studio.load("camera={follow: bug, distance: 90}")
    reporter = Recording()
    check_scene(scene, reporter, simulated=True)
    (note,) = reporter.told
    assert (note.kind, note.frame) == ("subject_tiny", 1)
    line = 1 + studio.scene.read_text().splitlines().index("camera: {follow: bug}")
    assert note.place.endswith(f"tiny.yaml:{line}")
