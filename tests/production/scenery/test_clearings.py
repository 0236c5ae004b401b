"""Clearings: ground that an outline encloses stays bare, open rings do not."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.scenery.clearings import STAYS, UNDER, Clearings, _enclosed
from pipeline.production.scenery.hearths import Hearths
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.simulation.terrain.heightfield import surface_of_vertices
from pipeline.spec import read_scene

CELL, CORNER, SHAPE = 0.06, np.array([-3.0, -3.0]), (101, 101)


def turning_ring(count: int, height: float) -> list[np.ndarray]:
    """Return 50 moments of points of a ring of 1.3 m, which turns between them."""
    moments = []
    for k in range(50):
        angle = 2 * np.pi * np.arange(count) / count + 0.37 * k
        ring = 1.3 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        moments.append(np.column_stack([ring, np.full(count, height)]))
    return moments


def test_the_ground_under_a_turning_deck_is_covered() -> None:
    found = _enclosed(turning_ring(80, 0.3), CORNER, SHAPE, CELL)
    assert found[50, 50]
    assert found.sum() * CELL**2 == pytest.approx(np.pi * 1.3**2, rel=0.25)
    assert not found[0].any()


def test_what_is_high_or_open_covers_nothing() -> None:
    assert not _enclosed(turning_ring(80, UNDER + 0.1), CORNER, SHAPE, CELL).any()
    # People who sit in a circle leave gaps between them.
    still = [turning_ring(6, 0.1)[0]] * 50
    assert not _enclosed(still, CORNER, SHAPE, CELL).any()
    brief = turning_ring(80, 0.3)[: round(0.8 * STAYS * 50)]
    gone = [np.zeros((0, 3))] * (50 - len(brief))
    assert not _enclosed(brief + gone, CORNER, SHAPE, CELL).any()


def take_of(*cast: str) -> Take:
    members = "".join(f"\n  - {member}" for member in cast)
    return simulate(read_scene(f"pronk: 1\nframes: 2\nterrain: flat\ncast:{members}\n"))


def covered(clearings: Clearings, *places: tuple[float, float]) -> list[bool]:
    x, z = np.array(places).T
    return clearings.is_covered(x, z).tolist()


def test_nothing_grows_through_a_seat_nor_a_slab() -> None:
    slab = "{prop: {shape: box, size: [1.4, 0.3, 0.8]}, at: [3, 0.15, 0]}"
    shelf = "{prop: {shape: box, size: [1.4, 0.1, 0.8]}, at: [6, 1.2, 0]}"
    seat = "{prop: {shape: box, size: [1.5, 0.06, 0.42]}, at: [0, 0.4, 0]}"
    found = Clearings.of(take_of(seat, slab, shelf))
    assert found is not None
    # All over the seat, not at its ends alone.
    assert all(covered(found, *((x, z) for x in np.linspace(-0.7, 0.7, 15) for z in (-0.15, 0.1))))
    assert all(covered(found, (3.0, 0.0), (2.4, 0.3), (3.6, -0.3), (3.3, 0.1)))
    # Grass grows beside them, and below what is above it.
    assert not any(covered(found, (3.0, 0.7), (1.4, 0.0), (6.0, 0.0)))
    # Solid things keep away from the middle of a large face as well.
    assert found.distance(np.array([3.0, 6.0]), np.array([0.0, 0.0])) == pytest.approx(0, abs=0.1)


def test_nothing_grows_in_a_fire() -> None:
    ball = "{prop: {shape: ball}, at: [2, 0.1, 0]}"
    take = take_of(ball)
    found = Clearings.of(take, Hearths(0, np.array([[-2.0, 1.0]]), np.array([0.4])))
    assert found is not None
    assert all(covered(found, (-2.0, 1.0), (-2.5, 1.0), (-2.0, 0.5)))
    assert not any(covered(found, (-3.0, 1.0)))
    assert found.distance(np.array([-2.0]), np.array([1.0])) == pytest.approx(0)
    unburnt = Clearings.of(take)
    assert unburnt is not None
    assert not any(covered(unburnt, (-2.0, 1.0)))


def test_fires_on_the_ground_are_hearths() -> None:
    text = """pronk: 1
frames: 2
terrain: flat
cast:
  - {name: fire, group: {rule: fire, radius: 0.3, size: 0.2}, at: [1, 2]}
  - {name: smoke, group: {rule: fire}, at: [1, 2], material: smoke}
  - {name: beacon, group: {rule: fire}, at: [4, 3, 2]}
  - {name: pole, prop: {shape: ball}, at: [0, 0.1, 0]}
  - {name: torch, group: {rule: fire}, at: [0, 0.1, 0], parent: pole}
"""
    scene = read_scene(text)
    take = simulate(scene)
    field = surface_of_vertices(take.terrain.vertices, take.terrain.cells)
    found = Hearths.of(scene, field)
    assert found.places == pytest.approx(np.array([[1, 2]]))
    assert found.radii == pytest.approx([0.4])
