"""Dancers that a script tells what to do, and that are posed."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.dancers.dancer_motion import DancerMotion
from pipeline.simulation.dancers.dancer_troupe import Dancers
from pipeline.simulation.simulate import Simulation
from pipeline.spec import dump, read_scene
from pipeline.spec.rpc_instruction import instruction_of

SCENE = """pronk: 1
duration: {duration}
{more}
dances:
  up:
    tempo_bpm: 60
    bar: 2
    subtasks:
      - {{hand: r, reach: [0.42, 1.5, 0.3]}}
      - {{hand: r, reach: [0.42, 1.2, 0.3]}}
  out:
    tempo_bpm: 60
    bar: 2
    subtasks:
      - {{hand: r, reach: [0.35, 1.4, 0.5]}}
      - {{hand: l, reach: [0.35, 1.4, -0.5]}}
  drum:
    tempo_bpm: 120
    bar: 2
    drums: {{tom: {{at: [0.4, 0.95, 0.2], height: 0.9}}}}
    subtasks:
      - {{hand: r, touch: tom, lift: 0.12, on: [1, 2], beats: 0.8}}
cast:
  - {{name: ada, dancer: torso, dance: up, {words}}}
  - {{name: tor, prop: {{shape: box}}, at: [3, 3]}}
script:
{script}
"""

BOTH = pytest.mark.parametrize("by", ["force-field", "joint-torque"])


def told(*script: str, words: str = "", duration: float = 6.0, more: str = "") -> Simulation:
    lines = "\n".join(f"  - {line}" for line in script) or "  []"
    if "beat:" not in words:
        words = f"start: 0, {words}"
    return Simulation(
        read_scene(SCENE.format(duration=duration, words=words, script=lines, more=more))
    )


def ada(simulation: Simulation) -> DancerMotion:
    troupe = next(t for t in simulation.troupes if isinstance(t, Dancers))
    return troupe.dancing[0]


def go(simulation: Simulation, until: float) -> np.ndarray:
    """Go on until a time; return where both palms are then (2, 3) [m]."""
    one = ada(simulation)
    while one.now < until - 1e-6:
        simulation.step()
    return np.array(one.moving.places[[arm.palm for arm in one.arms]])


def near(place: np.ndarray, wanted: tuple[float, float, float], far: float = 0.03) -> bool:
    return bool(np.linalg.norm(place - wanted) < far)


@BOTH
def test_a_dancer_stops_and_lets_its_arms_hang_and_goes_on(by: str) -> None:
    words = f"controller: {by}"
    one = told("{at: 1.5, who: ada, do: stop}", "{at: 3.5, who: ada, do: dance}", words=words)
    assert near(go(one, 1.1)[0], (0.42, 1.5, 0.3))
    for now in (2.9, 3.4):
        # It hangs beside the thigh, and stays there.
        hand = go(one, now)[0]
        assert hand[1] < 0.9
        assert abs(hand[0]) < 0.2
    assert near(go(one, 4.6)[0], (0.42, 1.5, 0.3))
    assert near(go(one, 5.6)[0], (0.42, 1.2, 0.3))


@BOTH
def test_a_dancer_freezes_where_it_is(by: str) -> None:
    one = told("{at: 0.6, who: ada, do: freeze}", words=f"controller: {by}")
    begin = go(one, 0.6)
    assert not near(begin[0], (0.42, 1.5, 0.3), 0.1)
    still = go(one, 1.2)
    # It comes to rest within a hand's breadth, and then is at rest.
    assert np.linalg.norm(still - begin, axis=1).max() < 0.12
    assert np.linalg.norm(go(one, 3.0) - still, axis=1).max() < 0.005


@BOTH
def test_it_dances_something_else_for_a_bar_and_goes_back(by: str) -> None:
    one = told("{at: 2.0, who: ada, do: {dance: out, bars: 1}}", words=f"controller: {by}")
    assert near(go(one, 1.1)[0], (0.42, 1.5, 0.3))
    assert near(go(one, 3.1)[0], (0.35, 1.4, 0.5))
    assert near(go(one, 4.1)[1], (0.35, 1.4, -0.5))
    assert near(go(one, 5.1)[0], (0.42, 1.5, 0.3))


def test_who_has_danced_its_bars_has_arrived_and_others_can_wait_for_that() -> None:
    one = told(
        "{at: 1.0, who: ada, do: {dance: out, bars: 1, tempo_bpm: 120}}",
        "{when: {arrived: ada}, who: ada, do: stop}",
    )
    heard = []
    while not one.finished:
        one.step()
        heard += [(h.kind, round(ada(one).now, 2)) for h in one.signals if h.who == "ada"]
    assert heard == [("arrived", 2.0)]
    assert go(one, 6.0)[0, 1] < 0.9


@pytest.mark.slow
def test_a_touch_of_two_others_makes_it_dance() -> None:
    text = SCENE.format(duration=6, words="start: 0, bars: 1", script="SCRIPT", more="")
    others = (
        "  - {name: ball, character: ball, at: [3, 3], velocity: [1, 0, 0]}\n"
        "  - {name: wall, character: box, at: [4.2, 3]}\n"
    )
    when = "  - {when: {touch: [ball, wall]}, who: ada, do: {dance: out}}"
    text = text.replace("script:\n", f"{others}script:\n").replace("SCRIPT", when)
    one = Simulation(read_scene(text))
    met = None
    while not one.finished:
        one.step()
        if met is None and any(h.kind == "touch" for h in one.happened):
            met = ada(one).now
            first = [move.land for move in ada(one).moves[0]]
    assert met is not None
    assert min(abs(land - met - 1.0) for land in [m.land for m in ada(one).moves[0]]) < 0.05
    assert met + 1.0 not in first
    assert near(go(one, 6.0)[1], (0.35, 1.4, -0.5))


@pytest.mark.slow
def test_characters_run_into_a_dancer_who_feels_that() -> None:
    text = SCENE.format(duration=4, words="start: 0, bars: 1", script="SCRIPT", more="")
    others = (
        "  - {name: ball, character: ball, at: [1.2, 1.0, 0.02], velocity: [-2.5, 1, 0]}\n"
        "  - {name: kid, character: child, at: [-1.4, 0]}\n"
    )
    script = (
        "  - {when: {touch: [ball, ada]}, who: ada, do: {dance: out}}\n"
        "  - {at: 0.1, who: kid, do: walk}\n"
    )
    text = text.replace("script:\n", f"{others}script:\n").replace("SCRIPT", script)
    one = Simulation(read_scene(text))
    met = None
    while not one.finished:
        one.step()
        if met is None and any({h.who, h.other} == {"ball", "ada"} for h in one.happened):
            met = ada(one).now
    assert met is not None
    assert 0.3 < met < 0.6
    assert near(go(one, 4.0)[1], (0.35, 1.4, -0.5))
    take = one.take()
    names = [node.name for node in take.nodes]
    # The ball bounces off, and the child does not walk through the dancer.
    ball, kid = (take.positions[:, names.index(name)] for name in (ball_node(names), "kid.pelvis"))
    assert ball[-1, 0] > 0.5
    assert kid[:, 0].max() < -0.15


def ball_node(names: list[str]) -> str:
    return next(name for name in names if name.startswith("ball"))


@BOTH
def test_a_dance_that_is_told_strikes_on_its_beats(by: str) -> None:
    one = told("{at: 1.5, who: ada, do: {dance: drum}}", words=f"controller: {by}", duration=5)
    while not one.finished:
        one.step()
    blows = [
        (c.step + c.fraction) / 96
        for c in one.take().contacts
        if (c.performer, c.other) == ("ada", "tom")
    ]
    # The first is as far away as a hand is on its way to a blow, 0.8 beats of half a second; from
    # where it happens to be it is not as well practised as the others.
    blows = [blow for blow in blows if blow > 1.6]
    wanted = [1.9 + 0.5 * k for k in range(6)]
    late = np.array(blows[: len(wanted)]) - wanted
    assert abs(late[0]) < 0.1
    assert np.abs(late[1:]).max() < 1 / 24


def test_who_is_locked_to_the_score_changes_on_its_beats() -> None:
    one = told(
        "{at: 1.3, who: ada, do: {dance: out}}",
        words="beat: 1",
        more="sound: {tempo_bpm: 60}",
    )
    go(one, 1.6)
    moves = ada(one).moves[0]
    assert moves[-1].land == pytest.approx(round(moves[-1].land))


@BOTH
def test_it_waits_and_goes_on(by: str) -> None:
    one = told("{at: 1.2, who: ada, do: {wait: 1.5}}", words=f"controller: {by}")
    still = go(one, 1.6)
    assert np.linalg.norm(go(one, 2.6) - still, axis=1).max() < 0.01
    assert near(go(one, 3.8)[0], (0.42, 1.5, 0.3))


@BOTH
def test_a_hand_reaches_for_a_place_and_is_let_go(by: str) -> None:
    one = told(
        "{at: 1.0, who: ada, do: {reach: [1.6, 1.3, 2.7], hand: left}}",
        "{at: 4.0, who: ada, do: {let_go: left}}",
        words=f"controller: {by}, at: [2, 2.5], heading_deg: 180",
        duration=7,
    )
    # Turned about it stands with its left at greater z.
    assert near(go(one, 2.2)[1], (0.4, 1.3, -0.2))
    # The right hand dances on meanwhile.
    assert near(go(one, 3.05)[0], (0.42, 1.5, 0.3))
    assert go(one, 5.6)[1, 1] < 0.9


@BOTH
def test_it_is_posed_and_released(by: str) -> None:
    pose = (
        "[{at: 1.5, limb: arm_l, reach: [0.4, 1.4, -0.3]}, "
        "{at: 2.5, joints: {shoulder_l_flexion_deg: 80, elbow_l_flexion_deg: 30, "
        "waist_flexion_deg: 12}}, {at: 3.5, release: arm_l}, {at: 3.5, release: trunk}]"
    )
    one = told(words=f"controller: {by}, pose: {pose}")
    assert near(go(one, 1.6)[1], (0.4, 1.4, -0.3))
    go(one, 2.9)
    dancing = ada(one)
    names = dancing.torso.names

    def angle(joint: str) -> float:
        return float(np.degrees(dancing.moving.q[names.index(joint)]))

    assert angle("shoulder_l_flexion") == pytest.approx(80, abs=5)
    assert angle("elbow_l_flexion") == pytest.approx(30, abs=5)
    assert angle("waist_flexion") == pytest.approx(12, abs=2)
    hand = go(one, 5.0)[1]
    assert hand[1] < 0.9
    assert abs(angle("waist_flexion")) < 2


def test_it_looks_at_a_place_and_at_its_hand_again() -> None:
    one = told(
        "{at: 0.5, who: ada, do: {look_at: [1, 1.5, -3]}}", "{at: 3.0, who: ada, do: {look: ahead}}"
    )
    neck = ada(one).torso.names.index("neck_rotation")
    go(one, 2.5)
    # To the left, where no hand is.
    assert ada(one).moving.q[neck] > 0.2
    go(one, 4.5)
    assert ada(one).moving.q[neck] < 0.1


def test_who_is_told_nothing_dances_as_ever() -> None:
    plain, told_late = told(), told("{at: 5.5, who: ada, do: stop}")
    apart = go(plain, 5.0) - go(told_late, 5.0)
    np.testing.assert_array_equal(apart, 0.0)


@pytest.mark.parametrize(
    ("script", "words", "path", "message"),
    [
        ("do: walk", "", "script[0].do", "'ada' is a dancer, who can dance, stop"),
        ("do: {go_to: [1, 1]}", "", "script[0].do.go_to", "'ada' is a dancer"),
        ("do: {dance: autt}", "", "script[0].do.dance", "no dance is called 'autt', known: "),
        ("do: {reach: tor}", "", "script[0].do.reach", "give the place of 'tor', [x, y, z]"),
        ("do: {reach: [3, 1, 0]}", "", "script[0].do.reach", "m from the shoulder"),
        ("do: {look_at: tor}", "", "script[0].do.look_at", "follows nobody"),
        (
            *("do: {dance: out, tempo_bpm: 100}", "beat: 1", "script[0].do.tempo_bpm"),
            "do not fit beat 1 of a score at 120",
        ),
        ("", "pose: [{at: 1, limb: leg_r, reach: [0, 1, 0]}]", "pose[0].limb", "only the arms"),
        ("", "pose: [{at: 1, release: arm_q}]", "pose[0].release", "did you mean 'arm_"),
        (
            *("", "pose: [{at: 1, joints: {elbow_flexion_deg: 3}}]"),
            *("pose[0].joints.elbow_flexion_deg", "did you mean 'elbow_"),
        ),
        (
            *(
                "",
                "pose: [{at: 1, limb: arm_r, reach: [0, 1, 0], joints: {elbow_l_flexion_deg: 3}}]",
            ),
            *("pose[0].joints.elbow_l_flexion_deg", "belongs to the other arm"),
        ),
        ("", "pose: [{at: 1, limb: arm_r, reach: [1, 1, 1]}]", "pose[0].reach", "the shoulder"),
        (
            "",
            "pose: [{at: 1, limb: arm_r, reach: [0.4, 1, 0], ease: in}]",
            "pose[0].ease",
            "remove",
        ),
    ],
)
def test_what_a_dancer_cannot_be_told_is_said(script, words, path, message) -> None:
    line = [f"{{at: 0.5, who: ada, {script}}}"] if script else []
    with pytest.raises(SceneError) as caught:
        told(*line, words=words)
    assert len(caught.value.problems) == 1, caught.value
    assert path in str(caught.value)
    assert message in str(caught.value)


def test_what_is_told_and_posed_is_written_out_and_read_again() -> None:
    text = SCENE.format(
        duration=4,
        words="beat: 2, pose: [{at: 1, limb: arm_r, reach: [0.4, 1.2, 0.2]}, "
        "{at: 2, joints: {elbow_l_flexion_deg: 40}}, {at: 3, release: arm_r}]",
        script="  - {at: 1, who: ada, do: {dance: out, bars: 1}}\n  - {at: 3, who: ada, do: stop}",
        more="sound: {tempo_bpm: 60}",
    )
    scene = read_scene(text)
    assert read_scene(dump(scene)) == scene


def test_others_do_not_dance() -> None:
    with pytest.raises(SceneError, match="is a creature; only a dancer can dance"):
        read_scene(
            "pronk: 1\nduration: 1\ncast: [{figure: beetle, name: a, walk: {}}]\n"
            "script: [{at: 0.5, who: a, do: dance}]\n"
        )


def test_two_dances_of_one_dancer_have_no_different_drums_of_one_name() -> None:
    more = "  other: {subtasks: [{touch: tom}], drums: {tom: {at: [0.4, 1, 0]}}}\n"
    text = SCENE.format(duration=2, words="gaze: true", script="SCRIPT", more="")
    text = text.replace("cast:\n", f"{more}cast:\n")
    lines = [
        f"  - {{at: {k}, who: ada, do: {{dance: {d}}}}}" for k, d in enumerate(("drum", "other"))
    ]
    with pytest.raises(SceneError, match="conflicts with the drum of 'drum'"):
        Simulation(read_scene(text.replace("SCRIPT", "\n".join(lines))))


def test_what_is_told_from_outside_goes_the_same_way_when_it_is_written_down() -> None:
    told_so = [(1.0, {"dance": "out", "bars": 1}), (3.5, "freeze"), (4.0, "dance"), (5.0, "stop")]
    text = SCENE.format(duration=6, words="start: 0", script="SCRIPT", more="")
    scene = read_scene(text.replace("SCRIPT", "  []"))
    one = Simulation(scene, directed=True)
    for at, do in told_so:
        go(one, at)
        one.add_instruction(instruction_of({"who": "ada", "do": do}, scene, at))
    lines = [f"  - {{at: {at}, who: ada, do: {json.dumps(do)}}}" for at, do in told_so]
    other = Simulation(read_scene(text.replace("SCRIPT", "\n".join(lines))))
    for simulation in (one, other):
        while not simulation.finished:
            simulation.step()
    np.testing.assert_array_equal(one.take().positions, other.take().positions)


def test_what_it_has_to_know_from_the_begin_is_refused_from_outside() -> None:
    scene = read_scene(SCENE.format(duration=6, words="start: 0", script="  []", more=""))
    one = Simulation(scene, directed=True)
    for do, message in (
        ({"reach": [0.4, 1.3, 0.2]}, "only reaches for places that the scene"),
        ({"dance": "drum"}, "the drums of 'drum' exist only if the scene's script names"),
    ):
        with pytest.raises(SceneError, match=message):
            one.add_instruction(instruction_of({"who": "ada", "do": do}, scene, 0.0))
    one.add_instruction(instruction_of({"who": "ada", "do": {"dance": "out"}}, scene, 0.0))
    assert near(go(one, 1.1)[0], (0.35, 1.4, 0.5))


def test_a_wait_within_some_bars_goes_on_with_them_and_then_back() -> None:
    one = told(
        "{at: 0.5, who: ada, do: {dance: out, bars: 1}}",
        "{at: 1.0, who: ada, do: {wait: 0.5}}",
        duration=8,
    )
    assert near(go(one, 2.55)[0], (0.35, 1.4, 0.5))
    assert near(go(one, 4.55)[0], (0.42, 1.5, 0.3))


@pytest.mark.nightly
@BOTH
@pytest.mark.parametrize("seed", range(4))
def test_whatever_is_told_it_stays_whole(by: str, seed: int) -> None:
    chance = np.random.default_rng(seed)
    said = [
        *("dance", "stop", "freeze", "let_go", "{wait: 0.4}", "{dance: out}", "{look: ahead}"),
        *("{dance: drum, bars: 1}", "{dance: up, tempo_bpm: 150}", "{look_at: [2, 1, 2]}"),
        *("{reach: [0.4, 1.5, 0.3]}", "{reach: [0.3, 1.2, 0.0], hand: both}", "{let_go: both}"),
    ]
    times = np.sort(chance.uniform(0, 8, 24)).round(2)
    script = [f"{{at: {at}, who: ada, do: {said[chance.integers(len(said))]}}}" for at in times]
    words = (
        f"controller: {by}, sway_deg: 4, pose: [{{at: 3, limb: arm_l, reach: [0.4, 1.2, -0.2]}}]"
    )
    one, deepest = told(*script, words=words, duration=9), 0.0
    limits = ada(one).torso.linkage.hinges
    while not one.finished:
        one.step()
        moving = ada(one).moving
        assert np.isfinite(moving.q).all()
        assert np.abs(moving.v).max() < 40
        for angle, hinge in zip(moving.q, limits, strict=True):
            assert hinge.lower - 0.1 < angle < hinge.upper + 0.1
        deepest = max([deepest, *(touch.depth for touch in moving.touches())])
    assert deepest < 0.02


@pytest.mark.slow
@BOTH
def test_shipped_dances_wave_and_applaud(by: str) -> None:
    one = told(
        "{at: 0.5, who: ada, do: {dance: waving, bars: 1}}",
        "{at: 3.6, who: ada, do: {dance: applauding, bars: 1}}",
        words=f"controller: {by}, bars: 1",
    )
    heights = []
    while not one.finished:
        one.step()
        heights.append(ada(one).moving.places[ada(one).arms[0].palm][1])
    # The hand goes up beside the head, and down again.
    assert max(heights[: round(3.0 * 96)]) > 1.6
    claps = [c for c in one.take().contacts if {c.part, c.other} == {"hand_r", "hand_l"}]
    times = np.array([(c.step + c.fraction) / 96 for c in claps])
    # From wherever its hands were, the first less exactly than those that follow.
    wanted = 4.0 + 0.4 * np.arange(4)
    assert len(times) == 4
    assert np.abs(times - wanted)[1:].max() < 1 / 24
