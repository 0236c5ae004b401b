"""Chunks follow what frames cost."""

from __future__ import annotations

import pytest

from pipeline.farm.chunk_plan import (
    FIRST_CHUNK,
    MAX_OVERHEAD,
    TARGET_SECONDS,
    FilmCosts,
    chunk_size,
)
from pipeline.farm.frame_worker import ChunkCost


def costs(per_frame: float, load: float = 1.0, first: float = 3.0) -> FilmCosts:
    found = FilmCosts()
    found.add(ChunkCost(rendered=5, load=load, first=first, frames=4 * per_frame))
    return found


def handed_out(frames: int, workers: int, known: FilmCosts) -> list[int]:
    """Return the sizes of all chunks of a film."""
    sizes = []
    while frames:
        sizes.append(chunk_size(frames, workers, known))
        frames -= sizes[-1]
    return sizes


def test_before_anything_is_measured_chunks_are_short() -> None:
    assert chunk_size(1000, 4, FilmCosts()) == FIRST_CHUNK
    assert chunk_size(1, 4, FilmCosts()) == 1


def test_costs_are_split_into_build_and_frames() -> None:
    found = costs(0.5, load=1.0, first=3.0)
    assert found.per_frame == pytest.approx(0.5)
    assert found.per_build == pytest.approx(3.5)
    assert found.expected(10) == pytest.approx(8.5)
    # A worker that has the film builds nothing.
    found.add(ChunkCost(rendered=4, load=0.01, frames=2.0))
    assert found.per_frame == pytest.approx(0.5)
    assert found.per_build == pytest.approx(3.5)


@pytest.mark.parametrize("per_frame", [0.05, 0.5, 5.0, 90.0])
def test_chunks_take_about_the_time_that_is_wanted(per_frame: float) -> None:
    found = costs(per_frame)
    size = chunk_size(100_000, 4, found)
    if size > 1 and size < 512:
        assert (size - 1) * per_frame <= TARGET_SECONDS <= size * per_frame


def test_costly_builds_make_chunks_longer() -> None:
    found = costs(0.5, load=10.0, first=10.5)
    size = chunk_size(100_000, 4, found)
    expected = found.expected(size)
    assert expected is not None
    assert found.per_build / expected <= 1.01 * MAX_OVERHEAD


@pytest.mark.parametrize("workers", [1, 3, 16])
def test_chunks_become_smaller_towards_the_end(workers: int) -> None:
    sizes = handed_out(500, workers, costs(0.5))
    assert sum(sizes) == 500
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] == 1
    assert sizes[0] > 1
