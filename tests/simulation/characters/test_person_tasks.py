"""Person tasks: sitting, looking, reaching, holding, hugging, freezing, turning, stepping aside."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.people.proportions import ADULT
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene
from pipeline.spec.scene_library import library
from pipeline.spec.scene_loader import load_scene
from tests.simulation.characters.character_yard import largest_joint_excess
from tests.simulation.characters.scripted_people import STEPS, J, play_scene, troupe_of

pytestmark = pytest.mark.slow

SIT = """
duration: 6.5
cast: [{name: a, character: adult}, {name: b, character: child, at: [3, 3]},
  {name: bench, character: bench, at: [3, 2.2], heading_deg: 90}]
script:
  - {at: 0.1, who: a, do: sit}
  - {at: 3.6, who: a, do: stand}
  - {at: 0.1, who: b, do: {sit: bench}}
"""


def test_sit_and_stand_orders_are_carried_out() -> None:
    excesses = []
    play = play_scene(
        SIT,
        lambda troupe, _: excesses.append(
            largest_joint_excess(troupe.arrays.nodes, troupe.arrays.limbs)
        ),
    )
    pelvis = play.joint("a", "pelvis")[:, 1]
    assert len(play.when("a")) == 2
    assert 1.2 < play.when("a")[0] < 2.0
    assert pelvis[int(3.4 * STEPS)] == pytest.approx(0.062 * ADULT.height, abs=0.02)
    assert pelvis[-1] == pytest.approx(ADULT.hip * ADULT.height, abs=0.02)
    # To stand up the shoulders lean far in front of the pelvis, over the feet.
    lean = play.joint("a", "shoulders")[:, 0] - play.joint("a", "pelvis")[:, 0]
    assert lean[int(3.7 * STEPS) : int(4.8 * STEPS)].max() > 0.15
    for side in "lr":
        foot = play.joint("a", f"foot_{side}")
        assert np.abs(foot - foot[0]).max() < 0.02
    assert max(excesses) < 0.02
    # On the bench, facing away from it.
    assert len(play.when("b")) == 1
    seat = play.joint("b", "pelvis")[-1]
    assert abs(seat[1] - 0.42 - 0.062 * 1.15) < 0.04
    assert abs(seat[2] - 2.2) < 0.25


MEET = """
duration: 7
cast: [{name: a, character: adult, at: [-1.2, 0]},
  {name: b, character: child, at: [1.2, 0.1], heading_deg: 180}]
script:
  - {at: 0, who: b, do: {hug: a}}
  - {when: {touch: [a, b]}, who: a, do: {hug: b}}
  - {at: 5, who: a, do: let_go}
  - {at: 5, who: b, do: let_go}
"""


def test_a_mutual_hug_closes_both_pairs_of_arms() -> None:
    play = play_scene(MEET)
    assert play.when("a")
    assert play.when("b")
    row = int(4.9 * STEPS)
    for name, other in (("a", "b"), ("b", "a")):
        back = 0.5 * (play.joint(other, "spine")[row] + play.joint(other, "shoulders")[row])
        direction = (play.joint(other, "pelvis")[row] - play.joint(name, "pelvis")[row]) * [
            1.0,
            0.0,
            1.0,
        ]
        direction /= np.hypot(*direction[[0, 2]])
        hands = [play.joint(name, f"hand_{side}")[row] for side in "lr"]
        # Around the other: both hands lie behind the middle of the other's chest.
        assert min((hand - back) @ direction for hand in hands) > 0.05
        assert min(math.dist(hand, back) for hand in hands) < 0.3
    # Arms too short to close behind a grown-up end on its back, and not in the air.
    a, b = (play.joint(name, "pelvis")[row] for name in "ab")
    direction = (a - b) * [1.0, 0.0, 1.0] / np.hypot(*(a - b)[[0, 2]])
    assert max((play.joint("b", f"hand_{s}")[row] - a) @ direction for s in "lr") < 0.11
    # The longer arms close behind the back of the smaller one, one hand above the other.
    left, right = (play.joint("a", f"hand_{side}")[row] for side in "lr")
    assert left[1] > right[1]
    assert math.dist(left, right) > 0.06
    away = play.joint("a", "pelvis")[row] - play.joint("b", "pelvis")[row]
    assert np.hypot(away[0], away[2]) < 0.5
    assert (play.records["arm_mode"][-1] == 0).all()


HOLD = """
duration: 6
cast: [{name: a, character: child, at: [-1.3, 0.15]}, {name: doll, character: ragdoll}]
script:
  - {at: 0, who: a, do: {grab: doll, part: foot_l, hand: left}}
  - {when: {arrived: a}, who: a, do: {go_to: [1.5, 0.6]}}
  - {at: 5.2, who: a, do: let_go}
"""


def test_a_grabbed_thing_hangs_from_the_hand_until_released() -> None:
    grips = []

    def look(troupe: Characters, _: int) -> None:
        hand, held = (int(n) for n in troupe.arrays.grips[0])
        p = troupe.arrays.p
        grips.append((held, math.dist(p[hand], p[held]) if held >= 0 else math.nan))

    play = play_scene(HOLD, look)
    held = np.array([node for node, _ in grips])
    apart = np.array([far for _, far in grips])[held >= 0]
    assert (held >= 0).sum() > STEPS
    assert (held[-20:] == -1).all()
    # The thing moves to the hand at no more than 1 m/s, and stays.
    assert np.abs(np.diff(apart)).max() * STEPS < 1.1
    assert apart[10:].max() < 1e-3
    first = play.firsts["doll"]
    # Its limbs swing while it hangs by a foot, so the highest node tells.
    highest = play.p[:, first : first + 16, 1].max(axis=1)
    assert highest[int(5.1 * STEPS)] > 0.4
    assert highest[-1] < 0.2


@pytest.mark.nightly
def test_each_hand_can_grab_a_different_thing() -> None:
    simulation = Simulation(load_scene(library() / "merry_go_round.yaml"))
    troupe = troupe_of(simulation)
    arrays, first = troupe.arrays, int(troupe.persons[0].grip)
    grips = arrays.grips[first : first + 2]
    rim = [int(arrays.owners["nodes"][0, 0]) + k for k in (0, 2)]
    apart: list[list[float]] = [[], []]
    angles = []
    while not simulation.finished:
        simulation.step()
        spoke = arrays.p[rim[1]] - arrays.p[rim[0]]
        angles.append(math.atan2(-spoke[2], spoke[0]))
        for k in range(2):
            if grips[k, 0] >= 0:
                apart[k].append(math.dist(*arrays.p[grips[k]]))
    for gaps, seconds in zip(apart, (2.9, 8.0), strict=True):
        assert len(gaps) > seconds * STEPS
        assert max(gaps[10:]) < 1e-3
    assert np.ptp(np.unwrap(angles)) > math.radians(60.0)


LOOK = """
duration: 5
cast: [{name: a, character: adult}, {name: b, character: child, at: [0, 2.5]}]
script:
  - {at: 0.1, who: a, do: {look_at: b}}
  - {at: 1.5, who: a, do: {look_at: [1.0, 2.2, -1.5]}}
  - {at: 3, who: a, do: {look: ahead}}
  - {at: 0.1, who: b, do: {reach: [0.2, 0.5, 2.4], hand: left}}
  - {at: 2.5, who: b, do: {reach: [0.25, 0.08, 2.4], hand: right}}
"""


def test_heads_turn_smoothly_and_hands_reach_their_places() -> None:
    play = play_scene(LOOK)
    gaze = play.records["gaze"][:, 0]
    head = play.joint("a", "head")
    for row, target in ((int(1.4 * STEPS), play.joint("b", "head")), (int(2.9 * STEPS), None)):
        at = np.array([1.0, 2.2, -1.5]) if target is None else target[row]
        direction = at - head[row]
        assert gaze[row, 0] == pytest.approx(math.atan2(-direction[2], direction[0]), abs=0.06)
        assert gaze[row, 1] == pytest.approx(
            math.atan2(direction[1], math.hypot(direction[0], direction[2])), abs=0.06
        )
    assert abs(gaze[-1, 0]) < 0.02
    assert np.abs(np.diff(gaze[:, 0])).max() * STEPS < 9.0
    # Shoulders turn with the head, at most by a quarter turn.
    twist = play.records["twist"][:, 0]
    assert 0.2 < np.abs(twist).max() < math.pi / 2.0
    left, right = (play.joint("b", f"hand_{side}") for side in "lr")
    assert math.dist(left[int(2.4 * STEPS)], [0.2, 0.5, 2.4]) < 0.03
    assert math.dist(right[-1], [0.25, 0.08, 2.4]) < 0.08


STILL = """
duration: 6
cast: [{name: a, character: adult}, {name: b, character: adult, at: [0, 3]}]
script:
  - {at: 0, who: a, do: {go_to: [4, 0]}}
  - {at: 1.5, who: a, do: freeze}
  - {at: 2.5, who: a, do: walk}
  - {at: 0.2, who: b, do: {turn_deg: 170}}
"""


def test_freeze_is_still_and_turning_does_not_cross_feet() -> None:
    play = play_scene(STILL)
    first = play.firsts["a"]
    frozen = play.p[int(1.9 * STEPS) : int(2.5 * STEPS), first : first + 16]
    assert np.abs(frozen - frozen[0]).max() < 2e-3
    # Starting to walk again is no blow.
    assert play.records["stun"][int(2.4 * STEPS) :, 0].max() < 0.2
    assert play.when("a")
    heading = play.records["heading"][:, 1]
    assert heading[-1] == pytest.approx(math.radians(170.0), abs=0.06)
    right = np.stack([np.sin(heading), np.cos(heading)], axis=1)
    feet = [play.joint("b", f"foot_{side}")[:, [0, 2]] for side in "lr"]
    assert ((feet[1] - feet[0]) * right).sum(axis=1).min() > 0.02
    assert play.when("b")[0] < 3.0


@pytest.mark.parametrize("direction", [(2.0, 0.6), (-1.2, 1.2)])
def test_a_shoved_person_staggers_and_recovers(direction: tuple[float, float]) -> None:
    def shove(troupe: Characters, step: int) -> None:
        if step == 48:
            own = slice(0, 16)
            troupe.arrays.nodes["previous"][own, 0] -= (
                direction[0] * troupe.world.clock.dt / troupe.count
            )
            troupe.arrays.nodes["previous"][own, 2] -= (
                direction[1] * troupe.world.clock.dt / troupe.count
            )

    play = play_scene("duration: 4.5\ncast: [{name: a, character: adult}]\n", shove)
    pelvis = play.joint("a", "pelvis")
    went = np.hypot(pelvis[-1, 0], pelvis[-1, 2])
    assert 0.1 < went < 1.5
    assert play.joint("a", "head")[:, 1].min() > 1.35
    assert sum(c.kind == "touch" for c in play.contacts) >= 2
    assert not play.records["stepping"][-1, 0]
    assert np.abs(pelvis[-1] - pelvis[-25]).max() < 0.01


def test_breath_lifts_the_shoulders_more_in_walking() -> None:
    scene = "duration: 5\ncast: [{name: a, character: adult}]\n"
    rest = play_scene(scene)
    lift = rest.joint("a", "shoulders")[:, 1] - rest.joint("a", "spine")[:, 1]
    assert 0.006 < np.ptp(lift[STEPS:]) < 0.02
    walk = "script: [{at: 0, who: a, do: walk}]\n"
    faster = play_scene(scene + walk)
    gone = [np.unwrap(2 * np.pi * play.records["breath"][:, 0])[-1] for play in (rest, faster)]
    assert gone[1] > 1.3 * gone[0]


POSED = """
duration: 4
cast:
  - name: a
    character: adult
    at: [0, 0]
    heading_deg: 90
    pose:
      - {at: 1, limb: arm_r, reach: [0.3, 1.7, 0.35]}
      - {at: 1.5, limb: arm_r, reach: [0.3, 1.7, 0.6]}
      - {at: 3, release: arm_r}
      - {at: 1.5, node: hand_l, reach: [-0.3, 1.0, -0.4], frame: world}
"""


def test_posed_hands_follow_their_keys() -> None:
    play = play_scene(POSED)
    row = int(2.8 * STEPS)
    # A person facing -Z has -Z ahead and +X to the right.
    assert math.dist(play.joint("a", "hand_r")[row], [0.6, 1.7, -0.3]) < 0.04
    assert math.dist(play.joint("a", "hand_l")[row], [-0.3, 1.0, -0.4]) < 0.04
    assert play.joint("a", "hand_r")[-1, 1] < 1.1


def crossing(count: int) -> str:
    """Return a scene of two groups of walkers on crossing paths."""
    lanes = [f"{1.0 * (k - (count - 1) / 2)}" for k in range(count)]
    cast = [f"  - {{name: e{k}, character: adult, at: [-4, {z}]}}" for k, z in enumerate(lanes)]
    cast += [
        f"  - {{name: n{k}, character: child, at: [{z}, 4.3], heading_deg: 90}}"
        for k, z in enumerate(lanes)
    ]
    script = [f"  - {{at: 0, who: e{k}, do: {{go_to: [4, {z}]}}}}" for k, z in enumerate(lanes)]
    script += [f"  - {{at: 0, who: n{k}, do: {{go_to: [{z}, -4]}}}}" for k, z in enumerate(lanes)]
    return "\n".join(["duration: 12", "cast:", *cast, "script:", *script])


def test_walkers_head_on_pass_each_other_on_the_right() -> None:
    play = play_scene("""
duration: 8
cast:
  - {name: a, character: adult, at: [-3.5, 0]}
  - {name: b, character: adult, at: [3.5, 0], heading_deg: 180}
script:
  - {at: 0, who: a, do: {go_to: [3.5, 0]}}
  - {at: 0, who: b, do: {go_to: [-3.5, 0]}}
""")
    assert sorted(name for _, name in play.arrived) == ["a", "b"]
    a, b = (play.joint(name, "pelvis")[:, [0, 2]] for name in "ab")
    meeting = np.abs(a[:, 0] - b[:, 0]).argmin()
    # Whoever walks along +X has +Z on the right.
    assert 0.5 < a[meeting, 1] - b[meeting, 1] < 1.4
    assert np.linalg.norm(a - b, axis=1).min() > 0.5


@pytest.mark.nightly
def test_crossing_walkers_step_aside() -> None:
    play = play_scene(crossing(3))
    names = [name for name in play.firsts if name[0] in "en"]
    assert sorted(name for _, name in play.arrived) == sorted(names)
    pelvis = np.array([play.joint(name, "pelvis") for name in names])[:, :, [0, 2]]
    apart = np.linalg.norm(pelvis[:, None] - pelvis[None], axis=-1)
    apart += 10.0 * np.eye(len(names))[:, :, None]
    assert apart.min() > 0.5
    # No walker falls or trips: each foot lands on its own side of the other.
    heights = {"e": 1.72, "n": 1.15}
    fastest = np.abs(np.diff(play.p, axis=0)).max() * STEPS
    assert fastest < 10.0
    for k, name in enumerate(names):
        assert play.joint(name, "head")[:, 1].min() > 0.8 * heights[name[0]]
        heading = play.records["heading"][:, k]
        right = np.stack([np.sin(heading), np.cos(heading)], axis=1)
        feet = [play.joint(name, f"foot_{side}")[:, [0, 2]] for side in "lr"]
        stands = (play.records["foot_state"][:, k] == 0).all(axis=1)
        assert ((feet[1] - feet[0]) * right).sum(axis=1)[stands].min() > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fight", pytest.param("square", marks=pytest.mark.nightly)])
@pytest.mark.nightly
def test_limbs_stay_together_in_a_dense_crowd(name: str) -> None:
    """Feet of a runner reach 10 m/s; a foot moved at once would have 200."""
    simulation = Simulation(load_scene(library() / f"{name}.yaml"))
    troupe = troupe_of(simulation)
    people = np.stack([np.arange(p.node, p.node + len(J)) for p in troupe.persons])
    before, fastest = troupe.arrays.p[people], np.zeros(len(people))
    while not simulation.finished:
        simulation.step()
        now = troupe.arrays.p[people]
        speeds = np.linalg.norm(now - before, axis=2).max(axis=1) * STEPS
        fastest, before = np.maximum(fastest, speeds), now
    # In a crowd of fifty a person may lose its footing between others, and recover.
    assert (fastest > 25.0).sum() <= len(people) // 25


def test_a_distant_persons_motion_is_bitwise_the_same_as_alone() -> None:
    alone = "duration: 2\ncast:\n  - {name: a, character: adult}\n"
    other = "  - {name: b, character: child, at: [14, 14]}\n"
    script = "script:\n  - {at: 0, who: a, do: {go_to: [2, 1]}}\n"
    one, two = play_scene(alone + script), play_scene(alone + other + script)
    np.testing.assert_array_equal(one.p, two.p[:, :16])
    # Characters are led by name.
    first = play_scene(alone + other.replace("name: b", "name: Z") + script)
    np.testing.assert_array_equal(one.p, first.p[:, 16:])


CAST = """pronk: 1
duration: 1
cast: [{name: a, character: adult}, {name: doll, character: ragdoll, at: [1, 1]},
  {name: ball, character: ball, at: [2, 2]}, {name: bug, figure: beetle, walk: {}, at: [-3, 3]},
  {name: pebble, body: {shape: sphere, radius: 0.1}, at: [4, 0.1, 4]},
  {name: gate, prop: {shape: box}, at: [5, 5]}]
script: [%s]
"""


@pytest.mark.parametrize(
    ("member", "message"),
    [
        (
            "{character: adult, pose: [{at: 0, limb: leg_l, reach: [0, 0, 0]}]}",
            "only hands of a person",
        ),
        ("{character: adult, pose: [{at: 0, joints: {elbow_r_deg: 4}}]}", "only hands of a person"),
        (
            "{character: ragdoll, pose: [{at: 0, limb: arm_l, reach: [0, 0, 0]}]}",
            "only a child or an adult",
        ),
    ],
)
def test_only_hands_of_people_can_be_posed(member: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        read_scene(f"pronk: 1\nduration: 1\ncast: [{member}]\n")


HUGGED = """
duration: 6
cast: [{name: a, character: adult, at: [0, 0]},
  {name: b, character: child, at: [1.6, 0.1], heading_deg: 180},
  {name: c, character: child, at: [0, 3]}]
script:
  - {at: 0.2, who: b, do: {hug: a}}
  - {when: {hug: [a, b]}, who: c, do: {go_to: [3, 3]}}
  - {when: {hug: [b, a]}, who: c, do: {go_to: [-1, 3]}}
"""


def test_a_hug_trigger_distinguishes_the_two_people() -> None:
    hugs = []
    simulation = Simulation(read_scene("pronk: 1\n" + HUGGED))
    while not simulation.finished:
        simulation.step()
        step = simulation.step_number
        hugs += [(step, h.who, h.other) for h in simulation.signals if h.kind == "hug"]
    followed = [order for order in simulation.order_log.records if order.who == "c"]
    (step, hugger, hugged), *others = hugs
    assert (hugger, hugged, others) == ("b", "a", [])
    # The trigger fires once, in the next step; that of the reverse hug does not.
    assert [(order.step, order.text) for order in followed] == [(step, "go_to [-1, 3]")]
    assert 0.9 < step / STEPS < 3.5


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("{at: 0, who: a, do: {hug: doo}}", "nobody in the cast is called 'doo'"),
        ("{at: 0, who: a, do: {hug: ball}}", "'ball' is a ball; name a child"),
        ("{at: 0, who: a, do: {hug: a}}", "'a' cannot do that to itself"),
        ("{at: 0, who: a, do: {grab: doll, part: arm}}", "no part of 'doll' is called 'arm'"),
        ("{at: 0, who: a, do: {grab: ball, part: head}}", "'ball' has no named parts"),
        (
            "{at: 0, who: a, do: {sit: doll}}",
            "'doll' is a ragdoll; name a bench, a box, a rock or what else",
        ),
        ("{at: 0, who: a, do: hop}", "is a child or an adult, for which hop is no order"),
        ("{at: 0, who: doll, do: stop}", "'doll' is a ragdoll, which no script moves"),
        ("{at: 0, who: bug, do: sit}", "'bug' is a creature that walks, for which sit is no order"),
        ("{at: 0, who: a, do: {hug: bug}}", "'bug' is a creature; name a child"),
        ("{when: {touch: [a, gat]}, who: a, do: stop}", "is called 'gat', did you mean 'gate'"),
        ("{when: {touch: [a, a]}, who: a, do: stop}", "'a' cannot touch itself"),
        ("{when: {}, who: a, do: stop}", "should have one of arrived, touch, near"),
        ("{when: {arrived: a, hug: [a, doll]}, who: a, do: stop}", "should have one of arrived"),
        ("{when: {hug: [a, dol]}, who: a, do: stop}", "is called 'dol', did you mean 'doll'"),
        ("{when: {hug: [aa, doll]}, who: a, do: stop}", "nobody in the cast is called 'aa'"),
        ("{when: {hug: [doll, a]}, who: a, do: stop}", "'doll' is a ragdoll; name a child or an"),
        ("{when: {hug: [a, a]}, who: a, do: stop}", "'a' cannot do that to itself"),
        ("{when: {hug: [a, ball]}, who: a, do: stop}", "'ball' is a ball; name a child"),
        ("{when: {hug: [bug, a]}, who: a, do: stop}", "'bug' is a creature; name a child or"),
        ("{at: 0, who: a, do: {let_go: up}}", "must be 'left', 'right' or 'both'"),
    ],
)
def test_impossible_orders_are_rejected_with_their_position(entry: str, message: str) -> None:
    with pytest.raises(SceneError, match=r"script\[0\]") as caught:
        read_scene(CAST % entry)
    assert message in str(caught.value)


def test_a_misspelt_kind_is_reported_once() -> None:
    text = CAST % "{when: {hug: [a, doll]}, who: a, do: {hug: doll}}"
    with pytest.raises(SceneError) as caught:
        read_scene(text.replace("character: adult", "character: adlt"))
    assert len(caught.value.problems) == 1
    assert "did you mean 'adult'" in str(caught.value)


def test_parts_are_named_by_joints() -> None:
    from pipeline.spec.character_kinds import PARTS

    assert set(PARTS) == set(J)
