"""Mushrooms: alike at all levels of detail, closed by gills below; rings face outward."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.scenery.mushrooms import KINDS, mushroom
from pipeline.production.scenery.prototype import Shape, add_rings, turned_rings


@pytest.mark.parametrize("seed", range(6))
def test_all_levels_of_detail_show_the_same_mushrooms(seed: int) -> None:
    """Or a camera that comes nearer would see them jump."""
    near, *farther = (mushroom(seed, level).vertices for level in range(4))
    size = np.ptp(near, axis=0)
    for far in farther:
        for side in (np.min, np.max):
            off = np.abs(side(far, axis=0) - side(near, axis=0))
            assert (off < 0.12 * size.max() + 0.002).all()


@pytest.mark.parametrize("seed", range(len(KINDS)))
def test_caps_face_up_and_gills_face_down(seed: int) -> None:
    shape = mushroom(seed, 0)
    normals = shape.normals[:, 1]
    assert normals.max() > 0.95
    assert normals.min() < -0.6
    # The topmost vertices belong to caps.
    top = shape.vertices[:, 1] > shape.vertices[:, 1].max() - 0.001
    assert (normals[top] > 0.5).all()


def test_only_the_fly_agaric_has_warts() -> None:
    pale = [
        ((shape.colors.min(axis=1) > 0.45) & (shape.normals[:, 1] > 0.5)).sum()
        for shape in (mushroom(seed, 0) for seed in range(3))
    ]
    assert pale[2] > 20 > pale[0]


def test_rings_face_outward_or_up() -> None:
    around = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    steps = np.linspace(0.5, 1.0, 4)[:, None]
    wall, plate = Shape(), Shape()
    add_rings(wall, turned_rings(np.ones((4, 1)), steps, around), np.ones(3))
    add_rings(plate, turned_rings(steps, np.zeros((4, 1)), around), np.ones(3), upward=True)
    shown = wall.prototype()
    assert ((shown.normals * shown.vertices)[:, [0, 2]].sum(axis=1) > 0.9).all()
    assert (plate.prototype().normals[:, 1] > 0.99).all()
    assert len(shown.solid) == 3 * 2 * 16
    for shape in (shown, plate.prototype()):
        a, b, c = (shape.vertices[shape.solid[:, k]] for k in range(3))
        assert (np.cross(b - a, c - a) * shape.normals[shape.solid[:, 0]]).sum(axis=1).min() > 0.0
