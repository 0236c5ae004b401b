"""Controllers mixed by arm and by subtask, other builds, field combination, and gaze."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.dancers.dancer_motion import DancerMotion
from pipeline.simulation.dancers.torso import LINKS, dancer_proportions
from pipeline.simulation.people.proportions import CHILD
from pipeline.spec import read_scene
from tests.simulation.dancers.dance_recorder import (
    MAX_PENETRATION,
    TOUCH_TOLERANCE,
    DanceRecording,
    build_dancer,
    record_motion,
)

TWO_CONTROLLERS = """dances:
  two:
    bar: 4
    subtasks:
      - {hand: r, reach: [0.45, 1.3, 0.2], controller: force-field}
      - {hand: r, reach: [0.40, 1.5, 0.4], controller: joint-torque}
      - {hand: r, reach: [0.45, 1.2, 0.3], controller: force-field}
      - {hand: l, reach: [0.45, 1.3, -0.2]}
"""


@pytest.mark.nightly
def test_arms_with_different_controllers_move_as_with_one() -> None:
    mixed = record_motion(
        "controller: {r: force-field, l: joint-torque}, tempo_bpm: 80, start: 1", 3.0
    )
    right, left = mixed.dancer.arms
    assert right.by_fields
    assert not left.by_fields
    # Before the hands meet, each arm moves as with one controller for both.
    for k, by in enumerate(("force-field", "joint-torque")):
        alone = record_motion(f"controller: {by}, tempo_bpm: 80, start: 1", 3.0)
        apart = np.linalg.norm(np.array(mixed.hands)[:, k] - np.array(alone.hands)[:, k], axis=1)
        assert apart.max() < 0.01


def test_controller_of_each_subtask_changes_at_rest() -> None:
    motion = DanceRecording(
        build_dancer("dance: two, tempo_bpm: 60, start: 0.5", more=TWO_CONTROLLERS)
    )
    by = []
    while motion.dancer.now < 4.8:
        motion.strikes += motion.dancer.advance()
        motion.record()
        by.append(motion.dancer.arms[0].by_fields)
    changes = np.flatnonzero(np.diff(np.array(by)))
    assert len(changes) == 3
    for move, hand in motion.moves()[:4]:
        site = motion.dancer.goals[move.subtask].sites[-1]
        rows = motion.around(move, 0.02, 0.05)
        goal = motion.dancer.moving.places[site]
        assert np.linalg.norm(np.array(motion.hands)[rows, hand] - goal, axis=1).min() < 0.02
    speed = np.linalg.norm(np.diff(np.array(motion.hands)[:, 0], axis=0), axis=1) * 96
    # The hand rests at each change.
    for change in changes[1:]:
        assert speed[change - 2 : change + 3].max() < 0.15


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("by", ["force-field", "joint-torque"])
def test_child_dances_macarena(by: str) -> None:
    scene = read_scene(
        f"pronk: 1\nduration: 20\ncast: [{{dancer: child, controller: {by}, tempo_bpm: 80}}]\n"
    )
    assert dancer_proportions(scene.dancers[0][1]) == CHILD
    config = f"controller: {by}, tempo_bpm: 80, start: 1.0"
    motion = record_motion(config, 1.0 + 12.3 * 0.75, build="child")
    missed = []
    for move, hand in motion.moves():
        goal = motion.dancer.goals[move.subtask]
        if goal.surface is not None:
            rows = motion.around(move, 0.1, 0.12)
            places = np.array(motion.places)[rows, move.subtask]
            away = np.linalg.norm(np.array(motion.hands)[rows, hand] - places, axis=1).min()
            missed.append(round(float(away), 3))
    assert max(missed) < TOUCH_TOLERANCE, missed
    assert max(motion.deepest.values()) < MAX_PENETRATION


def test_uncompensated_gravity_lowers_hand() -> None:
    config = "dance: two, tempo_bpm: 60, start: 0.5, controller: force-field"
    plain, sagging = (
        record_motion(f"{config}, compensate_gravity: {held}", 1.5, more=TWO_CONTROLLERS)
        for held in ("true", "false")
    )
    assert plain.hands[-1][0, 1] - sagging.hands[-1][0, 1] > 0.003


def test_winner_and_sum_of_fields_reach_the_same_place() -> None:
    ends = []
    for rule in ("sum", "winner"):
        config = f"dance: two, tempo_bpm: 60, start: 0.5, controller: force-field, combine: {rule}"
        motion = record_motion(config, 1.6, more=TWO_CONTROLLERS)
        ends.append(motion.hands[-1][0])
        speed = np.linalg.norm(np.diff(np.array(motion.hands)[:, 0], axis=0), axis=1) * 96
        assert speed.max() < 4.0
    np.testing.assert_allclose(ends[0], ends[1], atol=0.02)


def test_head_turns_to_moving_hand() -> None:
    names: list[float] = []
    for gaze in ("true", "false"):
        dancer: DancerMotion = build_dancer(
            f"dance: two, tempo_bpm: 60, gaze: {gaze}", more=TWO_CONTROLLERS
        )
        while dancer.now < 1.9:
            dancer.advance()
        names.append(float(dancer.moving.q[dancer.torso.names.index("neck_rotation")]))
    # To the right: a left turn is positive.
    assert names[0] < -0.1
    assert abs(names[1]) < 0.02


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("by", ["force-field", "joint-torque"])
@pytest.mark.nightly
def test_gaze_follows_hands(by: str) -> None:
    dancer = build_dancer(f"controller: {by}, tempo_bpm: 80, start: 1.0")
    head, rows = LINKS.index("head"), list[tuple[float, ...]]()
    while dancer.now < 10.0:
        dancer.advance()
        if dancer.gaze_site is None:
            continue
        R, p = dancer.moving.poses()
        face, offset = R[head][:, 0], dancer.moving.places[dancer.gaze_site] - p[head]
        level = np.hypot(offset[0], offset[2])
        turns = np.arctan2(face[2], face[0]), np.arctan2(offset[2], offset[0])
        nods = np.arcsin(face[1]), np.arctan2(offset[1], level)
        rows.append((*turns, *nods, offset[0]))
    earlier, later = np.array(rows)[:-24], np.array(rows)[24:]
    # The head lags a quarter of a second while hands are in front of it.
    ahead = earlier[:, 4] > 0.1
    for k in (0, 2):
        assert np.corrcoef(later[ahead, k], earlier[ahead, k + 1])[0, 1] > 0.6
