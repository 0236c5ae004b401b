"""Row scheduler: decides which rows of the take are computed when.

Rows are computed in batches, because array operations over many rows cost a tenth of row-by-row
ones. Three dependencies limit a batch:

* a troupe that is pushed (`WriteStage.AFTER_PUSHERS`) goes from row to row, after all that push it;
* a troupe that hits obstacles reads them one step ago, so their rows have to be written by then;
* groups (`WriteStage.LAST`) read the poses of all others and nobody reads theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pipeline.errors import SimulationError
from pipeline.simulation.attachment import Attachment, split_attachments
from pipeline.simulation.clock import Clock
from pipeline.simulation.contact_coupling import ContactCoupling
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact
from pipeline.simulation.troupe import Troupe, WriteStage, node_range, pushed_troupe


@dataclass(frozen=True, slots=True)
class BatchLimits:
    """Sizes of a batch of rows.

    Attributes:
        rows: largest batch.
        rows_with_bodies: largest batch where bodies are pushed: they report contacts as late.
        poses: nodes times rows that stay in the processor's cache.
    """

    rows: int = 96
    rows_with_bodies: int = 24
    poses: int = 65_536

    def size(self, nodes: int, with_bodies: bool) -> int:
        """Returns the number of rows of a batch for a scene of `nodes`."""
        rows = min(max(self.poses // max(nodes, 1), self.rows // 6), self.rows)
        return min(rows, self.rows_with_bodies) if with_bodies else rows


BATCH_LIMITS = BatchLimits()


@dataclass(frozen=True, eq=False)
class Batch:
    """Finished rows, all nodes in the world frame.

    Attributes:
        rows: numbers of the rows.
        p: (n, J, 3) positions of all nodes [m].
        R: (n, J, 3, 3) rotations.
        contacts: contacts of groups, which are known only now.
    """

    rows: slice
    p: Array
    R: Array
    contacts: Sequence[Contact]


class RowScheduler:
    """Buffers rows and writes them in batches.

    Args:
        clock: grid of steps and rows.
        troupes: all troupes, in the order of their nodes.
        recorder: the take under construction.
        attachments: all attachments, parents first.
        coupling: the troupe that hits obstacles and its obstacles, None without any.
        on_batch: called with each finished batch.

    Attributes:
        batch_size: number of rows written together.
        buffered: number of rows that the troupes have buffered so far.
        written: number of rows that are finished.
    """

    def __init__(
        self,
        clock: Clock,
        troupes: Sequence[Troupe],
        recorder: Recorder,
        attachments: Sequence[Attachment],
        coupling: ContactCoupling | None,
        on_batch: Callable[[Batch], None],
    ) -> None:
        self.clock, self.troupes, self.recorder = clock, troupes, recorder
        self.coupling, self._on_batch = coupling, on_batch
        self.buffered = self.written = 0
        self._last = [t for t in troupes if t.write_stage is WriteStage.LAST]
        self._pushed = pushed_troupe(troupes)
        # Attachments that push bodies, and those that depend on bodies.
        self._early, self._late = list[Attachment](), list(attachments)
        if self._pushed is not None:
            self._early, self._late = split_attachments(
                attachments, node_range(troupes, self._pushed)
            )
        self.batch_size = BATCH_LIMITS.size(len(recorder.nodes), self._pushed is not None)
        # Troupes whose rows wait while those of the obstacles are written one by one.
        self._deferred = list[Troupe]()
        if coupling is not None and not coupling.still:
            self._deferred = self._deferrable(coupling.troupe, attachments)
            self.batch_size = self.batch_size if self._deferred else 1

    def _deferrable(self, collider: Troupe, attachments: Sequence[Attachment]) -> list[Troupe]:
        """Returns the troupes that are no obstacles; none if anything goes with `collider`."""
        if self._pushed is not None and self._pushed.goes_with_others:
            return []
        if split_attachments(attachments, node_range(self.troupes, collider))[1]:
            return []
        return [collider, *self._last]

    @property
    def last_row(self) -> int:
        """Number of the last row that is buffered."""
        return self.buffered - 1

    def buffer_step(self, step: int) -> None:
        """Buffers the row at `step`, if there is one, and writes the batch that it completes.

        Raises:
            SimulationError: if a pose is not finite.
        """
        if self.clock.row_of_step(step) is None:
            return
        for troupe in self.troupes:
            troupe.buffer_row()
        self.buffered += 1
        if self._deferred:
            self._write_obstacles(slice(self.last_row, self.buffered))
        # Overlaps at the start are refused before the first step.
        overlaps = self.buffered == 1 and (self._pushed or self.coupling) is not None
        full = self.buffered - self.written == self.batch_size
        if overlaps or full or step >= self.clock.last_step:
            self.flush()

    def flush(self) -> None:
        """Writes all buffered rows.

        Raises:
            SimulationError: if a pose is not finite.
        """
        if self.buffered > self.written:
            self._write(slice(self.written, self.buffered))
            self.written = self.buffered

    def _write(self, rows: slice) -> None:
        first = self.written if self._deferred else -1
        for troupe, own in zip(self.troupes, self.recorder.rows(rows, first), strict=True):
            if troupe in self._deferred or not self._deferred:
                self._write_troupe(troupe, own, rows)
        R, p = self.recorder.attached(rows, () if self._deferred else self._late)
        contacts = [contact for troupe in self._last for contact in troupe.write_last(R, p)]
        self._refuse_divergence(self.recorder.store(rows))
        self._on_batch(Batch(rows, p, R, contacts))

    def _write_obstacles(self, row: slice) -> None:
        """Writes one row of all troupes that are obstacles to another."""
        rows = self.recorder.rows(row, self.written)
        for troupe, own in zip(self.troupes, rows, strict=True):
            if troupe not in self._deferred:
                self._write_troupe(troupe, own, row)
        self.recorder.attached(row, self._late)
        if self.coupling is not None and len(self.coupling.nodes):
            self.recorder.show(row, self.coupling.nodes)

    def _write_troupe(self, troupe: Troupe, own: Rows, rows: slice) -> None:
        """Writes the rows of one troupe, those before it having written theirs."""
        if troupe is self._pushed:
            R, p = self.recorder.attached(rows, self._early)
            if self.coupling is not None:
                self.coupling.push_solids()
            for k, row in enumerate(range(rows.start, rows.stop)):
                troupe.advance_to_row(self.clock.step_of_row(row), p[k], R[k])
        troupe.write(own)

    def _refuse_divergence(self, wrong: tuple[int, str] | None) -> None:
        if wrong is not None:
            row, node = wrong
            step = self.clock.step_of_row(row)
            raise SimulationError(
                f"the simulation diverged at step {step} "
                f"({float(self.clock.time_of(step)):.3f} s): "
                f"the pose of {node} is no longer finite"
            )
