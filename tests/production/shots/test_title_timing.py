"""Titles: which words a frame shows, and titles that cannot be shown."""

from __future__ import annotations

import pytest

from pipeline.errors import SceneError
from pipeline.production.run.scene_check import check_scene
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.shots.title_timing import TitledFilm, problems_of_titles, words_at
from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene
from pipeline.spec.scene import Scene

SCENE = """
pronk: 1
title: {title}
fps: 24
duration: 4
cast:
  - {{name: ann, figure: hopper}}
  - {{name: bob, figure: hopper, at: [3, 0]}}
film: {{size: [320, 180]}}
titles:
{titles}
terrain: {{kind: flat, surroundings: none, scatter: none}}
"""


def scene_with(*titles: str, title: str = "Dawn") -> Scene:
    return read_scene(SCENE.format(title=title, titles="\n".join(f"  - {one}" for one in titles)))


def titled(*titles: str, title: str = "Dawn") -> TitledFilm:
    return TitledFilm.of(scene_with(*titles, title=title))


def test_a_title_has_the_words_of_its_scene_and_fades() -> None:
    film = titled("{preset: title, start: 1, duration: 2, fade: 0.5}")
    assert words_at(film, 0.99) == ()
    assert words_at(film, 3.0) == ()
    (early,), (middle,) = words_at(film, 1.25), words_at(film, 2.0)
    assert early.text == "Dawn"
    assert (early.opacity, middle.opacity) == (0.5, 1.0)


def test_credits_roll_at_the_end_with_the_cast() -> None:
    film = titled("{preset: credits, duration: 2}")
    assert words_at(film, 1.9) == ()
    places = [words_at(film, time)[0].place[1] for time in (2.0, 3.0, 3.99)]
    assert places[0] > 1.0 > places[1] > places[2]
    assert places[2] < 0.0
    (words,) = words_at(film, 3.0)
    assert words.text.split("\n") == ["Dawn", "", "with", "ann", "bob"]


@pytest.mark.nightly
def test_frames_have_the_words_of_their_time_and_their_own_digest() -> None:
    with_title = scene_with("{preset: title, start: 1, duration: 1}")
    plain = with_title.model_copy(update={"titles": ()})
    builders = [ShotBuilder(scene, simulate(scene)) for scene in (with_title, plain)]
    for frame, same in ((1, True), (36, False), (60, True)):
        shots = [builder.shot(frame) for builder in builders]
        assert (shots[0].digest == shots[1].digest) == same
        assert bool(shots[0].words) != same
        assert shots[0].build == shots[1].build


@pytest.mark.parametrize(
    ("title", "message"),
    [
        ("{preset: titel}", r"no title is called 'titel', did you mean 'title'"),
        ("{preset: title, sise: 0.1}", r"titles\[0\].sise: .*size"),
        ("{text: W, size: 0.9}", r"titles\[0\].size"),
        ("{text: hi, place: left}", r"titles\[0\].place"),
    ],
)
def test_wrong_words_are_refused(title: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        scene_with(title)


def test_words_that_do_not_fit_are_refused_with_the_size_that_does() -> None:
    scene = scene_with("{text: A title that is far too long for one line of the frame, size: 0.2}")
    with pytest.raises(SceneError, match=r"scene:11.*titles\[0\].size: too large.*at most 0\.0\d+"):
        check_scene(scene)
    (problem,) = problems_of_titles(TitledFilm.of(scene))
    size = problem.message.split("at most ")[1].split()[0]
    text = "A title that is far too long for one line of the frame"
    assert not list(problems_of_titles(titled(f"{{text: {text}, size: {size}}}")))


def test_titles_without_words_or_after_the_end_are_refused() -> None:
    (empty,) = problems_of_titles(titled("{preset: title}", title="''"))
    assert "no words" in empty.message
    (late,) = problems_of_titles(titled("{text: hi, start: 9}"))
    assert "ends at 4 s" in late.message
