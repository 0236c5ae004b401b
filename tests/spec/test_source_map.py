"""Errors found after loading have file, line and column of their key."""

from __future__ import annotations

import pickle

import pytest

from pipeline.errors import Problem, SceneError
from pipeline.spec import Scene, read_scene

TEXT = """\
pronk: 1
duration: 2
figures:
  bug:
    nodes:
      hip: [0, 0]
      knee l: {at: [1, 0], radius: 0.1}
    chains: [[hip, knee l]]
    then: [{mirror: x},
           {mirror: y}]
    parts: {knee l: leg}
cast:
  - figure: bug
    walk: {speed: 0.5}
"""


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Return a scene that was read from text."""
    return read_scene(TEXT, "bug.yaml")


@pytest.mark.parametrize(
    ("path", "line", "column"),
    [
        ("figures.bug", 4, 3),
        ("figures.bug.nodes.hip", 6, 7),
        ("figures.bug.nodes.knee l", 7, 7),
        ("figures.bug.nodes.knee l.radius", 7, 36),
        ("figures.bug.parts.knee l", 11, 13),
        ("figures.bug.then[1]", 10, 12),
        ("figures.bug.joints.l1", 4, 3),  # not in the file: the nearest key above
        ("cast[0].walk.speed", 14, 19),
        ("cast[0].walk.gait", 14, 5),
        ("cast[0]", 13, 5),
    ],
)
def test_a_path_has_its_line_and_column(scene, path, line, column):
    problem = scene.source_map.with_location(Problem(path, "is odd"))
    assert (problem.line, problem.column, problem.file) == (line, column, "bug.yaml")
    assert problem.source == TEXT.split("\n")[line - 1]
    assert (problem.path, problem.message) == (path, "is odd")


def test_an_unknown_path_has_the_file_alone(scene):
    assert str(scene.source_map.with_location(Problem("zzz", "is odd"))) == "bug.yaml: zzz: is odd"
    assert str(scene.source_map.with_location(Problem("", "is odd"))) == "bug.yaml: is odd"


def test_a_located_problem_keeps_its_location(scene):
    known = Problem("figures.bug", "is odd", "other.yaml", 3, 4, "source")
    assert scene.source_map.with_location(known) == known
    error = scene.source_map.with_locations(SceneError([known, Problem("cast[0]", "too")]))
    assert [problem.line for problem in error.problems] == [3, 13]


def test_a_scene_without_text_has_no_locations(scene):
    config = scene.model_dump()
    made = Scene.model_validate(config)
    assert made.source_map.find("figures.bug") is None
    assert made == scene, "source locations take no part in equality"
    assert pickle.loads(pickle.dumps(scene)).source_map.find("cast[0]") == scene.source_map.find(
        "cast[0]"
    )
