"""Score builder: events relative to the listener; every cause is audible."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import pytest

from audio.cause_voices import cause_voice
from audio.notes import notes_of
from audio.synthesis import sound_parameters, synthesize
from pipeline.production.sound.event_files import events_jsonl
from pipeline.production.sound.score_builder import build_score
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.spec.sound_thresholds import Detect
from render.shot import CameraPose

if TYPE_CHECKING:
    from tests.production.conftest import Studio

AHEAD = CameraPose((0.0, 0.0, 0.0), (0.0, 0.0, -5.0))
"""Looks along -Z, so that +X is to its right."""


@pytest.fixture(scope="module")
def scene(unmade: Studio) -> Scene:
    return unmade.load()


def heard(
    scene: Scene, take: Take, place: Sequence[float], pose: CameraPose
) -> tuple[float, float]:
    x, y, z = place
    event = replace(take.events[0], place=(x, y, z))
    score, _ = build_score(scene, replace(take, events=(event,)), [pose] * take.header.frames)
    return score.events[0].azimuth, score.events[0].distance


@pytest.mark.parametrize(
    ("place", "azimuth"),
    [
        ((0, 0, -3), 0.0),
        ((3, 0, 0), math.pi / 2),
        ((-3, 0, 0), -math.pi / 2),
        ((2, 0, -2), math.pi / 4),
        ((-2, 0, -2), -math.pi / 4),
        ((2, 0, 2), 3 * math.pi / 4),
        # Height does not change the azimuth.
        ((2, 7, -2), math.pi / 4),
    ],
)
def test_sounds_on_the_right_of_the_picture_come_from_the_right(
    scene: Scene, take: Take, place: Sequence[float], azimuth: float
) -> None:
    found, distance = heard(scene, take, place, AHEAD)
    assert found == pytest.approx(azimuth)
    assert distance == pytest.approx(math.hypot(*place))


def test_turning_the_camera_changes_the_azimuth_only(scene: Scene, take: Take) -> None:
    back = CameraPose((0.0, 0.0, 0.0), (0.0, 0.0, 5.0))
    assert heard(scene, take, (3, 0, 0), back)[0] == pytest.approx(-math.pi / 2)
    down = CameraPose((0.0, 5.0, 0.0), (0.0, 0.0, 0.0), up=(1.0, 0.0, 0.0))
    # +X is up in this picture, so +Z is to the right; the target is 5 m ahead.
    assert heard(scene, take, (0, 0, 3), down)[0] == pytest.approx(math.atan2(3, 5))
    assert heard(scene, take, (0, 0, -3), down)[0] == pytest.approx(-math.atan2(3, 5))


def test_a_listener_at_a_configured_place(unmade: Studio, take: Take) -> None:
    scene = unmade.load("sound.listener=[10,0,0]")
    azimuth, distance = heard(scene, take, (7, 0, -4), AHEAD)
    assert distance == pytest.approx(5.0)
    assert azimuth == pytest.approx(math.atan2(-3, 4))


def test_events_after_the_last_frame_are_dropped_and_counted(scene: Scene, take: Take) -> None:
    event = take.events[0]
    events = tuple(replace(event, frame=frame) for frame in (7, 8, 9, 9))
    late = replace(take, events=events)
    score, dropped = build_score(scene, late, [AHEAD] * 8)
    assert ([e.frame for e in score.events], dropped) == ([7, 8], 2)
    lines = [json.loads(line) for line in events_jsonl(late).splitlines()]
    assert [line["frame"] for line in lines] == [7, 8]


def test_a_score_keeps_the_times_and_names_of_its_events(scene: Scene, take: Take) -> None:
    score, dropped = build_score(scene, take, [AHEAD] * take.header.frames)
    assert (score.rate, score.frames, score.title) == (Fraction(24), 8, "Tiny")
    assert len(score.events) + dropped == len(take.events) > 0
    for event in score.events:
        shown = (event.frame - 1) / score.rate
        assert shown - 1 / score.rate < event.time <= shown
        assert event.who == "bug"
        assert not event.part.startswith("bug")


def test_a_passing_sound_is_placed_at_its_nearest_point(scene: Scene, take: Take) -> None:
    """The camera is that of the row's frame."""
    samples = take.header.samples
    turned = replace(AHEAD, p_WC=(0.0, 0.0, 10.0), p_WT=(0.0, 0.0, 5.0))
    poses = [AHEAD] * 2 + [turned] * (take.header.frames - 2)
    places = ((-9.0, 0.0, -3.0), (-1.0, 0.0, -3.0), (4.0, 0.0, 7.0), (9.0, 0.0, 7.0))
    event = replace(
        take.events[0],
        frame=1,
        cause="swoosh",
        place=places[0],
        places=tuple(place for place in places for _ in range(samples)),
        track=(0, 4 * samples - 1),
    )
    score, _ = build_score(scene, replace(take, events=(event,)), poses)
    (placed,) = score.events
    assert placed.distance == pytest.approx(math.hypot(1, 3))
    assert placed.azimuth == pytest.approx(math.atan2(-1, 3))


@pytest.mark.parametrize("cause", Detect.model_fields)
def test_every_detected_cause_is_audible(scene: Scene, take: Take, cause: str) -> None:
    event = replace(take.events[0], cause=cause, frame=1, step=0, fraction=0.0, place=(0, 0, -2))
    poses = [AHEAD] * take.header.frames
    score, _ = build_score(scene, replace(take, events=(event,)), poses)
    (note,) = notes_of(score)
    assert -40 < note.level < 6
    parameters, _ = sound_parameters(note, 1, 0, 2.0)
    sound = synthesize(parameters, 1)
    assert np.isfinite(sound).all()
    assert np.abs(sound).max() == pytest.approx(1.0)
    # Only impacts sound by their materials alone.
    assert (cause_voice(cause) is None) == (cause in ("footfall", "collision"))


@pytest.mark.parametrize("cause", ["breath", "rustle"])
def test_breath_and_clothes_are_heard_near_the_camera_alone(
    scene: Scene, take: Take, cause: str
) -> None:
    near, far = (
        replace(take.events[0], cause=cause, frame=1, step=0, fraction=0.0, place=(0, 0, -z))
        for z in (7.9, 8.1)
    )
    poses = [AHEAD] * take.header.frames
    score, _ = build_score(scene, replace(take, events=(near, far)), poses)
    (heard_one,) = score.events
    assert heard_one.distance == pytest.approx(7.9)
