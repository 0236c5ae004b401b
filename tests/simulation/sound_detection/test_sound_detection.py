"""Sound events of contacts, motions and signals: causes, onsets, courses, and silence at rest."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.event_detection import sound_sources
from pipeline.simulation.scheduler import BatchLimits
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.sound_detection.active_intervals import ActiveInterval, IntervalTracker
from pipeline.simulation.sound_detection.contact_sounds import CONTACT_CAUSES
from pipeline.simulation.sound_detection.motion_sounds import MOTION_CAUSES, MotionSounds
from pipeline.simulation.sound_detection.sound_sources import SoundSources, rigid_parts
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Contact, SoundEvent, Take
from pipeline.simulation.take_store import read_take, write_take
from pipeline.spec import Scene, find_scene, load_scene, simulation_key
from pipeline.spec.sound_thresholds import Detect, SustainedCause, VocalCause
from tests.simulation.conftest import scene_of, walk_through

ARM = (
    "{{name: arm, figure: robot_arm, pose: ["
    "{{at: 0, joints: {{base_yaw_deg: 0}}}},"
    "{{at: 1, joints: {{base_yaw_deg: 0}}}},"
    "{{at: {end}, joints: {{base_yaw_deg: {turn}}}, ease: in-out}}]}}"
)
DART = (
    "{{name: dart, prop: {{shape: box, size: {size}}}, at: [0, 3, 0], keyframes: ["
    "{{at: 0, position: [-40, 3, 0]}}, {{at: 1, position: [-40, 3, 0]}},"
    "{{at: {end}, position: [0, 3, 0], ease: {ease}}}]}}"
)


def events_of(take: Take, cause: str) -> list[SoundEvent]:
    return [event for event in take.events if event.cause == cause]


def time_of(take: Take, event: SoundEvent) -> float:
    steps = take.header.rate * take.header.steps
    return float((event.step + Fraction(event.fraction)) / steps)


# --- footfalls ---------------------------------------------------------------------------------


def landings(scene: Scene) -> dict[str, list[float]]:
    """Return the landing times of each foot, from the poses of the last links alone.

    A foot stands while its tip does not move; it lands when it stands after moving.
    """
    walk = walk_through(scene)
    dt, herd = walk.simulation.world.clock.dt, walk.walkers.herd
    still = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1) < 2e-4
    names = [f"{herd.names[c]}.{leg}" for leg, c in zip(herd.leg_names, herd.owner, strict=True)]
    found = {}
    for leg, name in enumerate(names):
        # Three still intervals in a row are a stance; a swing is still at its apex at most once.
        stands = still[:-2, leg] & still[1:-1, leg] & still[2:, leg]
        found[name] = (np.flatnonzero(stands[1:] & ~stands[:-1]) * dt + dt).tolist()
    return found


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name",
    [
        "first_steps",
        "rocks",
        "ostrich",
        "dunes",
        "ramp",
        "stairs",
        "horse_gaits",
        "boulders",
        "procession",
    ],
)
def test_footfalls_match_the_landings_of_the_poses(name: str) -> None:
    scene = load_scene(find_scene(name))
    expected = landings(scene)
    take = simulate(scene)
    dt = 1.0 / float(scene.rate * scene.steps)
    end = float(scene.n_frames / scene.rate)
    assert sum(map(len, expected.values())) > 10
    for part, times in expected.items():
        own = [time_of(take, e) for e in events_of(take, "footfall") if e.part == part]
        # In the last rows the poses do not show whether a foot stands.
        own = [time for time in own if time < end - 4 * dt]
        times = [time for time in times if time < end - 4 * dt]
        assert len(own) == len(times), part
        np.testing.assert_allclose(own, times, atol=2.5 * dt)


# --- at rest -----------------------------------------------------------------------------------

RESTING = {
    "box": "{body: {shape: box}, at: [0, 0]}",
    "sphere": "{body: {shape: sphere, collide: terrain}, at: [0, 0]}",
    "die on edge of nothing": "{body: {shape: die, collide: terrain}, at: [0, 0]}",
    "wall": "{name: w, many: {of: brick, layout: wall, rows: 3, columns: 3}}",
    "prop": "{prop: {shape: box}, at: [0, 0]}",
    "robot": "{figure: robot_arm, at: [0, 0]}",
    "beetle": "{figure: beetle, at: [0, 0]}",
    "person": "{figure: person, at: [0, 0]}",
}


@pytest.mark.nightly
@pytest.mark.parametrize("what", RESTING)
def test_performers_at_rest_are_silent_for_ten_seconds(what: str) -> None:
    take = simulate(scene_of(RESTING[what], terrain="flat", duration=10))
    assert take.events == ()


@pytest.mark.parametrize("meets", ["all", "terrain"])
@pytest.mark.parametrize("shape", ["box", "sphere", "die"])
def test_bodies_that_settle_fall_silent_without_rattling(meets: str, shape: str) -> None:
    body = f"shape: {shape}, bounciness: 0.5, rolling: 0.02, collide: {meets}"
    member = f"{{name: b, body: {{{body}}}, at: [0, 0.8, 0], rotation_deg: [20, 0, 35]}}"
    take = simulate(scene_of(member, terrain="flat", duration=8))
    times = [time_of(take, event) for event in events_of(take, "collision")]
    assert 2 <= len(times) <= 40
    assert min(np.diff(times)) >= Detect().collision.pause - 1e-9
    assert max(time_of(take, event) for event in take.events) < 4
    last = max(event.track[1] for event in take.events) / 96
    assert last < 5


# --- motions -----------------------------------------------------------------------------------


def squeaks(
    turn: float, end: float, more: str = "", fps: int = 24
) -> tuple[Take, list[SoundEvent]]:
    scene = scene_of(ARM.format(turn=turn, end=end), duration=4, more=f"fps: {fps}\n{more}")
    take = simulate(scene)
    return take, events_of(take, "squeak")


def crossings(mean: float, threshold: float, start: float, span: float) -> tuple[float, float]:
    """Return the times at which an ease, of speed 30 mean s² (1 - s)², crosses a threshold."""
    product = math.sqrt(threshold / (30.0 * mean))
    root = math.sqrt(1.0 - 4.0 * product)
    return start + span * (1 - root) / 2, start + span * (1 + root) / 2


@pytest.mark.parametrize("fps", [24, 60])
def test_a_joint_squeaks_while_its_rate_exceeds_the_threshold(fps: int) -> None:
    take, found = squeaks(90, 3, fps=fps)
    (event,) = found
    row = 1.0 / float(take.header.rate * take.header.samples)
    begin, _ = crossings(45, Detect().squeak.above_deg_s, 1, 2)
    _, end = crossings(45, Detect().squeak.ends_deg_s, 1, 2)
    # The rate by rows is straight between them: a twentieth of a row here.
    assert time_of(take, event) == pytest.approx(begin, abs=0.1 * row)
    assert event.track[1] * row == pytest.approx(end, abs=1.01 * row)
    assert event.who == "arm"
    assert event.part == "arm.arm_m1.1"
    assert event.material == "yellow plastic"


def test_a_squeak_has_a_strength_and_a_place_at_each_row() -> None:
    take, (event,) = squeaks(90, 3)
    first, last = event.track
    assert len(event.strengths) == len(event.places) == last - first + 1
    node = [n.name for n in take.nodes].index(event.part)
    np.testing.assert_allclose(event.places, take.positions[first : last + 1, node], atol=1e-6)
    # As the rate of its joint, which the take has too.
    channel = [c.name for c in take.channels].index("arm.arm_m1.base_yaw")
    rate = np.abs(np.gradient(take.values[:, channel], 1 / 96))[first : last + 1]
    ratio = np.array(event.strengths)[1:-1] / rate[1:-1]
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-3)
    assert event.strength == pytest.approx(max(event.strengths), abs=1e-6)


def test_thresholds_follow_the_configuration() -> None:
    assert squeaks(6, 3)[1] == []
    assert len(squeaks(6, 3, "sound: {detect: {squeak: {above_deg_s: 2, below_deg_s: 1}}}")[1]) == 1
    assert squeaks(90, 3, "sound: {detect: {squeak: {heard: false}}}")[1] == []
    assert len(squeaks(90, 3, "sound: {detect: {squeak: {who: 'A*'}}}")[1]) == 1
    assert squeaks(90, 3, "sound: {detect: {squeak: {materials: {metal: 1}}}}")[1] == []
    assert squeaks(90, 3, "sound: {detect: {squeak: {least: 2.5}}}")[1] == []


def test_a_fast_joint_squawks_instead_of_squeaking() -> None:
    take, found = squeaks(150, 1.2)
    assert [event.cause for event in take.events] == ["squawk"]
    assert found == []
    quiet = "sound: {detect: {squawk: {heard: false}}}"
    assert len(squeaks(150, 1.2, quiet)[1]) == 1


def test_fur_does_not_squeak() -> None:
    take = simulate(scene_of("{figure: horse, walk: {}}", duration=3))
    assert {event.cause for event in take.events} == {"footfall"}


def darts(end: float, size: str, ease: str = "linear") -> Take:
    return simulate(scene_of(DART.format(end=end, size=size, ease=ease), duration=6))


def test_a_prop_swooshes_while_its_speed_exceeds_the_threshold() -> None:
    take = darts(3, "[0.6, 0.1, 0.1]", "in-out")
    (event,) = take.events
    assert event.cause == "swoosh"
    row = 1 / 96
    # 40 m in 2 s, from rest to rest.
    begin, _ = crossings(20, 9, 1, 2)
    _, end = crossings(20, 4.5, 1, 2)
    assert time_of(take, event) == pytest.approx(begin, abs=0.1 * row)
    assert event.track[1] * row == pytest.approx(end, abs=1.01 * row)
    assert event.strength == pytest.approx(1.875 * 20, rel=1e-3)


@pytest.mark.parametrize(
    ("end", "size", "causes"),
    [
        # 10 m/s is fast for a ball and slow for a body 2 m long.
        (5, "[0.3, 0.3, 0.3]", ["swoosh"]),
        (5, "[2, 0.3, 0.3]", []),
        # 5 m/s is quick for nothing.
        (9, "[0.1, 0.1, 0.1]", []),
        # At 20 m/s a wire sings at 400 Hz, and a beam does not.
        (3, "[1, 0.01, 0.01]", ["swoosh", "whistle"]),
        (3, "[1, 0.1, 0.1]", ["swoosh"]),
    ],
)
def test_swoosh_and_whistle_depend_on_size(end: float, size: str, causes: list[str]) -> None:
    assert sorted(event.cause for event in darts(end, size).events) == causes


def test_a_jump_of_a_keyframed_prop_makes_no_swoosh() -> None:
    assert darts(1.5, "[0.3, 0.3, 0.3]", "hold").events == ()


def pushed(
    rises: Callable[[Array], Array], feet: bool = True, lifts: Sequence[Contact] = ()
) -> list[SoundEvent]:
    """Return the push-offs of a creature whose nodes are raised by a function of time."""
    simulation = Simulation(scene_of("{name: roo, figure: kangaroo}", duration=3))
    while not simulation.finished:
        simulation.step()
    take, clock = simulation.take(), simulation.world.clock
    parts = rigid_parts(take.parts, take.meshes)
    figures = {"roo": None}
    sources = SoundSources(clock, take.nodes, parts, (), figures, frozenset())  # type: ignore[arg-type]
    up = rises(np.arange(clock.rows) / 96)
    p = take.positions.copy()
    # Feet stay in place when a creature gets up.
    p[:, : len(take.nodes) if feet else 1, 1] += up[:, None]
    rows = p, matrix(take.rotations), take.alive, take.values
    detectors = MotionSounds(Detect(), sources)
    detectors.add_contacts(lifts)
    events = []
    for first in range(0, clock.rows, 13):
        batch = slice(first, min(first + 13, clock.rows))
        events += detectors.events(batch, *(values[batch] for values in rows))
    return [event for event in events if event.cause == "boing"]


def jump(t: Array) -> Array:
    """Return the height after half a second at 8 m/s², 4 m/s at 1.5 s, then free flight."""
    push, flight = np.clip(t - 1, 0, 0.5), np.clip(t - 1.5, 0, 8 / 9.81)
    return 4.0 * push**2 + 4.0 * flight - 0.5 * 9.81 * flight**2


def test_a_flight_after_a_push_is_a_push_off() -> None:
    (event,) = pushed(jump)
    steps = Fraction(96)
    assert float((event.step + Fraction(event.fraction)) / steps) == pytest.approx(1.5, abs=1 / 96)
    assert event.strength == pytest.approx(4.0, abs=0.05)
    assert (event.cause, event.who, event.part) == ("boing", "roo", "roo.body")


def test_a_push_off_starts_at_the_lift_of_the_last_foot() -> None:
    nowhere = (0.0, 0.0, 0.0)
    lifts = [
        Contact(step, fraction, who, who, "terrain", nowhere, nowhere, 4, 1, "", "", 1, "lift")
        for who, step, fraction in [("roo", 143, 0.5), ("roo", 143, 0.75), ("bob", 144, 0.25)]
    ]
    (event,) = pushed(jump, lifts=lifts)
    assert (event.step, event.fraction, event.track) == (143, 0.75, (143, 143))


@pytest.mark.parametrize(
    "rises",
    [
        # A lift at 3 m/s, a hop of 5 cm, and a climb with a gait's bounce.
        lambda t: np.clip(3 * (t - 0.5), 0, 4),
        lambda t: 0.25 * jump(t) * (t > 1) * 0.2,
        lambda t: 2 * t + 0.02 * np.sin(12 * t),
    ],
)
def test_a_lifted_creature_makes_no_push_off(rises: Callable[[Array], Array]) -> None:
    assert pushed(rises) == []


def test_getting_up_makes_no_push_off() -> None:
    assert pushed(jump, feet=False) == []


@pytest.mark.nightly
def test_breathing_is_optional_and_follows_the_gait() -> None:
    scene = "{name: bob, figure: person, walk: {speed: 0.9, cycle: 1.0}}"
    ask = "sound: {detect: {breath: {heard: true, per_minute: 6, strides: 2}}}"
    assert events_of(simulate(scene_of(scene, duration=3)), "breath") == []
    take = simulate(scene_of(scene, duration=9, more=ask))
    times = [time_of(take, event) for event in events_of(take, "breath")]
    assert len(times) >= 3
    np.testing.assert_allclose(np.diff(times[1:]), 2.0, atol=0.02)
    resting = simulate(scene_of("{figure: person}", duration=25, more=ask))
    times = [time_of(resting, event) for event in events_of(resting, "breath")]
    np.testing.assert_allclose(times, [10, 20], atol=1e-6)


def test_a_swarm_is_heard_in_flight_as_one() -> None:
    swarms = (
        "{name: flies, group: {rule: swarm, count: 3, size: 0.02}, at: [1, 1, 0]}",
        "{name: gnats, group: {rule: swarm, count: 2}, at: [3, 1, 0]}",
    )
    take = simulate(scene_of(*swarms, duration=1, more="sound: {detect: {wings: {who: 'f*'}}}"))
    (wings,) = events_of(take, "wings")
    assert (wings.who, wings.part, wings.frame, wings.size) == ("flies", "flies.wings", 1, 0.02)
    nodes = [k for k, node in enumerate(take.nodes) if node.performer == "flies"]
    middle = take.positions[wings.track[0], nodes].mean(axis=0)
    np.testing.assert_allclose(wings.places[0], middle, atol=1e-5)
    assert 0.3 < wings.strength < 5.0


@pytest.mark.nightly
def test_clothes_rustle_on_request_while_limbs_move() -> None:
    walkers = "{name: bob, figure: person, walk: {}}", "{name: bug, figure: beetle, at: [3, 3]}"
    ask = "sound: {detect: {rustle: {heard: true}}}"
    assert events_of(simulate(scene_of(*walkers, duration=1)), "rustle") == []
    (rustle,) = events_of(simulate(scene_of(*walkers, duration=1, more=ask)), "rustle")
    assert rustle.who == "bob"
    assert rustle.material.endswith("cloth")
    standing = "{name: bob, figure: person}"
    assert events_of(simulate(scene_of(standing, duration=1, more=ask)), "rustle") == []


@pytest.mark.nightly
def test_a_person_breathes_faster_when_it_runs() -> None:
    ask = "sound: {detect: {breath: {heard: true}}}\n"
    run = "script: [{at: 0, who: ann, do: {go_to: [40, 0]}}]\n"
    person = "{name: ann, character: adult}"

    def breaths(more: str) -> int:
        take = simulate(scene_of(person, duration=20, more=ask + more))
        return len(events_of(take, "breath"))

    rest = breaths("")
    assert 4 <= rest <= 7
    assert breaths(run) > 1.3 * rest


@pytest.mark.nightly
def test_creatures_call_on_request_in_the_voice_of_their_mood() -> None:
    creatures = (
        "{name: bob, figure: person, mood: sad, walk: {}}",
        "{name: bug, figure: beetle, at: [3, 3]}",
    )
    ask = "sound: {detect: {call: {heard: true, every: 0.5, who: 'b*'}}}\n"
    mood = "script:\n  - {at: 1.5, who: bob, do: {mood: angry}}\n"
    third = "{name: calf, figure: person, at: [-3, 3]}"
    take = simulate(scene_of(*creatures, third, duration=3, more=ask + mood))
    calls = [event for event in take.events if event.cause in ("call", "growl", "whine")]
    for event in calls:
        expected = (
            "call" if event.who == "bug" else "whine" if time_of(take, event) < 1.5 else "growl"
        )
        assert event.cause == expected
        row = event.track[0]
        assert event.frame == 1 + math.ceil(row / take.header.samples)
        head = [node.name for node in take.nodes].index(event.part)
        assert math.dist(event.place, take.positions[row, head]) < 1e-5
    assert {event.cause for event in calls} == {"call", "growl", "whine"}
    times = {who: [time_of(take, e) for e in calls if e.who == who] for who in ("bob", "bug")}
    assert all(0.15 <= gap <= 0.87 for found in times.values() for gap in np.diff(found))
    assert times["bob"][0] != times["bug"][0]
    sizes = {event.who: event.size for event in calls}
    # Cubes of water as heavy as they are.
    assert 0.3 < sizes["bob"] < 0.5
    assert sizes["bug"] > 2 * sizes["bob"]  # this beetle weighs over a ton
    assert not Detect().call.heard


def test_a_rolling_ball_has_a_course() -> None:
    shape = "shape: sphere, collide: terrain, rolling: 0.05"
    ball = f"{{name: b, body: {{{shape}}}, at: [0, 0], velocity: [2, 0, 0]}}"
    take = simulate(scene_of(ball, duration=3))
    (event,) = events_of(take, "roll")
    first, last = event.track
    assert len(event.strengths) == len(event.places) == last - first + 1
    x = take.positions[first : last + 1, 0, 0]
    np.testing.assert_allclose(np.array(event.places)[:, 0], x, atol=1e-3)
    # Not at the ends of the gradient, and not where it still slips.
    np.testing.assert_allclose(event.strengths[9:-1], np.gradient(x, 1 / 96)[9:-1], rtol=5e-3)


# --- active intervals --------------------------------------------------------------------------


def intervals(level: list[float], least: float, pause: float, batch: int) -> list[ActiveInterval]:
    config = SustainedCause(least=least, pause=pause)
    tracker = IntervalTracker(np.array([1.0]), np.array([2.0]), config, 1.0)
    found = []
    for first in range(0, len(level), batch):
        rows = np.array(level[first : first + batch])[:, None]
        is_final = first + batch >= len(level)
        found += tracker.update(first, rows, rows[:, :, None], is_final)
    return found


@pytest.mark.parametrize("batch", [1, 2, 3, 5, 100])
def test_a_level_that_oscillates_around_a_threshold_is_one_interval(batch: int) -> None:
    level = [0.0, 4.0, *([1.9, 2.1] * 20), 0.0, 0.0, 0.0, 3.0, 0.0, 0.0]
    first, second = intervals(level, 0, 1, batch)
    assert (first.start, first.first, first.last, first.peak) == (0.5, 0, 41, 4.0)
    assert [row[0] for row in first.values] == level[:42]
    assert (second.start, second.last) == (44 + 2 / 3, 45)


@pytest.mark.parametrize("batch", [1, 4, 100])
def test_pauses_are_bridged_and_short_intervals_dropped(batch: int) -> None:
    level = [3.0, 3.0, 0.0, 0.0, 3.0, 3.0, 0.0, 0.0, 0.0, 0.0, 3.0]
    assert [s.last for s in intervals(level, 0, 2, batch)] == [5, 10]
    assert [s.last for s in intervals(level, 0, 1, batch)] == [1, 5, 10]
    assert [s.last for s in intervals(level, 1.5, 2, batch)] == [5]


# --- all of them -------------------------------------------------------------------------------

MIXED = (
    ARM.format(turn=90, end=3),
    "{name: dart, prop: {shape: box, size: [1, 0.01, 0.01]}, at: [0, 3, 0], velocity: [20, 0, 0]}",
    "{name: bug, figure: beetle, at: [3, 3], walk: {speed: 2, cycle: 0.4}}",
    "{name: b, body: {shape: box}, at: [-3, 2, 3], velocity: [2, 0, 0]}",
)
ALL = "sound: {detect: {breath: {heard: true}, squeak: {materials: {chitin: 1, plastic: 1}}}}"


@pytest.mark.nightly
def test_events_repeat_exactly_whatever_the_batches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = scene_of(*MIXED, duration=3, more=ALL)
    take = simulate(scene)
    assert {"squeak", "swoosh", "whistle", "breath", "footfall"} <= {e.cause for e in take.events}
    assert simulate(scene).digest == take.digest
    monkeypatch.setattr("pipeline.simulation.scheduler.BATCH_LIMITS", BatchLimits(7, 7))
    assert sorted(simulate(scene).events, key=repr) == sorted(take.events, key=repr)


def test_a_stored_take_keeps_its_events(tmp_path: Path) -> None:
    take = simulate(scene_of(*MIXED, duration=2, more=ALL))
    write_take(take, tmp_path / "take")
    assert read_take(tmp_path / "take").events == take.events


def test_every_cause_has_one_detector_and_every_detector_a_cause() -> None:
    vocal = [cause for cause, config in Detect() if isinstance(config, VocalCause)]
    assert sorted([*CONTACT_CAUSES, *MOTION_CAUSES, *vocal]) == sorted(Detect.model_fields)


def test_thresholds_are_part_of_the_simulation_key() -> None:
    louder = "sound: {volume_db: 3}"
    other = "sound: {detect: {swoosh: {above: 8}}}"
    plain, loud, high = (
        simulation_key(scene_of("{figure: beetle}", more=more)) for more in ("", louder, other)
    )
    assert plain == loud != high


@pytest.mark.parametrize(
    ("thresholds", "message"),
    [
        (
            "squeak: {above_deg_s: 2, below_deg_s: 4}",
            "squeak.below_deg_s: should not be more than above_deg_s, which is 2; is 4",
        ),
        ("squeak: {materials: {metall: 1}}", "did you mean 'metal'?"),
        ("squeek: {}", "did you mean 'squeak'?"),
        ("swoosh: {above: -1}", "sound.detect.swoosh.above"),
        ("swoosh: {above: fast}", "sound.detect.swoosh.above"),
    ],
)
def test_a_wrong_threshold_gets_one_clear_message(thresholds: str, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene_of("{figure: beetle}", more=f"sound: {{detect: {{{thresholds}}}}}")
    (problem,) = caught.value.problems
    assert message in f"{problem.path}: {problem.message}"
    assert json.dumps(problem.message)


def test_flying_parts_exclude_creatures_and_groups() -> None:
    simulation = Simulation(scene_of(*MIXED, "{group: {rule: swarm, count: 3}}"))
    figures = {"bug": None, "arm": None}
    clock, recorder = simulation.world.clock, simulation.recorder
    sources = sound_sources(scene_of(*MIXED), clock, recorder, figures)  # type: ignore[arg-type]
    assert [part.performer for part in sources.flying][:2] == ["dart", "b"]
