"""Body frames: identity at rest, rotations along bones and hinges, continuous in motion."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.people.body_frames import (
    FRAMES,
    MAX_NOD,
    MAX_WRIST_BEND,
    ORIGINS,
    PARENTS,
    Trunks,
    frame_origins,
    frames_from_joints,
    hands_on_trunks,
)
from pipeline.simulation.people.proportions import (
    ADULT,
    BACK_DEPTH,
    CHILD,
    JOINTS,
    TRUNK_BREADTH,
    Proportions,
)
from pipeline.simulation.spatial import Array, normalized, rotation

PEOPLE = pytest.mark.parametrize("proportions", [ADULT, CHILD], ids=["adult", "child"])
X, Y, Z = np.eye(3)


def bend_limb(proportions: Proportions, limb: str, side: str, swing: Array, angle: float) -> Array:
    """Return a person at rest but for one limb: swung whole, then bent at its hinge [rad]."""
    joints = proportions.rest()
    root, middle, tip = {"arm": ("shoulder", "elbow", "hand"), "leg": ("hip", "knee", "foot")}[limb]
    place = [JOINTS.index(f"{name}_{side}") for name in (root, middle, tip)]
    way = 1.0 if limb == "arm" else -1.0
    upper, lower = np.diff(joints[place], axis=0)
    joints[place[1]] = joints[place[0]] + swing @ upper
    joints[place[2]] = joints[place[1]] + swing @ rotation(Z, way * angle) @ lower
    return joints


def test_every_frame_has_an_origin_and_a_parent() -> None:
    assert len(FRAMES) == len(set(FRAMES)) == len(ORIGINS) == len(PARENTS) == 15
    assert set(ORIGINS) <= set(JOINTS)
    assert all(parent < number for number, parent in enumerate(PARENTS))


@PEOPLE
def test_rest_frames_are_not_rotated(proportions: Proportions) -> None:
    R, p = frames_from_joints(proportions.rest())
    np.testing.assert_allclose(R, np.broadcast_to(np.eye(3), R.shape), atol=1e-12)
    np.testing.assert_array_equal(p, frame_origins(proportions))


@PEOPLE
def test_frames_rotate_with_the_whole_body(proportions: Proportions) -> None:
    rng = np.random.default_rng(3)
    whole = rotation(normalized(rng.normal(size=(50, 3))), rng.uniform(0, 3, 50))
    shift = rng.normal(size=(50, 1, 3))
    joints = np.einsum("nij,kj->nki", whole, proportions.rest()) + shift
    R, _ = frames_from_joints(joints, soles=np.repeat(whole[:, None, :, 1], 2, axis=1))
    np.testing.assert_allclose(R, np.broadcast_to(whole[:, None], R.shape), atol=1e-9)


def test_frames_are_rotations_and_batches_match_single_poses() -> None:
    rng = np.random.default_rng(1)
    joints = ADULT.rest() + rng.normal(size=(400, 16, 3)) * 0.08
    gaze = rng.normal(size=(400, 3))
    R, p = frames_from_joints(joints, gaze)
    np.testing.assert_allclose(R @ np.swapaxes(R, -1, -2), np.eye(3) + 0 * R, atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-9)
    for k in (0, 7, 399):
        alone = frames_from_joints(joints[k], gaze[k])
        np.testing.assert_array_equal(alone[0], R[k])
        np.testing.assert_array_equal(alone[1], p[k])


@pytest.mark.parametrize("side", ["l", "r"])
@pytest.mark.parametrize("limb", ["arm", "leg"])
def test_a_bent_limb_turns_about_its_hinge(limb: str, side: str) -> None:
    """Beyond 25° of bend the hinge alone tells the twist, wherever the limb points."""
    rng = np.random.default_rng(2)
    names = ("upper_arm", "forearm") if limb == "arm" else ("thigh", "shin")
    upper, lower = (FRAMES.index(f"{name}_{side}") for name in names)
    way = 1.0 if limb == "arm" else -1.0
    for _ in range(60):
        swing = rotation(normalized(rng.normal(size=3)), rng.uniform(0, 3.1))
        angle = rng.uniform(np.radians(26), np.radians(140))
        R, _ = frames_from_joints(bend_limb(ADULT, limb, side, swing, angle))
        np.testing.assert_allclose(R[upper], swing, atol=1e-9)
        np.testing.assert_allclose(R[lower], swing @ rotation(Z, way * angle), atol=1e-9)


@pytest.mark.parametrize("limb", ["arm", "leg"])
def test_frames_lie_along_their_bones(limb: str) -> None:
    rng = np.random.default_rng(4)
    names = ("upper_arm_r", "forearm_r") if limb == "arm" else ("thigh_r", "shin_r")
    ends = ("shoulder_r", "elbow_r", "hand_r") if limb == "arm" else ("hip_r", "knee_r", "foot_r")
    joints = ADULT.rest() + rng.normal(size=(300, 16, 3)) * 0.1
    R, _ = frames_from_joints(joints)
    places = joints[:, [JOINTS.index(end) for end in ends]]
    along = normalized(np.diff(places, axis=1))
    for k, name in enumerate(names):
        np.testing.assert_allclose(-R[:, FRAMES.index(name), :, 1], along[:, k], atol=1e-9)


def _fastest(joints: Array, gaze: Array | None = None) -> float:
    """Return the largest rotation of any frame between rows [rad]."""
    R, _ = frames_from_joints(joints, gaze)
    step = np.swapaxes(R[:-1], -1, -2) @ R[1:]
    trace = np.clip((np.trace(step, axis1=-2, axis2=-1) - 1.0) / 2.0, -1.0, 1.0)
    return float(np.arccos(trace).max())


def test_limbs_turn_smoothly_from_straight_to_bent_and_overhead() -> None:
    """An arm swings in front from hanging to overhead while its elbow opens and closes."""
    s = np.linspace(0.0, 1.0, 1001)
    rows = []
    for t in s:
        swing = rotation(Z, 3.0 * t) @ rotation(X, -1.2 * np.sin(np.pi * t))
        rows.append(bend_limb(ADULT, "arm", "r", swing, 1.2 * np.sin(4 * np.pi * t) ** 2))
    # The joints turn by 1.2 · 4π / 1000 a row at most; the twist may follow at ten times that.
    assert _fastest(np.array(rows)) < 10 * 1.2 * 4 * np.pi / 1000
    rows = [
        bend_limb(ADULT, "leg", "l", rotation(Z, 0.9 * np.sin(t)), 0.5 * (1 - np.cos(2 * t)))
        for t in 2 * np.pi * s
    ]
    assert _fastest(np.array(rows)) < 0.04


def test_a_slightly_reversed_knee_does_not_flip() -> None:
    straight = np.linspace(-np.radians(5), np.radians(30), 500)
    rows = np.array([bend_limb(CHILD, "leg", "r", np.eye(3), angle) for angle in straight])
    R, _ = frames_from_joints(rows)
    assert (R[:, FRAMES.index("thigh_r"), 2, 2] > 0.999).all()


def test_heads_face_the_gaze_within_the_nod_limit() -> None:
    rng = np.random.default_rng(5)
    gaze = normalized(rng.normal(size=(200, 3)) * [1.0, 0.4, 1.0])
    R, _ = frames_from_joints(np.broadcast_to(ADULT.rest(), (200, 16, 3)), gaze)
    face = R[:, FRAMES.index("head"), :, 0]
    near = np.abs(gaze[:, 1]) < np.sin(MAX_NOD)
    assert near.any()
    assert not near.all()
    # Regularisation of a gaze along the neck bends others by a thousandth.
    assert ((face * gaze).sum(axis=-1)[near] > np.cos(3e-3)).all()
    assert (np.abs(face[:, 1]) <= np.sin(MAX_NOD) + 1e-9).all()
    upward, _ = frames_from_joints(ADULT.rest(), Y)
    assert np.isfinite(upward).all()


def test_soles_lie_flat_within_the_ankle_limit() -> None:
    foot = FRAMES.index("foot_r")
    forward = rotation(Z, np.radians(20))
    R, _ = frames_from_joints(bend_limb(ADULT, "leg", "r", forward, 0.6))
    np.testing.assert_allclose(R[foot, :, 1], Y, atol=1e-9)
    slope = normalized(np.array([-0.3, 1.0, 0.0]))
    R, _ = frames_from_joints(ADULT.rest(), soles=np.stack([slope, slope]))
    np.testing.assert_allclose(R[foot, :, 1], slope, atol=1e-9)
    # Feet of a person lying on the back follow the shins.
    lying = ADULT.rest() @ rotation(Z, np.pi / 2).T
    R, _ = frames_from_joints(lying)
    shin = R[FRAMES.index("shin_r")]
    assert np.degrees(np.arccos((shin[:, 1] * R[foot, :, 1]).sum())) < 20


FOREARMS = [FRAMES.index("forearm_l"), FRAMES.index("forearm_r")]


def around(off: float, share: float = 1.0) -> tuple[Array, Array, Array, Array]:
    """Return forearms and hands (2, 3, 3) of arms held ahead around somebody, and both before.

    Args:
        off: of the wrists from the back of the other one, who looks back at them [m].
        share: of the embrace.
    """
    depth, turned = BACK_DEPTH * ADULT.height + off, rotation(Y, np.pi)
    partner = ADULT.rest() @ turned.T
    spine = partner[[JOINTS.index(name) for name in ("pelvis", "spine", "shoulders")]]
    joints = ADULT.rest()
    wrists = []
    for side, way in (("l", -1.0), ("r", 1.0)):
        wrist = spine[1] + np.array([depth, 0.2, 0.09 * way])
        elbow = wrist + np.array([-0.15, -0.05, 0.19 * way])
        for name, place in (("elbow", elbow), ("hand", wrist)):
            joints[JOINTS.index(f"{name}_{side}")] = place
        joints[JOINTS.index(f"shoulder_{side}")] = elbow + np.array([-0.3, 0.05, -0.08 * way])
        wrists.append(wrist)
    R, _ = frames_from_joints(joints)
    before = R[FOREARMS]
    trunk = Trunks(spine[None], turned[None], np.array([ADULT.height]))
    length = np.array([ADULT.hand * ADULT.height])
    shares = np.full((1, 2), share)
    forearms, hands = hands_on_trunks(before[None], np.array([wrists]), length, trunk, shares)
    return forearms[0], hands[0], before, np.array(wrists)


def test_hands_around_somebody_lie_flat_on_the_back() -> None:
    forearms, hands, before, _ = around(0.02)
    for k, way in enumerate((-1.0, 1.0)):
        back, fingers = way * hands[k, :, 2], -hands[k, :, 1]
        # The back of the hand looks away from the partner, and fingers go on around it.
        assert back @ X > 0.9
        assert fingers @ (-way * Z) > 0.85
        assert 0.0 < fingers[1] < 0.4
        assert -before[k, :, 1] @ fingers > np.cos(MAX_WRIST_BEND) - 1e-9
        # The forearm keeps its direction and takes part in the turn of the hand.
        np.testing.assert_allclose(forearms[k, :, 1], before[k, :, 1], atol=1e-9)
        assert way * forearms[k, :, 2] @ X > way * before[k, :, 2] @ X + 0.1
    for found in (forearms, hands):
        np.testing.assert_allclose(found @ found.swapaxes(-1, -2), [np.eye(3)] * 2, atol=1e-12)
        np.testing.assert_allclose(np.linalg.det(found), 1.0)


@pytest.mark.parametrize(("off", "share"), [(0.4, 1.0), (0.02, 0.0)])
def test_hands_away_from_a_trunk_continue_their_forearms(off: float, share: float) -> None:
    forearms, hands, before, _ = around(off, share)
    np.testing.assert_allclose(hands, before, atol=1e-12)
    np.testing.assert_allclose(forearms, before, atol=1e-12)


def test_a_trunk_is_an_oval_around_its_spine() -> None:
    spine = ADULT.rest()[[JOINTS.index(name) for name in ("pelvis", "spine", "shoulders")]]
    trunk = Trunks(spine[None], np.eye(3)[None], np.array([ADULT.height]))
    depth, breadth = BACK_DEPTH * ADULT.height, TRUNK_BREADTH * ADULT.height
    places = spine[1] + np.array([[-depth - 0.03, 0.1, 0.0], [0.0, 0.1, breadth + 0.05]])
    normals, distances = trunk.surface(places[None])
    np.testing.assert_allclose(normals[0], [-X, Z], atol=1e-6)
    np.testing.assert_allclose(distances[0], [0.03, 0.05], atol=1e-9)
