"""Both controllers in one dancer, by arm and by subtask; other builds; other rules."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.dancers.dancer_motion import DancerMotion
from pipeline.simulation.dancers.torso import LINKS, dancer_proportions
from pipeline.simulation.people.proportions import CHILD
from pipeline.spec import read_scene
from tests.simulation.dancing import DanceRecording, build_dancer, record_motion
from tests.simulation.test_dancers import MAX_PENETRATION, TOUCH_TOLERANCE

TWO = """dances:
  two:
    bar: 4
    subtasks:
      - {hand: r, reach: [0.45, 1.3, 0.2], controller: force-field}
      - {hand: r, reach: [0.40, 1.5, 0.4], controller: joint-torque}
      - {hand: r, reach: [0.45, 1.2, 0.3], controller: force-field}
      - {hand: l, reach: [0.45, 1.3, -0.2]}
"""


@pytest.mark.nightly
def test_arms_may_have_controllers_of_their_own() -> None:
    mixed = record_motion(
        "controller: {r: force-field, l: joint-torque}, tempo_bpm: 80, start: 1", 3.0
    )
    right, left = mixed.dancer.arms
    assert right.by_fields
    assert not left.by_fields
    # Until they meet each does what it does where both arms are moved so.
    for k, by in enumerate(("force-field", "joint-torque")):
        alone = record_motion(f"controller: {by}, tempo_bpm: 80, start: 1", 3.0)
        apart = np.linalg.norm(np.array(mixed.hands)[:, k] - np.array(alone.hands)[:, k], axis=1)
        assert apart.max() < 0.01


def test_subtasks_may_have_controllers_of_their_own_and_go_over_smoothly() -> None:
    motion = DanceRecording(build_dancer("dance: two, tempo_bpm: 60, start: 0.5", more=TWO))
    by = []
    while motion.dancer.now < 4.8:
        motion.strikes += motion.dancer.advance()
        motion.record()
        by.append(motion.dancer.arms[0].by_fields)
    changes = np.flatnonzero(np.diff(np.array(by)))
    assert len(changes) == 3
    for move, hand in motion.moves()[:4]:
        spot = motion.dancer.goals[move.subtask].spots[-1]
        rows = motion.around(move, 0.02, 0.05)
        goal = motion.dancer.moving.places[spot]
        assert np.linalg.norm(np.array(motion.hands)[rows, hand] - goal, axis=1).min() < 0.02
    speed = np.linalg.norm(np.diff(np.array(motion.hands)[:, 0], axis=0), axis=1) * 96
    # At rest where one hands over to the other.
    for change in changes[1:]:
        assert speed[change - 2 : change + 3].max() < 0.15


@pytest.mark.slow
@pytest.mark.parametrize("by", ["force-field", "joint-torque"])
def test_a_child_dances_it_too(by: str) -> None:
    scene = read_scene(
        f"pronk: 1\nduration: 20\ncast: [{{dancer: child, controller: {by}, tempo_bpm: 80}}]\n"
    )
    assert dancer_proportions(scene.dancers[0][1]) == CHILD
    words = f"controller: {by}, tempo_bpm: 80, start: 1.0"
    motion = record_motion(words, 1.0 + 12.3 * 0.75, build="child")
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


def test_gravity_sags_a_dancer_who_is_not_held_up() -> None:
    words = "dance: two, tempo_bpm: 60, start: 0.5, controller: force-field"
    plain, sagging = (
        record_motion(f"{words}, compensate_gravity: {held}", 1.5, more=TWO)
        for held in ("true", "false")
    )
    assert plain.hands[-1][0, 1] - sagging.hands[-1][0, 1] > 0.003


def test_the_winner_takes_all_or_the_sum_and_both_arrive() -> None:
    ends = []
    for rule in ("sum", "winner"):
        words = f"dance: two, tempo_bpm: 60, start: 0.5, controller: force-field, combine: {rule}"
        motion = record_motion(words, 1.6, more=TWO)
        ends.append(motion.hands[-1][0])
        speed = np.linalg.norm(np.diff(np.array(motion.hands)[:, 0], axis=0), axis=1) * 96
        assert speed.max() < 4.0
    np.testing.assert_allclose(ends[0], ends[1], atol=0.02)


def test_heads_turn_to_the_hand_that_moves() -> None:
    names: list[float] = []
    for gaze in ("true", "false"):
        one: DancerMotion = build_dancer(f"dance: two, tempo_bpm: 60, gaze: {gaze}", more=TWO)
        while one.now < 1.9:
            one.advance()
        names.append(float(one.moving.q[one.torso.names.index("neck_rotation")]))
    # The right hand is to the right: a turn about the upright to the left would be positive.
    assert names[0] < -0.1
    assert abs(names[1]) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("by", ["force-field", "joint-torque"])
def test_the_gaze_follows_the_hands_through_the_whole_dance(by: str) -> None:
    one = build_dancer(f"controller: {by}, tempo_bpm: 80, start: 1.0")
    head, rows = LINKS.index("head"), list[tuple[float, ...]]()
    while one.now < 10.0:
        one.advance()
        if one.looks_at is None:
            continue
        R, p = one.moving.poses()
        face, way = R[head][:, 0], one.moving.places[one.looks_at] - p[head]
        level = np.hypot(way[0], way[2])
        turns = np.arctan2(face[2], face[0]), np.arctan2(way[2], way[0])
        nods = np.arcsin(face[1]), np.arctan2(way[1], level)
        rows.append((*turns, *nods, way[0]))
    earlier, later = np.array(rows)[:-24], np.array(rows)[24:]
    # A quarter of a second behind, as long as hands are in front of the head.
    ahead = earlier[:, 4] > 0.1
    for k in (0, 2):
        assert np.corrcoef(later[ahead, k], earlier[ahead, k + 1])[0, 1] > 0.6
