"""Faces: closed skins whose lids shut, whose mouths open, and whose expressions differ."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import trimesh

from pipeline.production.shots.skinning import Skin
from pipeline.simulation.expressions import ACTIONS, AT_EASE, EXPRESSIONS, face_of
from pipeline.simulation.face_units import COLUMNS, EYE_TURN, UNITS
from pipeline.simulation.people.face_mesh import FaceGrid, face_grid
from pipeline.simulation.people.face_morphs import FaceSkin, unit_offsets
from pipeline.simulation.people.face_shape import FaceShape
from pipeline.simulation.people.head_mesh import LIMBUS_DEG
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Face, Mesh, Node, Part
from pipeline.spec.expression import EMOTIONS
from tests.simulation.people.still_take import still_take

SHAPES = {"adult": FaceShape(0.0, 0.13), "child": FaceShape(1.0, 0.12)}
FACES = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)


def moves(shape: FaceShape, grid: FaceGrid) -> Array:
    skin = FaceSkin(grid.vertices, grid.jaw, grid.closing, grid.lid, grid.upper)
    return unit_offsets(shape, skin)


def acted(shape: FaceShape, grid: FaceGrid, **units: float) -> Array:
    offsets = moves(shape, grid)
    return grid.vertices + sum(share * offsets[UNITS.index(u)] for u, share in units.items())


@FACES
def test_heads_are_closed_and_stay_so_when_they_act(shape: FaceShape) -> None:
    grid = face_grid(shape)
    for places in (grid.vertices, acted(shape, grid, smile=1.0, jaw=1.0, blink=1.0)):
        head = trimesh.Trimesh(places, grid.faces, process=False)
        assert head.is_watertight
        assert head.volume > 0.25


def winding(places: Array, faces: Array, point: Array) -> float:
    """Return how often a surface winds around a point.

    Source: van Oosterom and Strackee 1983.
    """
    a, b, c = (places[faces[:, k]] - point for k in range(3))
    n_a, n_b, n_c = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    over = (a * np.cross(b, c)).sum(axis=-1)
    under = n_a * n_b * n_c + (a * b).sum(-1) * n_c + (b * c).sum(-1) * n_a + (c * a).sum(-1) * n_b
    return float(np.arctan2(over, under).sum() / (2.0 * np.pi))


@FACES
def test_shut_lids_cover_the_eyes_that_open_lids_leave_free(shape: FaceShape) -> None:
    grid = face_grid(shape)
    eye, radius = shape.eye
    front = eye + np.array([1.01 * radius, 0.0, 0.0])
    assert winding(grid.vertices, grid.faces, front) < 0.5
    assert winding(acted(shape, grid, blink=1.0), grid.faces, front) > 0.5


@FACES
def test_units_move_what_they_are_named_after(shape: FaceShape) -> None:
    grid, offsets = face_grid(shape), {}
    for name, moved in zip(UNITS, moves(shape, grid), strict=True):
        offsets[name] = moved
    (eye, _), (mouth, wide) = shape.eye, shape.mouth
    p = grid.vertices

    def at(unit: str, place: tuple[float, float, float]) -> Array:
        nearest = np.linalg.norm(p - np.array(place), axis=1).argmin()
        result: Array = offsets[unit][nearest]
        return result

    corner, brow = (0.33, mouth[1], wide), (0.36, eye[1] + 0.12, 0.06)
    assert at("smile", corner)[1] > 0.03
    assert at("smile", corner)[2] > 0.02
    assert at("corner_down", corner)[1] < -0.03
    assert at("stretch", corner)[2] > 0.03
    assert at("brow_inner_up", brow)[1] > 0.03
    assert at("brow_down", brow)[1] < -0.03
    chin = at("jaw", (0.33, -0.46, 0.0))
    assert chin[1] < -0.05
    assert abs(at("jaw", (0.40, mouth[1] + 0.05, 0.0))[1]) < 0.02
    # Nothing moves at the back of the head.
    back = p[:, 0] < -0.15
    assert all(np.abs(moved[back]).max() < 1e-3 for moved in offsets.values())


@FACES
def test_every_two_expressions_differ_where_it_shows(shape: FaceShape) -> None:
    """By two hundredths of a head, two pixels of a face of a hundred."""
    grid = face_grid(shape)
    offsets = moves(shape, grid)
    units = face_of(np.eye(len(EMOTIONS)))
    shown = np.einsum("eu,uvk->evk", units, offsets)
    for a, b in itertools.combinations(range(len(EMOTIONS)), 2):
        apart = np.linalg.norm(shown[a] - shown[b], axis=-1)
        assert np.quantile(apart, 0.97) > 0.02, (EMOTIONS[a], EMOTIONS[b])


def test_a_smile_keeps_the_lips_together_that_part_for_a_laugh() -> None:
    def acts(strength: float) -> dict[str, float]:
        emotions = np.array([strength if emotion == "joy" else 0.0 for emotion in EMOTIONS])
        return dict(zip(UNITS, face_of(emotions).tolist(), strict=True))

    smile, laugh = acts(0.5), acts(1.0)
    assert smile["smile"] > 0.45
    assert max(smile["jaw"], smile["lip_up"]) < 0.05
    assert min(laugh["jaw"], laugh["lip_up"]) > 0.29


def test_mixed_emotions_stay_within_full_action() -> None:
    assert set(EXPRESSIONS) == set(EMOTIONS)
    assert all(set(units) <= set(UNITS) for units in EXPRESSIONS.values())
    mixed = face_of(np.ones(len(EMOTIONS)))
    assert (mixed >= 0.0).all()
    assert (mixed <= 1.0).all()
    np.testing.assert_array_equal(face_of(np.zeros(len(EMOTIONS))), AT_EASE)
    np.testing.assert_allclose(face_of(np.eye(len(EMOTIONS))), ACTIONS, atol=1e-12)
    half = face_of(0.5 * np.eye(len(EMOTIONS))[0])
    assert half[UNITS.index("smile")] == pytest.approx(0.5 * EXPRESSIONS["joy"]["smile"])


def test_faces_move_the_vertices_of_their_own_performer() -> None:
    """An eye turns left and up about its middle; a unit moves its vertex by its share."""
    nodes = tuple(Node(f"{who}.head", who, -1, (0.0, 1.0, 0.0)) for who in ("ann", "ben"))
    spokes = np.array([[0.012, 0.0, 0.0], [0.0, 0.012, 0.0], [0.0, 0.0, 0.012]])
    middle = np.array([0.1, 1.1, 0.0])
    meshes = [
        Mesh(
            (middle + spokes).astype(np.float32),
            np.array([[0, 1, 2]], np.uint32),
            np.full((3, 2), k, np.int32),
            np.tile(np.array([1.0, 0.0], np.float32), (3, 1)),
            targets=np.array([*((v, EYE_TURN) for v in range(3)), (2, 0)], np.int32),
            offsets=np.concatenate([spokes, [[0.0, 0.0, 0.004]]]).astype(np.float32),
        )
        for k in (0, 1)
    ]
    parts = tuple(
        Part(f"{n.performer}.eye", n.performer, k, "eye", 0.02, (0, 2)) for k, n in enumerate(nodes)
    )
    acts = np.zeros((2, 1, len(COLUMNS)), np.float32)
    acts[1, 0, [0, EYE_TURN, EYE_TURN + 1]] = 0.5, np.radians(20.0), np.radians(10.0)
    take = still_take(nodes, meshes, parts, (Face("ben"),), acts)
    skin = Skin.of(take)
    np.testing.assert_allclose(skin.posed(take, 0.0), np.tile(middle + spokes, (2, 1)), atol=1e-6)
    after = skin.posed(take, 1.0) - middle
    np.testing.assert_allclose(after[:3], spokes, atol=1e-6)
    left, up = np.radians(20.0), np.radians(10.0)
    ahead = np.array([np.cos(up) * np.cos(left), np.sin(up), -np.cos(up) * np.sin(left)])
    np.testing.assert_allclose(after[3], 0.012 * ahead, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(after[3:5], axis=1), 0.012, atol=1e-6)
    halfway = skin.posed(take, 0.5)[5] - (middle + spokes[2])
    assert halfway[2] == pytest.approx(0.25 * 0.004, abs=3e-4)


@FACES
def test_lids_at_rest_lie_on_the_iris_and_leave_no_white_above_or_below(shape: FaceShape) -> None:
    grid = face_grid(shape)
    eye, radius = shape.eye
    iris = radius * np.sin(np.radians(LIMBUS_DEG))
    ahead = (np.abs(grid.vertices[:, 2] - eye[2]) < 0.02) & (grid.vertices[:, 0] > eye[0])
    for lid in (1.0, -1.0):
        margin = grid.vertices[ahead & (lid * grid.lid > 0.97), 1]
        height = lid * (margin - eye[1]) / iris
        assert len(height) > 1
        # In the upper third of the iris, or the lower half.
        assert (height < 0.9).all()
        assert (height > (1 / 3 if lid > 0.0 else 0.45)).all()


@FACES
def test_the_tip_of_a_nose_stands_out_a_little_before_its_root(shape: FaceShape) -> None:
    grid = face_grid(shape)
    x, y, z = grid.vertices.T
    middle = np.abs(z) < 0.02
    tip = x[middle & (np.abs(y + 0.14) < 0.05)].max()
    root = x[middle & (np.abs(y - shape.eye[0][1]) < 0.03)].max()
    assert 0.03 < tip - root < 0.07


def test_children_have_large_low_eyes_a_short_nose_and_a_small_chin() -> None:
    adult, child = (SHAPES[name] for name in ("adult", "child"))
    assert child.eye[1] > 1.15 * adult.eye[1]
    assert child.eye[0][1] < adult.eye[0][1] - 0.06
    chins, noses = [], []
    for shape in (adult, child):
        x, y, z = face_grid(shape).vertices.T
        middle = np.abs(z) < 0.02
        chins.append(float(x[middle & (np.abs(y + 0.43) < 0.025)].max()))
        noses.append(float(x[middle & (np.abs(y + 0.14) < 0.05)].max()))
    assert chins[1] < chins[0] - 0.015
    assert noses[1] < noses[0] - 0.015
