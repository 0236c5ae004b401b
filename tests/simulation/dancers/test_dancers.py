"""Goals of the Macarena with both controllers, and invariants of the motion."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.dancers.torso import JOINT_AXES, LINKS, build_torso
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.people.body_frames import FRAMES
from pipeline.simulation.people.proportions import ADULT, CHILD, SEGMENT_MASSES
from pipeline.simulation.simulate import simulate
from pipeline.spec import find_scene, load_scene, read_scene
from pipeline.spec.dancer import Dancer
from tests.simulation.dancers.dance_recorder import (
    MAX_PENETRATION,
    DanceRecording,
    build_dancer,
    missed_goals,
    record_motion,
)

TEMPI = (60, 80, 103)
CONTROLLERS = ("force-field", "joint-torque")

CASES = [
    pytest.param(by, tempo, marks=[] if tempo == 103 else pytest.mark.slow)
    for by in CONTROLLERS
    for tempo in TEMPI
]


def macarena(by: str, tempo: float) -> DanceRecording:
    config = f"controller: {by}, tempo_bpm: {tempo}, start: 1.0"
    return record_motion(config, 1.0 + 13.0 * 60.0 / tempo)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("by", "tempo"), CASES)
def test_every_goal_is_reached_without_penetration(by: str, tempo: float) -> None:
    motion = macarena(by, tempo)
    # Force fields cannot turn a hand.
    assert missed_goals(motion, skipped=(2, 3) if by == "force-field" else ()) == []
    deep = {pair: depth for pair, depth in motion.deepest.items() if depth > MAX_PENETRATION}
    assert deep == {}
    assert np.isfinite(np.array(motion.q)).all()


@pytest.mark.slow
def test_only_joint_torques_turn_palms() -> None:
    until = 1.0 + 3.9 * 60 / 80
    for by in CONTROLLERS:
        motion = record_motion(f"controller: {by}, tempo_bpm: 80, start: 1.0", until)
        wrist = [motion.q[-1][motion.dancer.torso.wrist(side).start] for side in "rl"]
        turned = np.degrees(wrist)
        assert (turned > 40).all() if by == "force-field" else (turned < -78).all()


def test_torso_has_its_links_joints_and_masses() -> None:
    for person in (ADULT, CHILD):
        torso = build_torso(person)
        moving = [link for link in torso.linkage.links if link.hinges]
        assert [link.name for link in moving] == [name for name in LINKS if name != "pelvis"]
        assert len(LINKS) - 1 == 8
        assert len(torso.names) == 20
        counts = [len(link.hinges) for link in moving]
        assert counts == [3, 3, 3, 1, 3, 3, 1, 3]
        model = LinkageSimulation(torso.linkage, 1e-3).model
        arms = sum(2 * SEGMENT_MASSES[name] for name in ("upper_arm", "forearm", "hand"))
        named = [model.body(link.name).mass[0] for link in moving]
        assert sum(named[2:]) == pytest.approx(arms * person.mass, rel=1e-9)
        assert named[1] == pytest.approx(SEGMENT_MASSES["head"] * person.mass, rel=1e-9)
        assert set(LINKS) <= set(FRAMES)


def test_arms_are_mirror_images() -> None:
    moving = LinkageSimulation(build_torso(ADULT).linkage, 1e-3)
    names = [hinge.name for hinge in moving.linkage.hinges]
    rng = np.random.default_rng(3)
    for _ in range(10):
        for joint in JOINT_AXES:
            if joint.split("_")[0] in ("shoulder", "elbow", "wrist"):
                stem, motion = joint.split("_")
                angle = rng.uniform(-0.4, 0.8)
                for side in "rl":
                    moving.q[names.index(f"{stem}_{side}_{motion}")] = angle
        moving.settle()
        right, left = moving.places[moving.pulled]
        np.testing.assert_allclose(left, right * [1, 1, -1], atol=1e-12)


@pytest.mark.parametrize(
    ("joint", "angle", "direction"),
    [
        ("shoulder_r_flexion", 90, (1, 0, 0)),
        ("shoulder_l_flexion", 90, (1, 0, 0)),
        ("shoulder_r_abduction", 90, (0, 0, 1)),
        ("shoulder_l_abduction", 90, (0, 0, -1)),
    ],
)
def test_joint_angles_follow_anatomy(joint: str, angle: float, direction: tuple[int, ...]) -> None:
    moving = LinkageSimulation(build_torso(ADULT).linkage, 1e-3)
    names = [hinge.name for hinge in moving.linkage.hinges]
    moving.q[names.index(joint)] = np.radians(angle)
    moving.settle()
    side = joint.split("_")[1]
    _, p = moving.poses()
    arm = p[LINKS.index(f"hand_{side}")] - p[LINKS.index(f"upper_arm_{side}")]
    np.testing.assert_allclose(arm / np.linalg.norm(arm), direction, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("by", CONTROLLERS)
def test_torques_speeds_and_angles_are_bounded(by: str) -> None:
    motion = macarena(by, 103)
    torques, q = np.abs(np.array(motion.torques)), np.array(motion.q)
    strengths = [hinge.strength for hinge in motion.dancer.torso.linkage.hinges]
    # Servos saturate at their strength; field forces and gravity compensation add less than half.
    assert (torques.max(axis=0) < 1.5 * np.array(strengths)).all()
    speeds = np.abs(np.diff(q, axis=0)) * 96
    assert speeds.max() < 25
    for k, hinge in enumerate(motion.dancer.torso.linkage.hinges):
        assert q[:, k].min() > hinge.lower - 0.06
        assert q[:, k].max() < hinge.upper + 0.06


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("by", CONTROLLERS)
def test_mechanical_energy_is_bounded(by: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    dancer = build_dancer(f"controller: {by}, tempo_bpm: 103, start: 1.0")
    moving, energies = dancer.moving, []
    moving.model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    while dancer.now < 9.0:
        dancer.advance()
        energies.append(moving.data.energy.copy())
    kinetic, potential = np.array(energies)[:, 1], np.array(energies)[:, 0]
    # An arm of 3.4 kg at 4 m/s has 27 J; both arms raised by 0.8 m have 53 J.
    assert 1.0 < kinetic.max() < 27.0
    assert np.ptp(potential) < 53.0


@pytest.mark.nightly
@pytest.mark.parametrize("by", CONTROLLERS)
def test_contact_times_do_not_depend_on_step(by: str) -> None:
    config = f"controller: {by}, tempo_bpm: 103, start: 1.0, steps_a_second: "
    coarse, fine = (
        record_motion(f"{config}{steps}", 1.0 + 13.0 * 60.0 / 103, 100.0) for steps in (1000, 2000)
    )
    errors = []
    for move, hand in coarse.moves():
        if coarse.dancer.goals[move.subtask].surface is None:
            continue
        own = [s for s in coarse.strikes if s.hand == f"hand_{'rl'[hand]}"]
        first = min(own, key=lambda s: abs(s.time - move.land))
        same = [s.time for s in fine.strikes if (s.hand, s.other) == (first.hand, first.other)]
        errors.append(min((abs(time - first.time) for time in same), default=np.inf))
    # A hand between ribs and belly may touch either first.
    assert sorted(errors)[:7] == pytest.approx([0.0] * 7, abs=0.0015)


@pytest.mark.nightly
def test_touch_events_are_on_frames_of_beats() -> None:
    scene = load_scene(find_scene("macarena"), ["duration=10"])
    take, beat = simulate(scene), 60.0 / 103
    dancers = [member for member in scene.cast if isinstance(member, Dancer)]
    assert [member.name for member in dancers] == ["adonis", "hermes"]
    for member in dancers:
        frames = [event.frame for event in take.events if event.who == member.name]
        for subtask in range(5, 13):
            on = member.start + subtask * beat
            assert min(abs((frame - 1) / 24.0 - on) for frame in frames) < 1.5 / 24.0, subtask


@pytest.mark.slow
def test_motion_is_reproducible_alone_and_beside_other_performers() -> None:
    head = "pronk: 1\nduration: 1.5\nseed: 4\ncast:\n"
    first = "- {name: a, dancer: torso, controller: force-field, tempo_bpm: 120, at: [0, 0]}\n"
    other = "- {name: b, dancer: child, at: [0, 1]}\n- {name: c, prop: {shape: box}, at: [2, 2]}\n"
    takes = [
        simulate(read_scene(head + cast)) for cast in (first, first, first + other, other + first)
    ]
    assert takes[0].digest == takes[1].digest
    rows = [
        take.positions[:, [i for i, n in enumerate(take.nodes) if n.performer == "a"]]
        for take in takes
    ]
    for more in rows[1:]:
        np.testing.assert_array_equal(rows[0], more)


@pytest.mark.slow
def test_dancer_stands_at_its_position_and_heading() -> None:
    head = "pronk: 1\nduration: 1.5\nterrain: {preset: hills}\ncast:\n"
    plain = "- {name: a, dancer: torso, tempo_bpm: 120}\n"
    moved = "- {name: a, dancer: torso, tempo_bpm: 120, at: [2, -3], heading_deg: 90}\n"
    plain_take, moved_take = (simulate(read_scene(head + cast)) for cast in (plain, moved))
    names = [node.name for node in plain_take.nodes]
    hand, foot = names.index("a.hand_r"), names.index("a.foot_r")
    for take in (plain_take, moved_take):
        # Feet stay where they are.
        np.testing.assert_array_equal(take.positions[0, foot], take.positions[-1, foot])
    offset = plain_take.positions[:, hand] - plain_take.positions[:, names.index("a.pelvis")]
    turned = moved_take.positions[:, hand] - moved_take.positions[:, names.index("a.pelvis")]
    np.testing.assert_allclose(
        turned, np.stack([offset[:, 2], offset[:, 1], -offset[:, 0]], -1), atol=1e-9
    )
