"""Contacts of hands on their beats and frames."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.clock import Clock
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene, find_scene, load_scene, read_scene
from tests.simulation.dancers.dance_recorder import record_motion

FRAME = 1.0 / 24.0
"""Duration of a frame [s]."""

CASES = [
    pytest.param("force-field", 24, 90, marks=[]),
    pytest.param("joint-torque", 24, 90, marks=pytest.mark.slow),
    pytest.param("force-field", 30, 75, marks=pytest.mark.slow),
]


def simulate_drummer(by: str, fps: int, tempo: float, duration: float = 6.0) -> tuple[Scene, Take]:
    changes = [f"cast[0].controller={by}", f"fps={fps}", f"cast[0].tempo_bpm={tempo}"]
    scene = load_scene(find_scene("drummer"), [*changes, f"duration={duration}"])
    return scene, simulate(scene)


def expected_frames(scene: Scene, drum: str) -> list[int]:
    """Returns the frames of a drum's strikes by the configuration alone."""
    member, dance = scene.dancers[0][1], scene.dances["drumming"]
    beat = 60.0 / float(member.tempo_bpm or 0)
    clock = Clock(scene.rate, scene.n_frames)
    frames = []
    for bar in range(20):
        for subtask in dance.subtasks:
            for on in subtask.on or ():
                time = member.start + (bar * 4 + on - 1) * beat
                if subtask.touch == drum and time < float(scene.duration or 0) - 0.05:
                    step = clock.step_from(time)
                    frames.append(clock.frame_of(step, 0.0))
    return sorted(frames)


@pytest.mark.slow
@pytest.mark.parametrize(("by", "fps", "tempo"), CASES)
def test_strikes_are_on_pattern_frames(by: str, fps: int, tempo: float) -> None:
    scene, take = simulate_drummer(by, fps, tempo)
    for drum in ("high", "low"):
        blows = [e for e in take.events if e.other == drum and e.cause == "collision"]
        heard = [blow.frame for blow in blows if blow.frame <= scene.n_frames]
        assert heard == expected_frames(scene, drum)


def test_drummer_locked_to_score_strikes_on_beats() -> None:
    cast = "[{dancer: torso, dance: drumming, tempo_bpm: 60, beat: 3}]"
    scene = read_scene(f"pronk: 1\nduration: 4\nsound: {{tempo_bpm: 120}}\ncast: {cast}\n")
    take = simulate(scene)
    # Half the score's tempo, from its third beat at 1 s, in eighths.
    blows = [e.frame for e in take.events if e.other == "high" and e.frame <= scene.n_frames]
    assert blows == [1 + 24 + 12 * k for k in range(6)]


def test_strikes_have_speed_position_and_material() -> None:
    _, take = simulate_drummer("force-field", 24, 90, 3.0)
    blows = [contact for contact in take.contacts if contact.other == "high"]
    assert len(blows) > 4
    for blow in blows:
        assert blow.part == "hand_r"
        assert blow.kind == "hit"
        assert blow.surface == "leather"
        assert 0.2 < blow.speed < 2.0
        assert 0.0 <= blow.fraction < 1.0
        np.testing.assert_allclose(blow.normal, (0, 1, 0), atol=0.05)
        assert blow.place[1] == pytest.approx(0.98, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("by", ["force-field", "joint-torque"])
def test_claps_are_on_beats(by: str) -> None:
    motion = record_motion(f"dance: clapping, controller: {by}, tempo_bpm: 100, start: 0.6", 6.2)
    claps = [s.time for s in motion.strikes if {s.hand, s.other} == {"hand_r", "hand_l"}]
    wanted = [0.6 + 0.6 * (on - 1) for on in (2, 4, 10)]
    for time in wanted:
        assert min(abs(clap - time) for clap in claps) < FRAME
    assert all(min(abs(clap - time) for time in wanted) < FRAME for clap in claps)


TOUCHED = [
    pytest.param(by, tempo, marks=pytest.mark.slow if tempo == 103 else pytest.mark.nightly)
    for by in ("force-field", "joint-torque")
    for tempo in (60, 80, 103, 150)
]


@pytest.mark.parametrize(("by", "tempo"), TOUCHED)
def test_touches_are_at_their_places_within_a_frame_of_beats(by: str, tempo: float) -> None:
    beat = 60.0 / tempo
    motion = record_motion(f"controller: {by}, tempo_bpm: {tempo}, start: 1.0", 1.0 + 28.5 * beat)
    solids = {"shoulder": "yoke", "head": "head", "low": "ribs", "ribs": "ribs", "hip": "pelvis"}
    for move, hand in [*motion.moves(0), *motion.moves(1)]:
        goal = motion.dancer.goals[move.subtask]
        if goal.surface is None:
            continue
        solid, own = solids[str(goal.subtask.touch).split("_")[0]], f"hand_{'rl'[hand]}"
        # The other hand may lie behind the head already: a brush against it is no arrival.
        near = [
            s
            for s in motion.strikes
            if own == s.hand
            and not s.other.startswith("hand")
            and abs(s.time - move.land) < 0.5 * beat
        ]
        first = min(near, key=lambda s: s.time)
        assert abs(first.time - move.land) < FRAME, (goal.subtask.name, move.bar, near)
        # A neighbouring solid may be touched first, or an arm.
        neighbours = {"ribs": ("ribs", "breast", "belly"), "head": ("head", "neck")}
        others = (*neighbours.get(solid, (solid,)), "upper_arm_r", "upper_arm_l")
        assert first.other in others, (goal.subtask.name, near)
