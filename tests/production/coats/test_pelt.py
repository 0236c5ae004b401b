"""Pelts: strands that are as narrow as a pixel are smooth."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.coats.pelt import Pelt, grown_pelt, strand_count
from pipeline.production.scenery.stones import icosphere
from pipeline.simulation.take import Mesh
from render.config import MATERIALS


def pelt(pixel: float) -> Pelt:
    """Return the hair of a ball of 0.2 m, 0.05 m long, seen in pixels of a size [m]."""
    vertices, faces = icosphere(3)
    ball = (0.1 * vertices).astype(np.float32)
    one = len(ball)
    hair = np.tile(np.array([0.0, -0.05, 0.0], np.float32), (one, 1))
    nodes, weights = np.zeros((one, 2), np.int32), np.tile(np.float32([1.0, 0.0]), (one, 1))
    mesh = Mesh(ball, faces.astype(np.uint32), nodes, weights, hair=hair)
    count, width = strand_count(mesh, pixel, vanes=False)
    return grown_pelt(mesh, MATERIALS["black fur"], count, width, pixel, (1, 2), ("", "", ""))


def test_strands_that_are_narrow_in_the_frame_are_smoother_and_stray_less() -> None:
    near, middle, far = pelt(0.0002), pelt(0.0008), pelt(0.003)
    assert near.relief == 1.0 > middle.relief > far.relief
    strays = [np.abs(one.astray[:, 1]).mean() / one.relief for one in (near, middle, far)]
    assert strays[0] == pytest.approx(strays[1], rel=0.05)
    assert strays[2] < 0.7 * strays[1]


def test_strands_are_made_again_to_the_byte() -> None:
    one, other = pelt(0.001), pelt(0.001)
    for name in ("corners", "shares", "astray", "clumping", "colors"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()
