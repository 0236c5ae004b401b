"""Skinning against a slow evaluation, and shots."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.simulation.spatial import Array, matrix, rotation
from pipeline.simulation.take import Mesh, Take
from pipeline.spec import Scene


def rotated(q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotate a vector by a quaternion wxyz: v + 2w (u × v) + 2 u × (u × v)."""
    w, u = q[0], q[1:]
    return v + 2 * w * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v))


def slowly(take: Take, mesh: Mesh, vertex: int, row: int) -> NDArray[np.float64]:
    """Move a vertex by a part of the screw that takes its first node's frame to its second's.

    A screw turns by θ about a line and slides by d along it. With weights 1 - w and w of its
    ends the mean of the two dual quaternions is a screw about the same line, by
    φ = 2 atan2(w sin θ/2, 1 - w + w cos θ/2) and d ∂φ/∂θ.
    """
    (a, b), w = mesh.nodes[vertex], float(mesh.weights[vertex, 1])
    rest = [np.array(take.nodes[node].rest) for node in (a, b)]
    p, q = take.positions[row], take.rotations[row]
    here = p[a] + rotated(q[a], mesh.vertices[vertex].astype(float) - rest[0])
    if w == 0.0:
        return here
    there = p[b] + rotated(q[b], mesh.vertices[vertex].astype(float) - rest[1])
    turn = matrix(q[b]) @ matrix(q[a]).T
    angle = float(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0)))
    shift = there - turn @ here
    if angle < 1e-9:
        return here + w * shift
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    axis /= 2.0 * np.sin(angle)
    slide = float(axis @ shift)
    point = np.linalg.pinv(np.eye(3) - turn) @ (shift - slide * axis)
    A, B = 1.0 - w + w * np.cos(angle / 2), w * np.sin(angle / 2)
    part = 2.0 * np.arctan2(B, A)
    slope = (w * np.cos(angle / 2) * A + w * np.sin(angle / 2) * B) / (A * A + B * B)
    return point + rotation(axis, part) @ (here - point) + slide * slope * axis


def posed_by_two(q: Array, mesh: Mesh) -> Array:
    """Return the vertices (V, 3) of a mesh on two nodes, at the origin, turned by q (2, 4)."""
    take = SimpleNamespace(
        nodes=[SimpleNamespace(rest=(0.0, 0.0, 0.0))] * 2,
        rotations=q[None],
        positions=np.zeros((1, 2, 3)),
        scales=np.zeros((1, 0, 3)),
        scaled=(),
        alive=np.ones((1, 2), bool),
        faces=(),
    )
    return np.asarray(Skin.of_meshes(take, [mesh]).posed(take, 0))  # type: ignore[arg-type]


@pytest.mark.parametrize(("degrees", "share"), [(0.0, 0.0), (30.0, 0.5), (90.0, 1.0), (150.0, 1.0)])
def test_creases_act_by_the_sine_of_the_bend(degrees: float, share: float) -> None:
    """The nodes turn about one place, where a vertex of either stays without its crease."""
    crease, q = np.array([0.02, -0.01, 0.03]), np.array([[1.0, 0.0, 0.0, 0.0]] * 2)
    half = np.radians(degrees) / 2
    q[1] = [np.cos(half), 0.0, 0.0, np.sin(half)]
    mesh = Mesh(
        np.zeros((3, 3), np.float32),
        np.array([[0, 1, 2]], np.uint32),
        np.array([[0, 1]] * 3, np.int32),
        np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 0.0]], np.float32),
        creases=np.array([crease, crease, 0 * crease], np.float32),
    )
    posed = posed_by_two(q, mesh)
    wanted = share * np.array([crease, matrix(q[1]) @ crease, 0 * crease])
    np.testing.assert_allclose(posed, wanted, atol=1e-7)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0, 90.0, 130.0])
def test_creases_of_limbs_that_twist_act_by_the_rise_of_the_limb(degrees: float) -> None:
    """A limb is swung ahead from hanging: it rises by 1 less the cosine."""
    crease, half = np.array([0.02, -0.01, 0.03]), np.radians(degrees) / 2
    q = np.array([[1.0, 0.0, 0.0, 0.0], [np.cos(half), 0.0, 0.0, np.sin(half)]])
    mesh = Mesh(
        np.zeros((3, 3), np.float32),
        np.array([[0, 1, 2]], np.uint32),
        np.array([[0, 1]] * 3, np.int32),
        np.array([[1.0, 0.0]] * 3, np.float32),
        creases=np.array([crease] * 3, np.float32),
        twists=np.array([[0.8, -0.6, 0.0]] * 3, np.float32),
    )
    rise = min(1.0 - np.cos(np.radians(degrees)), 1.0)
    np.testing.assert_allclose(posed_by_two(q, mesh), [rise * crease] * 3, atol=1e-7)


@pytest.mark.parametrize("held", [1.0, 0.5])
def test_a_vertex_leaves_out_a_share_of_the_twist_of_its_limb(held: float) -> None:
    """The second node is twisted by 80 degrees about its limb, which is swung ahead by 90."""
    twist, middle = np.radians(80.0), np.array([1.0, 0.0, 0.0])
    c, s = np.cos(twist / 2), np.sin(twist / 2)
    root = np.sqrt(0.5)
    # From hanging to ahead about Z; before that about Y.
    q = np.array([[1.0, 0.0, 0.0, 0.0], [root * c, -root * s, root * s, root * c]])
    mesh = Mesh(
        np.array([[0.1, -0.5, 0.0]] * 3, np.float32),
        np.array([[0, 1, 2]], np.uint32),
        np.array([[0, 1]] * 3, np.int32),
        np.array([[0.0, 1.0]] * 3, np.float32),
        twists=np.array([held * middle, 0 * middle, held * middle], np.float32),
    )
    posed = posed_by_two(q, mesh)
    for place, share in zip(posed, (held, 0.0, held), strict=True):
        angle = (1.0 - share) * twist
        # Of the 0.1 m ahead of the hanging limb, which point up once it is swung ahead.
        wanted = [0.5, 0.1 * np.cos(angle), -0.1 * np.sin(angle)]
        np.testing.assert_allclose(place, wanted, atol=1e-6)


def rigid(skin: Skin, node: int) -> NDArray[np.bool_]:
    """Return which vertices follow one node alone."""
    found: NDArray[np.bool_] = (skin.nodes[0] == node) & (skin.weights[1, :, 0] == 0.0)
    return found


def blended(take: Take) -> Take:
    """Return the take with every vertex shared between its node and another."""
    random = np.random.default_rng(5)
    meshes = []
    for mesh in take.meshes:
        share = random.random((len(mesh.vertices), 1)).astype(np.float32)
        nodes = mesh.nodes.copy()
        nodes[:, 1] = random.integers(len(take.nodes), size=len(nodes))
        meshes.append(replace(mesh, nodes=nodes, weights=np.hstack([1 - share, share])))
    return replace(take, meshes=tuple(meshes))


@pytest.mark.parametrize("shared", [False, True])
def test_vertices_match_a_slow_evaluation(take: Take, shared: bool) -> None:
    take = blended(take) if shared else take
    skin = Skin.of(take)
    random = np.random.default_rng(1)
    for row in (0, 13, len(take.positions) - 1):
        posed = skin.posed(take, row)
        for i, part in enumerate(visible_parts(take)):
            mesh = take.meshes[part.seen]
            own = posed[skin.starts[i] : skin.starts[i + 1]]
            assert len(own) == len(mesh.vertices)
            for vertex in random.integers(len(own), size=5):
                np.testing.assert_allclose(own[vertex], slowly(take, mesh, vertex, row), atol=2e-6)


def test_a_hinge_keeps_its_volume(take: Take) -> None:
    """Vertices between two nodes at one point keep their radius with any weights."""
    rng = np.random.default_rng(7)
    one = blended(take)
    positions = take.positions.copy()
    positions[3] = [0.4, 1.0, -0.2]
    rotations = rng.normal(size=take.rotations.shape)
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    nodes = tuple(replace(node, rest=(0.0, 0.0, 0.0)) for node in take.nodes)
    one = replace(one, nodes=nodes, positions=positions, rotations=rotations)
    before = np.concatenate([one.meshes[part.seen].vertices for part in visible_parts(one)])
    radius = np.linalg.norm(Skin.of(one).posed(one, 3) - [0.4, 1.0, -0.2], axis=-1)
    np.testing.assert_allclose(radius, np.linalg.norm(before, axis=-1), rtol=1e-5, atol=1e-6)


def test_separating_nodes_stretch_the_vertices_between_them(take: Take) -> None:
    one = blended(take)
    turned = np.broadcast_to(take.rotations[:, :1], take.rotations.shape)
    one = replace(one, rotations=turned)
    skin = Skin.of(one)
    R, p = matrix(turned[3]), one.positions[3]
    ends = [p[skin.nodes[k]] + (R[0] @ skin.vertices[k].T).T for k in (0, 1)]
    expected = skin.weights[0] * ends[0] + skin.weights[1] * ends[1]
    np.testing.assert_allclose(skin.posed(one, 3), expected, atol=2e-6)


def test_a_scale_is_along_the_axes_of_its_node(take: Take) -> None:
    factors = np.tile([2.0, 0.5, 3.0], (len(take.positions), 1, 1))
    scaled = replace(take, scales=factors, scaled=(1,))
    row = 7
    posed, skin = Skin.of(scaled).posed(scaled, row), Skin.of(take)
    plain = skin.posed(take, row)
    own = rigid(skin, 1)
    others = (skin.nodes != 1).all(axis=0)
    np.testing.assert_array_equal(posed[others], plain[others])
    offsets = skin.vertices[0, own] * factors[0, 0]
    expected = [rotated(take.rotations[row, 1], offset) for offset in offsets]
    np.testing.assert_allclose(posed[own] - take.positions[row, 1], expected, atol=2e-6)


def test_dead_nodes_are_hidden(take: Take) -> None:
    alive = take.alive.copy()
    alive[5, 1] = False
    dead = replace(take, alive=alive)
    skin = Skin.of(take)
    own = skin.nodes[0] == 1
    assert own.any()
    np.testing.assert_array_equal(skin.posed(dead, 5)[own], 0.0)
    np.testing.assert_array_equal(skin.posed(dead, 5)[~own], skin.posed(take, 5)[~own])
    np.testing.assert_array_equal(skin.posed(dead, 4), skin.posed(take, 4))


def test_a_shot_shows_its_frame(tiny: Scene, take: Take) -> None:
    shooting = ShotBuilder(tiny, take)
    skin = Skin.of(take)
    for frame in (1, 8):
        shot = shooting.shot(frame)
        bodies = shot.meshes
        assert shot.scenery[0].name == "terrain"
        assert shot.scenery is shooting.shot(1).scenery
        assert [mesh.name for mesh in bodies] == [part.name for part in visible_parts(take)]
        posed = skin.posed(take, (frame - 1) * take.header.samples)
        np.testing.assert_array_equal(np.concatenate([m.vertices for m in bodies]), posed)
        assert shot.camera == shooting.poses[frame - 1]
        assert {mesh.material for mesh in shot.meshes} <= shot.materials.keys()
    # A mesh at rest is one object in all moments, digested once.
    assert shooting.shot(1).scenery[0] is shooting.shot(2).scenery[0]


def test_a_part_is_visible_only_in_its_life(tiny: Scene, take: Take) -> None:
    first, *others = take.parts
    samples = take.header.samples
    short = replace(first, life=(2 * samples, 4 * samples))
    shooting = ShotBuilder(tiny, replace(take, parts=(short, *others)))
    seen = [float(np.ptp(shooting.shot(f).meshes[0].vertices, axis=0).max()) for f in range(1, 9)]
    assert [extent > 0 for extent in seen] == [f in (3, 4) for f in range(1, 9)]


@pytest.fixture(scope="module")
def tiny(request: pytest.FixtureRequest) -> Scene:
    scene: Scene = request.getfixturevalue("unmade").load()
    return scene
