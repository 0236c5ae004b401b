"""Any content of a file gives a scene or a list of problems."""

from __future__ import annotations

import re

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeline.errors import SceneError
from pipeline.spec import Scene, dump, read_scene

SCENE = """\
pronk: 1
title: &t Beetle over the rocks
fps: "30000/1001"
duration: 6.5
terrain: {preset: hills, height: 2, material: dry soil}
figures:
  ant:
    style: insect
    nodes:
      head: [0, -1.1]
      tail: {at: [0, 1.0], radius: 0.05}
      knee1: &k [0.7, -0.6]
    chains: [[head, tail], [tail, knee1]]
    then: [{mirror: x, nodes: [knee1]}]
    parts: {knee1: leg}
cast:
  - {name: bug, figure: ant, at: *k, heading_deg: 30, walk: {gait: tripod, cycle: 0.7}}
  - figure: ant
    walk: {gait: {up: {l1: 0.0}, down: {l1: 0.5}}}
materials: {goo: {preset: moss, color: "#102030"}}
camera: [{follow: bug, view: side}, {start: 2, at: [1, 2, 3]}]
light: {sun: {hour: 16.5, day: 172}}
film: {size: [1280, 720], preset: preview}
sound: {scale: C minor pentatonic, voices: [{when: {who: bug}, pitch: by foot}]}
"""
CONFIG = yaml.safe_load(SCENE)
ODD = ["", "~", "-1", "0", "1e9", ".nan", "[]", "{}", "true", "'3'", "*k", "*t", "&k", "!x 1",
       "? a", "- b", "{a: [1, 2]}", "x: 1", "|\n  text", "\t", "<<: *k", "9999999999999999999",
       "1e-300", "!!binary aGk=", "#", "---", "...", "%YAML 1.1", "@", "`", "\\", '"\\x', "é",
       "\u2028", "[1, a]", "[[1, 2], 3]", "{preset: noon}", "{sun: {}, studio: {}}", "null",
       "{preset: 3}", "{preset: [1]}", "{preset: {a: 1}}", "studio", "off"]  # fmt: skip
PIECES = re.findall(r"\w+|[^\w]", SCENE)


def read_or_problems(content, overrides=()):
    """Return the scene or the problems; any other exception fails the test."""
    try:
        return read_scene(content, "scene.yaml", overrides=overrides)
    except SceneError as error:
        problems = error.problems
    assert problems
    assert all(problem.message in str(problem) for problem in problems)
    return problems


def positions(problems):
    return [(p.line, p.column) for p in problems if p.file == "scene.yaml"]


@given(st.binary(max_size=300))
def test_any_bytes_give_a_scene_or_problems(content):
    read_or_problems(content)


@given(st.text(max_size=300))
def test_any_text_gives_a_scene_or_problems(text):
    read_or_problems(text)


@given(st.lists(st.sampled_from([*ODD, *PIECES, ": ", "\n", "\n  ", ", "]), max_size=40))
def test_any_tokens_give_a_scene_or_problems(pieces):
    read_or_problems("".join(pieces))


@pytest.mark.slow
@given(st.data())
@settings(max_examples=300)
def test_replaced_tokens_give_a_round_tripping_scene_or_located_problems(data):
    pieces = list(PIECES)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(pieces) - 1))
        pieces[at] = data.draw(st.sampled_from(ODD) | st.sampled_from(PIECES))
    text = "".join(pieces)
    found = read_or_problems(text)
    if isinstance(found, Scene):
        assert read_scene(dump(found)) == found
        return
    assert positions(found) == sorted(positions(found))
    lines = re.split("\r\n|[\n\r\x85\u2028\u2029]", text)
    for problem in found:
        if problem.source:
            assert problem.source == lines[problem.line - 1]
            assert 1 <= problem.column <= len(problem.source) + 1


@given(st.binary(max_size=4), st.data())
def test_replaced_bytes_give_a_scene_or_problems(content, data):
    start = data.draw(st.integers(0, len(SCENE)))
    end = start + data.draw(st.integers(0, 8))
    read_or_problems(SCENE.encode()[:start] + content + SCENE.encode()[end:])


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["hills", "day", "moss", "trot", "bug", "ant", "leg", "preview", "#112233"]),
    lambda below: (
        st.lists(below, max_size=4)
        | st.dictionaries(
            st.sampled_from(["preset", "kind", "at", "sun", "name"]) | st.text(max_size=4),
            below,
            max_size=3,
        )
    ),
    max_leaves=6,
)


def paths_in(config, path=()):
    yield path
    if isinstance(config, dict | list):
        for step, value in config.items() if isinstance(config, dict) else enumerate(config):
            yield from paths_in(value, (*path, step))


PATHS = [path for path in paths_in(CONFIG) if path]


@pytest.mark.slow
@given(st.sampled_from(PATHS), VALUES)
@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow])
def test_any_value_at_any_path_gives_a_round_tripping_scene_or_problems(path, value):
    config = yaml.safe_load(SCENE)
    below = config
    for step in path[:-1]:
        below = below[step]
    below[path[-1]] = value
    found = read_or_problems(yaml.safe_dump(config, sort_keys=False))
    if isinstance(found, Scene):
        assert read_scene(dump(found)) == found


@given(st.sampled_from(PATHS), st.sampled_from(ODD))
def test_any_override_of_any_path_gives_a_scene_or_problems(path, value):
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    read_or_problems(SCENE, [f"{text.removeprefix('.')}={value}"])


@given(st.lists(st.text(max_size=20), max_size=3))
def test_any_texts_as_overrides_give_a_scene_or_problems(config):
    read_or_problems(SCENE, config)


@pytest.mark.sample(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    "content",
    [
        b"[" * 2**20,
        b"- " * 2**19,
        b"{a: " * 2**18,
        b"? " * 2**19,
        b"a: " + b"x" * (8 * 2**20 - 3),
        b"a: [" + b"1," * 150_000 + b"]",
        b"pronk: 1\ncast: [" + b"{}," * 20_000 + b"]",
        b"pronk: 1\nduration: 1\nfigures: {a: {nodes: {n: [0, 0]}, chains: ["
        + b"[x, y]," * 15_000
        + b"]}}\ncast: [{figure: a}]",
        b"".join(b"k%d: 1\n" % i for i in range(40_000)),
    ],
    ids=["brackets", "dashes", "braces", "questions", "long text", "long list", "large cast",
         "many unknown nodes", "many unknown keys"],
)  # fmt: skip
def test_large_files_are_refused_in_bounded_time(content):
    assert not isinstance(read_or_problems(content), Scene)
