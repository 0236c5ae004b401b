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
    face_down,
    ground_of,
    still,
    thrown,
)

BALL = {"shape": "sphere", "radius": 0.2}
FALLING = (BALL, *(words for words in SHAPES if words["shape"] not in ("pyramid", "hull")))

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


def run(bouncing: TerrainBodies, seconds: float) -> list[tuple[float, GroundImpact]]:
    """Go on for some seconds; return the times of impacts, and the impacts."""
    found = []
    for k in range(round(seconds / DT)):
        found += [(k * DT + one.time, one) for one in bouncing.advance(DT)]
    return found


def speeds(impacts: Sequence[tuple[float, GroundImpact]], body: int) -> Array:
    return np.array([one.speed for _, one in impacts if one.body == body])


def dropped_flat(b: float, height: float, **more: Any) -> TerrainBodies:
    """Return balls and polyhedra at rest over flat ground, each on a facet."""
    ground = ground_of(TERRAINS["flat"])
    bouncing = thrown(FALLING, ground, bounciness=b, **more)
    hulls = bouncing.bodies.hulls
    low = np.array([BALL["radius"] if hull is None else hull.offsets[0] for hull in hulls])
    p = np.column_stack([np.linspace(-8, 8, len(low)), low + height, np.zeros(len(low))])
    bouncing.state.put(np.arange(len(low)), still(p, face_down(bouncing)))
    bouncing.find_contacts()
    return bouncing


@pytest.mark.slow
@pytest.mark.parametrize("b", [0.3, 0.8])
def test_bounce_heights_follow_bounciness(b: float) -> None:
    impacts = run(dropped_flat(b, 1.0, friction=0.0), 4.5)
    first = np.sqrt(2.0 * 9.81)
    expected = first * b ** np.arange(40)
    expected = expected[expected > REST_SPEED * 1.001]
    for body in range(len(FALLING)):
        found = speeds(impacts, body)
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
    words = [BALL, SHAPES[4], SHAPES[0]]
    chance = np.random.default_rng(2)
    state = still([[0, 1, 0], [2, 1, 0], [4, 1, 0]], attitudes(chance, 3))
    bouncing = thrown(
        words, ground_of("{kind: flat, size: [100, 100]}"), state, bounciness=1.0, friction=0.0
    )
    before, seen = total_energy(bouncing.bodies, bouncing.state), 0
    while seen < count:
        seen += sum(one.body == 0 for one in bouncing.advance(0.25))
    np.testing.assert_allclose(total_energy(bouncing.bodies, bouncing.state), before, rtol=1e-3)


def drops(chance: np.random.Generator, count: int, terrain: str) -> TerrainBodies:
    """Return bodies of any kind in any state above a terrain."""
    words = []
    for i in range(count):
        shape = (*SHAPES, BALL)[i % (len(SHAPES) + 1)]
        b, mu = chance.uniform(0, 0.97), chance.choice([0.0, chance.uniform(0, 1.2)])
        words.append({**shape, "bounciness": float(b), "friction": float(mu)})
    ground = ground_of(TERRAINS[terrain], int(chance.integers(1000)))
    x, z = chance.uniform(-7, 7, (2, count))
    p = np.column_stack([x, ground.height(x, z) + 0.6 + chance.uniform(0, 2, count), z])
    v, w = chance.normal(size=(2, count, 3)) * [[[2.0]], [[6.0]]]
    bouncing = thrown(words, ground, State(p, attitudes(chance, count), v, w))
    # Walls beside it may be higher than what is right below a body.
    while (deep := bouncing.depths() > 0.0).any():
        bouncing.state.p[deep, 1] += 0.5
        bouncing.find_contacts()
    return bouncing


@pytest.mark.parametrize("terrain", TERRAINS)
@pytest.mark.parametrize(
    "count",
    [
        pytest.param(10, marks=pytest.mark.slow, id="110"),
        pytest.param(100, marks=pytest.mark.nightly, id="1100"),
    ],
)
def test_energy_never_rises_and_no_body_sinks(terrain: str, count: int) -> None:
    bouncing = drops(np.random.default_rng(count), count, terrain)
    before = total_energy(bouncing.bodies, bouncing.state)
    for _ in range(96 * 5):
        bouncing.advance(DT)
        after = total_energy(bouncing.bodies, bouncing.state)
        over = bouncing.state.p[:, 1] > -5.0
        assert (after - before <= 1e-9 * np.abs(before))[over].all()
        before = after
        assert (bouncing.depths() <= 0.01 * bouncing.bodies.size).all()
    # Whose middle is not above the ground has gone through it.
    p = bouncing.state.p
    there = bouncing.ground.field.inside(p[:, 0], p[:, 2])
    assert (p[:, 1] > bouncing.ground.height(p[:, 0], p[:, 2]))[there].all()


@pytest.mark.slow
@pytest.mark.parametrize("terrain", TERRAINS)
def test_no_body_tunnels_at_fifty_metres_a_second(terrain: str) -> None:
    chance = np.random.default_rng(7)
    bouncing = drops(chance, 24, terrain)
    way = chance.normal(size=(24, 3))
    way[:, 1] = -np.abs(way[:, 1]) * chance.uniform(0, 1, 24)
    bouncing.state.v[:] = 50.0 * way / np.linalg.norm(way, axis=1, keepdims=True)
    for _ in range(60):
        bouncing.advance(DT)
        assert (bouncing.depths() <= 0.01 * bouncing.bodies.size).all()
        p = bouncing.state.p
        there = bouncing.ground.field.inside(p[:, 0], p[:, 2])
        assert (p[:, 1] > bouncing.ground.height(p[:, 0], p[:, 2]))[there].all()


def test_a_body_under_the_terrain_falls_on() -> None:
    state = still([[10.5, -2.0, 0.0]])
    state.v[:] = [-8.0, 0.0, 0.0]
    bouncing = thrown([{"shape": "cube"}], ground_of(TERRAINS["flat"]), state)
    assert run(bouncing, 1.0) == []
    np.testing.assert_allclose(bouncing.state.p[0], [2.5, -2.0 - 0.5 * 9.81, 0.0], atol=1e-3)


def test_resting_bodies_are_silent_and_sleep() -> None:
    bouncing = dropped_flat(0.3, 0.3)
    impacts = run(bouncing, 2.5)
    assert not bouncing.awake.any()
    assert max(time for time, _ in impacts) < 1.2
    where = bouncing.state.p.copy()
    assert run(bouncing, 0.5) == []
    np.testing.assert_array_equal(bouncing.state.p, where)
    assert (np.abs(bouncing.depths()) < 1e-4 * bouncing.bodies.size).all()


@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_sliding_stops_at_the_friction_distance(mu: float) -> None:
    words = {"shape": "box", "size": [0.6, 0.1, 0.6], "friction": mu, "bounciness": 0.0}
    state = still([[0.0, 0.05, 0.0]])
    state.v[:] = [2.0, 0.0, 0.0]
    bouncing = thrown([words], ground_of("{kind: flat, size: [20, 20]}"), state)
    run(bouncing, 2.0 / (mu * 9.81) + 0.3)
    assert bouncing.state.p[0, 0] == pytest.approx(2.0**2 / (2.0 * mu * 9.81), rel=2e-3)
    assert abs(bouncing.state.p[0, 2]) < 1e-6


def test_a_ball_rolls_down_at_five_sevenths_of_gravity() -> None:
    ramp = "{kind: ramp, size: [40, 10], slope_deg: 15, course: up, start: -15, height: 8}"
    ground = ground_of(ramp)
    slope = np.radians(15.0)
    x = 10.0
    top = float(ground.height(np.array(x), np.array(0.0)))
    p = [[x - 0.2 * np.sin(slope), top + 0.2 * np.cos(slope), 0.0]]
    bouncing = thrown([BALL | {"rolling": 0.0, "friction": 0.8}], ground, still(p))
    run(bouncing, 1.0)
    speed = np.linalg.norm(bouncing.state.v[0])
    assert speed == pytest.approx(5.0 / 7.0 * 9.81 * np.sin(slope), rel=2e-3)
    # It rolls: the point that touches stands still.
    assert np.linalg.norm(bouncing.state.w[0]) * 0.2 == pytest.approx(speed, rel=1e-3)


def test_rolling_resistance_stops_a_ball() -> None:
    state = still([[0.0, 0.2, 0.0]])
    state.v[:], state.w[:] = [0.6, 0.0, 0.0], [0.0, 0.0, -3.0]
    bouncing = thrown([BALL | {"rolling": 0.02}], ground_of(TERRAINS["flat"]), state)
    run(bouncing, 3.2)
    assert not bouncing.awake.any()
    # The ground's force stands before the middle by rolling × size, and slows v = ω r down.
    slowed = 5.0 / 7.0 * 9.81 * 0.02 * 0.4 / 0.2
    assert bouncing.state.p[0, 0] == pytest.approx(0.6**2 / (2.0 * slowed), rel=0.02)


def test_soft_impacts_last_their_duration() -> None:
    hard, soft = (dropped_flat(0.6, 0.5, soft=time, friction=0.0) for time in (0.0, 0.05))
    for bouncing in (hard, soft):
        while bouncing.state.p[0, 1] > 0.2:
            bouncing.advance(DT / 8)
    deepest = 0.2
    for _ in range(96):
        soft.advance(DT / 8)
        deepest = min(deepest, float(soft.state.p[0, 1]))
    # A constant force turns -u into b u over Δt: it sinks u Δt / (2 (1 + b)).
    sinks = np.sqrt(2.0 * 9.81 * 0.5) * 0.05 / 2.0 / 1.6
    assert 0.2 - deepest == pytest.approx(sinks, rel=0.02)


@pytest.mark.slow
def test_bodies_move_alike_alone_and_beside_others() -> None:
    everyone = drops(np.random.default_rng(5), 6, "fractal")
    start = everyone.state.some(np.arange(6))
    run(everyone, 1.0)
    for i in range(6):
        words_alone = drops(np.random.default_rng(5), 6, "fractal")
        bodies = words_alone.bodies.some(np.array([i]))
        alone = TerrainBodies(bodies, start.some(np.array([i])), words_alone.ground)
        run(alone, 1.0)
        np.testing.assert_array_equal(alone.state.p[0], everyone.state.p[i])
        np.testing.assert_array_equal(alone.state.q[0], everyone.state.q[i])
