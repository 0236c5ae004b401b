"""Hands that touch: on their beats, on their frames, and into the score."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.clock import Clock
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene, find_scene, load_scene
from tests.simulation.dancing import danced

CASES = [
    pytest.param("force-field", 24, 90, marks=[]),
    pytest.param("joint-torque", 24, 90, marks=pytest.mark.slow),
    pytest.param("force-field", 30, 75, marks=pytest.mark.slow),
]


def drummed(by: str, fps: int, tempo: float, duration: float = 6.0) -> tuple[Scene, Take]:
    changes = [f"cast[0].controller={by}", f"fps={fps}", f"cast[0].tempo_bpm={tempo}"]
    scene = load_scene(find_scene("drummer"), [*changes, f"duration={duration}"])
    return scene, simulate(scene)


def asked(scene: Scene, drum: str) -> list[int]:
    """Return the frames on which the pattern has a drum, from the words alone."""
    member, dance = scene.dancers[0][1], scene.dances["drumming"]
    beat = 60.0 / float(member.tempo_bpm or 0)
    clock = Clock(scene.rate, scene.n_frames)
    frames = []
    for bar in range(20):
        for one in dance.subtasks:
            for on in one.on or ():
                time = member.start + (bar * 4 + on - 1) * beat
                if one.touch == drum and time < float(scene.duration or 0) - 0.05:
                    step = clock.step_from(time)
                    frames.append(clock.frame_of(step, 0.0))
    return sorted(frames)


@pytest.mark.slow
@pytest.mark.parametrize(("by", "fps", "tempo"), CASES)
def test_a_pattern_comes_out_on_its_frames(by: str, fps: int, tempo: float) -> None:
    scene, take = drummed(by, fps, tempo)
    for drum in ("high", "low"):
        blows = [e for e in take.events if e.other == drum and e.cause == "collision"]
        heard = [blow.frame for blow in blows if blow.frame <= scene.n_frames]
        assert heard == asked(scene, drum)


def test_blows_are_contacts_of_hands_with_speed_place_and_material() -> None:
    _, take = drummed("force-field", 24, 90, 3.0)
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
def test_claps_are_heard_on_their_beats(by: str) -> None:
    seen = danced(f"dance: clapping, controller: {by}, tempo_bpm: 100, start: 0.6", 6.2)
    claps = [s.time for s in seen.strikes if {s.hand, s.other} == {"hand_r", "hand_l"}]
    wanted = [0.6 + 0.6 * (on - 1) for on in (2, 4, 10)]
    for time in wanted:
        assert min(abs(clap - time) for clap in claps) < 0.1
    assert all(min(abs(clap - time) for time in wanted) < 0.1 for clap in claps)


@pytest.mark.slow
@pytest.mark.parametrize("by", ["force-field", "joint-torque"])
def test_the_dance_touches_the_body_where_it_says_and_near_its_beats(by: str) -> None:
    seen = danced(f"controller: {by}, tempo_bpm: 80, start: 1.0", 1.0 + 12.5 * 0.75)
    solids = {"shoulder": "yoke", "head": "head", "low": "ribs", "ribs": "ribs", "hip": "pelvis"}
    for move, hand in seen.moves():
        goal = seen.dancing.goals[move.subtask]
        if goal.surface is None:
            continue
        solid = solids[str(goal.words.touch).split("_")[0]]
        near = [
            s
            for s in seen.strikes
            if s.hand == f"hand_{'rl'[hand]}" and abs(s.time - move.land) < 0.15
        ]
        # What is touched first may be what is beside it: an arm that lies there, or the other hand.
        beside = {"ribs": ("ribs", "breast", "belly"), "head": ("head", "neck", "hand_r", "hand_l")}
        others = (*beside.get(solid, (solid,)), "upper_arm_r", "upper_arm_l")
        assert any(s.other in others for s in near), (goal.words.name, near)
