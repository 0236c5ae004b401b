"""Time estimates: reported before rendering, corrected, and stored."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.production.run.time_estimate import (
    MAX_PACES,
    Estimate,
    frame_work,
    rounded_duration,
    stored_paces,
)
from render.backend import Backend
from render.config import Film

BACKEND = Backend("llvm_ad_rgb", "", "23.1", "for a test")


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def estimate(name: str = "a", total: int = 100, **config: object) -> Estimate:
    return Estimate(name, Film.model_validate(config).resolved(), BACKEND, 1, total)


def filmed(film: Estimate, each: float, first: float = 20.0) -> list[str]:
    """Estimate a film of constant pace after a slow first frame; return the reports."""
    reports = [film.after(done, first + each * (done - 1)) for done in range(1, film.total + 1)]
    film.store()
    return [text for text in reports if text is not None]


def test_without_earlier_films_the_first_frames_give_the_estimate() -> None:
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
    (reports,) = filmed(slower, 5.0)
    assert "about 8 min for 96 frames" in reports


def test_another_film_takes_as_long_as_its_work() -> None:
    filmed(estimate(), 2.0)
    other = estimate("b", size=(1280, 720))
    assert other.before() == (
        "render: about 14 min for 100 frames of 1280x720, by other films on this machine"
    )
    assert frame_work(other.film) == pytest.approx(4 * frame_work(estimate().film))


def test_tiny_frames_predict_only_their_own_film() -> None:
    filmed(estimate("tiny", size=(64, 36)), 0.3)
    assert estimate().before() is None
    assert "by the last time" in str(estimate("tiny", size=(64, 36)).before())


def test_estimates_include_the_start() -> None:
    filmed(estimate(), 2.0, first=302.0)
    assert "about 8 min for 100 frames" in str(estimate().before())


def test_a_long_start_is_replaced_by_a_shorter_one() -> None:
    filmed(estimate(), 2.0, first=302.0)
    filmed(estimate(), 2.0, first=22.0)
    filmed(estimate(), 2.0, first=102.0)
    assert "about 4 min for 100 frames" in str(estimate().before())


def test_short_films_report_nothing() -> None:
    assert filmed(estimate(total=20), 0.1, first=0.5) == []
    assert estimate(total=20).before() is None


@pytest.mark.parametrize("content", ["", "[1]", '{"a": "x"}', '{"a": -1}', "\x00"])
def test_damaged_paces_are_ignored(tmp_path: Path, content: str) -> None:
    place = tmp_path / "pronk" / "paces.json"
    place.parent.mkdir()
    place.write_text(content)
    assert stored_paces() == {}
    filmed(estimate(), 2.0)
    assert estimate().before() is not None


@pytest.mark.slow
def test_the_oldest_paces_are_dropped() -> None:
    filmed(estimate("first"), 2.0)
    for i in range(MAX_PACES - 2):
        filmed(estimate(f"s{i}", total=5), 1.0)
    assert len(stored_paces()) == MAX_PACES
    assert "by other films" in str(estimate("first").before())
    assert "by the last time" in str(estimate(f"s{MAX_PACES - 3}").before())


def test_paces_that_cannot_be_stored_do_no_harm(
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
def test_durations_are_rounded(seconds: float, text: str) -> None:
    assert rounded_duration(seconds) == text
