"""How long a film will take: said before, put right in time, remembered."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.production.run.time_estimate import (
    MOST,
    Estimate,
    remembered,
    spoken,
    work_of,
)
from render.backend import Backend
from render.config import Film

BACKEND = Backend("llvm_ad_rgb", "", "23.1", "for a test")


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def estimate(name: str = "a", total: int = 100, **words: object) -> Estimate:
    return Estimate(name, Film.model_validate(words).resolved(), BACKEND, 1, total)


def filmed(one: Estimate, each: float, first: float = 20.0) -> list[str]:
    """Film at a pace, after a slow first frame; return what is said."""
    said = [one.after(done, first + each * (done - 1)) for done in range(1, one.total + 1)]
    one.remember()
    return [text for text in said if text is not None]


def test_nothing_known_nothing_said_until_some_frames_are_done() -> None:
    one = estimate()
    assert one.before() is None
    assert filmed(one, 2.0) == [
        "render: about 3 min for 96 frames of 640x360, by the first of them"
    ]


def test_the_same_film_takes_as_long_as_it_did() -> None:
    filmed(estimate(), 2.0)
    again = estimate()
    assert again.before() == "render: about 4 min for 100 frames of 640x360, by the last time"
    assert filmed(again, 2.1) == []
    slower = estimate()
    slower.before()
    (said,) = filmed(slower, 5.0)
    assert "about 8 min for 96 frames" in said


def test_another_film_takes_as_long_as_its_work() -> None:
    filmed(estimate(), 2.0)
    other = estimate("b", size=(1280, 720))
    assert other.before() == (
        "render: about 14 min for 100 frames of 1280x720, by other films on this machine"
    )
    assert work_of(other.film) == pytest.approx(4 * work_of(estimate().film))


def test_tiny_frames_tell_of_their_own_film_alone() -> None:
    filmed(estimate("tiny", size=(64, 36)), 0.3)
    assert estimate().before() is None
    assert "by the last time" in str(estimate("tiny", size=(64, 36)).before())


def test_the_first_frame_is_counted_in() -> None:
    filmed(estimate(), 2.0, first=302.0)
    assert "about 8 min for 100 frames" in str(estimate().before())


def test_a_begin_that_took_long_once_is_forgotten_for_a_shorter_one() -> None:
    filmed(estimate(), 2.0, first=302.0)
    filmed(estimate(), 2.0, first=22.0)
    filmed(estimate(), 2.0, first=102.0)
    assert "about 4 min for 100 frames" in str(estimate().before())


def test_short_films_say_nothing() -> None:
    assert filmed(estimate(total=20), 0.1, first=0.5) == []
    assert estimate(total=20).before() is None


@pytest.mark.parametrize("content", ["", "[1]", '{"a": "x"}', '{"a": -1}', "\x00"])
def test_a_damaged_memory_is_forgotten(tmp_path: Path, content: str) -> None:
    place = tmp_path / "pronk" / "paces.json"
    place.parent.mkdir()
    place.write_text(content)
    assert remembered() == {}
    filmed(estimate(), 2.0)
    assert estimate().before() is not None


@pytest.mark.slow
def test_memory_is_bounded_and_the_oldest_goes_first() -> None:
    filmed(estimate("first"), 2.0)
    for i in range(MOST - 2):
        filmed(estimate(f"s{i}", total=5), 1.0)
    assert len(remembered()) == MOST
    assert "by other films" in str(estimate("first").before())
    assert "by the last time" in str(estimate(f"s{MOST - 3}").before())


def test_a_memory_that_cannot_be_kept_does_no_harm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    filmed(estimate(), 2.0)
    assert estimate().before() is None


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (3, "5 s"),
        (42, "40 s"),
        (100, "2 min"),
        (720, "12 min"),
        (7200, "2 h 0 min"),
        (9000, "2 h 30 min"),
    ],
)
def test_times_are_said_as_one_says_them(seconds: float, text: str) -> None:
    assert spoken(seconds) == text
