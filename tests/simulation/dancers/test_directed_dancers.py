"""Dancers with script orders and poses."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.dancers.dancer_motion import DancerMotion
from pipeline.simulation.dancers.dancer_troupe import DancerTroupe
from pipeline.simulation.expressions import AT_EASE
from pipeline.simulation.face_units import UNITS
from pipeline.simulation.simulate import Simulation, simulate
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
  - {{name: ada, dancer: torso, dance: up, {config}}}
  - {{name: tor, prop: {{shape: box}}, at: [3, 3]}}
script:
{script}
"""

EACH_CONTROLLER = pytest.mark.parametrize("by", ["force-field", "joint-torque"])


def build_simulation(
    *script: str, config: str = "", duration: float = 6.0, more: str = ""
) -> Simulation:
    lines = "\n".join(f"  - {line}" for line in script) or "  []"
    if "beat:" not in config:
        config = f"start: 0, {config}"
    return Simulation(
        read_scene(SCENE.format(duration=duration, config=config, script=lines, more=more))
    )


def ada(simulation: Simulation) -> DancerMotion:
    troupe = next(t for t in simulation.troupes if isinstance(t, DancerTroupe))
    return troupe.dancing[0]


def run_until(simulation: Simulation, until: float) -> np.ndarray:
    """Runs until a time, and returns the positions (2, 3) of both palms [m]."""
    dancer = ada(simulation)
    while dancer.now < until - 1e-6:
        simulation.step()
    return np.array(dancer.moving.places[[arm.palm for arm in dancer.arms]])


def is_close(
    place: np.ndarray, target: tuple[float, float, float], tolerance: float = 0.03
) -> bool:
    return bool(np.linalg.norm(place - target) < tolerance)


@EACH_CONTROLLER
def test_stop_hangs_arms_and_dance_resumes(by: str) -> None:
    config = f"controller: {by}"
    simulation = build_simulation(
        "{at: 1.5, who: ada, do: stop}", "{at: 3.5, who: ada, do: dance}", config=config
    )
    assert is_close(run_until(simulation, 1.1)[0], (0.42, 1.5, 0.3))
    for now in (2.9, 3.4):
        # The hand stays beside the thigh.
        hand = run_until(simulation, now)[0]
        assert hand[1] < 0.9
        assert abs(hand[0]) < 0.2
    assert is_close(run_until(simulation, 4.6)[0], (0.42, 1.5, 0.3))
    assert is_close(run_until(simulation, 5.6)[0], (0.42, 1.2, 0.3))


@EACH_CONTROLLER
def test_frozen_dancer_stands_still(by: str) -> None:
    simulation = build_simulation("{at: 0.6, who: ada, do: freeze}", config=f"controller: {by}")
    start = run_until(simulation, 0.6)
    assert not is_close(start[0], (0.42, 1.5, 0.3), 0.1)
    still = run_until(simulation, 1.2)
    # The hands stop within a hand's breadth.
    assert np.linalg.norm(still - start, axis=1).max() < 0.12
    assert np.linalg.norm(run_until(simulation, 3.0) - still, axis=1).max() < 0.005


@EACH_CONTROLLER
def test_ordered_bar_is_followed_by_the_own_dance(by: str) -> None:
    simulation = build_simulation(
        "{at: 2.0, who: ada, do: {dance: out, bars: 1}}", config=f"controller: {by}"
    )
    assert is_close(run_until(simulation, 1.1)[0], (0.42, 1.5, 0.3))
    assert is_close(run_until(simulation, 3.1)[0], (0.35, 1.4, 0.5))
    assert is_close(run_until(simulation, 4.1)[1], (0.35, 1.4, -0.5))
    assert is_close(run_until(simulation, 5.1)[0], (0.42, 1.5, 0.3))


def test_arrived_signal_follows_the_last_bar() -> None:
    simulation = build_simulation(
        "{at: 1.0, who: ada, do: {dance: out, bars: 1, tempo_bpm: 120}}",
        "{when: {arrived: ada}, who: ada, do: stop}",
    )
    signals = []
    while not simulation.finished:
        simulation.step()
        signals += [
            (h.kind, round(ada(simulation).now, 2)) for h in simulation.signals if h.who == "ada"
        ]
    assert signals == [("arrived", 2.0)]
    assert run_until(simulation, 6.0)[0, 1] < 0.9


@pytest.mark.slow
def test_touch_of_other_performers_triggers_dance() -> None:
    text = SCENE.format(duration=6, config="start: 0, bars: 1", script="SCRIPT", more="")
    others = (
        "  - {name: ball, character: ball, at: [3, 3], velocity: [1, 0, 0]}\n"
        "  - {name: wall, character: box, at: [4.2, 3]}\n"
    )
    when = "  - {when: {touch: [ball, wall]}, who: ada, do: {dance: out}}"
    text = text.replace("script:\n", f"{others}script:\n").replace("SCRIPT", when)
    simulation = Simulation(read_scene(text))
    met = None
    while not simulation.finished:
        simulation.step()
        if met is None and any(h.kind == "touch" for h in simulation.signals):
            met = ada(simulation).now
            first = [move.land for move in ada(simulation).moves[0]]
    assert met is not None
    assert min(abs(land - met - 1.0) for land in [m.land for m in ada(simulation).moves[0]]) < 0.05
    assert met + 1.0 not in first
    assert is_close(run_until(simulation, 6.0)[1], (0.35, 1.4, -0.5))


@pytest.mark.nightly
def test_characters_collide_with_dancer() -> None:
    text = SCENE.format(duration=4, config="start: 0, bars: 1", script="SCRIPT", more="")
    others = (
        "  - {name: ball, character: ball, at: [1.2, 1.0, 0.02], velocity: [-2.5, 1, 0]}\n"
        "  - {name: kid, character: child, at: [-1.4, 0]}\n"
    )
    script = (
        "  - {when: {touch: [ball, ada]}, who: ada, do: {dance: out}}\n"
        "  - {at: 0.1, who: kid, do: walk}\n"
    )
    text = text.replace("script:\n", f"{others}script:\n").replace("SCRIPT", script)
    simulation = Simulation(read_scene(text))
    met = None
    while not simulation.finished:
        simulation.step()
        if met is None and any({h.who, h.other} == {"ball", "ada"} for h in simulation.signals):
            met = ada(simulation).now
    assert met is not None
    assert 0.3 < met < 0.6
    assert is_close(run_until(simulation, 4.0)[1], (0.35, 1.4, -0.5))
    take = simulation.take()
    names = [node.name for node in take.nodes]
    # The ball bounces off; the child does not walk through the dancer.
    ball, kid = (take.positions[:, names.index(name)] for name in (ball_node(names), "kid.pelvis"))
    assert ball[-1, 0] > 0.5
    assert kid[:, 0].max() < -0.15


def ball_node(names: list[str]) -> str:
    return next(name for name in names if name.startswith("ball"))


@EACH_CONTROLLER
def test_ordered_dance_strikes_on_beats(by: str) -> None:
    simulation = build_simulation(
        "{at: 1.5, who: ada, do: {dance: drum}}", config=f"controller: {by}", duration=5
    )
    while not simulation.finished:
        simulation.step()
    blows = [
        (c.step + c.fraction) / 96
        for c in simulation.take().contacts
        if (c.performer, c.other) == ("ada", "tom")
    ]
    # The first strike takes 0.8 beats of half a second; its start is not practised.
    blows = [blow for blow in blows if blow > 1.6]
    wanted = [1.9 + 0.5 * k for k in range(6)]
    late = np.array(blows[: len(wanted)]) - wanted
    assert abs(late[0]) < 0.1
    assert np.abs(late[1:]).max() < 1 / 24


def test_locked_dancer_changes_dance_on_beats() -> None:
    simulation = build_simulation(
        "{at: 1.3, who: ada, do: {dance: out}}",
        config="beat: 1",
        more="sound: {tempo_bpm: 60}",
    )
    run_until(simulation, 1.6)
    moves = ada(simulation).moves[0]
    assert moves[-1].land == pytest.approx(round(moves[-1].land))


@EACH_CONTROLLER
def test_wait_pauses_and_resumes_the_dance(by: str) -> None:
    simulation = build_simulation(
        "{at: 1.2, who: ada, do: {wait: 1.5}}", config=f"controller: {by}"
    )
    still = run_until(simulation, 1.6)
    assert np.linalg.norm(run_until(simulation, 2.6) - still, axis=1).max() < 0.01
    assert is_close(run_until(simulation, 3.8)[0], (0.42, 1.5, 0.3))


@EACH_CONTROLLER
def test_ordered_hand_reaches_its_place_until_let_go(by: str) -> None:
    simulation = build_simulation(
        "{at: 1.0, who: ada, do: {reach: [1.6, 1.3, 2.7], hand: left}}",
        "{at: 4.0, who: ada, do: {let_go: left}}",
        config=f"controller: {by}, at: [2, 2.5], heading_deg: 180",
        duration=7,
    )
    # Turned by 180 degrees: the left side is at greater z.
    assert is_close(run_until(simulation, 2.2)[1], (0.4, 1.3, -0.2))
    # The right hand dances on meanwhile.
    assert is_close(run_until(simulation, 3.05)[0], (0.42, 1.5, 0.3))
    assert run_until(simulation, 5.6)[1, 1] < 0.9


@EACH_CONTROLLER
@pytest.mark.parametrize("place", ["shelf", "[0.4, 1.3, 0.35]"])
def test_ordered_hand_is_at_its_place_when_the_order_is_done(by: str, place: str) -> None:
    order = f"{{at: 1, who: ada, do: {{reach: {place}}}}}"
    more = "places: {shelf: [0.4, 1.3, 0.35]}"
    simulation = build_simulation(order, config=f"controller: {by}", duration=4.0, more=more)
    while not (ended := simulation.order_log.ended):
        simulation.step()
    assert [record.outcome for record in ended] == ["done"]
    assert is_close(run_until(simulation, ada(simulation).now)[0], (0.4, 1.3, 0.35), 0.06)


@EACH_CONTROLLER
def test_posed_joint_holds_its_angle_until_released(by: str) -> None:
    pose = (
        "[{at: 1.5, limb: arm_l, reach: [0.4, 1.4, -0.3]}, "
        "{at: 2.5, joints: {shoulder_l_flexion_deg: 80, elbow_l_flexion_deg: 30, "
        "waist_flexion_deg: 12}}, {at: 3.5, release: arm_l}, {at: 3.5, release: trunk}]"
    )
    simulation = build_simulation(config=f"controller: {by}, pose: {pose}")
    assert is_close(run_until(simulation, 1.6)[1], (0.4, 1.4, -0.3))
    run_until(simulation, 2.9)
    dancing = ada(simulation)
    names = dancing.torso.names

    def angle(joint: str) -> float:
        return float(np.degrees(dancing.moving.q[names.index(joint)]))

    assert angle("shoulder_l_flexion") == pytest.approx(80, abs=5)
    assert angle("elbow_l_flexion") == pytest.approx(30, abs=5)
    assert angle("waist_flexion") == pytest.approx(12, abs=2)
    hand = run_until(simulation, 5.0)[1]
    assert hand[1] < 0.9
    assert abs(angle("waist_flexion")) < 2


def test_head_turns_to_an_ordered_place_and_back() -> None:
    simulation = build_simulation(
        "{at: 0.5, who: ada, do: {look_at: [1, 1.5, -3]}}", "{at: 3.0, who: ada, do: {look: ahead}}"
    )
    neck = ada(simulation).torso.names.index("neck_rotation")
    run_until(simulation, 2.5)
    # To the left, away from the hands.
    assert ada(simulation).moving.q[neck] > 0.2
    run_until(simulation, 4.5)
    assert ada(simulation).moving.q[neck] < 0.1


@pytest.mark.nightly
def test_later_order_does_not_change_earlier_motion() -> None:
    plain, late_order = build_simulation(), build_simulation("{at: 5.5, who: ada, do: stop}")
    apart = run_until(plain, 5.0) - run_until(late_order, 5.0)
    np.testing.assert_array_equal(apart, 0.0)


@pytest.mark.parametrize(
    ("script", "config", "path", "message"),
    [
        (
            "do: walk",
            "",
            "script[0].do",
            "'ada' is a dancer, for which walk is no order; write look_at",
        ),
        ("do: {go_to: [1, 1]}", "", "script[0].do.go_to", "'ada' is a dancer"),
        ("do: {dance: autt}", "", "script[0].do.dance", "no dance is called 'autt', "),
        ("do: {reach: tor}", "", "script[0].do.reach", "give the place of 'tor', [x, y, z]"),
        ("do: {reach: [3, 1, 0]}", "", "script[0].do.reach", "m from the shoulder"),
        ("do: {look_at: toro}", "", "script[0].do.look_at", "toro"),
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
def test_invalid_order_or_pose_is_refused(script, config, path, message) -> None:
    line = [f"{{at: 0.5, who: ada, {script}}}"] if script else []
    with pytest.raises(SceneError) as caught:
        build_simulation(*line, config=config)
    assert len(caught.value.problems) == 1, caught.value
    assert path in str(caught.value)
    assert message in str(caught.value)


def test_script_and_pose_round_trip() -> None:
    text = SCENE.format(
        duration=4,
        config="beat: 2, pose: [{at: 1, limb: arm_r, reach: [0.4, 1.2, 0.2]}, "
        "{at: 2, joints: {elbow_l_flexion_deg: 40}}, {at: 3, release: arm_r}]",
        script="  - {at: 1, who: ada, do: {dance: out, bars: 1}}\n  - {at: 3, who: ada, do: stop}",
        more="sound: {tempo_bpm: 60}",
    )
    scene = read_scene(text)
    assert read_scene(dump(scene)) == scene


def test_dance_order_needs_dancer() -> None:
    message = "'a' is a beetle, and dances are for the trunk and arms of a person"
    with pytest.raises(SceneError, match=message):
        read_scene(
            "pronk: 1\nduration: 1\ncast: [{figure: beetle, name: a, walk: {}}]\n"
            "script: [{at: 0.5, who: a, do: dance}]\n"
        )


def test_conflicting_drums_of_two_dances_are_refused() -> None:
    more = "  other: {subtasks: [{touch: tom}], drums: {tom: {at: [0.4, 1, 0]}}}\n"
    text = SCENE.format(duration=2, config="gaze: true", script="SCRIPT", more="")
    text = text.replace("cast:\n", f"{more}cast:\n")
    lines = [
        f"  - {{at: {k}, who: ada, do: {{dance: {d}}}}}" for k, d in enumerate(("drum", "other"))
    ]
    with pytest.raises(SceneError, match="conflicts with the drum of 'drum'"):
        Simulation(read_scene(text.replace("SCRIPT", "\n".join(lines))))


def test_live_orders_equal_script() -> None:
    orders = [(1.0, {"dance": "out", "bars": 1}), (3.5, "freeze"), (4.0, "dance"), (5.0, "stop")]
    text = SCENE.format(duration=6, config="start: 0", script="SCRIPT", more="")
    scene = read_scene(text.replace("SCRIPT", "  []"))
    simulation = Simulation(scene, directed=True)
    for at, do in orders:
        run_until(simulation, at)
        simulation.add_instruction(instruction_of({"who": "ada", "do": do}, scene, at))
    lines = [f"  - {{at: {at}, who: ada, do: {json.dumps(do)}}}" for at, do in orders]
    other = Simulation(read_scene(text.replace("SCRIPT", "\n".join(lines))))
    for run in (simulation, other):
        while not run.finished:
            run.step()
    np.testing.assert_array_equal(simulation.take().positions, other.take().positions)


def test_live_order_needing_new_drums_or_places_is_refused() -> None:
    scene = read_scene(SCENE.format(duration=6, config="start: 0", script="  []", more=""))
    simulation = Simulation(scene, directed=True)
    for do, message in (
        ({"reach": [0.4, 1.3, 0.2]}, "only reaches for places that the scene"),
        ({"dance": "drum"}, "the drums of 'drum' exist only if the scene's script names"),
    ):
        with pytest.raises(SceneError, match=message):
            simulation.add_instruction(instruction_of({"who": "ada", "do": do}, scene, 0.0))
    simulation.add_instruction(instruction_of({"who": "ada", "do": {"dance": "out"}}, scene, 0.0))
    assert is_close(run_until(simulation, 1.1)[0], (0.35, 1.4, 0.5))


def test_wait_within_bars_resumes_them() -> None:
    simulation = build_simulation(
        "{at: 0.5, who: ada, do: {dance: out, bars: 1}}",
        "{at: 1.0, who: ada, do: {wait: 0.5}}",
        duration=8,
    )
    assert is_close(run_until(simulation, 2.55)[0], (0.35, 1.4, 0.5))
    assert is_close(run_until(simulation, 4.55)[0], (0.42, 1.5, 0.3))


@pytest.mark.nightly
@EACH_CONTROLLER
@pytest.mark.parametrize("seed", range(4))
def test_random_orders_keep_limits(by: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    orders = [
        *("dance", "stop", "freeze", "let_go", "{wait: 0.4}", "{dance: out}", "{look: ahead}"),
        *("{dance: drum, bars: 1}", "{dance: up, tempo_bpm: 150}", "{look_at: [2, 1, 2]}"),
        *("{reach: [0.4, 1.5, 0.3]}", "{reach: [0.3, 1.2, 0.0], hand: both}", "{let_go: both}"),
    ]
    times = np.sort(rng.uniform(0, 8, 24)).round(2)
    script = [f"{{at: {at}, who: ada, do: {orders[rng.integers(len(orders))]}}}" for at in times]
    config = (
        f"controller: {by}, sway_deg: 4, pose: [{{at: 3, limb: arm_l, reach: [0.4, 1.2, -0.2]}}]"
    )
    simulation, deepest = build_simulation(*script, config=config, duration=9), 0.0
    limits = ada(simulation).torso.linkage.hinges
    while not simulation.finished:
        simulation.step()
        moving = ada(simulation).moving
        assert np.isfinite(moving.q).all()
        assert np.abs(moving.v).max() < 40
        for angle, hinge in zip(moving.q, limits, strict=True):
            assert hinge.lower - 0.1 < angle < hinge.upper + 0.1
        deepest = max([deepest, *(touch.depth for touch in moving.touches())])
    assert deepest < 0.02


@pytest.mark.nightly
@EACH_CONTROLLER
def test_waving_raises_the_hand_and_applauding_claps(by: str) -> None:
    simulation = build_simulation(
        "{at: 0.5, who: ada, do: {dance: waving, bars: 1}}",
        "{at: 3.6, who: ada, do: {dance: applauding, bars: 1}}",
        config=f"controller: {by}, bars: 1",
    )
    heights = []
    while not simulation.finished:
        simulation.step()
        heights.append(ada(simulation).moving.places[ada(simulation).arms[0].palm][1])
    # The hand rises beside the head.
    assert max(heights[: round(3.0 * 96)]) > 1.6
    claps = [c for c in simulation.take().contacts if {c.part, c.other} == {"hand_r", "hand_l"}]
    times = np.array([(c.step + c.fraction) / 96 for c in claps])
    # The first clap starts anywhere and is less exact.
    wanted = 4.0 + 0.4 * np.arange(4)
    assert len(times) == 4
    assert np.abs(times - wanted)[1:].max() < 1 / 24


def test_dancers_show_joy_while_they_dance_and_what_they_are_told() -> None:
    smile = UNITS.index("smile")
    text = SCENE.format(
        duration=6,
        more="",
        config="start: 0",
        script="  - {at: 2, who: ada, do: {express: joy}}\n"
        "  - {at: 4, who: ada, do: {express: own}}\n  - {at: 4, who: ada, do: stop}",
    )
    take = simulate(read_scene(text))
    rows = (np.array([1.9, 3.9, 6.0]) / 6.0 * (len(take.expressions) - 1)).astype(int)
    shown = take.expressions[rows, 0, smile]
    np.testing.assert_allclose(shown, [0.5, 1.0, AT_EASE[smile]], atol=0.03)
