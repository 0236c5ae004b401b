"""Force fields: convergence, bell-shaped speed, and sums within the convex hull."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.simulation.curves import ease
from pipeline.simulation.dancers.arm_control import ArmController
from pipeline.simulation.dancers.dance_goals import hanging_posture, reaching_posture
from pipeline.simulation.dancers.force_fields import (
    FIELD_RATE,
    SPEED_LIMIT,
    HandField,
    desired_velocity,
    minimum_jerk_phase,
    minimum_jerk_step,
    strongest_point,
    weighted_point,
)
from pipeline.simulation.dancers.posture_sequence import PostureSpline, natural_spline_curvatures
from pipeline.simulation.dancers.torso import (
    ARM,
    HANDS,
    PALM_FRACTION,
    Torso,
    build_torso,
)
from pipeline.simulation.dynamics.linkage import Site
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.people.joint_limits import HINGE_LIMITS
from pipeline.simulation.people.proportions import ADULT, JOINTS
from pipeline.simulation.spatial import Array

TICK = 1.0 / 96.0
"""Control interval [s]."""

STEPS = 11
"""Physics steps per control interval."""

POSITION_TOLERANCE = 0.012
"""Position tolerance of a reached point [m]."""

SHOULDER = ADULT.rest()[JOINTS.index("shoulder_r")]
REACH = (ADULT.upper_arm + ADULT.forearm + PALM_FRACTION * ADULT.hand) * ADULT.height

places = st.tuples(*[st.floats(-1.0, 1.0, allow_subnormal=False)] * 3)


def standing_torso(
    sites: tuple[Site, ...] = (), compensated: bool = True
) -> tuple[Torso, LinkageSimulation, ArmController]:
    """Returns a torso with a force field on the right hand; the left arm hangs."""
    torso = build_torso(ADULT, sites, compensated=compensated)
    moving = LinkageSimulation(torso.linkage, TICK / STEPS)
    for side in HANDS:
        own = slice(torso.arm(side).start, torso.wrist(side).stop)
        moving.q[own] = hanging_posture()
    moving.targets[:] = moving.q
    moving.settle()
    arms = [ArmController(side, torso, moving, FIELD_RATE, False) for side in HANDS]
    arms[0].drive(True)
    return torso, moving, arms[0]


def simulate_arm(
    moving: LinkageSimulation, arm: ArmController, seconds: float, start: float = 0.0
) -> Array:
    """Returns the positions (n, 3) of the hand, one per tick [m]."""
    rows = []
    for k in range(round(seconds / TICK)):
        arm.control(start + k * TICK)
        done = 0
        while done < STEPS:
            done += moving.advance(STEPS - done)
        rows.append(moving.places[arm.palm].copy())
    return np.array(rows)


@given(st.lists(st.tuples(places, st.floats(0.01, 1.0)), min_size=1, max_size=6))
def test_weighted_point_lies_in_convex_hull(fields) -> None:
    points = [point for point, _ in fields]
    weights = np.array([weight for _, weight in fields])
    weights /= weights.sum()
    point = weighted_point(points, weights.tolist())
    # Support function of the hull, in random directions.
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(40, 3))
    along = np.array(points) @ directions.T
    own = np.array(point) @ directions.T
    assert (own <= along.max(axis=0) + 1e-12).all()
    # The sum of the fields is zero there.
    each = [FIELD_RATE * (np.array(p) - point) for p in points]
    np.testing.assert_allclose((weights[:, None] * each).sum(axis=0), 0.0, atol=1e-11)
    assert strongest_point(points, weights.tolist()) == points[int(np.argmax(weights))]


@given(places, places, st.floats(0.1, 50.0))
def test_field_points_to_equilibrium_point(point, x, rate) -> None:
    v = np.array(desired_velocity(point, x, rate))
    d = np.array(point) - x
    assert np.linalg.norm(np.cross(v, d)) <= 1e-9
    assert v @ d >= 0.0
    assert np.linalg.norm(v) <= SPEED_LIMIT + 1e-12
    assert desired_velocity(point, point, rate) == (0.0, 0.0, 0.0)


def test_minimum_jerk_step_has_derivative_and_inverse() -> None:
    s = np.linspace(0, 1, 101)
    np.testing.assert_allclose([minimum_jerk_step(float(x))[0] for x in s], ease(s), atol=1e-15)
    h = 1e-6
    for x in (0.1, 0.4, 0.77):
        slope = (minimum_jerk_step(x + h)[0] - minimum_jerk_step(x - h)[0]) / (2 * h)
        assert minimum_jerk_step(x)[1] == pytest.approx(slope, rel=1e-7)
        assert minimum_jerk_phase(minimum_jerk_step(x)[0]) == pytest.approx(x, abs=1e-9)


def test_equilibrium_point_stays_in_bounds_for_any_hand_motion() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        places = rng.uniform(-1, 1, (4, 3))
        fields = HandField(np.zeros(3), FIELD_RATE, False)
        fields.go([0, 1, 2, 3], 0.0, 1.0, places)
        low, high = np.minimum(places.min(axis=0), 0.0), np.maximum(places.max(axis=0), 0.0)
        for now in np.arange(0.0, 2.5, 0.01):
            fields.desired(tuple(rng.uniform(-1, 1, 3).tolist()), float(now), places)
            assert (np.array(fields.point) >= low - 1e-12).all()
            assert (np.array(fields.point) <= high + 1e-12).all()
        np.testing.assert_allclose(fields.point, places[3], atol=1e-12)


def test_leg_starts_do_not_depend_on_control_rate() -> None:
    places = np.array([[0.0, 0.0, 0.0], [0.3, 0.2, 0.0], [0.1, 0.5, 0.2], [0.4, 0.4, 0.4]])
    found = []
    for rate in (96, 97, 480, 5000):
        fields = HandField(places[0], FIELD_RATE, False)
        fields.go([1, 2, 3], 0.0, 1.2, places)
        lag = 0.013
        for k in range(round(1.5 * rate)):
            # A hand that lags behind the point by a fixed time.
            now = k / rate
            s = np.interp(now - lag, [0.0, 0.3, 0.7, 1.2], [0.0, 1.0, 2.0, 3.0])
            x = [np.interp(s, range(4), places[:, i]) for i in range(3)]
            fields.desired((x[0], x[1], x[2]), now, places)
        found.append([leg.start for leg in fields.legs])
        assert len(fields.legs) == 3
    np.testing.assert_allclose(found[:-1], [found[-1]] * 3, atol=2e-4)


@pytest.mark.parametrize("time", [0.5, 0.8, 1.2])
@pytest.mark.parametrize("place", [(0.45, 1.3, 0.3), (0.3, 1.6, 0.45), (0.55, 1.15, 0.12)])
def test_free_reach_has_bell_shaped_speed(place, time) -> None:
    torso, moving, arm = standing_torso((Site("goal", -1, np.array(place)),))
    start = moving.places[arm.palm].copy()
    arm.fields.stay(start)
    arm.fields.go([torso.site("goal")], 0.0, time, moving.places)
    path = np.concatenate([start[None], simulate_arm(moving, arm, time + 0.3)])
    assert np.linalg.norm(path[-1] - place) < 0.005
    speed = np.linalg.norm(np.diff(path, axis=0), axis=1) / TICK
    top = int(np.argmax(speed))
    # One peak, within 3 % of its height.
    tolerance = 0.03 * speed[top]
    assert (np.maximum.accumulate(speed[: top + 1]) - speed[: top + 1]).max() < tolerance
    assert (speed[top:] - np.minimum.accumulate(speed[top:])).max() < tolerance
    t = (np.arange(len(speed)) + 0.5) * TICK / time
    bell = np.where(t < 1, 30 * t**2 * (1 - t) ** 2, 0.0)
    assert np.corrcoef(speed, bell)[0, 1] > 0.95


def clearance(start: Array, end: Array, torso: Torso) -> float:
    """Returns the distance of a straight segment from the trunk and head [m]."""
    x = start + np.linspace(0, 1, 31)[:, None] * (end - start)
    least = np.inf
    for link in torso.linkage.links[:3]:
        for solid in link.solids:
            a, b = solid.ends
            s = np.clip((x - a) @ (b - a) / max((b - a) @ (b - a), 1e-12), 0.0, 1.0)
            away = np.linalg.norm(x - a - s[:, None] * (b - a), axis=1)
            least = min(least, away.min() - solid.radius)
    return float(least)


@pytest.mark.parametrize(
    ("count", "seed"),
    [
        pytest.param(50, 1, marks=pytest.mark.slow),
        pytest.param(500, 2, marks=pytest.mark.nightly),
    ],
)
def test_random_reaches_arrive_without_penetration(count: int, seed: int) -> None:
    """Start and goal are random reachable points, behind the back too."""
    rng = np.random.default_rng(seed)
    torso, moving, arm = standing_torso()
    home, own, done, retries = moving.q.copy(), torso.arm("r"), 0, 0
    lower, upper = np.radians([HINGE_LIMITS[joint] for joint in ARM]).T
    # Further abduction repeats postures with another flexion.
    upper[1] = np.radians(90.0)

    def random_posture() -> tuple[Array, Array]:
        while True:
            moving.q[:], moving.v[:] = home, 0.0
            moving.q[own] = rng.uniform(lower, upper)
            moving.settle()
            if not moving.touches():
                return moving.q[own].copy(), moving.places[arm.palm].copy()

    while done < count:
        goal, (angles, start) = random_posture()[1], random_posture()
        away = [np.linalg.norm(x - SHOULDER) for x in (start, goal)]
        if max(away) > REACH - 0.05 or clearance(start, goal, torso) < 0.05:
            continue
        moving.q[:], moving.v[:] = home, 0.0
        moving.q[own] = angles
        moving.targets[:] = moving.q
        moving.settle()
        arm.fields.stay(start)
        arm.trace(goal[None], reaching_posture(), 0.0, 1.0)
        now = 0.0
        for _ in range(10):
            hand = simulate_arm(moving, arm, 1.5, now)[-1]
            now += 1.5
            if np.linalg.norm(hand - goal) < POSITION_TOLERANCE and arm.by_fields:
                break
        assert np.linalg.norm(hand - goal) < POSITION_TOLERANCE, (angles, start, goal, hand)
        retries += arm.retry_until > 0.0
        done += 1
    assert retries < 0.1 * count


def blocked_reach() -> tuple[LinkageSimulation, ArmController, Array, float]:
    """Returns an arm at the start of a retreat, its goal, and the time."""
    torso, moving, arm = standing_torso()
    moving.q[torso.arm("r")] = [1.07, -0.70, -1.69, 1.26]
    moving.targets[:] = moving.q
    moving.settle()
    goal = np.array([-0.139, 1.196, 0.311])
    arm.fields.stay(moving.places[arm.palm])
    arm.trace(goal[None], reaching_posture(), 0.0, 1.0)
    now = 0.0
    while arm.by_fields:
        assert now < 4.0
        simulate_arm(moving, arm, TICK, now)
        now += TICK
    return moving, arm, goal, now


def test_hand_blocked_by_trunk_retreats_and_reaches_goal() -> None:
    moving, arm, goal, now = blocked_reach()
    # The forearm is blocked by the belly.
    assert np.linalg.norm(moving.places[arm.palm] - goal) > 0.05
    hand = simulate_arm(moving, arm, 2.5, now)[-1]
    assert arm.by_fields
    assert arm.retry_until < now + 2.5
    assert np.linalg.norm(hand - goal) < POSITION_TOLERANCE


def test_new_order_ends_retreat() -> None:
    moving, arm, _, now = blocked_reach()
    posture = hanging_posture()
    arm.drive(False)
    arm.turn((posture,), now, now + 0.8)
    simulate_arm(moving, arm, 2.0, now)
    assert not arm.by_fields
    np.testing.assert_allclose(moving.q[arm.all], posture, atol=0.05)
    moving, arm, _, now = blocked_reach()
    arm.hold(now)
    hand = moving.places[arm.palm].copy()
    assert arm.by_fields
    assert np.linalg.norm(simulate_arm(moving, arm, 2.0, now)[-1] - hand) < 0.05


def test_uncompensated_arm_sags_by_weight_over_field_stiffness() -> None:
    goal = np.array([0.42, 1.25, 0.25])
    found = []
    for compensated in (True, False):
        torso, moving, arm = standing_torso(compensated=compensated)
        arm.fields.stay(goal)
        simulate_arm(moving, arm, 2.0)
        x = moving.places[arm.palm]
        found.append(x - goal)
        # At rest the field force c k (goal - x) balances gravity.
        force = torso.linkage.drag * FIELD_RATE * (goal - x)
        own = torso.arm("r")
        J = moving.jacobian(0)[:, own]
        balance = J.T @ force + moving.push[own] - moving.data.qfrc_bias[own]
        balance += moving.data.qfrc_gravcomp[own]
        np.testing.assert_allclose(balance, 0.0, atol=0.15)
    assert np.linalg.norm(found[0]) < 0.001
    assert found[1][1] < -0.0015


def test_posture_spline_interpolates_and_rests_at_both_ends() -> None:
    rng = np.random.default_rng(2)
    keys = [rng.normal(size=7) for _ in range(5)]
    passage = PostureSpline(keys, 1.0, 3.0)
    times = np.linspace(1.0, 3.0, 4001)
    q, v = (np.array(column) for column in zip(*(passage.at(float(t)) for t in times), strict=True))
    for key in keys:
        assert np.abs(q - key).max(axis=1).min() < 2e-3
    np.testing.assert_allclose(np.gradient(q, times, axis=0)[5:-5], v[5:-5], atol=1e-3)
    np.testing.assert_allclose(v[[0, -1]], 0.0, atol=1e-6)
    np.testing.assert_array_equal(passage.at(9.0)[0], keys[-1])


def test_spline_curvatures_match_scipy() -> None:
    interpolate = pytest.importorskip("scipy.interpolate")
    rng = np.random.default_rng(7)
    knots = np.cumsum(rng.uniform(0.1, 1.0, 6))
    keys = rng.normal(size=(6, 3))
    theirs = interpolate.CubicSpline(knots, keys, bc_type="natural")
    np.testing.assert_allclose(natural_spline_curvatures(knots, keys), theirs(knots, 2), atol=1e-10)
