"""Row storage: long arrays lie on disk, with equal results."""

from __future__ import annotations

import mmap
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from pipeline.errors import StoreError
from pipeline.simulation import row_storage
from pipeline.simulation.row_storage import allocate_rows, release_rows, row_chunks
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take_store import read_take, write_take

if TYPE_CHECKING:
    from pipeline.spec import Scene


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let everything but the smallest lie on disk, a few rows at a time."""
    monkeypatch.setattr(row_storage, "MAX_IN_MEMORY", 2000)
    monkeypatch.setattr(row_storage, "CHUNK_BYTES", 9000)


@pytest.mark.usefixtures("short")
def test_released_rows_keep_their_values() -> None:
    rows = allocate_rows((500, 3), float)
    assert isinstance(rows.base, mmap.mmap)
    assert not rows.any()
    for some in row_chunks(rows):
        rows[some] = np.arange(500)[some, None]
        release_rows(rows)
    assert np.array_equal(rows, np.arange(500)[:, None] * np.ones(3))


@pytest.mark.usefixtures("short")
@pytest.mark.parametrize(("count", "multiple"), [(0, 1), (1, 1), (1000, 1), (1000, 64), (999, 999)])
def test_chunks_cover_all_rows_in_order(count: int, multiple: int) -> None:
    slices = list(row_chunks(allocate_rows((count, 10), float), multiple))
    seen = [row for some in slices for row in range(some.start, some.stop)]
    assert seen == list(range(count))
    assert all((some.stop - some.start) % multiple == 0 for some in slices[:-1])


@pytest.mark.usefixtures("short")
def test_a_full_disk_is_an_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(row_storage.tempfile, "tempdir", None)
    with pytest.raises(StoreError, match="TMPDIR"):
        allocate_rows((2**50, 2**4), np.uint8)


@pytest.mark.nightly
def test_a_take_on_disk_equals_the_take_in_memory(
    scene_of: Callable[..., Scene], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of("{figure: horse, scale: 0.5, walk: {}}", terrain="hills", duration=3)
    in_memory = simulate(scene)
    monkeypatch.setattr(row_storage, "MAX_IN_MEMORY", 2000)
    monkeypatch.setattr(row_storage, "CHUNK_BYTES", 9000)
    on_disk = simulate(scene)
    assert isinstance(on_disk.rotations.base, mmap.mmap)
    assert on_disk.digest == in_memory.digest
    write_take(on_disk, tmp_path / "take")
    read = read_take(tmp_path / "take")
    assert isinstance(read.rotations.base, mmap.mmap)
    assert read.digest == in_memory.digest
    for (_, one), (_, two) in zip(in_memory.arrays(), read.arrays(), strict=True):
        assert one.tobytes() == two.tobytes()
