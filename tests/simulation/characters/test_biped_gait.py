"""Biped gait: planted feet, knees, elbows, and strides as measured of people."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from pipeline.simulation.characters import character_plans
from pipeline.simulation.characters.biped_gait import _step_progress
from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.gait_timing import duty_factor, stride_rate
from pipeline.simulation.characters.person_record import FOOT, HIP, KNEE, PERSON, STANCE, SWING
from pipeline.simulation.dynamics.compiled import Records, entry
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.people.proportions import ADULT, CHILD
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import build_ground
from pipeline.spec import read_scene
from tests.simulation.characters.character_yard import largest_joint_excess, leg_overlap
from tests.simulation.characters.scripted_people import (
    STEPS,
    Play,
    play_scene,
    spells,
    walk,
    walk_scene,
)

pytestmark = pytest.mark.slow

BODIES = {"adult": ADULT, "child": CHILD}

WALKS = [
    ("adult", 1.35, "flat"),
    pytest.param("adult", 0.6, "flat", marks=pytest.mark.slow),
    pytest.param("adult", 1.8, "flat", marks=pytest.mark.slow),
    pytest.param("adult", 3.2, "flat", marks=pytest.mark.slow),
    pytest.param("child", 1.0, "flat", marks=pytest.mark.slow),
    pytest.param("child", 2.2, "flat", marks=pytest.mark.nightly),
    pytest.param("adult", 1.2, "{preset: hills, height: 0.6}", marks=pytest.mark.slow),
    pytest.param("child", 0.9, "{preset: hills, height: 0.6}", marks=pytest.mark.nightly),
]


@entry
def strides_at(speed: float, leg: float) -> tuple[float, float]:
    """Return the stride rate and the duty factor."""
    return stride_rate(speed, leg), duty_factor(speed, leg)


ON_GROUND = 0.006
"""Height below which a point of a sole counts as standing [m]."""


def soles(play: Play, kind: str, side: str) -> list[Array]:
    """Return the positions of heel and ball (K, 3) in the skinned mesh [m]."""
    body = BODIES[kind]
    R, p = play.frames[f"a.foot_{side}"]
    length, ankle = body.foot * body.height, body.ankle * body.height
    return [p + R @ [x * length, -ankle, 0.0] for x in (-0.24, 0.48)]


@pytest.mark.sample(2)
@pytest.mark.parametrize(("kind", "speed", "terrain"), WALKS)
def test_stance_soles_slip_less_than_two_centimetres(kind: str, speed: float, terrain: str) -> None:
    play = walk(kind, speed, terrain)
    scene = read_scene("pronk: 1\n" + walk_scene(kind, speed, terrain))
    ground = build_ground(scene.terrain, scene.seed)
    stands = 0
    for side in "lr":
        for place in soles(play, kind, side):
            above = place[:, 1] - ground.height(place[:, 0], place[:, 2])
            assert above.min() > -0.02
            for first, last in spells(above < ON_GROUND):
                stood = place[first : last + 1]
                stands += last - first > 10
                slips = np.hypot(stood[:, 0] - stood[0, 0], stood[:, 2] - stood[0, 2])
                assert slips.max() < 0.02
    assert stands >= 6


@pytest.mark.parametrize(("kind", "speed", "terrain"), WALKS)
def test_knees_bend_forward_and_elbows_back(kind: str, speed: float, terrain: str) -> None:
    play = walk(kind, speed, terrain)
    for side in "lr":
        hip, knee, foot = (play.joint("a", f"{n}_{side}") for n in ("hip", "knee", "foot"))
        along = foot - hip
        along /= np.linalg.norm(along, axis=1)[:, None]
        off = knee - hip
        off = off - (off * along).sum(axis=1)[:, None] * along
        heading = play.records["heading"][:, 0]
        ahead = np.stack([np.cos(heading), 0 * heading, -np.sin(heading)], axis=1)
        # In front of the line from hip to foot, or on it.
        up = np.cross(np.stack([np.sin(heading), 0 * heading, np.cos(heading)], axis=1), along)
        assert ((off * up).sum(axis=1) > -1e-3).all()
        assert ((off * ahead).sum(axis=1) > -0.02).all()


def corners(kind: str, speed: float, turn_deg: float, every: float = 1.176) -> str:
    """Return the scene of a walker with new targets around sharp corners before arrival.

    Args:
        kind: of the person.
        speed: at which it goes [m/s].
        turn_deg: of each corner, to the left and to the right in turn.
        every: after which it is sent on [s].
    """
    legs, far, heading, x, z = 4, 1.2 * speed, 0.0, 0.0, 0.0
    scene = f"duration: {1.2 * legs + 2.0}\ncast: [{{name: a, character: {kind}, at: [0, 0]}}]\n"
    scene += f"script:\n  - {{at: 0, who: a, do: {{speed: {speed}}}}}\n"
    for k in range(legs):
        x, z = x + far * math.cos(heading), z - far * math.sin(heading)
        scene += f"  - {{at: {every * k:.3f}, who: a, do: {{go_to: [{x:.3f}, {z:.3f}]}}}}\n"
        heading += math.radians(turn_deg if k % 2 == 0 else -turn_deg)
    return scene


def depths_in_corners(kind: str, speed: float, turn_deg: float, every: float) -> Array:
    """Return (K,) the overlap of the legs of a walker around `corners` [m]."""
    deep: list[float] = []

    def look(troupe: Characters, _: int) -> None:
        deep.append(leg_overlap(troupe.arrays.nodes, troupe.arrays.links))

    play_scene(corners(kind, speed, turn_deg, every), look)
    return np.array(deep)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("kind", "speed", "turn_deg", "every"),
    [
        ("adult", 1.3, 60.0, 1.176),
        ("adult", 1.3, 180.0, 1.176),
        ("child", 1.7, 60.0, 1.176),
        ("child", 1.0, 180.0, 1.176),
        ("adult", 1.3, 140.0, 1.176),
        ("adult", 1.0, 140.0, 1.176),
        ("adult", 1.6, 140.0, 1.176),
        ("adult", 1.0, 140.0, 0.95),
        ("child", 1.4, 140.0, 1.176),
        ("child", 1.0, 120.0, 1.176),
        ("child", 1.7, 160.0, 1.05),
    ],
)
def test_legs_do_not_collide_on_zigzag_routes(
    kind: str, speed: float, turn_deg: float, every: float
) -> None:
    assert depths_in_corners(kind, speed, turn_deg, every).max() < 0.008


@pytest.mark.nightly
@pytest.mark.parametrize(("kind", "speed", "most"), [("adult", 1.3, 0.03), ("child", 1.2, 0.008)])
def test_legs_do_not_collide_for_a_turn_at_any_gait_phase(
    kind: str, speed: float, most: float
) -> None:
    """Thighs of an adult, 16 cm thick, press one another for a few hundredths of a second.

    A knee that swings is thrown forward past the other one quicker than it is turned outward.
    """
    for every in (0.8, 0.87, 0.92, 1.0, 1.08, 1.13, 1.25):
        deep = depths_in_corners(kind, speed, 150.0, every)
        assert deep.max() < most
        assert (deep > 0.008).sum() <= 0.06 * STEPS


@pytest.mark.parametrize(("kind", "speed"), [("adult", 1.0), ("adult", 1.3), ("adult", 1.6)])
def test_a_far_landing_place_in_a_turn_does_not_throw_the_body(kind: str, speed: float) -> None:
    """The pelvis tilts by 4 degrees in a walk, and by 30 in a fall to one side."""
    play = play_scene(corners(kind, speed, 160.0, 0.95))
    across = play.joint("a", "hip_r") - play.joint("a", "hip_l")
    lists = np.arcsin(across[:, 1] / np.linalg.norm(across, axis=1))
    assert np.abs(lists).max() < math.radians(9.0)


def knee_turn_speeds(play: Play, name: str, side: str) -> Array:
    """Return (K - 1,) the speeds at which a knee turns about the line from hip to foot [m/s]."""
    hip, knee, foot = (play.joint(name, f"{joint}_{side}") for joint in ("hip", "knee", "foot"))
    line = (foot - hip) / np.linalg.norm(foot - hip, axis=1, keepdims=True)
    off = knee - hip - ((knee - hip) * line).sum(axis=1, keepdims=True) * line
    radius = np.linalg.norm(off, axis=1)
    direction = off / np.maximum(radius, 1e-6)[:, None]
    cosine = np.clip((direction[1:] * direction[:-1]).sum(axis=1), -1.0, 1.0)
    speeds: Array = np.arccos(cosine) * 0.5 * (radius[1:] + radius[:-1]) * STEPS
    return speeds


@pytest.mark.parametrize(("kind", "speed"), [("child", 2.6), ("adult", 1.3)])
def test_knees_of_runners_and_turning_walkers_do_not_swivel(kind: str, speed: float) -> None:
    places = [(2.0, 0.3), (-1.0, 1.2), (-1.5, -1.0), (1.0, 0.5)]
    orders = "".join(
        f"  - {{at: {0.1 + 1.4 * k:.1f}, who: a, do: {{go_to: [{x}, {z}]}}}}\n"
        for k, (x, z) in enumerate(places)
    )
    play = play_scene(
        f"duration: 6\ncast: [{{name: a, character: {kind}, at: [-2, 0]}}]\n"
        f"script:\n  - {{at: 0, who: a, do: {{speed: {speed}}}}}\n{orders}"
    )
    moved = np.linalg.norm(np.diff(play.joint("a", "pelvis"), axis=0), axis=1).max() * STEPS
    assert moved > 0.7 * speed
    assert max(knee_turn_speeds(play, "a", side).max() for side in "lr") < 2.0


def test_a_knee_that_has_made_room_comes_back_slowly() -> None:
    """It would jerk inward once the other one is past."""
    play = play_scene(corners("adult", 1.0, 140.0))
    targets, heading = play.records["targets"][:, 0], play.records["heading"][:, 0]
    right = np.stack([np.sin(heading), 0.0 * heading, np.cos(heading)], axis=1)
    for k, side in enumerate((-1.0, 1.0)):
        hip, knee, foot = targets[:, HIP + k], targets[:, KNEE + k], targets[:, FOOT + k]
        line = (foot - hip) / np.linalg.norm(foot - hip, axis=1, keepdims=True)
        off = knee - hip - ((knee - hip) * line).sum(axis=1, keepdims=True) * line
        outward = side * (right - (right * line).sum(axis=1, keepdims=True) * line)
        sine = (off * outward).sum(axis=1)
        sine /= np.linalg.norm(off, axis=1) * np.linalg.norm(outward, axis=1)
        turn = np.arcsin(np.clip(sine, -1.0, 1.0))
        assert turn.max() > math.radians(20.0)
        assert np.diff(turn).min() * STEPS > -5.0


def test_a_foot_that_is_left_behind_starts_its_swing_from_rest() -> None:
    """The clock that hurries to its turn would start it in mid-swing, with a jerk."""
    pushes = np.array([[1.2, 0.0], [-1.2, 0.0], [0.0, 1.2], [-1.0, 0.4], [1.4, -0.6], [-0.9, 0.9]])

    def shove(troupe: Characters, step: int) -> None:
        nodes, persons, dt = troupe.arrays.nodes, troupe.persons, troupe.world.clock.dt
        for k, first in enumerate(persons["node"]):
            if step == 48 + 3 * k:
                persons["velocity"][k], persons["stun"][k] = pushes[k], 0.6
                own = slice(first, first + 16)
                nodes["previous"][own, 0] -= pushes[k, 0] * dt / troupe.count
                nodes["previous"][own, 2] -= pushes[k, 1] * dt / troupe.count

    cast = "".join(
        f"  - {{name: p{k}, character: child, at: [0, {4 * k - 10}]}}\n" for k in range(len(pushes))
    )
    play = play_scene(f"duration: 2\ncast:\n{cast}", shove)
    hurried = 0
    for k in range(len(pushes)):
        state, phase = play.records["foot_state"][:, k], play.records["phase"][:, k]
        turned = np.diff(phase) % 1.0
        hurried += int(((turned > 0.04) & (turned < 0.2)).sum())
        for side in range(2):
            lifts = (state[1:, side] == SWING) & (state[:-1, side] == STANCE)
            assert np.all((phase[1:][lifts] + 0.5 * side) % 1.0 < 0.025)
    assert hurried > 0


def test_joints_never_bend_backwards() -> None:
    from tests.simulation.characters.scripted_people import play_scene

    seen = []
    play_scene(
        walk_scene("adult", 1.35),
        lambda troupe, _: seen.append(
            largest_joint_excess(troupe.arrays.nodes, troupe.arrays.limbs)
        ),
    )
    assert max(seen) < 0.02


@pytest.mark.parametrize(("kind", "speed", "terrain"), WALKS)
def test_elbows_swing_smoothly(kind: str, speed: float, terrain: str) -> None:
    """A human elbow goes through some 15 to 30 degrees and back once a stride.

    The bound is the jerk, over differences of three rows, of a wiggle of three degrees at 8 Hz: a
    swing of 15 degrees at a stride a second has a hundredth of it, and the rest is what a foot
    shakes that leaves the ground.
    """
    play = walk(kind, speed, terrain)
    bound = math.radians(3.0) * (2.0 * math.sin(math.pi * 8.0 / 32.0)) ** 3 * 32.0**3
    for side in "lr":
        upper = play.joint("a", f"elbow_{side}") - play.joint("a", f"shoulder_{side}")
        lower = play.joint("a", f"hand_{side}") - play.joint("a", f"elbow_{side}")
        across = np.linalg.norm(np.cross(upper, lower), axis=1)
        angle = np.arctan2(across, (upper * lower).sum(axis=1))
        every = angle[:: STEPS // 32]
        jerk = np.abs(np.diff(every, 3)) * 32.0**3
        assert jerk.max() < bound
        assert np.ptp(angle[STEPS:-STEPS]) > math.radians(4.0)


def test_step_rate_matches_measured_walking() -> None:
    # 115 steps a minute at 1.4 m/s; children of six take 140 at 1.0 m/s.
    assert 120.0 * strides_at(1.4, ADULT.hip * ADULT.height)[0] == pytest.approx(115.0, abs=2.0)
    assert 120.0 * strides_at(1.0, CHILD.hip * CHILD.height)[0] == pytest.approx(140.0, abs=5.0)
    play = walk("adult", 1.35)
    falls = [(c.step + c.fraction) / STEPS for c in play.contacts if c.kind == "touch"]
    middle = np.diff(falls[2:-3])
    expected = 1.0 / (2.0 * strides_at(1.35, ADULT.hip * ADULT.height)[0])
    np.testing.assert_allclose(middle, expected, rtol=0.06)


@pytest.mark.parametrize(("speed", "flies"), [(1.35, False), (3.2, True)])
@pytest.mark.slow
def test_walkers_always_have_stance_and_runners_have_flight(speed: float, flies: bool) -> None:
    play = walk("adult", speed, "flat", 9.0 if flies else 4.0)
    doing = play.records["foot_state"][:, 0]
    going = np.hypot(*play.records["velocity"][:, 0].T) > 0.85 * speed
    assert going.sum() > 20
    assert bool((doing[going] == 1).all(axis=1).any()) == flies
    assert (strides_at(speed, ADULT.hip * ADULT.height)[1] < 0.5) == flies


def test_arms_swing_against_legs_and_the_pelvis_bobs() -> None:
    play = walk("adult", 1.35)
    going = np.hypot(*play.records["velocity"][:, 0].T) > 1.25
    for arm, leg in (("l", "r"), ("r", "l")):
        pelvis = play.joint("a", "pelvis")[going, 0]
        hand = play.joint("a", f"hand_{arm}")[going, 0] - pelvis
        foot = play.joint("a", f"foot_{leg}")[going, 0] - pelvis
        assert np.corrcoef(hand, foot)[0, 1] > 0.7
    height = play.joint("a", "pelvis")[going, 1]
    assert 0.015 < np.ptp(height) < 0.07


def test_an_arriving_walker_closes_the_feet() -> None:
    play = walk("adult", 1.35)
    assert len(play.when("a")) == 1
    end = play.p[-1]
    feet = np.array([play.joint("a", f"foot_{side}")[-1] for side in "lr"])
    assert np.hypot(*(end[0] - [2.0, 0.0, 0.3])[[0, 2]]) < 0.12
    assert abs(feet[0, 0] - feet[1, 0]) < 0.06
    assert 0.12 < feet[1, 2] - feet[0, 2] < 0.26
    speed = np.abs(play.joint("a", "pelvis")[-1] - play.joint("a", "pelvis")[-12]) * 8.0
    assert speed.max() < 0.01


def test_footfalls_are_contacts_with_the_ground() -> None:
    play = walk("adult", 1.35)
    falls = [c for c in play.contacts if c.kind == "touch"]
    assert {c.part for c in falls} == {"a.foot_l", "a.foot_r"}
    assert {c.other for c in falls} == {"terrain"}
    sides = [c.part[-1] for c in falls]
    assert all(a != b for a, b in pairwise(sides))
    assert all(abs(c.place[1]) < 1e-6 and 0.05 < c.speed < 2.0 and c.energy > 0.0 for c in falls)
    assert not [c for c in play.contacts if c.other == "terrain" and c.kind != "touch"]


def zigzag(kind: str, speed: float, seed: int) -> tuple[float, float]:
    """Turn a person in mid-step, for 8 s.

    Returns:
        Its greatest pain, and how fast its fastest node was [m/s].
    """
    rng, heading = np.random.Generator(np.random.PCG64(seed)), 0.0
    pain, fastest = 0.0, 0.0

    def turn(troupe: Characters, step: int) -> None:
        nonlocal heading, pain, fastest
        me = troupe.persons[0]
        if step % (STEPS // 2) == 0:
            heading = float(me.heading) + math.radians(float(rng.uniform(-90.0, 90.0)))
            if math.hypot(*me.at) > 7.0:
                heading = math.atan2(me.at[1], -me.at[0])
        me.pace = speed
        troupe.dispatcher.controllers[0].go(
            me.at[0] + 5.0 * math.cos(heading), me.at[1] - 5.0 * math.sin(heading)
        )
        pain = max(pain, float(troupe.arrays.owners["pain"][0]))
        gone = np.abs(troupe.arrays.p - troupe.arrays.previous).max()
        fastest = max(fastest, float(gone) * troupe.count * STEPS)

    terrain = "{kind: flat, size: [24, 24]}"
    play_scene(f"duration: 8\nterrain: {terrain}\ncast: [{{name: a, character: {kind}}}]\n", turn)
    return pain, fastest


TURNS = [
    ("child", 1.5, 0),
    pytest.param("child", 0.8, 1, marks=pytest.mark.slow),
    pytest.param("child", 2.2, 2, marks=pytest.mark.slow),
    pytest.param("adult", 1.1, 0, marks=pytest.mark.slow),
]


@pytest.mark.nightly
@pytest.mark.parametrize(("kind", "speed", "seed"), TURNS)
def test_turning_in_mid_step_does_not_trip(kind: str, speed: float, seed: int) -> None:
    pain, fastest = zigzag(kind, speed, seed)
    assert pain == 0.0
    # Feet and hands swing at a few times the running speed.
    assert fastest < 5.0 * speed + 5.0


@pytest.mark.nightly
@pytest.mark.parametrize(("kind", "speed", "seed"), TURNS)
def test_a_stopped_foot_is_not_pulled_to_its_target_at_once(
    kind: str, speed: float, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The own legs are the nearest obstacles if they may collide.
    meetings = (*character_plans.TOUCHING_LINKS, *character_plans.TOUCHING_LEGS)
    monkeypatch.setattr("pipeline.simulation.characters.character_plans.TOUCHING_LINKS", meetings)
    pain, fastest = zigzag(kind, speed, seed)
    assert pain < 2.0
    assert fastest < 5.0 * speed + 9.0


@entry
def way_of_foot(persons: Records, u: float) -> tuple[float, float]:
    """Return the fractions of the way ahead and of the rise of the left foot of a person."""
    return _step_progress(persons[0], 0, u)


@pytest.mark.parametrize("rise", [0.4, 0.0, -0.4])
def test_a_foot_goes_up_before_ahead_and_ahead_before_down(rise: float) -> None:
    person = zero_records(1, PERSON)
    person["hip_height"], person["swing_end"] = 0.5, rise * 0.5
    person["step_rise"] = abs(rise) * 0.5
    ways = [way_of_foot(person, u) for u in (0.0, 0.25, 0.5, 0.75, 1.0)]
    assert ways[0] == pytest.approx((0.0, 0.0))
    assert ways[-1] == pytest.approx((1.0, 1.0))
    leads = [up - ahead for ahead, up in ways[1:-1]]
    assert all(np.sign(lead) == np.sign(rise) for lead in leads)
    assert max(map(abs, leads)) >= 0.3 * abs(rise)


@pytest.mark.parametrize("rise", [0.4, -0.4])
def test_along_a_slope_a_foot_goes_straight(rise: float) -> None:
    """Held up until it is ahead, it would be drawn up to the hip where there is no edge."""
    person = zero_records(1, PERSON)
    person["hip_height"], person["swing_end"] = 0.5, rise * 0.5
    for u in (0.25, 0.5, 0.75):
        ahead, up = way_of_foot(person, u)
        assert ahead == pytest.approx(up)


def test_rounded_hills_have_no_high_steps() -> None:
    """Where it lands in a hollow, the ground is level and yet lower than where it lifted off."""
    play = play_scene(
        "duration: 6\nterrain: {kind: hills, height: 1.1, spacing: 6}\n"
        "cast: [{name: a, character: child, scale: 0.9, at: [4, -3], heading_deg: 140}]\n"
        "script:\n  - {at: 0, who: a, do: {speed: 2.2}}\n"
        "  - {at: 0, who: a, do: {go_to: [-5, 4]}}\n"
    )
    rise = np.abs(play.records["swing_end"] - play.records["liftoff_place"][..., 1])[:, 0]
    leg = play.records["hip_height"][0, 0]
    assert rise.max() > 0.2 * leg
    assert play.records["slowing"].max() < 0.3


def test_hurried_climbers_take_stairs_one_by_one() -> None:
    """Three or four at once, as fit into their stride, would fold the leg up to the hip."""
    play = play_scene(
        "duration: 7\nterrain: {kind: stairs, steps: 6, step_height: 0.17, step_depth: 0.32, "
        "start: 0.5, size: [20, 12]}\n"
        "cast: [{name: a, character: adult, at: [-2.5, 1.2], scale: 0.9}]\n"
        "script:\n  - {at: 0, who: a, do: {speed: 1.9}}\n"
        "  - {at: 0, who: a, do: {go_to: [8, 1.8]}}\n"
    )
    stood = play.records["stance_place"][:, 0, :, 1]
    assert stood.max() > 0.9
    assert np.abs(stood[:, 0] - stood[:, 1]).max() < 1.5 * 0.17


def test_a_person_that_kicks_stays_upright() -> None:
    """A kicking foot has still the landing place of its last step, and does not land there."""
    play = play_scene(
        "duration: 5\ncast:\n  - {name: ball, character: ball, at: [2, 1]}\n"
        "  - {name: a, character: child, at: [2.5, 3]}\n"
        "script:\n  - {at: 0, who: a, do: {kick: ball}}\n"
    )
    kicks = play.records["kick_foot"][:, 0] >= 0
    assert kicks.sum() > 0.3 * STEPS
    assert play.records["pelvis_drop"][kicks].max() < 0.05
    moved = play.records["kick_velocity"][kicks, 0]
    # Nowhere on its way it turns at a corner.
    assert np.linalg.norm(np.diff(moved, axis=0), axis=1).max() < 2.0
