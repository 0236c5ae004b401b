"""Frame ranges, and the layout of contact sheets."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import UsageError
from pipeline.production.reports.stills import GAP, PAPER, laid_out, spread
from pipeline.production.run.frame_ranges import contiguous, described, parse_frames


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        (None, range(1, 91)),
        ("5", [5]),
        ("1-4", [1, 2, 3, 4]),
        ("4-1", [1, 2, 3, 4]),
        ("1-3,60-90x10", [1, 2, 3, 60, 70, 80, 90]),
        ("3,1-3,2", [1, 2, 3]),
        (" 7 - 8 ".replace(" - ", "-"), [7, 8]),
    ],
)
def test_frames_are_ascending_and_each_once(text: str | None, frames: list[int]) -> None:
    assert parse_frames(text, 90) == tuple(frames)


@given(st.text("0123456789-x,:y@# .abc", max_size=12))
def test_any_text_gives_frames_of_the_scene_or_a_message(text: str) -> None:
    frames: tuple[int, ...] = ()
    message = ""
    try:
        frames = parse_frames(text, 20)
    except UsageError as error:
        message = str(error)
    assert bool(frames) != message.startswith(f"--frames '{text}': ")
    assert list(frames) == sorted(set(frames))
    assert set(frames) <= set(range(1, 21))


@given(st.sets(st.integers(1, 300), min_size=1))
def test_a_description_names_its_frames(frames: set[int]) -> None:
    asked = tuple(sorted(frames))
    text = described(asked)
    assert len(text) <= 80
    assert "/" not in text
    assert "," not in text
    assert contiguous(asked) == (asked == tuple(range(asked[0], asked[-1] + 1)))
    if len(asked) < 15:
        assert parse_frames(text.replace("_", ","), 300) == asked


def test_other_frames_have_another_description() -> None:
    random = np.random.default_rng(3)
    many = {
        described(tuple(int(f) for f in sorted(random.choice(900, 99, replace=False) + 1)))
        for _ in range(50)
    }
    assert len(many) == 50


@given(st.integers(1, 5000), st.integers(1, 400))
def test_a_spread_is_even_from_the_first_to_the_last(last: int, count: int) -> None:
    frames = spread(last, count)
    assert len(frames) == min(count, last)
    assert frames[0] == 1
    assert len(frames) == 1 or frames[-1] == last
    steps = np.diff(frames)
    assert len(steps) == 0 or steps.max() - steps.min() <= 1


@given(st.integers(1, 7), st.integers(1, 9))
def test_a_sheet_shows_each_picture_once_in_reading_order(count: int, columns: int) -> None:
    pictures = [np.full((4, 6, 3), 100 + i, np.uint8) for i in range(count)]
    sheet = laid_out(pictures, columns)
    for i in range(count):
        places = np.argwhere(sheet[..., 0] == 100 + i)
        assert len(places) == 4 * 6
        row, column = divmod(i, min(columns, count))
        assert tuple(places[0]) == (GAP + row * (4 + GAP), GAP + column * (6 + GAP))
    assert (sheet == PAPER).sum() == sheet.size - count * 4 * 6 * 3
