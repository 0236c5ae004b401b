"""Mass properties against closed forms, laws, and trimesh."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pipeline.errors import MassError
from pipeline.simulation.dynamics.mass import MassProperties, joined, mass_of_points, mass_of_solid
from pipeline.simulation.spatial import Array, matrix, normalized

Mesh = tuple[Array, NDArray[np.int64]]
SEEDS = st.integers(0, 2**32 - 1)

# Two triangles a side, counter-clockwise from outside; corner k has the bits of k as z, y, x.
BOX = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


def box(low: Array, high: Array) -> Mesh:
    corners = np.array(list(itertools.product((0, 1), repeat=3)))
    return low + corners * (high - low), BOX


def hull(points: Array) -> Mesh:
    """Return the convex hull of points in general position: faces with none of them outside."""
    faces = []
    for i, j, k in itertools.combinations(range(len(points)), 3):
        normal = np.cross(points[j] - points[i], points[k] - points[i])
        heights = (points - points[i]) @ normal
        heights[[i, j, k]] = 0.0
        if (heights <= 0).all():
            faces.append((i, j, k))
        elif (heights >= 0).all():
            faces.append((i, k, j))
    return points, np.array(faces)


def random_hull(rng: np.random.Generator) -> Mesh:
    spread = rng.uniform(0.2, 3, 3)
    return hull(rng.normal(size=(int(rng.integers(4, 13)), 3)) * spread)


def random_pose(rng: np.random.Generator) -> Array:
    X = np.eye(4)
    X[:3, :3] = matrix(normalized(rng.normal(size=4)))
    X[:3, 3] = rng.uniform(-3, 3, 3)
    return X


def moved(X: Array, points: Array) -> Array:
    return points @ X[:3, :3].T + X[:3, 3]


def assert_same(one: MassProperties, other: MassProperties, tolerance: float = 1e-12) -> None:
    size = np.sqrt(np.trace(other.inertia) / other.mass) + np.linalg.norm(other.centre)
    assert one.mass == pytest.approx(other.mass, rel=tolerance)
    assert np.abs(one.centre - other.centre).max() <= tolerance * size
    assert np.abs(one.inertia - other.inertia).max() <= tolerance * other.mass * size**2
    assert (one.inertia == one.inertia.T).all()


def trimesh_mass(mesh: Mesh, density: float) -> MassProperties:
    """Return the mass properties by trimesh."""
    theirs = trimesh.Trimesh(*mesh, process=False)
    assert theirs.is_watertight
    theirs.density = density
    return MassProperties(theirs.mass, theirs.center_mass, theirs.moment_inertia)


def test_a_box_has_the_closed_form_inertia() -> None:
    low, sides = np.array([-1.0, 2.0, 0.5]), np.array([0.5, 1.5, 2.5])
    mass = mass_of_solid(*box(low, low + sides), density=700.0)
    m = 700.0 * sides.prod()
    inertia = np.diag(m / 12 * ((sides**2).sum() - sides**2))
    assert_same(mass, MassProperties(m, low + sides / 2, inertia), 1e-14)


def test_a_tetrahedron_has_the_closed_form_inertia() -> None:
    """With edges of 1 along the axes: about its corner ∫ x² dV = 1/60, ∫ x y dV = 1/120."""
    vertices = np.vstack([np.zeros(3), np.eye(3)])
    faces = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])
    mass = mass_of_solid(vertices, faces, 6.0)
    corner = 6.0 * (np.full((3, 3), -1 / 120) + np.diag([2 / 60 + 1 / 120] * 3))
    assert np.allclose(mass.about(np.zeros(3)), corner, rtol=1e-14)
    # About the centre of mass: ∫ x² dV = 1/160, ∫ x y dV = -1/480.
    centre = 6.0 * (np.full((3, 3), 1 / 480) + np.diag([2 / 160 - 1 / 480] * 3))
    assert_same(mass, MassProperties(1.0, np.full(3, 0.25), centre), 1e-14)


def test_meshes_of_a_ball_converge_to_its_inertia() -> None:
    errors = []
    for level in (2, 3, 4):
        ball = trimesh.creation.icosphere(level, 0.4)
        mass = mass_of_solid(ball.vertices, ball.faces, 1000.0)
        whole = 1000.0 * 4 / 3 * np.pi * 0.4**3
        errors.append(abs(mass.moment(np.array([0.0, 1.0, 0.0])) / (0.4 * whole * 0.4**2) - 1))
    # A flat triangle misses the ball by the square of its side.
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.05)


def test_mass_of_random_hulls_matches_trimesh() -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        vertices, faces = random_hull(rng)
        vertices = vertices + rng.uniform(-2, 2, 3)
        assert_same(mass_of_solid(vertices, faces, 3.5), trimesh_mass((vertices, faces), 3.5), 1e-9)


@given(SEEDS)
def test_mass_properties_transform_with_their_solid(seed: int) -> None:
    rng = np.random.default_rng(seed)
    vertices, faces = random_hull(rng)
    X = random_pose(rng)
    there = mass_of_solid(moved(X, vertices), faces, 2.0)
    assert_same(mass_of_solid(vertices, faces, 2.0).in_frame(X), there, 1e-10)
    back = np.linalg.inv(X)
    assert_same(there.in_frame(back), mass_of_solid(vertices, faces, 2.0), 1e-10)


@given(SEEDS)
def test_joined_bodies_match_one_mesh_of_all(seed: int) -> None:
    """The order and nesting of the parts do not matter."""
    rng = np.random.default_rng(seed)
    meshes = [random_hull(rng) for _ in range(int(rng.integers(1, 5)))]
    first = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    whole = mass_of_solid(
        np.concatenate([vertices for vertices, _ in meshes]),
        np.concatenate([faces + n for (_, faces), n in zip(meshes, first[:-1], strict=True)]),
        2.0,
    )
    parts = [mass_of_solid(*mesh, 2.0) for mesh in meshes]
    assert_same(joined(parts), whole, 1e-10)
    assert_same(joined([joined(parts[:1]), *parts[:0:-1]]), whole, 1e-10)


def test_two_halves_add_up_and_a_hole_is_subtracted() -> None:
    low, cut, high = np.zeros(3), np.array([0.7, 2.0, 3.0]), np.array([1.0, 2.0, 3.0])
    whole = mass_of_solid(*box(low, high), 5.0)
    halves = mass_of_solid(*box(low, cut), 5.0), mass_of_solid(*box(cut * [1, 0, 0], high), 5.0)
    assert_same(joined(halves), whole)
    outer, inner = box(low, high), box(np.array([0.1, 0.2, 0.3]), np.array([0.6, 1.5, 2.0]))
    hollow = mass_of_solid(
        np.concatenate([outer[0], inner[0]]), np.concatenate([BOX, BOX[:, ::-1] + 8]), 5.0
    )
    assert_same(joined([hollow, mass_of_solid(*inner, 5.0)]), whole)


def test_inertia_of_a_small_distant_solid_keeps_its_precision() -> None:
    here = mass_of_solid(*box(np.zeros(3), np.full(3, 0.01)), 1000.0)
    vertices, faces = box(np.full(3, 1000.0), np.full(3, 1000.01))
    far = mass_of_solid(vertices, faces, 1000.0)
    # Coordinates of 1000 m are rounded to 1e-13 m, 1e-11 of the side.
    assert np.allclose(far.inertia, here.inertia, rtol=1e-9, atol=1e-9 * here.inertia[0, 0])


@given(SEEDS)
def test_point_masses_have_a_full_inertia_tensor(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, p = rng.uniform(0, 2, 7), rng.normal(size=(7, 3))
    mass = mass_of_points(m, p)
    inertia = np.zeros((3, 3))
    for mass_k, L in zip(m, p - m @ p / m.sum(), strict=True):
        inertia += mass_k * (L @ L * np.eye(3) - np.outer(L, L))
    assert_same(mass, MassProperties(m.sum(), m @ p / m.sum(), inertia), 1e-12)
    axis = normalized(rng.normal(size=3))
    away = np.linalg.norm(np.cross(p - mass.centre, axis), axis=-1)
    assert mass.moment(axis) == pytest.approx(m @ away**2)
    X = random_pose(rng)
    assert_same(mass.in_frame(X), mass_of_points(m, moved(X, p)), 1e-10)
    point = rng.normal(size=3)
    about = sum(
        mass_k * (L @ L * np.eye(3) - np.outer(L, L))
        for mass_k, L in zip(m, p - point, strict=True)
    )
    assert np.allclose(mass.about(point), about)


@given(SEEDS)
def test_principal_moments_satisfy_the_triangle_inequality(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low, middle, high = np.linalg.eigvalsh(mass_of_solid(*random_hull(rng), 1.0).inertia)
    assert 0 < low
    assert high < low + middle


def test_surfaces_without_volume_are_refused() -> None:
    vertices, faces = box(np.zeros(3), np.ones(3))
    turned = np.concatenate([BOX[:-1], BOX[-1:, ::-1]])
    broken = np.where(np.arange(8)[:, None] == 3, np.nan, vertices)
    refused = {
        "is open": [
            (vertices, BOX[:-1]),
            (vertices, turned),
            (vertices, np.vstack([BOX, BOX[:1]])),
        ],
        "inside out": [(vertices, BOX[:, ::-1])],
        "no volume": [(vertices * [1, 0, 1], BOX), (vertices * 0, BOX)],
        "not finite": [(broken, BOX), (vertices, BOX[:0])],
        "names a vertex": [(vertices, BOX + 1), (vertices, BOX - 1)],
    }
    for message, meshes in refused.items():
        for mesh in meshes:
            with pytest.raises(MassError, match=message):
                mass_of_solid(*mesh, 1.0)
    with pytest.raises(MassError, match="between vertices 1 and 3 "):
        mass_of_solid(vertices, BOX[:-1], 1.0)
    for density in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(MassError, match="density must be finite and positive"):
            mass_of_solid(vertices, faces, density)


def test_points_without_positive_mass_are_refused() -> None:
    for masses in ([0.0, 0.0], [-1.0, 0.5], [np.nan, 1.0]):
        with pytest.raises(MassError, match="total mass"):
            mass_of_points(masses, np.zeros((2, 3)))
    with pytest.raises(MassError, match="none of them negative"):
        mass_of_points([-1.0, 2.0], np.zeros((2, 3)))
    with pytest.raises(MassError, match="nothing was joined"):
        joined([])
