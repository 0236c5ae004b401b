"""Bodies over a terrain: closed forms, non-increasing energy, no tunnelling."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from pipeline.simulation.dynamics.impact import REST_SPEED
from pipeline.simulation.dynamics.rigid_body import State, total_energy
from pipeline.simulation.dynamics.terrain_bodies import GroundImpact, TerrainBodies
from pipeline.simulation.spatial import Array
from tests.simulation.dynamics.terrain_body_builder import (
    DT,
    SHAPES,
    attitudes,
    build_terrain_bodies,
    face_down,
    ground_of,
    still,
)

BALL = {"shape": "sphere", "radius": 0.2}
FALLING = (BALL, *(config for config in SHAPES if config["shape"] not in ("pyramid", "hull")))

TERRAINS = {
    "flat": "{kind: flat, size: [20, 20]}",
    "fractal": "{kind: fractal, height: 1.5, roughness: 0.55, size: [20, 20], cells: [120, 120]}",
    "quads": "{kind: fractal, polygons: quads, height: 1.5, size: [20, 20], cells: [120, 120]}",
    "hills": "{kind: hills, size: [20, 20], cells: [120, 120]}",
    "stairs": "{kind: stairs, size: [20, 20], cells: [120, 120]}",
    "turned": "{kind: stairs, size: [20, 20], cells: [120, 120], heading_deg: 33, at: [1, 2]}",
    "ramp": "{kind: ramp, size: [20, 20], cells: [120, 120]}",
    "ditches": "{kind: ditches, size: [20, 20], cells: [280, 280]}",
    "stones": "{kind: stones, size: [20, 20], cells: [280, 280]}",
    "boulders": "{kind: boulders, size: [20, 20], cells: [280, 280]}",
    "sum": "{kind: sum, size: [20, 20], cells: [280, 280], of: [{kind: hills}, {kind: boulders}]}",
}

DEEP_AT_ONCE = {"fractal": 0.02, "stones": 0.06}
"""Depth of an edge that comes upon a corner of the ground from the side, in sizes of the body: such
a contact begins deep, and the body is pushed out within a few steps."""


def run(falling: TerrainBodies, seconds: float) -> list[tuple[float, GroundImpact]]:
    """Advance by `seconds`; return the impacts and their times [s]."""
    found = []
    for k in range(round(seconds / DT)):
        found += [(k * DT + impact.time, impact) for impact in falling.advance(DT)]
    return found


def impact_speeds(impacts: Sequence[tuple[float, GroundImpact]], body: int) -> Array:
    """Return the impact speeds of a body [m/s]."""
    return np.array([impact.speed for _, impact in impacts if impact.body == body])


def build_resting_drop(bounciness: float, height: float, **common: Any) -> TerrainBodies:
    """Return balls and polyhedra at rest over flat ground, each on a facet."""
    ground = ground_of(TERRAINS["flat"])
    falling = build_terrain_bodies(FALLING, ground, bounciness=bounciness, **common)
    hulls = falling.bodies.hulls
    low = np.array([BALL["radius"] if hull is None else hull.offsets[0] for hull in hulls])
    p = np.column_stack([np.linspace(-8, 8, len(low)), low + height, np.zeros(len(low))])
    falling.state.put(np.arange(len(low)), still(p, face_down(falling)))
    falling.find_contacts()
    return falling


@pytest.mark.slow
@pytest.mark.parametrize("b", [0.3, 0.8])
def test_bounce_heights_follow_bounciness(b: float) -> None:
    impacts = run(build_resting_drop(b, 1.0, friction=0.0), 4.5)
    first = np.sqrt(2.0 * 9.81)
    expected = first * b ** np.arange(40)
    expected = expected[expected > REST_SPEED * 1.001]
    for body in range(len(FALLING)):
        found = impact_speeds(impacts, body)
        assert len(found) == len(expected)
        # Heights go with the squares of speeds: h b^(2n) within 0.1 %.
        np.testing.assert_allclose((found / first) ** 2, (expected / first) ** 2, rtol=1e-3)


@pytest.mark.parametrize(
    "count",
    [
        pytest.param(12, id="12"),
        pytest.param(100, marks=pytest.mark.slow, id="100"),
        pytest.param(1000, marks=pytest.mark.nightly, id="1000"),
    ],
)
def test_full_bounciness_conserves_energy(count: int) -> None:
    configs = [BALL, SHAPES[4], SHAPES[0]]
    rng = np.random.default_rng(2)
    state = still([[0, 1, 0], [2, 1, 0], [4, 1, 0]], attitudes(rng, 3))
    falling = build_terrain_bodies(
        configs, ground_of("{kind: flat, size: [100, 100]}"), state, bounciness=1.0, friction=0.0
    )
    before, seen = total_energy(falling.bodies, falling.state), 0
    while seen < count:
        seen += sum(one.body == 0 for one in falling.advance(0.25))
    np.testing.assert_allclose(total_energy(falling.bodies, falling.state), before, rtol=1e-3)


def build_random_drop(rng: np.random.Generator, count: int, terrain: str) -> TerrainBodies:
    """Return bodies of all shapes in random states above a terrain."""
    configs = []
    for i in range(count):
        shape = (*SHAPES, BALL)[i % (len(SHAPES) + 1)]
        b, mu = rng.uniform(0, 0.97), rng.choice([0.0, rng.uniform(0, 1.2)])
        configs.append({**shape, "bounciness": float(b), "friction": float(mu)})
    ground = ground_of(TERRAINS[terrain], int(rng.integers(1000)))
    x, z = rng.uniform(-7, 7, (2, count))
    p = np.column_stack([x, ground.height(x, z) + 0.6 + rng.uniform(0, 2, count), z])
    v, w = rng.normal(size=(2, count, 3)) * [[[2.0]], [[6.0]]]
    falling = build_terrain_bodies(configs, ground, State(p, attitudes(rng, count), v, w))
    # A wall beside a body may be higher than the ground below its centre.
    while (deep := falling.depths() > 0.0).any():
        falling.state.p[deep, 1] += 0.5
        falling.find_contacts()
    return falling


@pytest.mark.sample(4)
@pytest.mark.parametrize("terrain", TERRAINS)
@pytest.mark.parametrize(
    "count",
    [
        pytest.param(10, marks=pytest.mark.slow, id="110"),
        pytest.param(100, marks=pytest.mark.nightly, id="1100"),
    ],
)
def test_energy_never_rises_and_no_body_sinks_into_the_ground(terrain: str, count: int) -> None:
    falling = build_random_drop(np.random.default_rng(count), count, terrain)
    before = total_energy(falling.bodies, falling.state)
    sizes, deep_steps = falling.bodies.size, np.zeros(count)
    for _ in range(96 * 5):
        falling.advance(DT)
        after = total_energy(falling.bodies, falling.state)
        over = falling.state.p[:, 1] > -5.0
        assert (after - before <= 1e-9 * np.abs(before))[over].all()
        before, depth = after, falling.depths()
        assert (depth <= DEEP_AT_ONCE.get(terrain, 0.01) * sizes).all()
        deep_steps = np.where(depth > 0.01 * sizes, deep_steps + 1, 0)
        assert deep_steps.max() <= 5
    # A centre of mass below the surface means that the body has tunnelled.
    p = falling.state.p
    inside = falling.ground.field.inside(p[:, 0], p[:, 2])
    assert (p[:, 1] > falling.ground.height(p[:, 0], p[:, 2]))[inside].all()


@pytest.mark.sample(4)
@pytest.mark.slow
@pytest.mark.parametrize("terrain", TERRAINS)
def test_no_body_tunnels_at_fifty_metres_a_second(terrain: str) -> None:
    rng = np.random.default_rng(7)
    falling = build_random_drop(rng, 24, terrain)
    way = rng.normal(size=(24, 3))
    way[:, 1] = -np.abs(way[:, 1]) * rng.uniform(0, 1, 24)
    falling.state.v[:] = 50.0 * way / np.linalg.norm(way, axis=1, keepdims=True)
    for _ in range(60):
        falling.advance(DT)
        assert (falling.depths() <= 0.01 * falling.bodies.size).all()
        p = falling.state.p
        inside = falling.ground.field.inside(p[:, 0], p[:, 2])
        assert (p[:, 1] > falling.ground.height(p[:, 0], p[:, 2]))[inside].all()


def test_a_body_under_the_terrain_falls_freely() -> None:
    state = still([[10.5, -2.0, 0.0]])
    state.v[:] = [-8.0, 0.0, 0.0]
    falling = build_terrain_bodies([{"shape": "cube"}], ground_of(TERRAINS["flat"]), state)
    assert run(falling, 1.0) == []
    np.testing.assert_allclose(falling.state.p[0], [2.5, -2.0 - 0.5 * 9.81, 0.0], atol=1e-3)


def test_resting_bodies_are_silent_and_sleep() -> None:
    falling = build_resting_drop(0.3, 0.3)
    impacts = run(falling, 2.5)
    assert not falling.awake.any()
    assert max(time for time, _ in impacts) < 1.2
    where = falling.state.p.copy()
    assert run(falling, 0.5) == []
    np.testing.assert_array_equal(falling.state.p, where)
    assert (np.abs(falling.depths()) < 1e-4 * falling.bodies.size).all()


@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_sliding_stops_at_the_friction_distance(mu: float) -> None:
    config = {"shape": "box", "size": [0.6, 0.1, 0.6], "friction": mu, "bounciness": 0.0}
    state = still([[0.0, 0.05, 0.0]])
    state.v[:] = [2.0, 0.0, 0.0]
    falling = build_terrain_bodies([config], ground_of("{kind: flat, size: [20, 20]}"), state)
    run(falling, 2.0 / (mu * 9.81) + 0.3)
    assert falling.state.p[0, 0] == pytest.approx(2.0**2 / (2.0 * mu * 9.81), rel=2e-3)
    assert abs(falling.state.p[0, 2]) < 1e-6


def test_a_ball_rolls_down_at_five_sevenths_of_gravity() -> None:
    ramp = "{kind: ramp, size: [40, 10], slope_deg: 15, course: up, start: -15, height: 8}"
    ground = ground_of(ramp)
    slope = np.radians(15.0)
    x = 10.0
    top = float(ground.height(np.array(x), np.array(0.0)))
    p = [[x - 0.2 * np.sin(slope), top + 0.2 * np.cos(slope), 0.0]]
    falling = build_terrain_bodies([BALL | {"rolling": 0.0, "friction": 0.8}], ground, still(p))
    run(falling, 1.0)
    speed = np.linalg.norm(falling.state.v[0])
    assert speed == pytest.approx(5.0 / 7.0 * 9.81 * np.sin(slope), rel=2e-3)
    # It rolls: the point that touches stands still.
    assert np.linalg.norm(falling.state.w[0]) * 0.2 == pytest.approx(speed, rel=1e-3)


def test_rolling_resistance_stops_a_ball() -> None:
    state = still([[0.0, 0.2, 0.0]])
    state.v[:], state.w[:] = [0.6, 0.0, 0.0], [0.0, 0.0, -3.0]
    falling = build_terrain_bodies([BALL | {"rolling": 0.02}], ground_of(TERRAINS["flat"]), state)
    run(falling, 3.2)
    assert not falling.awake.any()
    # The ground's force stands before the middle by rolling × size, and slows v = ω r down.
    slowed = 5.0 / 7.0 * 9.81 * 0.02 * 0.4 / 0.2
    assert falling.state.p[0, 0] == pytest.approx(0.6**2 / (2.0 * slowed), rel=0.02)


def test_soft_impacts_last_their_duration() -> None:
    hard, soft = (build_resting_drop(0.6, 0.5, soft=time, friction=0.0) for time in (0.0, 0.05))
    for falling in (hard, soft):
        while falling.state.p[0, 1] > 0.2:
            falling.advance(DT / 8)
    deepest = 0.2
    for _ in range(96):
        soft.advance(DT / 8)
        deepest = min(deepest, float(soft.state.p[0, 1]))
    # A constant force turns -u into b u over Δt: it sinks u Δt / (2 (1 + b)).
    sinks = np.sqrt(2.0 * 9.81 * 0.5) * 0.05 / 2.0 / 1.6
    assert 0.2 - deepest == pytest.approx(sinks, rel=0.02)


@pytest.mark.slow
def test_bodies_move_alike_alone_and_beside_others() -> None:
    everyone = build_random_drop(np.random.default_rng(5), 6, "fractal")
    start = everyone.state.some(np.arange(6))
    run(everyone, 1.0)
    for i in range(6):
        same_drop = build_random_drop(np.random.default_rng(5), 6, "fractal")
        bodies = same_drop.bodies.some(np.array([i]))
        alone = TerrainBodies(bodies, start.some(np.array([i])), same_drop.ground)
        run(alone, 1.0)
        np.testing.assert_array_equal(alone.state.p[0], everyone.state.p[i])
        np.testing.assert_array_equal(alone.state.q[0], everyone.state.q[i])
