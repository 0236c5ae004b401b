"""Posed joints, limbs and bodies, over walking and standing."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_frames import FigureFrames
from pipeline.simulation.figures.figure_posture import FigurePosture
from pipeline.simulation.figures.ik_goals import dexterity
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.pose_plan import PartNames
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array, heading, matrix, turn
from pipeline.simulation.take import Take, TakeNote
from tests.simulation.conftest import scene_of

ROW = 1 / 96


class Posed:
    """A take of one creature with its parts by name."""

    def __init__(self, *cast: str, duration: float = 2) -> None:
        simulation = Simulation(scene_of(*cast, duration=duration))
        while not simulation.finished:
            simulation.step()
        self.take: Take = simulation.take()
        troupe = simulation.troupes[0]
        assert isinstance(troupe, WalkerTroupe)
        self.figure: Figure = troupe.herd.figures[0]
        self.height = float(troupe.herd.body_height[0])
        self.names = PartNames(self.figure)

    def link(self, node: str) -> tuple[Array, Array, Array]:
        """Return R_WB (K, 3, 3) of the link that ends at a node, its end (K, 3), and its ends."""
        limb, number = self.names.nodes[node]
        link = self.figure.skeleton.limbs[limb].links[number]
        R, p = matrix(self.take.rotations[:, link]), self.take.positions[:, link]
        ends = self.figure.skeleton.links[link].ends
        return R, p + turn(R, ends[1] - ends[0]), ends

    def place(self, node: str) -> Array:
        """Return the position of a node (K, 3) [m]."""
        return self.link(node)[1]

    def from_feet(self, node: str) -> Array:
        """Return the position of a node (K, 3) from the ground below a body that looks ahead."""
        return self.place(node) - self.body[1] + [0.0, self.height, 0.0]

    def joint(self, name: str) -> Array:
        """Return the values (K,) of a joint [degrees]."""
        limb, column = self.names.joints[name]
        joint = self.figure.skeleton.limbs[limb].joints[column]
        channel = f"{self.take.parts[0].performer}.{self.figure.skeleton.joint_names[joint]}"
        i = [c.name for c in self.take.channels].index(channel)
        return np.degrees(self.take.values[:, i])

    @property
    def body(self) -> tuple[Array, Array]:
        """R_WB (K, 3, 3) and p_WB (K, 3)."""
        return matrix(self.take.rotations[:, 0]), self.take.positions[:, 0]

    def fastest(self) -> float:
        """Return the greatest speed of a joint [rad/s]."""
        moves = [i for i, c in enumerate(self.take.channels) if c.unit == "rad"]
        return float(np.abs(np.diff(self.take.values[:, moves], axis=0)).max() / ROW)


@cache
def person(pose: str, more: str = "at: [0, 0]") -> Posed:
    return Posed(f"{{figure: person, name: p, {more}, pose: [{pose}]}}")


@cache
def plain(more: str = "at: [0, 0]") -> Posed:
    return Posed(f"{{figure: person, name: p, {more}}}")


WALKING = "at: [0.5, -1], heading_deg: 30, walk: {}"


@pytest.mark.nightly
def test_joint_reaches_its_value_and_returns() -> None:
    keys = (
        "{at: 0.75, joints: {elbow_r_deg: 90}}, {at: 1, joints: {elbow_r_deg: 60}},"
        " {at: 1.4, release: elbow_r_deg}"
    )
    posed, itself = person(keys, WALKING), plain(WALKING)
    elbow, own = posed.joint("elbow_r_deg"), itself.joint("elbow_r_deg")
    before, after = int(0.25 / ROW), int(np.ceil(1.9 / ROW))
    np.testing.assert_array_equal(elbow[:before], own[:before])
    np.testing.assert_allclose(elbow[after:], own[after:], atol=1e-12)
    assert elbow[72] == pytest.approx(90, abs=1e-9)
    assert elbow[96] == pytest.approx(60, abs=1e-9)
    # The other arm and the walk are unchanged.
    np.testing.assert_array_equal(posed.joint("elbow_l_deg"), itself.joint("elbow_l_deg"))
    np.testing.assert_allclose(posed.place("toe_r"), itself.place("toe_r"), rtol=0, atol=1e-12)


FRAMES = {"feet": [0.3, 1.3, 0.35], "body": [0.3, 0.4, 0.35], "world": [1.5, 1.3, -1.3]}


@pytest.mark.parametrize("frame", FRAMES)
def test_hand_reaches_its_place_in_every_frame(frame: str) -> None:
    goal = np.array(FRAMES[frame])
    asked = f"limb: arm_r, frame: {frame}, reach: {goal.tolist()}"
    posed = person(f"{{at: 0.5, {asked}}}, {{at: 0.8, {asked}}}", WALKING)
    R, p = posed.body
    if frame == "body":
        goal = p + turn(R, goal)
    elif frame == "feet":
        goal = p - [0, posed.height, 0] + heading(np.radians(30)) @ goal
    first = round(0.5 / ROW)
    last = first + 20 if frame == "world" else len(p)
    gap = np.linalg.norm(posed.place("hand_r") - goal, axis=1)[first:last]
    assert gap.max() < 1e-4
    assert bool(posed.take.notes) == (frame == "world")
    assert posed.fastest() < 14.001


@pytest.mark.nightly
def test_elbow_has_priority_over_hand() -> None:
    # An elbow is as far from its shoulder as the arm is long.
    itself = plain()
    limb = itself.figure.skeleton.limbs[itself.names.limbs["arm_r"]]
    shoulder = turn(itself.body[0][0], itself.figure.skeleton.places[limb.joints[0]])
    upper = itself.figure.skeleton.links[limb.links[0]].ends
    ahead = np.array([0.64, -0.6, 0.48]) * np.linalg.norm(upper[1] - upper[0])
    goal = shoulder + np.array([0, itself.height, 0]) + ahead
    elbow = f"{{at: 0, node: elbow_r, reach: {goal.tolist()}}}"
    hand = "{at: 0, limb: arm_r, reach: [-0.2, 1.7, 0.3], priority: 2}"
    both, alone = person(f"{elbow}, {hand}"), person(elbow)
    origin = both.body[1] - [0, both.height, 0]
    assert np.linalg.norm(both.place("elbow_r") - origin - goal, axis=1).max() < 1e-4
    # The hand is nearer to its goal than without one, and points at it from the elbow.
    wanted = origin + np.array([-0.2, 1.7, 0.3])
    gap = [np.linalg.norm(one.place("hand_r") - wanted, axis=1)[-1] for one in (both, alone)]
    assert gap[0] < gap[1] - 0.05


def test_weights_share_the_error_within_a_priority() -> None:
    near, far = "[0.1, 1.0, 0.4]", "[0.1, 1.6, 0.4]"
    even = f"{{at: 0, limb: arm_r, reach: {near}}}, {{at: 0, node: wrist_r, reach: {far}}}"
    heavy = even.replace(f"wrist_r, reach: {far}", f"wrist_r, reach: {far}, weight: 20")
    gaps = []
    for keys in (even, heavy):
        posed = person(keys)
        goal = posed.body[1] - [0, posed.height, 0] + [0.1, 1.6, 0.4]
        gaps.append(np.linalg.norm(posed.place("wrist_r") - goal, axis=1)[-1])
    assert gaps[1] < 0.5 * gaps[0]


def test_aim_and_turn_orient_the_link() -> None:
    keys = "{at: 0, limb: arm_m, reach: [0.8, 0.4, 0.5], aim: [0, -1, 0]}"
    arm = Posed(f"{{figure: robot_arm, at: [0, 0], pose: [{keys}]}}")
    R, place, ends = arm.link("hand")
    along = turn(R, (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0]))
    np.testing.assert_allclose(along[-1], [0, -1, 0], atol=1e-4)
    np.testing.assert_allclose(
        place[-1] - arm.body[1][-1] + [0, arm.height, 0], [0.8, 0.4, 0.5], atol=1e-4
    )
    turn_keys = "{at: 0, node: elbow_r, frame: body, turn_deg: [10, 20, 70]}"
    R, _, _ = person(turn_keys).link("elbow_r")
    R_WB, _ = person(turn_keys).body
    asked = R_WB[-1] @ rotation_from_angles(np.radians([10.0, 20.0, 70.0]))
    np.testing.assert_allclose(R[-1], asked, atol=1e-3)


def test_moved_body_keeps_its_feet() -> None:
    keys = "{at: 0.2, body: {move: [0, 0, 0]}}, {at: 1, body: {move: [-0.3, -0.38, 0]}}"
    posed, itself = person(keys), plain()
    down = posed.body[1] - itself.body[1]
    np.testing.assert_allclose(down[96:], np.tile([-0.3, -0.38, 0.0], (97, 1)), atol=1e-6)
    for toe in ("toe_l", "toe_r"):
        assert np.linalg.norm(posed.place(toe) - itself.place(toe), axis=1).max() < 1e-4
    assert posed.fastest() < 8


def test_posed_foot_makes_no_footfall() -> None:
    member = "{{figure: beetle, name: b, at: [0, 0], walk: {{}}, pose: [{}]}}"
    lifted = Posed(member.format("{at: 0, limb: l1, frame: body, reach: [0.9, 0.2, -1.2]}"))
    feet = {contact.part for contact in lifted.take.contacts}
    assert "b.l1" not in feet
    assert {"b.l2", "b.l3", "b.r1", "b.r2", "b.r3"} <= feet


def test_limb_on_a_moving_limb_keeps_its_goal() -> None:
    keys = (
        "{at: 0, joints: {thorax_yaw_deg: -20}}, {at: 1.5, joints: {thorax_yaw_deg: 20}},"
        " {at: 0, limb: feeler_l, frame: world, reach: [1.45, 0.60, -0.55]}"
    )
    posed = Posed(f"{{figure: beetle, name: b, at: [0, 0], pose: [{keys}]}}")
    limb = posed.names.limbs["feeler_l"]
    assert posed.figure.skeleton.parents[posed.figure.skeleton.limbs[limb].joints[0]] >= 0
    tip = posed.figure.skeleton.limbs[limb].links[-1]
    ends = posed.figure.skeleton.links[tip].ends
    R, p = matrix(posed.take.rotations[:, tip]), posed.take.positions[:, tip]
    place = p + turn(R, ends[1] - ends[0])
    assert np.ptp(posed.joint("thorax_yaw_deg")) > 30
    missed = [note for note in posed.take.notes if "feeler" in note.part]
    gap = np.linalg.norm(place - [1.45, 0.60, -0.55], axis=1)
    assert (gap.max() < 1e-3) != bool(missed)
    assert not missed


def test_unreachable_goal_is_approached_and_noted_once() -> None:
    posed = person("{at: 0.5, limb: arm_r, reach: [3, 1.4, 0.2]}")
    notes = [note for note in posed.take.notes if note.part == "p.arm_r1"]
    assert [note.kind for note in notes] == ["missed_key"]
    limb = posed.figure.skeleton.limbs[posed.names.limbs["arm_r"]]
    shoulder = posed.figure.skeleton.places[limb.joints[0]]
    R, p = posed.body
    stretched = np.linalg.norm(posed.place("hand_r") - p - turn(R, shoulder), axis=1)[-1]
    assert stretched > 0.99 * limb.length


THREE_GOALS = ([-0.23, 0.51, 0.78], [0.45, 0.12, 0.58], [-0.03, 0.49, 0.91])
"""Each is within reach of the right hand, relative to the body."""


def _hand_keys(goals: Sequence[Sequence[float]], step: float = 0.5) -> str:
    return ", ".join(
        f"{{at: {step * (k + 1)}, limb: arm_r, frame: body, reach: {list(goal)}}}"
        for k, goal in enumerate(goals)
    )


def test_goals_in_a_row_are_all_reached() -> None:
    # From the first, iterations towards the second end at limits, half a metre off.
    posed = person(_hand_keys(THREE_GOALS))
    R, p = posed.body
    for key, goal in enumerate(THREE_GOALS):
        row = round(0.5 * (key + 1) / ROW)
        assert np.linalg.norm(posed.place("hand_r")[row] - p[row] - R[row] @ goal) < 1e-3
    assert not posed.take.notes
    assert posed.fastest() < 14.001


def test_pose_does_not_depend_on_rows_worked_out_together() -> None:
    """Rows one by one, and all at once."""
    member = f"{{figure: person, name: p, at: [0, 0], pose: [{_hand_keys(THREE_GOALS)}]}}"
    simulation = Simulation(scene_of(member, duration=1))
    posture = simulation.troupes[0].authored_poses.postures[0]  # type: ignore[attr-defined]
    q, frames = _standing(posture.figure, 97)
    whole, _, _ = posture.values(q, frames)
    again = FigurePosture(posture.figure, posture.plan, np.random.default_rng(3))
    alone = FigurePosture(posture.figure, posture.plan, np.random.default_rng(3))
    parts = [again.values(q[a : a + 7], _rows(frames, a, a + 7))[0] for a in range(0, 97, 7)]
    np.testing.assert_array_equal(np.concatenate(parts), alone.values(q, frames)[0])
    np.testing.assert_allclose(np.concatenate(parts), whole, atol=1e-3)


def test_joint_steps_halve_with_the_time_step() -> None:
    posed = person(_hand_keys(THREE_GOALS))
    arm = [i for i, c in enumerate(posed.take.channels) if "arm_r" in c.name]
    q = posed.take.values[:, arm]
    fine, coarse = np.abs(np.diff(q, axis=0)).max(), np.abs(np.diff(q[::2], axis=0)).max()
    assert fine < 0.6 * coarse


BLOCK = np.array([0.5, 0.7, 0.16])


@pytest.mark.parametrize("avoid", ["", ", avoid: []"])
def test_arm_goes_around_a_box(avoid: str) -> None:
    keys = ", ".join(
        f"{{at: {at}, limb: arm_m, reach: [0.75, 0.35, {z}]{avoid}}}"
        for at, z in ((0.25, -0.55), (1.25, 0.55))
    )
    arm = f"{{figure: robot_arm, name: p, at: [0, 0], pose: [{keys}]}}"
    block = f"{{prop: {{shape: box, size: {BLOCK.tolist()}}}, name: block, at: [0.75, 0.35, 0]}}"
    posed = Posed(arm, block, duration=1.3)
    inside = 0
    for _, link in posed.names.nodes.values():
        number = posed.figure.skeleton.limbs[0].links[link]
        ends = posed.figure.skeleton.links[number].ends
        R, p = matrix(posed.take.rotations[:, number]), posed.take.positions[:, number]
        for part in np.linspace(0.0, 1.0, 5):
            place = p + turn(R, part * (ends[1] - ends[0]))
            deep = np.abs(place - [0.75, 0.35, 0.0]) < BLOCK / 2.0
            inside += int(deep.all(axis=1).sum())
    assert (inside == 0) == (avoid == "")
    end = posed.from_feet("hand")[round(1.25 / ROW)]
    np.testing.assert_allclose(end, [0.75, 0.35, 0.55], atol=1e-3)
    assert posed.fastest() < 8


def test_dexterity_moves_the_limb_away_from_singularities() -> None:
    plain, able = (
        Posed(
            "{figure: robot_arm, name: p, at: [0, 0],"
            f" pose: [{{at: 0, limb: arm_m, reach: [0.6, 0.5, 0.3]{more}}}]}}",
            duration=0.1,
        )
        for more in ("", ", dexterity: 1")
    )
    batch = LimbBatch.of([(plain.figure.skeleton, plain.figure.skeleton.limbs[0])])
    measures = []
    for posed in (plain, able):
        arm = [i for i, c in enumerate(posed.take.channels) if ".arm_m1." in c.name]
        measures.append(float(dexterity(batch, batch.pose(posed.take.values[:1, arm]))[0]))
        np.testing.assert_allclose(posed.from_feet("hand")[0], [0.6, 0.5, 0.3], atol=1e-3)
    assert measures[1] > 1.02 * measures[0]


PLENTY = ", priority: 3, weight: 2, avoid: [], dexterity: 0.5"


def test_keys_take_what_they_leave_out_from_the_keys_before() -> None:
    def values(more: str) -> Array:
        keys = [f"{{at: 0, limb: arm_r, reach: [0.3, 1, 0.3]{PLENTY}}}"]
        keys += [f"{{at: 0.2, limb: arm_r, reach: [0.3, 1.2, 0.3]{more}}}"]
        member = f"{{figure: person, name: p, at: [0, 0], pose: [{', '.join(keys)}]}}"
        return Posed(member, duration=0.3).take.values

    np.testing.assert_array_equal(values(""), values(PLENTY))
    with pytest.raises(SceneError, match=r"dexterity: is 0\.5 for the keys before"):
        values(", dexterity: 0")


def _standing(figure: Figure, count: int) -> tuple[Array, FigureFrames]:
    """Return joint values at rest, and frames of a figure that stands, in `count` rows."""
    R, p = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3))
    up = p + np.array([0.0, 1.0, 0.0])
    q = np.tile(figure.skeleton.preferred, (count, 1))
    return q, FigureFrames(np.arange(count) * ROW, ROW, R, up, R, p)


def _rows(frames: FigureFrames, first: int, last: int) -> FigureFrames:
    here = slice(first, last)
    return replace(
        frames,
        times=frames.times[here],
        R_WB=frames.R_WB[here],
        p_WB=frames.p_WB[here],
        R_WG=frames.R_WG[here],
        p_WG=frames.p_WG[here],
    )


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("{at: 1, limb: arm_x, reach: [0, 0, 0]}", "no limb 'arm_x', did you mean"),
        ("{at: 1, node: elbow, reach: [0, 0, 0]}", "no node 'elbow', did you mean"),
        ("{at: 1, node: chest, reach: [0, 0, 0]}", "part of the body, which the word body moves"),
        ("{at: 1, joints: {elbow_deg: 4}}", "no joint 'elbow_deg', did you mean"),
        ("{at: 1, joints: {elbow_r_deg: 400}}", "goes from -2.29 to 148 degrees, not to 400"),
        ("{at: 1, limb: arm_r}", "needs a goal: reach or aim or turn_deg"),
        ("{at: 1, reach: [0, 0, 0]}", "needs limb or node"),
        (
            "{at: 1, limb: arm_r, reach: [0, 1, 0], avoid: [grond]}",
            "'grond' is no prop that stands or moves by its keys",
        ),
        ("{at: 1, limb: arm_r, node: hand_r, reach: [0, 0, 0]}", "either limb or node"),
        ("{at: 1, limb: arm_r, aim: [0, 0, 0]}", "has no direction"),
        ("{at: 1}", "should have limb, node, joints, body or release"),
        ("{at: 1, release: arm_r}", "nothing is asked of 'arm_r' at 1"),
        ("{at: -1, release: arm_r}", "at least 0"),
        (
            "{at: 0, limb: arm_r, reach: [0, 1, 0]}, {at: 0, limb: arm_r, reach: [0, 1, 0]}",
            "asked for twice at 0",
        ),
        (
            "{at: 0, limb: arm_r, reach: [0, 1, 0]},"
            " {at: 1, limb: arm_r, reach: [0, 1, 0], frame: world}",
            "is feet for the keys before",
        ),
    ],
)
def test_invalid_poses_are_refused(key: str, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        Simulation(scene_of(f"{{figure: person, pose: [{key}]}}"))
    assert all(problem.line > 0 and "pose[" in problem.path for problem in caught.value.problems)


@pytest.mark.nightly
def test_keys_that_cannot_be_reached_are_known_without_steps() -> None:
    """And the place that is advised instead is reached."""
    # At 1.1 s it is too soon for the joints; the others are too far away.
    goals = {0.5: [3.0, 0.4, 0.2], 1.0: [0.42, 0.15, 0.52], 1.5: [0.2, 2.5, 0.2]}
    keys = [f"{{at: {at}, limb: arm_r, frame: body, reach: {to}}}" for at, to in goals.items()]
    keys += ["{at: 1, limb: arm_l, reach: [0.2, 1.5, -1.0]}"]
    keys += ["{at: 1.1, limb: arm_l, reach: [0.2, 0.8, -0.3]}"]

    def member(keys: Sequence[str]) -> str:
        return f"{{figure: person, name: p, at: [0, 0], pose: [{', '.join(keys)}]}}"

    def foreseen(keys: Sequence[str]) -> list[TakeNote]:
        return Simulation(scene_of(member(keys), duration=1.6)).foreseen_notes()

    notes, posed = foreseen(keys), Posed(member(keys), duration=1.6)
    assert notes == [note for note in posed.take.notes if note.kind == "missed_key"]
    times = [note.step * ROW for note in notes]
    assert times == pytest.approx([0.5, 1.0, 1.1, 1.5], abs=ROW)
    assert "would have to turn faster" in notes[2].text
    R, p = posed.body
    for note, at in ((notes[0], 0.5), (notes[3], 1.5)):
        gap = np.linalg.norm(posed.place("hand_r") - p - turn(R, np.array(goals[at])), axis=1)
        assert f"misses its key at {at:g} s by {gap[note.step]:.2g} m" in note.text
    for number, note in ((0, notes[0]), (2, notes[3]), (3, notes[1])):
        found = re.search(r"; (\[.*\]) is the nearest place within it", note.text)
        assert found is not None
        keys[number] = re.sub(r"reach: \[.*?\]", f"reach: {found[1]}", keys[number])
    assert not foreseen(keys[:-1])
