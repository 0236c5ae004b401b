"""Values from the command line."""

from __future__ import annotations

import pytest

from pipeline.errors import SceneError
from pipeline.spec import read_scene
from pipeline.spec.terrain.kinds import FlatTerrain, HillsTerrain

SCENE = """\
pronk: 1
duration: 2
terrain: hills
figures: {bug: {nodes: {hip: [0, 0]}}, ant: {nodes: {hip: &p [0, 0], top: *p}}}
materials: {goo: bone}
cast:
  - {figure: bug, name: queen}
  - figure: ant
"""


def loaded(*overrides):
    return read_scene(SCENE, "scene.yaml", overrides=overrides)


def problems_of(*overrides):
    with pytest.raises(SceneError) as caught:
        loaded(*overrides)
    return [str(problem) for problem in caught.value.problems]


def test_overrides_replace_values_of_the_scene():
    scene = loaded(
        "cast[0].walk.speed=0.5", "cast.ant.scale = 2", "film.size=[320, 180]", "title=A film"
    )
    assert scene.cast[0].walk.speed == 0.5
    assert scene.cast[1].scale == 2
    assert scene.film.size == (320, 180)
    assert scene.title == "A film"


def test_the_last_override_wins_and_values_may_contain_equals_signs():
    assert loaded("title=a", "title='b=c'").title == "b=c"


def test_frames_and_duration_replace_each_other():
    assert loaded("frames=7").n_frames == 7
    assert loaded("frames=7", "duration=1").n_frames == 24


def test_a_preset_is_adjusted_or_replaced():
    assert loaded("terrain.height=3").terrain == HillsTerrain(height=3)
    assert loaded("terrain=flat").terrain == FlatTerrain()
    assert loaded("materials.goo.roughness=1").materials["goo"].roughness == 1
    assert loaded("light.sun.hour=12").light.sun.hour == 12


def test_overriding_an_alias_changes_one_node():
    nodes = loaded("figures.ant.nodes.top[1]=-3").figures["ant"].nodes
    assert (nodes["hip"].at, nodes["top"].at) == ((0, 0), (0, -3))


def test_an_override_replaces_an_invalid_value():
    assert read_scene(SCENE.replace("2\n", "-2\n", 1), overrides=["duration=3"]).n_frames == 72


def test_overrides_find_members_by_their_generated_names():
    text = SCENE + "  - figure: ant\n"
    scene = read_scene(text, overrides=["cast.ant_2.scale=3"])
    assert [member.scale for member in scene.cast] == [1, 1, 3]


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ("cast[0].walk.sped=1", "cast[0].walk.sped: unknown key, did you mean 'speed'?"),
        ("cast.queen.scale=x", "cast[0].scale: should be a number, is the text 'x'"),
        ("cast[0].scale=.nan", "cast[0].scale: must be a finite number, is .nan"),
        ("cast[0].scale=!x 1", "cast[0].scale: the tag '!x' is refused: a file is plain data"),
        ("cast[2].scale=1", "cast[2]: cast has 2 entries, counted from 0"),
        ("cast.quen.scale=1",
         "cast.quen: nothing in cast is called 'quen', did you mean 'queen'?"),
        ("duration.x=1", "duration.x: duration is no mapping, so nothing below it can be set"),
        ("film[0]=1", "film[0]: film is no list"),
        ("camra.distance=1", "camra: unknown key, did you mean 'camera'?"),
        ("duration", "should be path=value, such as cast[0].walk.speed=0.5"),
        ("=1", "'' is no path; write one as cast[0].walk.speed"),
        ("a..b=1", "'a..b' is no path; write one as cast[0].walk.speed"),
        ("[0]=1", "'[0]' is no path; write one as cast[0].walk.speed"),
        ("cast[-1].scale=1", "'cast[-1].scale' is no path; write one as cast[0].walk.speed"),
        ("cast[0]scale=1", "'cast[0]scale' is no path; write one as cast[0].walk.speed"),
        ("title=", "title: should be text, is empty"),
        ("pronk=2", "pronk: this pronk reads version 1 of the language, not 2"),
    ],
)  # fmt: skip
def test_an_invalid_override_is_refused_with_its_path(overrides, message):
    assert problems_of(overrides) == [f"--set {overrides}: {message}"]


def test_a_syntax_error_in_a_value_names_the_override():
    (problem,) = problems_of("film.size=[320, 180")
    assert problem.startswith("--set film.size=[320, 180: film.size: is not YAML: ")


def test_problems_of_the_file_come_before_those_of_the_command_line():
    with pytest.raises(SceneError) as caught:
        read_scene(SCENE + "sead: 1\n", "scene.yaml", overrides=["fps=0"])
    assert [problem.file for problem in caught.value.problems] == ["scene.yaml", "--set fps=0"]
