"""Skinning and shots: every vertex where its nodes take it, evaluated slowly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.production.shooting import Shooting
from pipeline.production.skinning import Skin
from pipeline.simulation.take import Mesh, Take
from pipeline.spec import Scene


def rotated(q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotate a vector by a quaternion wxyz: v + 2w (u × v) + 2 u × (u × v)."""
    w, u = q[0], q[1:]
    return v + 2 * w * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v))


def slowly(take: Take, mesh: Mesh, vertex: int, row: int) -> NDArray[np.float64]:
    place = np.zeros(3)
    for node, weight in zip(mesh.nodes[vertex], mesh.weights[vertex], strict=True):
        offset = mesh.vertices[vertex].astype(float) - np.array(take.nodes[node].rest)
        moved = take.positions[row, node] + rotated(take.rotations[row, node], offset)
        place += float(weight) * moved
    return place


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
def test_vertices_stand_where_a_slow_evaluation_puts_them(take: Take, shared: bool) -> None:
    take = blended(take) if shared else take
    skin = Skin.of(take)
    random = np.random.default_rng(1)
    for row in (0, 13, len(take.positions) - 1):
        posed = skin.posed(take, row)
        for i, part in enumerate(take.parts):
            mesh = take.meshes[part.mesh]
            own = posed[skin.starts[i] : skin.starts[i + 1]]
            assert len(own) == len(mesh.vertices)
            for vertex in random.integers(len(own), size=5):
                np.testing.assert_allclose(own[vertex], slowly(take, mesh, vertex, row), atol=2e-6)


def test_a_scale_is_along_the_axes_of_its_node(take: Take) -> None:
    factors = np.tile([2.0, 0.5, 3.0], (len(take.positions), 1, 1))
    scaled = replace(take, scales=factors, scaled=(1,))
    row = 7
    posed, skin = Skin.of(scaled).posed(scaled, row), Skin.of(take)
    plain = skin.posed(take, row)
    own = skin.nodes[0] == 1
    np.testing.assert_array_equal(posed[~own], plain[~own])
    offsets = skin.vertices[0, own] * factors[0, 0]
    expected = [rotated(take.rotations[row, 1], offset) for offset in offsets]
    np.testing.assert_allclose(posed[own] - take.positions[row, 1], expected, atol=2e-6)


def test_what_is_not_alive_is_not_seen(take: Take) -> None:
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
    shooting = Shooting(tiny, take)
    skin = Skin.of(take)
    for frame in (1, 8):
        shot = shooting.shot(frame)
        ground, bodies = shot.meshes[:2], shot.meshes[2:]
        assert [mesh.name for mesh in ground] == ["terrain", "horizon"]
        assert [mesh.name for mesh in bodies] == [part.name for part in take.parts]
        posed = skin.posed(take, (frame - 1) * take.header.samples)
        np.testing.assert_array_equal(np.concatenate([m.vertices for m in bodies]), posed)
        assert shot.camera == shooting.poses[frame - 1]
        assert {mesh.material for mesh in shot.meshes} <= shot.materials.keys()
    # What stands still is one and the same object, which is not digested again.
    assert shooting.shot(1).meshes[0] is shooting.shot(2).meshes[0]


def test_a_part_is_seen_only_in_its_life(tiny: Scene, take: Take) -> None:
    first, *others = take.parts
    samples = take.header.samples
    short = replace(first, life=(2 * samples, 4 * samples))
    shooting = Shooting(tiny, replace(take, parts=(short, *others)))
    seen = [float(np.ptp(shooting.shot(f).meshes[2].vertices, axis=0).max()) for f in range(1, 9)]
    assert [extent > 0 for extent in seen] == [f in (3, 4) for f in range(1, 9)]


@pytest.fixture(scope="module")
def tiny(request: pytest.FixtureRequest) -> Scene:
    scene: Scene = request.getfixturevalue("unmade").load()
    return scene
