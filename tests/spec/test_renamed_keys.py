"""Earlier names of keys: the same scene, with a warning that says the new name and the line."""

from __future__ import annotations

import logging

import pytest

from pipeline.errors import SceneError
from pipeline.spec import read_scene, simulation_key
from pipeline.spec.rpc_instruction import instruction_of

SCENE = """pronk: 1
frames: 2
{rows}: 2
moods: {{heavy: {{{bob}: 0.5}}}}
cast:
  - figure: beetle
    walk: {{{bob}: 0.01}}
script:
  - {{at: 0, who: beetle, do: {{gait: tripod, {bob}: 0.02}}}}
"""

OLD = SCENE.format(rows="samples", bob="bounciness")
NEW = SCENE.format(rows="rows_per_frame", bob="body_bob")


def test_old_keys_equal_new_keys(caplog: pytest.LogCaptureFixture) -> None:
    new = read_scene(NEW, "new.yaml")
    assert not caplog.messages
    old = read_scene(OLD, "old.yaml")
    assert old == new
    assert simulation_key(old) == simulation_key(new)
    assert (new.rows_per_frame, new.moods["heavy"].body_bob) == (2, 0.5)


def test_each_old_key_gives_one_warning(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "pronk"):
        read_scene(OLD, "old.yaml")
    assert sorted(caplog.messages) == [
        "warning: old.yaml:3: samples is now called rows_per_frame; write that",
        "warning: old.yaml:4: moods.heavy.bounciness is now called body_bob; write that",
        "warning: old.yaml:7: cast[0].walk.bounciness is now called body_bob; write that",
        "warning: old.yaml:9: script[0].do.bounciness is now called body_bob; write that",
    ]


def test_old_keys_work_on_the_command_line(caplog: pytest.LogCaptureFixture) -> None:
    changes = ["samples=1", "cast.beetle.walk.bounciness=0.03"]
    scene = read_scene(NEW, "new.yaml", overrides=changes)
    assert scene.rows_per_frame == 1
    (_, creature), *_ = scene.creatures
    assert creature.walk is not None
    assert creature.walk.body_bob == 0.03
    assert [message.partition(" is now")[0] for message in caplog.messages] == [
        "warning: --set samples=1: samples",
        "warning: --set cast.beetle.walk.bounciness=0.03: cast[0].walk.bounciness",
    ]


def test_old_and_new_name_together_are_refused_at_the_old_one() -> None:
    with pytest.raises(SceneError) as refused:
        read_scene(NEW.replace("frames: 2\n", "frames: 2\nsamples: 2\n", 1), "both.yaml")
    (problem,) = refused.value.problems
    assert (problem.file, problem.line, problem.column) == ("both.yaml", 3, 1)
    assert "'rows_per_frame'" in problem.message


def test_bounciness_of_bodies_keeps_its_name(caplog: pytest.LogCaptureFixture) -> None:
    body = "{body: {shape: sphere, bounciness: 0.9}}"
    scene = read_scene(f"pronk: 1\nframes: 1\ncast: [{body}]", "ball.yaml")
    assert scene.cast[0].body.bounciness == 0.9
    assert not caplog.messages


def test_rpc_instructions_accept_old_keys() -> None:
    values = {"who": "beetle", "do": {"gait": "tripod", "bounciness": 0.02}}
    scene = read_scene(NEW)
    assert instruction_of(values, scene, 0.0).do == scene.script[0].do
