"""The row scheduler: batches, and which troupe is written when."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import ClassVar

import numpy as np
import pytest

from pipeline.errors import SimulationError
from pipeline.simulation.attachment import Attachment
from pipeline.simulation.clock import Clock
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.scheduler import Batch, BatchLimits, RowScheduler
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, Header, Node
from pipeline.simulation.terrain import Ground, build_ground
from pipeline.simulation.troupe import Troupe, WriteStage
from pipeline.spec import read_scene

CLOCK = Clock(Fraction(24), frames=6, steps=4, samples=2)


class Mover(Troupe):
    """One node that moves along X by 1 m a row."""

    def __init__(self, name: str, log: list[tuple[str, int]]) -> None:
        self.name, self.log = name, log
        self.inventory = Inventory((Node(name, name, -1, (0.0, 0.0, 0.0)),), (), (), ())
        self.buffered = 0
        self.rows = list[int]()

    def buffer_row(self) -> None:
        """See `Troupe`."""
        self.rows.append(self.buffered)
        self.buffered += 1

    def write(self, rows: Rows) -> None:
        """See `Troupe`."""
        self.log.append((self.name, len(self.rows)))
        rows.positions[:, 0, 0] = self.rows
        rows.rotations[:] = np.eye(3)
        rows.alive[:] = True
        self.rows.clear()


class Diverging(Mover):
    """A mover whose position is not finite from row 5 on."""

    def write(self, rows: Rows) -> None:
        """See `Troupe`."""
        late = np.array(self.rows) >= 5
        super().write(rows)
        rows.positions[late] = np.nan


class Pushed(Mover):
    """A mover that is pushed by the first node."""

    write_stage: ClassVar[WriteStage] = WriteStage.AFTER_PUSHERS

    def buffer_row(self) -> None:
        """See `Troupe`."""

    def advance_to_row(self, step: int, p: Array, R: Array) -> None:
        """See `Troupe`."""
        self.log.append(("pushed at", step))
        self.rows.append(int(p[0, 0]) + 100)


class Last(Mover):
    """A mover that reads all other nodes."""

    write_stage: ClassVar[WriteStage] = WriteStage.LAST

    def write_last(self, R: Array, p: Array) -> list[Contact]:
        """See `Troupe`."""
        self.log.append(("last sees", int(p[-1, 0, 0])))
        return []


@pytest.fixture(scope="module")
def ground() -> Ground:
    """Flat ground."""
    return build_ground(
        read_scene(
            "pronk: 1\nduration: 1\ncast: [{prop: {shape: ball, radius: 1}, at: [0, 0]}]"
        ).terrain,
        0,
    )


def scheduler_of(
    troupes: Sequence[Troupe], ground: Ground, attachments: Sequence[Attachment] = ()
) -> tuple[RowScheduler, list[Batch]]:
    """Return a scheduler without obstacles, and the list that it appends batches to."""
    header = Header("", "", CLOCK.rate, CLOCK.frames, CLOCK.samples, CLOCK.steps, 0, {})
    recorder = Recorder(header, CLOCK, ground, [troupe.inventory for troupe in troupes])
    batches = list[Batch]()
    return RowScheduler(CLOCK, troupes, recorder, attachments, None, batches.append), batches


def run(scheduler: RowScheduler) -> None:
    for step in range(CLOCK.last_step + 1):
        scheduler.buffer_step(step)


def slices(batches: Sequence[Batch]) -> list[tuple[int, int]]:
    return [(batch.rows.start, batch.rows.stop) for batch in batches]


def test_rows_are_written_in_full_batches_and_the_rest_at_the_end(ground: Ground) -> None:
    scheduler, batches = scheduler_of([Mover("a", [])], ground)
    scheduler.batch_size = 5
    run(scheduler)
    assert slices(batches) == [(0, 5), (5, 10), (10, 13)]
    x = scheduler.recorder.positions[:, 0, 0]
    assert np.array_equal(x, np.arange(CLOCK.rows))


def test_a_flush_writes_what_is_buffered_and_nothing_twice(ground: Ground) -> None:
    scheduler, batches = scheduler_of([Mover("a", [])], ground)
    for step in range(5):
        scheduler.buffer_step(step)
    scheduler.flush()
    scheduler.flush()
    assert slices(batches) == [(0, 3)]
    assert scheduler.last_row == 2


def test_a_pushed_troupe_goes_row_by_row_after_its_pusher(ground: Ground) -> None:
    log = list[tuple[str, int]]()
    scheduler, batches = scheduler_of([Mover("a", log), Pushed("b", log)], ground)
    run(scheduler)
    # The first row alone, so that overlaps at the start are found before the first step.
    assert slices(batches) == [(0, 1), (1, 13)]
    assert log[:3] == [("a", 1), ("pushed at", 0), ("b", 1)]
    assert log[3:6] == [("a", 12), ("pushed at", 2), ("pushed at", 4)]
    assert np.array_equal(scheduler.recorder.positions[:, 1, 0], 100 + np.arange(CLOCK.rows))


def test_the_last_troupe_sees_attached_nodes_in_the_world(ground: Ground) -> None:
    log = list[tuple[str, int]]()
    rider = Attachment("rider", np.array([0]), 1, ())
    troupes = [Mover("rider", log), Mover("horse", log), Last("birds", log)]
    scheduler, _ = scheduler_of(troupes, ground, [rider])
    run(scheduler)
    # The displacements of rider and horse add up.
    assert log[-1] == ("last sees", 2 * (CLOCK.rows - 1))


def test_divergence_names_the_step_and_the_node(ground: Ground) -> None:
    scheduler, _ = scheduler_of([Diverging("a", [])], ground)
    with pytest.raises(SimulationError, match=r"step 10 .* the pose of a is no longer finite"):
        run(scheduler)


@pytest.mark.parametrize(
    ("nodes", "with_bodies", "size"),
    [(1, False, 96), (1, True, 24), (1000, False, 65), (100_000, False, 16)],
)
def test_batches_shrink_with_the_number_of_nodes(nodes: int, with_bodies: bool, size: int) -> None:
    assert BatchLimits().size(nodes, with_bodies) == size
