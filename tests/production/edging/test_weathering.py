"""Plaster bears traces of rain where water runs, and panes show rooms."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.edging.carpentry import Carpentry, subdivide_sides
from pipeline.production.edging.house_front import Front
from pipeline.production.edging.rooms_behind_panes import add_rooms
from pipeline.production.edging.weathering import CELL, add_weathering
from pipeline.simulation.spatial import Array
from render.shot import Mesh

Triple = tuple[float, float, float]

HEADING = 0.7
PLACE = np.array([3.0, -5.0])


def front() -> Front:
    return Front(PLACE, HEADING, (8.0, 9.0, 6.0), 0.5, [(1.0, 3.0, 1.4)], [(1.0, 3.1, 1.0, 1.5)])


def boxes(
    places: list[tuple[float, float, float]], sizes: list[tuple[float, float, float]]
) -> Mesh:
    """Return boxes at places along, over and before the facade."""
    carpentry = Carpentry()
    c, s = np.cos(HEADING), np.sin(HEADING)
    for (along, up, before), size in zip(places, sizes, strict=True):
        x, z = PLACE[0] + c * along + s * before, PLACE[1] - s * along + c * before
        carpentry.add("edging cream", np.array([x, 0.5 + up, z]), size, HEADING)
    (mesh,) = carpentry.meshes()
    return mesh


def wall() -> Mesh:
    return boxes([(0.0, 3.0, -0.17)], [(8.0, 6.0, 0.34)])


def area(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]].astype(float) for k in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def share(mesh: Mesh, along: tuple[float, float], up: tuple[float, float]) -> float:
    """Return the mean dirt in a rectangle of the facade."""
    assert mesh.cover is not None
    local = front().local(mesh.vertices.astype(float))
    own = (local[:, 2] > -0.01) & (local[:, 0] > along[0]) & (local[:, 0] < along[1])
    own &= (local[:, 1] > up[0]) & (local[:, 1] < up[1])
    # Dirt is dark, worn wash is pale.
    return float((mesh.cover[own, 3] * (1.0 - mesh.cover[own, 0])).mean())


def test_cells_cover_the_wall_and_are_small() -> None:
    plain, aged = wall(), add_weathering(wall(), [front()], 3)
    assert area(aged) == pytest.approx(area(plain), rel=1e-5)
    local = front().local(aged.vertices.astype(float))
    facade = (local[aged.faces][:, :, 2] > -0.01).all(axis=1)
    corners = local[aged.faces[facade]]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    assert edges.max() <= 1.415 * CELL
    # Nobody sees the back of the wall: it is not divided.
    assert ((local[aged.faces][:, :, 2] < -0.33).all(axis=1)).sum() == 2


@pytest.mark.parametrize("seed", [1, 7, 40])
def test_water_leaves_dirt_at_the_foot_under_the_eaves_and_below_sills(seed: int) -> None:
    aged = add_weathering(wall(), [front()], seed)
    middle = share(aged, (-3.5, -0.5), (2.5, 3.5))
    assert share(aged, (-4.0, 4.0), (0.0, 0.4)) > middle + 0.1
    assert share(aged, (-4.0, 4.0), (5.7, 6.0)) > middle + 0.08
    # The sill reaches from 0.3 to 1.7 along.
    assert share(aged, (0.25, 0.4), (2.5, 2.95)) > middle + 0.1
    assert share(aged, (0.25, 0.4), (2.5, 2.95)) > share(aged, (0.9, 1.1), (2.5, 2.95))


def test_what_belongs_to_no_house_stays_as_it_was() -> None:
    far = boxes([(20.0, 1.0, 0.0)], [(2.0, 2.0, 0.3)])
    aged = add_weathering(far, [front()], 1)
    assert aged.cover is not None
    assert len(aged.vertices) == len(far.vertices)
    assert not aged.cover[:, 3].any()


def colors(low: float, seed: int) -> Array:
    pane = boxes([(1.0, low + 0.75, -0.27)], [(1.0, 1.5, 0.02)])
    own = Front(PLACE, HEADING, (8.0, 9.0, 6.0), 0.5, [], [(1.0, low, 1.0, 1.5)])
    room = add_rooms(pane, [own], seed)
    assert room.cover is not None
    assert (room.cover[:, 3] == 1.0).all()
    return np.asarray(room.cover[:, :3], float)


def test_rooms_differ_from_window_to_window_and_are_the_same_again() -> None:
    assert np.array_equal(colors(3.1, 5), colors(3.1, 5))
    assert not np.array_equal(colors(3.1, 5), colors(3.1, 6))
    assert not np.array_equal(colors(3.1, 5), colors(4.1, 5))
    assert np.ptp(colors(3.1, 5).mean(axis=1)) > 0.05


def test_cells_of_a_side_that_tapers_are_small_wherever_it_begins() -> None:
    carpentry = Carpentry()
    carpentry.add("edging cream", np.zeros(3), (4.0, 1.0, 2.0), top=(1.0, 0.01))
    (gable,) = carpentry.meshes()
    divided = subdivide_sides(gable, 0.5, np.ones(6, bool))
    corners = divided.vertices[divided.faces].astype(float)
    assert np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max() < 0.8


def test_a_gable_over_the_eaves_is_clean_and_has_no_drips() -> None:
    gable = boxes([(3.9, 4.0, -4.0)], [(0.2, 8.0, 7.0)])
    aged = add_weathering(gable, [front()], 1)
    assert aged.cover is not None
    local = front().local(aged.vertices.astype(float))
    dirt = aged.cover[:, 3] * (1.0 - aged.cover[:, 0])
    own = local[:, 0] > 3.99
    assert own.sum() > 1000
    assert dirt[own & (local[:, 1] > 7.6)].mean() < 0.2
    bare = Front(PLACE, HEADING, (8.0, 9.0, 6.0), 0.5)
    assert np.array_equal(add_weathering(gable, [bare], 1).cover, aged.cover)


def test_houses_beside_one_another_have_stains_of_their_own() -> None:
    covers = []
    for z in (0.0, 8.0):
        carpentry = Carpentry()
        carpentry.add("edging cream", np.array([0.0, 3.0, z - 0.17]), (8.0, 6.0, 0.34))
        (mesh,) = carpentry.meshes()
        house = Front(np.array([0.0, z]), 0.0, (8.0, 9.0, 6.0), 0.0)
        covers.append(add_weathering(mesh, [house], 3).cover)
    assert not np.array_equal(*covers)
