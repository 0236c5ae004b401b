"""Hopping: closed forms of flight, landing and pushing, and invariants of every step."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking import hop_phases, hop_simulation
from pipeline.simulation.locomotion.pronking.flight_swing import (
    MAX_PITCH,
    SWING_KNOTS,
    flight_swing,
)
from pipeline.simulation.locomotion.pronking.hop_events import trip_on_wall
from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.locomotion.pronking.leg_forces import distribute_force, phase_force
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.spec import find_scene, load_scene
from tests.simulation.conftest import SHIPPED, scene_of
from tests.simulation.locomotion.hop_recorder import HopRecording, hop_through
from tests.simulation.locomotion.joint_pops import joint_pops

G = np.array([0.0, -GRAVITY, 0.0])

HOPPERS = {
    "kangaroo": "{distance: 1.6, height: 0.8}",
    "antelope": "{distance: 1.2, height: 0.5}",
    "hopper": "{}",
    "ostrich": "{speed: 4}",
    "beetle": "{distance: 0.6, height: 0.4}",
    "spider": "{}",
    "person": "{}",
}

FASTEST_FOOT = 20.0
"""Greatest speed of a foot of a kangaroo that trips at 4 m/s; in its swings they go at 12 [m/s]."""

HILLS = "{preset: hills, size: [80, 80], cells: [320, 320]}"


def member(figure: str, config: str, more: str = "") -> str:
    return f"{{figure: {figure}, pronk: {config}{more}}}"


@pytest.fixture(scope="module", params=HOPPERS)
def level_hops(request) -> HopRecording:
    return hop_through(scene_of(member(request.param, HOPPERS[request.param]), duration=4))


# --- forces ---------------------------------------------------------------------------


def test_phase_force_reaches_its_velocity_at_its_height():
    v0, v1, rise = (1.0, -4.0, 0.2), (0.5, 0.0, -0.1), -0.6
    one = phase_force(80.0, 1e6, v0, v1, rise)
    a = np.array(one.acceleration)
    np.testing.assert_allclose(np.array(v0) + one.time * a, v1, atol=1e-12)
    assert -4.0 * one.time + 0.5 * a[1] * one.time**2 == pytest.approx(rise)
    np.testing.assert_allclose(np.array(one.force), 80.0 * (a - G), rtol=1e-12)


def test_saturated_phase_force_is_bounded_and_takes_longer():
    free = phase_force(80.0, 1e6, (0.0, -4.0, 0.0), (0.0, 0.0, 0.0), -0.4)
    held = phase_force(80.0, 2000.0, (0.0, -4.0, 0.0), (0.0, 0.0, 0.0), -0.4)
    assert held.saturated
    assert not free.saturated
    assert math.hypot(*held.force) == pytest.approx(2000.0)
    assert held.time > free.time


def test_legs_that_sprawl_are_drawn_up_less_than_those_that_stand_upright() -> None:
    hips = np.array([[0.2, 0.0, 0.1], [0.2, 0.0, -0.1]])
    raised = []
    for aside, depth in ((0.05, 0.5), (0.45, 0.2)):
        feet = hips + np.array([[0.0, -depth, aside], [0.0, -depth, -aside]])
        hopper = SimpleNamespace(
            hips=hips,
            rest_feet=feet * [1.0, 0.0, 1.0],
            standing_height=depth,
            folded_lengths=np.full(2, 0.05),
            leg_length=0.5,
        )
        swing = flight_swing(hopper, feet, feet, 0.0, 0.6, np.zeros(3), False)  # type: ignore[arg-type]
        raised.append(swing.rising[:, 1] - feet[:, 1])
    assert raised[0] == pytest.approx(0.42 * 0.5)
    assert (raised[1] > 0.02).all()
    assert (raised[1] < 0.35 * raised[0]).all()


@pytest.mark.parametrize(
    ("time", "speed", "legs"), [(0.6, 3.0, 4), (0.1, 3.0, 4), (0.6, 0.0, 4), (0.6, 3.0, 2)]
)
def test_legs_stretch_back_and_reach_ahead_the_more_the_longer_and_faster_they_fly(
    time: float, speed: float, legs: int
) -> None:
    length = 0.8
    hips = np.array([[x, 0.0, z] for x in (0.5, -0.5) for z in (-0.1, 0.1)])[-legs:]
    hopper = SimpleNamespace(
        hips=hips,
        rest_feet=hips,
        standing_height=0.75,
        folded_lengths=np.full(legs, 0.2),
        leg_length=length,
    )
    start, end = (hips + np.array([x, -0.75, 0.0]) for x in (-0.1, 0.1))
    # A little askew, as on hills.
    v = np.array([speed, 2.0, 0.01 * speed])
    swing = flight_swing(hopper, start, end, 0.0, time, v, False)  # type: ignore[arg-type]
    leap = (1.0 if time > 0.5 else 0.2) * (speed > 0.0)
    steady = [start + share * (end - start) for share in SWING_KNOTS]
    rising, falling = swing.rising - hips, swing.falling - hips
    hind = slice(legs - 2, legs)
    # Hind legs: stretched back, then gathered below the body.
    behind = (1.0 - leap) * (steady[1] - hips)[hind, 0] - leap * 0.62 * length
    np.testing.assert_allclose(rising[hind, 0], behind, atol=4e-3)
    if leap == 1.0:
        stretches = np.linalg.norm(rising[hind], axis=-1)
        np.testing.assert_allclose(stretches, 0.95 * length, atol=4e-3)
        assert (falling[hind, 1] > rising[hind, 1]).all()
        assert (np.abs(falling[hind, 0]) < 0.2 * length).all()
    if legs == 4:
        # Forelegs: folded below the breast, then stretched ahead.
        assert leap < 1.0 or (rising[:2, 1] > rising[hind, 1]).all()
        ahead = (1.0 - leap) * (steady[2] - hips)[:2, 0] + leap * 0.46 * length
        np.testing.assert_allclose(falling[:2, 0], ahead, atol=4e-3)
    if speed == 0.0:
        # On the spot feet are drawn straight up.
        np.testing.assert_allclose(swing.rising[:, 0], steady[1][:, 0], atol=1e-12)
        np.testing.assert_allclose(swing.rising[:, 1], start[:, 1] + 0.42 * length)
    if time == 0.1:
        moves = np.diff([swing.tips(t) for t in np.linspace(0.0, time, 400)], axis=0)
        # Not torn along.
        assert np.linalg.norm(moves, axis=-1).max() / (time / 399) < 2.25 * speed


def test_swinging_legs_pitch_a_body_by_their_momentum():
    scene = scene_of("{figure: antelope, pronk: {distance: 1.8, height: 0.6}}", duration=3)
    simulation = Simulation(scene)
    troupe = next(t for t in simulation.troupes if isinstance(t, HopperTroupe))
    (one,) = troupe.simulations
    while one.state.phase != "flight":
        simulation.step()
    state, hopper = one.state, one.hopper
    pitch, swing = state.pitch, state.swing
    assert pitch.at(state.swing.begin[0])[0] == 0.0
    assert pitch.at(pitch.begin + pitch.time)[0] == 0.0
    up, down = pitch.angles[1:3]
    # Up in front while hind legs trail, down while forelegs reach.
    assert math.radians(3.0) < up < MAX_PITCH
    assert -MAX_PITCH < down < math.radians(-1.0)
    times = pitch.begin + np.array(SWING_KNOTS) * pitch.time
    way = swing.end - swing.start
    moved = [
        float((hopper.leg_masses @ (swing.start + s * way - swing.tips(t)))[0])
        for s, t in zip(SWING_KNOTS, times, strict=True)
    ]
    # Its sign is that of the way by which the feet are behind their steady way.
    assert moved[1] > 0.0 > moved[2]
    for t in (0.1, 0.4, 0.8):
        now, step = pitch.begin + t * pitch.time, 1e-6
        slope = (pitch.at(now + step)[0] - pitch.at(now - step)[0]) / (2.0 * step)
        assert pitch.at(now)[1] == pytest.approx(slope, abs=1e-6)
    turns = []
    while one.state.phase == "flight":
        turns.append(one.state.body(hopper).R[1, 0])
        simulation.step()
    # What is left of it at the landing goes on in the attitude.
    assert one.state.pitch.angles == (0.0,) * 4
    turns.append(one.state.body(hopper).R[1, 0])
    assert max(turns) > math.sin(math.radians(3.0))
    assert np.abs(np.diff(turns)).max() < 3.0 * simulation.world.clock.dt


def test_leg_forces_add_up_within_their_bound():
    rng = np.random.default_rng(4)
    for _ in range(100):
        n = int(rng.integers(1, 7))
        levers = rng.normal(size=(n, 3))
        force = np.array([*rng.normal(size=2) * 50.0, 0.0])[[0, 2, 1]] + [0.0, 900.0 * n, 0.0]
        moment = rng.normal(size=3) * 300.0
        most = 1.3 * float(np.linalg.norm(force)) / n
        shares = distribute_force(force, moment, levers, most)
        np.testing.assert_allclose(shares.sum(axis=0), force, atol=1e-9)
        assert (shares[:, 1] >= -1e-9).all()
        assert (np.linalg.norm(shares, axis=-1) <= most * (1 + 1e-9)).all()


def test_four_legs_give_the_whole_moment():
    levers = np.array([[0.5, 0.1, -0.2], [-0.5, 0.1, -0.2], [0.5, 0.1, 0.2], [-0.5, 0.1, 0.2]])
    shares = distribute_force(
        np.array([0.0, 4000.0, 0.0]), np.array([60.0, 0.0, 200.0]), levers, 1e5
    )
    found = np.cross(levers, shares).sum(axis=0)
    np.testing.assert_allclose(found[[0, 2]], [60.0, 200.0], atol=1e-9)


# --- on level ground -----------------------------------------------------------------------


@pytest.mark.nightly
def test_apex_and_distance_are_as_requested(level_hops):
    hopper, seen = level_hops.troupe.hoppers[0], level_hops.states[0]
    flights = level_hops.lifts
    assert len(flights) >= 3
    for _, v in flights:
        assert v[1] ** 2 / (2 * GRAVITY) == pytest.approx(hopper.jump.height, rel=0.01)
        assert 2 * v[1] / GRAVITY * math.hypot(v[0], v[2]) == pytest.approx(
            hopper.jump.distance, rel=0.01
        )
    # The flight lasts until it is back at the height of its lift-off.
    for (_, a), (__, b) in itertools.pairwise(enumerate(seen)):
        if a.phase == "flight" and b.phase == "landing":
            p, _ = flights[b.jumps - 1]
            assert b.p[1] <= p[1] + 0.02 * hopper.leg_length


@pytest.mark.sample(3)
def test_flights_are_parabolas(level_hops):
    states = [s for s in level_hops.states[0] if s.phase == "flight" and s.jumps]
    flights = level_hops.lifts
    times = level_hops.lift_times
    for s in states:
        (p, v), t = flights[s.jumps - 1], s.time - times[s.jumps - 1]
        np.testing.assert_allclose(s.p, p + t * v + 0.5 * t * t * G, atol=1e-9)
        np.testing.assert_allclose(s.v, v + t * G, atol=1e-9)


LIBRARY = (
    "ant antelope beetle camel cat centipede crab dog elephant frog giraffe hopper horse kangaroo "
    "lizard mouse ostrich person scorpion spider tripod"
).split()
"""Shipped figures with legs."""


def test_tested_figures_are_all_legged_ones_of_the_library(library):
    legged = {name for name in SHIPPED if library(name).skeleton.legs}
    assert legged == set(LIBRARY)


@pytest.mark.sample(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("figure", "config"), [(figure, "{}") for figure in LIBRARY] + list(HOPPERS.items())
)
def test_landings_end_at_rest_at_the_crouch(monkeypatch, figure, config):
    ends, begins = [], []
    begin, push = hop_phases.begin_landing, hop_phases.begin_push

    def landing(hopper, ground, state, events):
        # The crouch before the first jump starts from standing, not from a flight.
        if state.jump_count:
            begins.append((state.p[1], state.v[1]))
        begin(hopper, ground, state, events)

    def pushing(hopper, ground, state, events):
        if state.jump_count:
            ends.append((state.p[1] - hopper.mass.centre[1], hopper.crouch_height))
        push(hopper, ground, state, events)

    for module in (hop_phases, hop_simulation):
        monkeypatch.setattr(module, "begin_landing", landing)
        monkeypatch.setattr(module, "begin_push", pushing)
    ended = hop_simulation.finish_phase
    speeds = []

    def recorded_end(hopper, ground, state, events):
        if state.phase == "landing" and state.jump_count:
            speeds.append(float(state.v[1]))
        ended(hopper, ground, state, events)

    monkeypatch.setattr(hop_simulation, "finish_phase", recorded_end)
    hops = hop_through(scene_of(member(figure, config), duration=8), until=3)
    centre = hops.troupe.hoppers[0].mass.centre[1]
    assert len(ends) == len(begins) == len(speeds) >= 3
    for (height, crouch), (top, fall), speed in zip(ends, begins, speeds, strict=True):
        assert abs(height - crouch) < 0.01 * (top - centre - crouch)
        assert abs(speed) < 0.01 * abs(fall)


def test_leg_forces_accelerate_the_mass(level_hops):
    hopper, seen = level_hops.troupe.hoppers[0], level_hops.states[0]
    for a, b in itertools.pairwise(seen):
        if a.phase == b.phase and a.phase in ("landing", "pushing") and a.jumps == b.jumps:
            found = (b.v - a.v) / (b.time - a.time)
            want = a.forces.sum(axis=0) / hopper.mass.mass + G
            np.testing.assert_allclose(found, want, atol=1e-6)


SMOOTH = "{kind: hills, size: [12, 12], cells: [1200, 1200], height: 0.12, spacing: 6}"
"""Low hills whose triangles are 1 cm wide, a hundredth of a jump."""


def landing_errors(figure: str, config: str, terrain: str) -> tuple[float, float]:
    """Return the errors of the first landings at a time step and at half of it [m]."""
    points = []
    for steps in (4, 8, 64):
        scene = scene_of(
            member(figure, config),
            terrain=terrain,
            duration=5,
            more=f"steps: {steps}\nrows_per_frame: 4",
        )
        points.append(landing_points(hop_through(scene, until=3))[:3])
        assert len(points[-1]) == 3
    return tuple(float(np.abs(p - points[-1]).max()) for p in points[:2])


@pytest.mark.parametrize(
    "config", [pytest.param("{}", marks=pytest.mark.nightly), "{turn_deg: 20}"]
)
@pytest.mark.parametrize(
    "figure",
    [
        pytest.param("kangaroo", marks=pytest.mark.nightly),
        pytest.param("antelope", marks=pytest.mark.nightly),
        pytest.param("hopper", marks=pytest.mark.slow),
    ],
)
@pytest.mark.nightly
def test_landing_points_on_smooth_hills_converge_with_the_step(figure, config):
    # The rest is the error of the attitude by Runge-Kutta of fourth order: 16 times smaller.
    coarse, fine = landing_errors(figure, config, SMOOTH)
    assert 1e-9 < coarse < 1e-4
    assert coarse > 8.0 * fine


@pytest.mark.slow
@pytest.mark.parametrize(
    "figure",
    [
        pytest.param("kangaroo", marks=pytest.mark.nightly),
        pytest.param("antelope", marks=pytest.mark.nightly),
        "hopper",
    ],
)
@pytest.mark.nightly
def test_landing_points_on_level_ground_do_not_depend_on_the_step(figure):
    # Phases are closed forms and events are located in them, so only rounding is left.
    coarse, fine = landing_errors(figure, "{}", "flat")
    assert coarse < 1e-11
    assert fine < 1e-11


def landing_points(hops: HopRecording) -> np.ndarray:
    """Return the centres of the feet (k, 3) at each landing [m]."""
    n = len(hops.troupe.hoppers[0].hips)
    places = [h.place for h in hops.events[0] if h.kind == "touch"]
    count = len(places) // n * n
    return np.array(places[:count]).reshape(-1, n, 3).mean(axis=1)


# --- every terrain--------------------------------------------------------------------------

OFTEN = ("kangaroo",)
CASES = [
    pytest.param(
        (figure, terrain),
        marks=pytest.mark.slow if figure in OFTEN else pytest.mark.nightly,
        id=f"{figure}-{where}",
    )
    for figure in LIBRARY
    for where, terrain in (("flat", "flat"), ("hills", HILLS))
]


@pytest.fixture(scope="module", params=CASES)
def long_hops(request) -> HopRecording:
    figure, terrain = request.param
    at = ", at: [-30, 0]" if terrain != "flat" else ""
    scene = scene_of(member(figure, "{}", at), terrain=terrain, duration=40)
    return hop_through(scene, until=20)


@pytest.mark.nightly
def test_twenty_jumps_without_toppling(long_hops):
    assert long_hops.states[0][-1].jumps >= 20
    assert all(s.phase != "fallen" for s in long_hops.states[0])
    if np.ptp(long_hops.simulation.world.ground.field.heights) == 0.0:
        assert max(s.tilt for s in long_hops.states[0]) < math.radians(15.0)


def written_rows(hops: HopRecording) -> int:
    """Return the number of rows that are written."""
    return hops.simulation.scheduler.written


@pytest.mark.sample(1)
def test_planted_feet_do_not_slip_or_sink(long_hops):
    rows = written_rows(long_hops)
    tips, herd = long_hops.tips()[:rows], long_hops.troupe.herd
    down = np.array([s.down for s in long_hops.states[0]][:rows])
    both = down[1:] & down[:-1]
    same = np.array([a.jumps == b.jumps for a, b in itertools.pairwise(long_hops.states[0][:rows])])
    moved = np.linalg.norm(np.diff(tips, axis=0), axis=-1)
    assert moved[both & same[:, None]].max() < 1e-3
    ground = long_hops.simulation.world.ground
    over = tips[..., 1] - herd.foot_radius - ground.height(tips[..., 0], tips[..., 2])
    assert over.min() > -1e-3


def test_leg_joints_are_within_limits(long_hops):
    rows = written_rows(long_hops)
    skeleton = long_hops.troupe.herd.figures[0].skeleton
    joints = [j for limb in skeleton.legs for j in limb.joints]
    q = long_hops.simulation.recorder.values[:rows, 2 : 2 + len(joints)]
    assert (q >= skeleton.lower[joints] - 1e-9).all()
    assert (q <= skeleton.upper[joints] + 1e-9).all()


def test_fetlocks_and_heels_of_hoppers_stay_above_their_feet(level_hops):
    """A leg folds no farther in a crouch than leaves its ankle above the ground."""
    recorder, (figure,) = level_hops.simulation.recorder, level_hops.troupe.herd.figures
    if figure.style == "insect":
        pytest.skip("knees of sprawling legs are above their hips")
    last = [k for limb in figure.skeleton.legs for k in limb.links[-1:]]
    rows = written_rows(level_hops)
    over = recorder.positions[:rows, last, 1] - level_hops.troupe.herd.foot_radius
    assert over.min() > -5e-3


# --- falling ------------------------------------------------------------------------------------


@pytest.mark.nightly
def test_hopper_without_balance_topples():
    scene = scene_of(member("kangaroo", "{balance: 0}"), duration=5)
    hops = hop_through(scene)
    assert hops.states[0][-1].phase == "fallen"
    take = hops.take
    assert [n.kind for n in take.notes].count("toppled") == 1
    assert any(c.kind == "hit" for c in take.contacts)
    assert any(e.cause == "collision" for e in take.events)


@pytest.mark.nightly
def test_falls_are_reproducible():
    scene = scene_of(member("kangaroo", "{balance: 0}"), duration=4)
    one, two = (simulate(scene) for _ in range(2))
    assert one.digest == two.digest


@pytest.mark.nightly
def test_tripping_scene_is_reproducible():
    scene = load_scene(find_scene("tripping"))
    one, two = (simulate(scene) for _ in range(2))
    assert one.digest == two.digest
    steps = {kind: [n.step for n in one.notes if n.kind == kind] for kind in ("tripped", "toppled")}
    assert steps["tripped"]
    assert len(steps["toppled"]) == 1
    assert steps["tripped"][0] <= steps["toppled"][0]


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "duration"), [("dropped", 1.25), ("tripping", 3.25)])
def test_legs_that_land_hard_or_meet_a_wall_do_not_pop(name, duration):
    scene = load_scene(find_scene(name))
    hops = hop_through(scene.model_copy(update={"duration": duration}))
    recorder, herd = hops.simulation.recorder, hops.troupe.herd
    q = np.zeros((len(recorder.values), *herd.legs.is_joint.shape))
    q[:, herd.legs.is_joint] = recorder.values[:, 2 : 2 + int(herd.legs.is_joint.sum())]
    bodies = recorder.rotations[:, 0], recorder.positions[:, 0]
    dt = hops.simulation.world.clock.dt
    assert joint_pops(herd, q, hops.tips(), bodies, dt) == []
    # A foot that a wall catches comes up along it, and does not appear on top.
    jumps = np.linalg.norm(np.diff(hops.tips(), axis=0), axis=-1) / dt
    assert jumps.max() < FASTEST_FOOT


def test_weak_legs_let_the_body_strike_the_ground():
    scene = scene_of(
        "{figure: antelope, at: [0, 4, 0], pronk: {max_force: 0.7, height: 0.2, distance: 0.4}}",
        duration=3,
    )
    hops = hop_through(scene)
    hopper = hops.troupe.hoppers[0]
    assert any(h.kind == "body" for h in hops.events[0])
    assert any(h.kind == "saturated" for h in hops.events[0])
    sizes = [np.linalg.norm(s.forces, axis=-1).max() for s in hops.states[0]]
    assert max(sizes) == pytest.approx(hopper.max_leg_force, rel=1e-9)


# --- events -----------------------------------------------------------------------------------


def test_sound_events_of_take_off_and_landing(level_hops):
    take, n = level_hops.take, len(level_hops.troupe.hoppers[0].hips)
    jumps = level_hops.states[0][-1].jumps
    lifts = [c for c in take.contacts if c.kind == "lift"]
    touches = [c for c in take.contacts if c.kind == "touch"]
    assert len(lifts) == n * jumps
    assert len(touches) in (n * jumps, n * (jumps - 1))
    offs = [e for e in take.events if e.cause == "boing"]
    falls = [e for e in take.events if e.cause == "footfall"]
    assert len(offs) == jumps
    assert len(falls) == len(touches)
    # Joints may squeak besides.
    assert {e.cause for e in take.events} <= {"boing", "footfall", "squeak", "squawk"}
    rise = GRAVITY / (take.header.rate * take.header.samples)
    for one, lift, (p, v) in zip(offs, lifts[::n], level_hops.lifts, strict=True):
        # Measured between two rows, so less by the effect of gravity within one; and of the body,
        # which turning legs move a little from the centre of mass.
        assert v[1] - 1.1 * float(rise) <= one.strength <= v[1] + 1e-3
        assert one.step + one.fraction == pytest.approx(lift.step + lift.fraction)
        assert np.hypot(one.place[0] - p[0], one.place[2] - p[2]) < p[1]
    # Feet come down with the body, which falls no faster than it rose.
    for one in falls:
        assert 0.35 < one.strength / np.linalg.norm(level_hops.lifts[0][1]) < 1.5


@pytest.mark.nightly
def test_impacts_of_a_fall_are_few_and_decay():
    hops = hop_through(scene_of(member("kangaroo", "{balance: 0}"), duration=7))
    take = hops.take
    hits = [e for e in take.events if e.cause == "collision"]
    fell = next(n.step for n in take.notes if n.kind == "toppled")
    assert [n.kind for n in take.notes].count("toppled") == 1
    assert 1 <= len(hits) <= 40
    assert all(e.step >= fell - 1 for e in hits)
    last = max(e.step for e in hits)
    assert last < fell + 5 * 96
    assert hits[-1].strength < 0.5 * max(e.strength for e in hits)


# --- aiming --------------------------------------------------------------------------------------


@pytest.mark.sample(1)
@pytest.mark.parametrize("figure", ["hopper", "kangaroo", "antelope"])
def test_jumps_land_on_their_targets(figure):
    spots = [(1.3, 0.2), (2.4, -0.3), (3.2, 0.6), (3.3, 1.7)]
    config = f"{{land_at: {[list(s) for s in spots]}}}"
    hops = hop_through(scene_of(member(figure, config), duration=8))
    found = landing_points(hops)[:, [0, 2]]
    assert len(found) == len(spots)
    assert np.abs(found - spots).max() < 0.015
    assert hops.states[0][-1].phase == "standing"


DITCHES = "{preset: ditches, size: [30, 6], start: -8, width: 0.5, spacing: 1.4, foot_radius: 0.05}"


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("figure", "x"), [pytest.param("hopper", -9.0, marks=pytest.mark.nightly), ("kangaroo", -8.8)]
)
def test_landings_avoid_forbidden_zones(figure, x):
    at = f", at: [{x}, 0], scale: 0.7"
    heedless, careful = (
        hop_through(scene_of(member(figure, config, at), terrain=DITCHES, duration=9))
        for config in ("{}", "{avoid: true}")
    )
    assert any(n.kind == "misplaced" for n in heedless.take.notes)
    assert all(n.kind != "misplaced" for n in careful.take.notes)
    assert careful.states[0][-1].p[0] > -9.0 + 5.0


@pytest.mark.parametrize("figure", ["spider", "kangaroo"])
def test_feet_that_walls_catch_add_no_energy(figure: str) -> None:
    one = hop_through(scene_of(member(figure, "{}"), duration=0.2)).troupe.simulations[0]
    hopper, state = one.hopper, one.state

    def kinetic_energy() -> float:
        R, w = state.body(hopper).R, np.array(state.attitude[1])
        spin = R.T @ w @ hopper.mass.inertia @ R.T @ w
        return float(0.5 * hopper.mass.mass * state.v @ state.v + 0.5 * spin)

    state.v, state.attitude = np.array([3.0, 1.0, -0.5]), (state.attitude[0], (0.5, -6.0, 2.0))
    tips = state.body(hopper).to_world(state.swing.tips(state.time))
    # Far out, as of legs that are stretched, where an impulse turns a body most.
    tips = state.p + 2.0 * (tips - state.p)
    before = kinetic_energy()
    trip_on_wall(hopper, state, np.arange(len(tips)), tips, one.events)
    assert 0.2 * before < kinetic_energy() < before
