"""Fillets between a trunk and a shank that grows out of it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from pipeline.simulation.figures.hide.fillets import filleted
from pipeline.simulation.figures.hide.lumps import ball, budgeted
from pipeline.simulation.figures.hide.sheets import tube
from pipeline.simulation.figures.solids import Solid, vertex_normals

LUMPS = [ball(np.zeros(3), (1.0, 1.0, 1.0), 0.1)]


def parts() -> tuple[Solid, Solid]:
    """Return a ball and a tube that goes out of it upward."""
    line = np.linspace(0.2, 2.4, 40)[:, None] * np.array([0.0, 1.0, 0.0])
    return budgeted(LUMPS, 0.1, 4000), tube(line, np.full(40, 0.4), 24)


def kink(trunk: Solid, shank: Solid) -> float:
    """Return the median angle between both surfaces where they go through one another [degrees]."""
    off, nearest = cKDTree(shank.vertices).query(trunk.vertices)
    near = off < 0.06
    assert near.sum() > 10
    one, other = (vertex_normals(x.vertices, x.faces) for x in (trunk, shank))
    cosines = (one[near] * other[nearest[near]]).sum(axis=-1)
    return float(np.degrees(np.arccos(np.clip(np.median(cosines), -1.0, 1.0))))


def test_both_surfaces_have_one_normal_where_they_meet() -> None:
    trunk, shank = parts()
    assert kink(trunk, shank) > 50.0
    assert kink(*filleted(trunk, LUMPS, shank)) < 25.0


def test_what_is_far_from_the_other_stays() -> None:
    trunk, shank = parts()
    after = filleted(trunk, LUMPS, shank)
    low = trunk.vertices[:, 1] < 0.0
    high = shank.vertices[:, 1] > 1.8
    np.testing.assert_array_equal(after[0].vertices[low], trunk.vertices[low])
    np.testing.assert_array_equal(after[1].vertices[high], shank.vertices[high])
