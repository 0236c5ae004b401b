"""Figure walks: contact sheets of figures that walk, crawl or can only stand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.production.reports.figure_sheet import drawn_figures
from pipeline.production.reports.figure_walk import (
    COLUMNS,
    COUNT,
    SIZE,
    VIEWS,
    _cycle_frames,
    _simulated,
    walk_sheet,
)
from pipeline.production.run.progress import Reporter
from render.image_files import read_png


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("horse", "walks"),
        ("inchworm", "crawls as an inchworm"),
        ("robot_arm", "stands, because it cannot walk (figure 'it' has no legs"),
    ],
)
def test_any_figure_shows_what_it_can_do(name: str, says: str) -> None:
    (drawn,) = drawn_figures(name)
    _, take, text = _simulated(drawn.figure, drawn.scene, Reporter())
    assert text.startswith(says)
    frames, cycle = _cycle_frames(take)
    assert len(frames) == COUNT
    assert 1 <= frames[0] < frames[-1] <= take.header.frames
    assert 0.2 < cycle <= 8.0


@pytest.mark.nightly
def test_a_walk_is_rendered_from_two_sides(tmp_path: Path) -> None:
    (drawn,) = drawn_figures("horse")
    walk = walk_sheet(drawn.figure, drawn.scene, tmp_path, "auto", Reporter())
    assert walk.file == tmp_path / "horse_walk.png"
    picture = read_png(walk.file)
    width, height = SIZE
    assert picture.shape[1] > COLUMNS * width
    assert picture.shape[0] > len(VIEWS) * COUNT // COLUMNS * height
    first, later = picture[6 : 6 + height, 6 : 6 + width], picture[6 : 6 + height, 12 + width :]
    assert np.abs(first.astype(int) - later[:, :width]).max() > 60, "the horse moves its legs"
