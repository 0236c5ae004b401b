"""Walking persons that dance: palms where the guide has them, planted feet, strikes, refusals."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.locomotion.dancing.dancing_arms import DancingArms
from pipeline.simulation.people.dressed_figure import person_bones
from pipeline.simulation.people.guided_dance import GUIDED_FRAMES, GUIDED_JOINTS, GuidedPose
from pipeline.simulation.people.proportions import JOINTS, PALM_FRACTION
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array, rotation
from pipeline.simulation.take import Take
from pipeline.spec import read_scene

DANCE = """
dances:
  salute:
    bar: 2
    tempo_bpm: 120
    subtasks:
      - {hand: r, joints: {shoulder_flexion_deg: 90, elbow_flexion_deg: 4}}
      - {hand: l, touch: chest}
"""
STEPS = 96
"""World steps in a second."""


def text_of(script: str, member: str = "figure: person, walk: {}", seconds: float = 4.0) -> str:
    return (
        f"pronk: 1\nduration: {seconds}\nterrain: flat\n{DANCE}"
        f"cast: [{{name: ann, {member}}}]\nscript: [{script}]\n"
    )


@cache
def person() -> Figure:
    scene = read_scene("pronk: 1\nduration: 1\ncast: [{figure: person}]\n")
    return build_figure("person", scene.figures["person"], 1.0)


@cache
def danced() -> tuple[Take, tuple[str, ...]]:
    script = (
        "{at: 0, who: ann, do: {dance: salute, bars: 1}}, "
        "{when: {arrived: ann}, who: ann, do: {wait: 9}}"
    )
    simulation = Simulation(read_scene(text_of(script, seconds=6.0)))
    while not simulation.finished:
        simulation.step()
    take = simulation.take()
    return take, tuple(node.name for node in take.nodes)


def path(name: str) -> Array:
    take, names = danced()
    result: Array = take.positions[:, names.index(name)]
    return result


def raised(figure: Figure, angle: float, sway: float) -> GuidedPose:
    """Return a guide whose right arm is raised ahead by an angle, its chest swayed [rad]."""
    proportions = person_bones(figure).proportions
    rest = dict(zip(JOINTS, proportions.rest(), strict=True))
    shoulder, spine, pelvis = rest["shoulder_r"], rest["spine"], rest["pelvis"]
    R = rotation(np.array([1.0, 0.0, 0.0]), np.array(sway))
    arm = rotation(np.array([0.0, 0.0, 1.0]), np.array(angle))
    joints, arms = [], []
    for name in GUIDED_JOINTS:
        place = rest[name]
        if name in ("elbow_r", "hand_r"):
            place = shoulder + arm @ (place - shoulder)
        joints.append(spine - pelvis + R @ (place - spine))
    for name in GUIDED_FRAMES:
        arms.append(R @ arm if name.endswith("_r") else R)
    return GuidedPose(np.array(joints), np.array(arms), np.array([1.0, 0.0, 0.0]))


@pytest.mark.parametrize(("angle", "sway"), [(1.5, 0.0), (1.0, 0.07), (0.4, -0.07)])
def test_palm_and_chest_are_where_the_guide_has_them(angle: float, sway: float) -> None:
    figure = person()
    arms = DancingArms(figure, 1.0 / STEPS)
    pose = raised(figure, angle, sway)
    q, trunk = arms.follow(pose, None)
    for _ in range(STEPS):
        q, trunk = arms.follow(pose, q)
    whole = figure.skeleton.preferred.copy()
    whole[arms.joints] = q
    X = JointTree.of(figure.skeleton).pose(whole)
    arm = next(limb for limb in figure.skeleton.limbs if limb.name == "arm_r1")
    link = figure.skeleton.links[arm.links[-1]]
    palm = (1.0 - PALM_FRACTION) * link.ends[0] + PALM_FRACTION * link.ends[1]
    place = X[link.joint, :3, 3] + X[link.joint, :3, :3] @ (
        palm - figure.skeleton.places[link.joint]
    )
    place = trunk.p + trunk.R @ place
    hand = float(np.linalg.norm(link.ends[1] - link.ends[0]))
    wrist = pose.joints[GUIDED_JOINTS.index("hand_r")]
    turned = pose.arms[GUIDED_FRAMES.index("hand_r")]
    wanted = arms.hips + wrist - PALM_FRACTION * hand * turned[:, 1]
    assert np.linalg.norm(place - wanted) < 3e-3
    lower, upper = figure.skeleton.lower[arms.joints], figure.skeleton.upper[arms.joints]
    np.testing.assert_array_less(lower - 1e-9, q)
    np.testing.assert_array_less(q, upper + 1e-9)


@pytest.mark.nightly
def test_an_arm_is_stretched_ahead_and_hangs_again() -> None:
    hand = path("ann.arm_r1.3") - path("ann.arm_r1.1")
    length = float(np.linalg.norm(hand, axis=1).max())
    ahead = hand[:, 0] / length
    assert ahead.max() > 0.97
    assert abs(hand[int(ahead.argmax()), 1]) < 0.08
    assert hand[-1, 1] < -0.9 * length
    steps = np.linalg.norm(np.diff(hand, axis=0), axis=1) * STEPS
    assert steps.max() < 6.0


@pytest.mark.nightly
def test_a_hand_strikes_the_chest_and_the_order_is_done() -> None:
    take, _ = danced()
    hits = [contact for contact in take.contacts if contact.part == "hand_l"]
    assert [hit.other for hit in hits[:1]] == ["breast"]
    assert hits[0].performer == "ann"
    # On the chest of an adult as it stands.
    assert hits[0].place[1] == pytest.approx(1.3, abs=0.12)
    assert [order.text.split(",")[0] for order in take.orders] == ["dance salute", "wait 9"]
    assert not [note for note in take.notes if note.kind != "drawn"]


@pytest.mark.nightly
def test_feet_stay_where_they_are_while_the_arms_dance() -> None:
    hit = next(c for c in danced()[0].contacts if c.part == "hand_l")
    for side in "lr":
        foot = path(f"ann.{side}1.3")[hit.step - 30 : hit.step + 30]
        assert float(np.ptp(foot, axis=0).max()) < 5e-3


@pytest.mark.parametrize(
    ("member", "order", "message"),
    [
        ("figure: horse, walk: {}", "{dance: salute}", "'ann' is a horse, and dances are for"),
        ("figure: person, walk: {}", "dance", "'ann' has no dance of its own; write {dance: NAME"),
        ("figure: person", "{dance: salute}", "'ann' neither walks nor hops; give it walk: {}"),
        (
            "figure: person, walk: {}, pose: [{at: 0, limb: arm_r, reach: [0.3, 1.2, 0.2]}]",
            "{dance: salute}",
            "'ann' has a pose, which conflicts with dances; remove pose",
        ),
    ],
)
def test_a_dance_that_a_creature_cannot_dance_is_refused(
    member: str, order: str, message: str
) -> None:
    with pytest.raises(SceneError) as caught:
        read_scene(text_of(f"{{at: 0, who: ann, do: {order}}}", member))
    assert "script[0]" in str(caught.value)
    assert message in str(caught.value)


def test_a_dance_with_drums_is_refused_with_its_line() -> None:
    drums = "    drums: {tom: {at: [0.4, 1.0, 0]}}\n    subtasks:"
    text = text_of("{at: 0, who: ann, do: {dance: salute}}").replace("    subtasks:", drums)
    with pytest.raises(SceneError, match=r"script\[0\].do.dance: 'salute' has drums"):
        Simulation(read_scene(text))
