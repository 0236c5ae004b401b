"""MuJoCo worlds: bounces, friction, piles, kinematic bodies, and the bridge to compiled code."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import pytest

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impact_arrays import PAIR
from pipeline.simulation.dynamics.impact_law import MEASURED_BOUNCINESS, sort_pairs
from pipeline.simulation.dynamics.kinematic_bodies import Poses
from pipeline.simulation.dynamics.mujoco_callback import array_at, layout_of
from pipeline.simulation.dynamics.mujoco_model import add_ground
from pipeline.simulation.dynamics.mujoco_world import TERRAIN, MujocoWorld
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.terrain.heightfield import HeightField, QuadField
from tests.simulation.dynamics.collision_worlds import (
    FLAT,
    STEP,
    ball,
    box,
    initial_state,
    polyhedron,
    run,
    world_of,
)

CUBE = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
WALL = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def speed_ratios(strikes: list, body: int) -> list[float]:
    """Return the speed of each bounce of a body relative to the one before."""
    speeds = [s.speed for _, s in strikes if s.one == body and s.speed > 0.3]
    return [b / a for a, b in pairwise(speeds)]


@pytest.mark.parametrize("b", [b for b in MEASURED_BOUNCINESS if 0.0 < b < 1.0])
def test_ball_box_and_polyhedron_bounce_by_their_bounciness(b: float) -> None:
    bodies = [ball(0.15, b), box((0.3, 0.3, 0.3), b), polyhedron(1.5 * np.array(CUBE), b)]
    strikes = run(world_of(bodies, [[-1, 1.15, 0], [0, 1.15, 0], [1, 1.15, 0]]), 2.0)
    for body in range(3):
        found = speed_ratios(strikes, body)
        assert found
        np.testing.assert_allclose(found, b, atol=0.015)


def test_bodies_without_bounciness_stay_down() -> None:
    world = world_of([ball(0.15, 0.0), box((0.3, 0.3, 0.3), 0.0)], [[0, 1.15, 0], [1, 1.15, 0]])
    strikes = run(world, 1.5)
    assert sorted(s.one for _, s in strikes) == [0, 1]
    np.testing.assert_allclose(world.state.p[:, 1], 0.15, atol=1e-4)


@pytest.mark.parametrize(("b", "c"), [(0.5, 0.5), (0.2, 0.9), (0.95, 0.95)])
def test_lower_bounciness_of_two_balls_decides_and_momentum_is_conserved(
    b: float, c: float
) -> None:
    bodies = [ball(0.1, b, 0.0, mass=1.0), ball(0.1, c, 0.0, mass=3.0)]
    world = world_of(bodies, [[-0.5, 8, 0], [0.5, 8, 0]], [[3.0, 0, 0], [-1.0, 0, 0]])
    (_, strike), *_ = run(world, 0.4)
    v = world.state.v[:, 0]
    assert (v[1] - v[0]) / 4.0 == pytest.approx(min(b, c), abs=0.015)
    assert v @ [1.0, 3.0] == pytest.approx(0.0, abs=1e-9)
    assert {strike.one, strike.other} == {0, 1}
    assert strike.speed == pytest.approx(4.0, rel=1e-3)
    assert strike.energy == pytest.approx(0.5 * 0.75 * 16.0, rel=2e-3)
    assert strike.normal == pytest.approx((-1.0, 0.0, 0.0), abs=1e-3)


def test_strike_has_its_time_place_speed_and_energy() -> None:
    world = world_of([ball(0.15, 0.5)], [[0.3, 1.15, 0.2]])
    (time, strike), *_ = run(world, 1.0)
    assert strike.other == TERRAIN
    assert time == pytest.approx(np.sqrt(2.0 / GRAVITY), abs=1e-3)
    assert strike.speed == pytest.approx(np.sqrt(2.0 * GRAVITY), rel=3e-3)
    assert strike.energy == pytest.approx(GRAVITY, rel=6e-3)
    np.testing.assert_allclose(strike.place, [0.3, 0.0, 0.2], atol=5e-3)


def test_ball_leaves_a_moving_wall_at_twice_its_speed() -> None:
    world = world_of([ball(0.1, 1.0, 0.0)], [[0.0, 5.0, 0.0]], pushers=[WALL])
    start, v = np.array([[-0.6, 5.0, 0.0]]), np.array([[3.0, 0.0, 0.0]])
    world.place_pushers(Poses(start, np.eye(3)[None]))
    for i in range(40):
        world.advance(Poses(start + (i + 1) * STEP * v, np.eye(3)[None]))
    assert world.state.v[0, 0] == pytest.approx(6.0, rel=0.01)
    end = world.data.qpos.reshape(-1, 7)[1, :3]
    np.testing.assert_allclose(end, (start + 40 * STEP * v)[0], atol=1e-4)


def test_ball_leaves_a_turning_wall_at_twice_the_speed_of_its_surface() -> None:
    world = world_of([ball(0.05, 1.0, 0.0)], [[0.2, 5.0, 0.8]], pushers=[WALL])
    angles = 2.0 * STEP * np.arange(60)
    R = np.array(
        [[[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]] for a in angles]
    )
    world.place_pushers(Poses(np.array([[0.0, 5.0, 0.0]]), R[:1]))
    for k in range(1, 60):
        world.advance(Poses(np.array([[0.0, 5.0, 0.0]]), R[k : k + 1]))
    v = world.state.v[0, [0, 2]]
    # The surface moves at 2 rad/s times its arm, 0.8 m or a little more where they meet.
    assert 3.0 < np.hypot(*v) < 3.6


def test_sliding_distance_follows_coulomb_friction() -> None:
    world = world_of([box((0.3, 0.1, 0.3), 0.0, 0.4)], [[0, 0.05, 0]], [[3.0, 0, 0]])
    run(world, 2.0)
    assert world.state.p[0, 0] == pytest.approx(9.0 / (2.0 * 0.4 * GRAVITY), rel=0.02)


def test_frictionless_box_keeps_its_speed() -> None:
    world = world_of([box((0.3, 0.1, 0.3), 0.0, 0.0)], [[0, 0.05, 0]], [[3.0, 0, 0]])
    run(world, 2.0)
    assert world.state.v[0, 0] == pytest.approx(3.0, rel=1e-3)


@pytest.mark.parametrize("b", [0.5, 0.9])
def test_friction_impulse_of_a_bounce_spins_the_ball(b: float) -> None:
    world = world_of([ball(0.1, b, 0.2)], [[0, 0.3, 0]], [[6.0, 0, 0]])
    run(world, 0.25)
    impulse = (1.0 + b) * np.sqrt(2.0 * GRAVITY * 0.2)
    assert world.state.w[0, 2] == pytest.approx(-0.2 * impulse / (0.4 * 0.1), rel=0.05)


def test_stack_of_ten_stands_for_a_minute_and_sleeps() -> None:
    places = [[0, 0.15 + 0.3 * k, 0] for k in range(10)]
    world = world_of([box((0.3, 0.3, 0.3))] * 10, places)
    assert run(world, 60.0) == []
    np.testing.assert_allclose(world.state.p, places, atol=1e-3)
    assert world.asleep.all()


@pytest.mark.nightly
@pytest.mark.parametrize("b", [0.3, 0.6])
def test_wall_of_fifty_comes_to_rest_after_a_blow(b: float) -> None:
    places = [
        [0.242 * (k - 4 + 0.5 * (row % 2)), 0.0355 + 0.071 * row, 0.0]
        for row in range(6)
        for k in range(8 + (row + 1) % 2)
    ][:50]
    bodies = [box((0.24, 0.071, 0.115), b, 0.6)] * 50
    bodies.append(ball(0.12, 0.2, 0.6, mass=15.0))
    velocities = [[0, 0, 0]] * 50 + [[0, 0, -7.0]]
    world = world_of(bodies, [*places, [0, 0.25, 1.0]], velocities)
    run(world, 6.0)
    moved = np.abs(world.state.p[:50] - places).max(axis=1)
    assert (moved > 0.1).sum() > 5
    assert np.abs(world.state.v[:50]).max() < 0.02
    # Sleeping bodies rest by definition; no body penetrates another.
    assert all(overlap.depth < 0.01 * 0.24 for overlap in world.overlaps())


@pytest.mark.parametrize("speed", [20.0, 50.0])
def test_fast_bodies_do_not_tunnel(speed: float) -> None:
    # A plate and a ball, both thinner than they move in a step, and the ground.
    plate = box((2.0, 2.0, 0.04), 0.2)
    world = world_of([plate, ball(0.05, 0.5)], [[0, 3, 0], [0, 3, 1]], [[0, 0, 0], [0, 0, -speed]])
    run(world, 0.3)
    assert world.state.p[1, 2] > world.state.p[0, 2]
    world = world_of([ball(0.05, 0.5)], [[0, 1, 0]], [[0, -speed, 0]])
    run(world, 0.1)
    assert world.state.v[0, 1] == pytest.approx(0.5 * speed, rel=0.05)


def test_collision_geometry_of_the_ground_is_its_surface() -> None:
    rng = np.random.default_rng(1)
    for kind in (HeightField, QuadField):
        field = kind(rng.random((8, 12)), (5.0, 4.0), (1.0, -2.0), 0.7)
        spec = mujoco.MjSpec()
        add_ground(spec, mujoco, field, {}, False)
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        worst, hit = 0.0, np.zeros(1, dtype=np.int32)
        for u, v in rng.uniform(-0.49, 0.49, (200, 2)):
            x, z = field.to_world(np.array(5.0 * u), np.array(4.0 * v))
            down = mujoco.mj_ray(model, data, [x, 9.0, z], [0, -1, 0], None, 1, -1, hit)
            worst = max(worst, abs(9.0 - down - float(field.height(x, z))))
        # Quadrilaterals within a twenty-fourth of their twist, which is up to 2 here.
        assert worst < (1e-6 if kind is HeightField else 2.0 / 24.0)


@pytest.mark.parametrize("shape", ["box", "ball"])
def test_bodies_bounce_straight_up_from_a_level_height_field(shape: str) -> None:
    heights = np.zeros((41, 41))
    heights[0, 0] = -1.0
    body = {"box": box((0.3, 0.3, 0.3), 0.5), "ball": ball(0.15, 0.5)}[shape]
    world = world_of([body], [[0.03, 0.65, 0.01]], field=HeightField(heights, (10.0, 10.0)))
    strikes = run(world, 1.0)
    # The second landing of a box is slightly tilted.
    np.testing.assert_allclose(
        speed_ratios(strikes, 0)[: 1 if shape == "box" else 4], 0.5, atol=0.02
    )
    assert np.abs(world.state.p[0, [0, 2]] - [0.03, 0.01]).max() < 0.01


def test_slab_on_more_cells_than_contacts_lies_flat() -> None:
    heights = np.zeros((41, 41))
    heights[:, 0] = -1.0
    slab = box((2.0, 0.2, 1.5), 0.1)
    world = world_of([slab], [[0.03, 0.3, 0.01]], field=HeightField(heights, (4.0, 4.0)))
    run(world, 2.0)
    state = world.state
    assert state.p[0, 1] == pytest.approx(0.1, abs=2e-4)
    assert abs(state.q[0, [1, 3]]).max() < 1e-3
    assert world.asleep.all()


def test_box_slides_down_a_slope_at_the_closed_form_speed() -> None:
    rise = np.tile(np.linspace(4.0, 0.0, 41), (41, 1))
    field = HeightField(rise, (10.0, 10.0))
    angle = np.arctan(0.4)
    state = initial_state([[-3.0, 3.2 + 0.0502 / np.cos(angle), 0]])
    state.q[0] = [np.cos(-angle / 2), 0, 0, np.sin(-angle / 2)]
    world = MujocoWorld([box((0.3, 0.1, 0.3), 0.0, 0.1)], state, field, (), STEP)
    run(world, 1.0)
    acceleration = GRAVITY * (np.sin(angle) - 0.1 * np.cos(angle))
    assert np.hypot(*world.state.v[0, :2]) == pytest.approx(acceleration, rel=0.02)


def test_impact_callback_is_removed_after_a_step() -> None:
    mujoco.set_mjcb_passive(None)
    run(world_of([ball(0.1)], [[0, 0.2, 0]]), 0.3)
    assert mujoco.get_mjcb_passive() is None


def test_mujoco_warnings_are_logged_and_leave_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    world = world_of([ball(0.1)], [[0, 0.2, 0]])
    world.data.qvel[0] = np.nan
    mujoco.mj_step(world.model, world.data)
    assert "MuJoCo" in caplog.text
    assert not list(tmp_path.iterdir())


def test_compiled_code_reads_the_values_of_the_bindings() -> None:
    world = world_of([ball(0.1), box((0.2, 0.2, 0.2))], [[0, 0.099, 0], [0.15, 0.099, 0]])
    world.advance()
    mujoco.mj_forward(world.model, world.data)
    layout = layout_of(mujoco)
    data = array_at(world.data._address, 1, layout.data)[0]
    assert data.ncon == world.data.ncon > 2
    assert data.nefc == world.data.nefc
    assert data.time == world.data.time
    contacts = array_at(data.contact, data.ncon, layout.contact)
    for name in layout.contact.names or ():
        np.testing.assert_array_equal(contacts[name], getattr(world.data.contact, name))
    springs = array_at(data.efc_KBIP, 4 * data.nefc, np.dtype("f8"))
    np.testing.assert_array_equal(springs, world.data.efc_KBIP.ravel())


def test_sleeping_box_wakes_when_pushed() -> None:
    world = world_of([box((0.2, 0.2, 0.2))], [[0, 0.1, 0]], pushers=[WALL])
    world.place_pushers(Poses(np.array([[-3.0, 1.0, 0.0]]), np.eye(3)[None]))
    still = Poses(np.array([[-3.0, 1.0, 0.0]]), np.eye(3)[None])
    for _ in range(60):
        world.advance(still)
    assert world.asleep.all()
    for i in range(60):
        world.advance(Poses(np.array([[-3.0 + 0.1 * i, 1.0, 0.0]]), np.eye(3)[None]))
    assert world.state.p[0, 0] > 2.0


def test_pairs_stay_in_order_whatever_order_contacts_have() -> None:
    pairs = zero_records(40, PAIR)
    keys = np.random.default_rng(1).permutation(40)
    pairs["key"], pairs["onset"] = keys, 0.5 * keys
    sort_pairs.py_func(pairs, 40)
    np.testing.assert_array_equal(pairs["key"], np.arange(40))
    np.testing.assert_array_equal(pairs["onset"], 0.5 * np.arange(40))


def test_worlds_are_reproducible_to_the_bit() -> None:
    def end_state() -> bytes:
        world = world_of(
            [box((0.2, 0.2, 0.2))] * 6, [[0.05 * k, 0.1 + 0.25 * k, 0] for k in range(6)]
        )
        run(world, 1.5)
        return world.data.qpos.tobytes()

    assert end_state() == end_state()


def test_flat_ground_ends_at_its_edge() -> None:
    world = world_of([ball(0.1)], [[19.8, 0.1, 0.0]], [[2.0, 0.0, 0.0]], field=FLAT)
    run(world, 1.0)
    assert world.state.p[0, 1] < -1.0
