"""Rigid bodies: hulls and masses against trimesh, free rotation against MuJoCo and conservation."""

from __future__ import annotations

from itertools import pairwise

import mujoco
import numpy as np
import pytest
import trimesh

from pipeline.errors import MassError
from pipeline.simulation.bodies.body_meshes import bevelled
from pipeline.simulation.bodies.body_model import body_hull
from pipeline.simulation.dynamics.free_motion import MAX_STEP_ANGLE, rotate_freely
from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.dynamics.mass import mass_of_solid
from pipeline.simulation.dynamics.rigid_body import State, angular_momentum, kinetic_energy
from pipeline.simulation.spatial import Array
from pipeline.spec.body import Body
from tests.simulation.dynamics.terrain_body_builder import (
    DT,
    POLYHEDRA,
    SHAPES,
    attitudes,
    build_terrain_bodies,
    ground_of,
)


@pytest.mark.parametrize("i", range(len(SHAPES)), ids=POLYHEDRA)
def test_masses_agree_with_trimesh(i: int) -> None:
    config = Body.model_validate({"body": SHAPES[i]}).body
    hull = body_hull(config, "")
    own = mass_of_solid(hull.vertices, hull.faces, config.density)
    theirs = trimesh.Trimesh(hull.vertices, hull.faces, process=False)
    theirs.density = config.density
    assert theirs.is_watertight
    assert own.mass == pytest.approx(theirs.mass, rel=1e-9)
    assert own.centre == pytest.approx(theirs.center_mass, abs=1e-9)
    np.testing.assert_allclose(own.inertia, theirs.moment_inertia, rtol=0, atol=1e-9 * own.mass)


@pytest.mark.parametrize(
    ("shape", "facets"),
    [("tetrahedron", 4), ("cube", 6), ("octahedron", 8), ("dodecahedron", 12), ("icosahedron", 20)],
)
def test_regular_solids_are_regular(shape: str, facets: int) -> None:
    hull = body_hull(Body.model_validate({"body": {"shape": shape}}).body, "")
    assert len(hull.facets) == facets
    assert len(hull.vertices) - len(hull.edges) + len(hull.facets) == 2
    ends = hull.vertices[hull.edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    np.testing.assert_allclose(lengths, lengths[0], rtol=1e-12)
    moments = np.linalg.eigvalsh(mass_of_solid(hull.vertices, hull.faces, 1.0).inertia)
    np.testing.assert_allclose(moments, moments[0], rtol=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_hulls_contain_their_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(5, 300)), 3))
    if seed % 2:
        # On a grid many points lie in one plane, in one line, or on one another.
        points = np.round(points)
    hull = hull_of(points)
    offsets = [
        float(n @ hull.vertices[f[0]]) for n, f in zip(hull.normals, hull.facets, strict=True)
    ]
    assert (points @ hull.normals.T - offsets).max() < 1e-9
    theirs = trimesh.Trimesh(hull.vertices, hull.faces, process=False)
    assert theirs.is_watertight
    assert len(hull.vertices) - len(hull.edges) + len(hull.facets) == 2


def test_flat_points_have_no_hull() -> None:
    with pytest.raises(MassError, match="in one plane"):
        hull_of(np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1.0]]))
    with pytest.raises(MassError, match="in one line"):
        hull_of(np.outer(np.arange(5.0), [1.0, 2.0, 3.0]))


def test_points_within_rounding_of_one_another_have_a_hull_or_are_refused() -> None:
    """Of points of very different distances rounding may leave triangles open."""
    closed = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        points = rng.normal(size=(12, 3))
        near = rng.normal(size=(9, 3)) * 10.0 ** rng.uniform(-12, -4, (9, 1))
        points = np.concatenate([points * [1.0, 1.0, 1e-9], near])
        try:
            hull = hull_of(points)
        except MassError:
            continue
        assert trimesh.Trimesh(hull.vertices, hull.faces, process=False).is_watertight
        closed += 1
    # To refuse all of them would be no answer.
    assert closed > 30


@pytest.mark.parametrize("shape", ["cube", "tetrahedron", "dodecahedron", "pyramid"])
def test_bevels_stay_inside_and_on_the_facets(shape: str) -> None:
    hull = body_hull(Body.model_validate({"body": {"shape": shape}}).body, "")
    offsets = np.array(
        [n @ hull.vertices[f[0]] for n, f in zip(hull.normals, hull.facets, strict=True)]
    )
    out = bevelled(hull).vertices @ hull.normals.T - offsets
    assert out.max() < 1e-12
    # Every facet is still touched: it stands as it would without.
    assert (np.abs(out).min(axis=0) < 1e-9).all()


MOMENTS = np.array([0.1, 0.25, 0.32])


def mujocos(q: Array, w: Array, step: float, seconds: float) -> tuple[Array, Array]:
    """Return attitude and angular velocity of a free body by MuJoCo's Runge-Kutta rule."""
    x, y, z = MOMENTS
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" integrator="RK4" gravity="0 0 0"/><worldbody><body>'
        f'<freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{x} {y} {z}"/>'
        "</body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    data.qpos[3:], data.qvel[3:] = q, w
    for _ in range(round(seconds / step)):
        mujoco.mj_step(model, data)
    return data.qpos[3:].copy(), data.qvel[3:].copy()


@pytest.mark.sample(2)
@pytest.mark.parametrize("seed", range(5))
def test_free_rotation_agrees_with_mujoco(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, w = attitudes(rng, 1), rng.normal(size=(1, 3)) * 4.0
    inertia, step = np.diag(MOMENTS)[None], 1e-3
    theirs = mujocos(q[0], w[0], step, 5.0)
    for _ in range(5000):
        rotate_freely(q, w, inertia, np.linalg.inv(inertia), step)
    sign = np.sign(q[0] @ theirs[0])
    np.testing.assert_allclose(sign * q[0], theirs[0], atol=1e-9)
    np.testing.assert_allclose(w[0], theirs[1], atol=1e-9)


def test_the_series_of_a_step_has_converged() -> None:
    rng = np.random.default_rng(8)
    q, w = attitudes(rng, 50), rng.normal(size=(50, 3))
    inertia = np.tile(np.diag([0.05, 0.5, 0.52]), (50, 1, 1))
    inverse = np.linalg.inv(inertia)
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    whole, halves = (q.copy(), w.copy()), (q.copy(), w.copy())
    rotate_freely(*whole, inertia, inverse, MAX_STEP_ANGLE)
    for _ in range(2):
        rotate_freely(*halves, inertia, inverse, MAX_STEP_ANGLE / 2)
    for a, b in zip(whole, halves, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)


def test_momentum_and_energy_are_conserved_in_flight() -> None:
    falling = build_terrain_bodies(SHAPES, ground_of("flat"))
    bodies, rng = falling.bodies, np.random.default_rng(4)
    n = len(SHAPES)
    state = State(np.zeros((n, 3)), attitudes(rng, n), np.zeros((n, 3)), np.zeros((n, 3)))
    state.w = rng.normal(size=(n, 3)) * 5.0
    turning, moving = angular_momentum(bodies, state), kinetic_energy(bodies, state.v, state.w)
    for _ in range(5 * 240):
        rotate_freely(state.q, state.w, bodies.inertia, bodies.inverse, 1 / 240)
    scale = np.linalg.norm(turning, axis=1, keepdims=True)
    np.testing.assert_allclose(angular_momentum(bodies, state) / scale, turning / scale, atol=1e-9)
    np.testing.assert_allclose(kinetic_energy(bodies, state.v, state.w), moving, rtol=1e-9)


def test_a_flight_is_a_parabola_at_any_spin() -> None:
    falling = build_terrain_bodies(SHAPES, ground_of("flat"))
    state, n = falling.state, len(SHAPES)
    rng = np.random.default_rng(1)
    state.v[:], state.w[:] = rng.normal(size=(2, n, 3)) * 6.0
    p, v, spin = state.p.copy(), state.v.copy(), angular_momentum(falling.bodies, state)
    for _ in range(96 * 2):
        falling.advance(DT)
    expected = p + 2.0 * v - [0.0, 0.5 * 9.81 * 4.0, 0.0]
    np.testing.assert_allclose(state.p, expected, atol=1e-10)
    np.testing.assert_allclose(angular_momentum(falling.bodies, state), spin, atol=1e-10)


def test_scalar_inertia_spins_at_a_constant_rate() -> None:
    config = {"shape": "box", "size": [0.8, 0.1, 0.3]}
    falling = build_terrain_bodies([config, config | {"inertia": "scalar"}], ground_of("flat"))
    falling.state.w[:] = [0.2, 0.3, 6.0]
    seen = [falling.state.w.copy()]
    for _ in range(96):
        falling.advance(DT)
        seen.append(falling.state.w.copy())
    w = np.array(seen)
    np.testing.assert_allclose(w[:, 1], np.tile(w[0, 1], (97, 1)), atol=1e-12)
    changes = [float(np.abs(b - a).max()) for a, b in pairwise(w[:, 0])]
    assert max(changes) > 1e-3
