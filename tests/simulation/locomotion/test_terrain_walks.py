"""Walkers on every kind of terrain: they progress, keep their footholds and stop at barriers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.simulation.take import Take
from tests.simulation.conftest import Walk

pytestmark = pytest.mark.slow

MILLIMETRE = 1e-3

MAX_STOP_ACCELERATION = 5.0
"""Greatest acceleration of a stopping walker [m/s²]."""

TERRAINS = {
    "stairs": "stairs",
    "stairs down": "{preset: stairs, course: down}",
    "ramp": "ramp",
    "ditches": "ditches",
    "stones": "stones",
    "boulders": "boulders",
    "rocks": "rocks",
    "rocks of quads": "{preset: rocks, polygons: quads}",
    "rough stairs": "{kind: sum, of: [stairs, {preset: rocks, height: 0.08}]}",
}

WALKERS = {"beetle": 0.7, "spider": 0.7, "horse": 1.0, "person": 1.0}

PAIRS = [(figure, name) for figure in WALKERS for name in TERRAINS]

BARRIERS = {
    "moat": "{kind: ditches, width: 4, depth: 1, spacing: 8}",
    "cliff down": "{kind: stairs, step_height: 1.5, step_depth: 3, course: down}",
    "cliff up": "{kind: stairs, step_height: 1.5, step_depth: 3, course: up}",
}


@pytest.mark.sample(5)
@pytest.mark.parametrize(("figure", "name"), PAIRS)
def test_walkers_cross_passable_terrain(
    figure: str,
    name: str,
    scene_of: Callable[..., object],
    walk_through: Callable[..., object],
) -> None:
    member = f"{{figure: {figure}, scale: {WALKERS[figure]}, at: [-1.5, 0], walk: {{}}}}"
    # Stones lie between banks; after them quick walkers come to the end of the terrain.
    duration = 4.4 if name == "stones" and figure in ("horse", "person") else 7
    walk = walk_through(scene_of(member, terrain=TERRAINS[name], duration=duration, seed=1))
    take = walk.take
    # A shin may graze a stone.
    assert {note.kind for note in take.notes} <= {"passes_through"}
    assert take.positions[-1, 0, 0] > 2.2
    assert_feet_on_the_ground(walk)


@pytest.mark.nightly
@pytest.mark.parametrize("name", BARRIERS)
@pytest.mark.parametrize("figure", WALKERS)
def test_walkers_stop_before_barriers(
    figure: str,
    name: str,
    scene_of: Callable[..., object],
    walk_through: Callable[..., object],
) -> None:
    member = f"{{figure: {figure}, scale: {WALKERS[figure]}, at: [-1.5, 0], walk: {{}}}}"
    walk = walk_through(scene_of(member, terrain=BARRIERS[name], duration=10, seed=1))
    # A horse leans its neck, which rises no further, over the edge of a cliff as high as its chest.
    leans = ["passes_through"] if (figure, name) == ("horse", "cliff up") else []
    assert [note.kind for note in walk.take.notes] == ["stopped", *leans]
    assert_feet_on_the_ground(walk)
    # The walker stands level with its start, at rest, and stopped without a jolt.
    body = walk.take.positions[:, 0]
    assert abs(body[-1, 1] - body[0, 1]) < 0.1 * walk.walkers.herd.body_height[0]
    assert np.ptp(body[-24:], axis=0).max() < MILLIMETRE
    dt = walk.simulation.world.clock.dt
    along = np.abs(np.diff(body[:, 0], 2)).max() / dt**2
    assert along < MAX_STOP_ACCELERATION


def assert_feet_on_the_ground(walk: Walk) -> None:
    """Check that planted feet do not slip or sink and stand on steppable ground."""
    take, ground = walk.take, walk.simulation.world.ground
    down = walk.standing[1:] & walk.standing[:-1]
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)
    assert moved[down].max() < 0.1 * MILLIMETRE
    ball = np.random.default_rng(0).normal(size=(40, 3))
    ball /= np.linalg.norm(ball, axis=-1, keepdims=True)
    p = walk.tips[:, :, None] + walk.walkers.herd.foot_radius[:, None, None] * ball
    assert (p[..., 1] - ground.height(p[..., 0], p[..., 2])).min() > -MILLIMETRE
    x, y, z = np.array([contact.place for contact in take.contacts]).T
    assert ground.steppable(x, z).all()
    assert np.abs(y - ground.height(x, z)).max() < 1e-12


@pytest.mark.nightly
def test_walks_on_a_rotated_terrain_are_rotated_walks(
    scene_of: Callable[..., object], walk_through: Callable[..., object]
) -> None:
    # On uneven ground no foothold choice depends on rounding.
    beetle = "{{figure: beetle, scale: 0.7, at: [{}, {}], heading_deg: {}, walk: {{}}}}"
    ground_format = "{{preset: rocks, at: [{}, {}], heading_deg: {}}}"

    def walk(member: tuple[float, ...], terrain: tuple[float, ...]) -> Take:
        cast, ground = beetle.format(*member), ground_format.format(*terrain)
        return walk_through(scene_of(cast, terrain=ground, duration=4)).take

    straight = walk((-1.0, 0.3, 0), (0, 0, 0))
    # A quarter turn about +Y takes x to -z and z to x; the middle is moved to [5, 3].
    turned = walk((5.3, 4.0, 90), (5, 3, 90))
    x, y, z = np.moveaxis(straight.positions, -1, 0)
    expected = np.stack([z + 5, y, 3 - x], axis=-1)
    assert np.abs(turned.positions - expected).max() < 1e-6
    assert [c.part for c in turned.contacts] == [c.part for c in straight.contacts]
