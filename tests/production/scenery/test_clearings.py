"""Clearings: ground that an outline encloses stays bare, open rings do not."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.scenery.clearings import STAYS, UNDER, _enclosed

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
