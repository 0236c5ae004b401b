"""Islands: pieces of ground that can be stood on, and those that steps connect."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.simulation.terrain.ground import Ground
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.simulation.terrain.islands import Islands, labelled

SIDE = 24


def flooded(free: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the numbers of pieces in the order of their first cells, found cell by cell."""
    numbers = np.full(free.shape, -1)
    count = 0
    for first in map(tuple, np.argwhere(free)):
        if numbers[first] >= 0:
            continue
        found = [first]
        while found:
            row, column = found.pop()
            if not (0 <= row < free.shape[0] and 0 <= column < free.shape[1]):
                continue
            if free[row, column] and numbers[row, column] < 0:
                numbers[row, column] = count
                found += [(row + 1, column), (row - 1, column), (row, column + 1)]
                found.append((row, column - 1))
        count += 1
    return numbers


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.9, 1.0])
def test_pieces_are_numbered_in_the_order_of_their_first_cells(share: float) -> None:
    free = np.random.default_rng(3).random((SIDE, SIDE + 7)) < share
    assert (labelled(free) == flooded(free)).all()


def stones(heights: list[float]) -> Islands:
    """Return the islands of stones in a row, three cells wide, with gaps of two cells."""
    ground = np.zeros((4, 5 * len(heights)))
    forbidden = np.ones((3, 5 * len(heights) - 1), dtype=bool)
    for k, height in enumerate(heights):
        ground[:, 5 * k : 5 * k + 4] = height
        forbidden[:, 5 * k : 5 * k + 3] = False
    field = HeightField(ground, (float(forbidden.shape[1]), 3.0))
    return Islands(Ground(field, forbidden, "rock"))


def reached(islands: Islands, gap: float, rise: float, start: float = 0.0) -> list[bool]:
    """Return which stones are reached from the one at `start`, counted in cells."""
    left = -0.5 * islands.ground.field.size[0]
    cells = islands.reached(np.array([left + 1.5 + 5.0 * start, 0.0]), 0.5, gap, rise)
    return cells[1, 1::5].tolist()


def test_steps_lead_over_narrow_gaps_and_low_rises_one_after_the_other() -> None:
    islands = stones([0.0, 0.3, 0.6, 1.5, 1.6])
    assert reached(islands, 2.0, 0.4) == [True, True, True, False, False]
    assert reached(islands, 2.0, 0.4, start=4) == [False, False, False, True, True]
    assert reached(islands, 2.0, 1.0) == [True] * 5
    assert reached(islands, 2.0, 0.2) == [True, False, False, False, False]
    # The cells on either side of a gap count with it.
    assert reached(islands, 0.0, 5.0) == [True, False, False, False, False]


def test_ground_without_forbidden_cells_is_reached_whole() -> None:
    field = HeightField(np.zeros((4, 4)), (3.0, 3.0))
    forbidden = np.zeros((3, 3), dtype=bool)
    assert Islands(Ground(field, forbidden, "rock")).reached(np.zeros(2), 1.0, 0.1, 0.1).all()
    nowhere = Islands(Ground(field, ~forbidden, "rock")).reached(np.zeros(2), 1.0, 0.1, 0.1)
    assert not nowhere.any()
