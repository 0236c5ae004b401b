"""Encounters: a troupe that runs into the solids of others, a step after they were there.

Solids are felt in the row before, with the speeds they have there, and go on so within the step.
What gives way is pushed at once as far as the troupe knows, and by its own room until the next
row; what that makes of it is felt then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.pushing import Pushed, Pushers
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.solid import Motion, Obstacle
from pipeline.simulation.spatial import matrix, turn
from pipeline.simulation.troupe import Bumps, Yields


class Encounters:
    """One troupe, and what it may run into.

    Args:
        troupe: who runs.
        recorder: where rows are written.
        fixed: solids that are not pushed.
        yielding: those that are, if there are any.
        yields: the troupe that they are of.
        still: whether all stay where they begin, so that they are felt once.
    """

    def __init__(
        self,
        troupe: Bumps,
        recorder: Recorder,
        fixed: Sequence[Obstacle],
        yielding: Sequence[Obstacle],
        yields: Yields | None,
        still: bool,
    ) -> None:
        self.still = still
        self.troupe, self.recorder, self.yields = troupe, recorder, yields
        taken = {id(one) for one in troupe.surround([*fixed, *yielding])}
        self.nodes = np.array([one.node for one in fixed if id(one) in taken], dtype=np.int64)
        # Which of those that yield are felt; they come after the others.
        self._which = np.array([id(one) in taken for one in yielding], dtype=bool)
        clock = recorder.clock
        row = clock.dt * (clock.steps // clock.samples)
        self._motion = Pushers(len(self.nodes), row)
        self._row = -1

    def feel(self, row: int) -> None:
        """Let the troupe feel where all solids are in a row that is written, and how fast."""
        if row == self._row or (self.still and self._row >= 0):
            return
        first, self._row = self._row < 0, row
        recorder, nodes = self.recorder, self.nodes
        if self.yields is not None and not len(nodes):
            self.troupe.feel(_some(self.yields.motion(), self._which))
            return
        here = Pushed(recorder.positions[row, nodes], matrix(recorder.quaternions[row, nodes]))
        if first:
            self._motion.put(here)
        speeds = self._motion.motion(here)
        motion = Motion(
            here.p,
            here.R,
            speeds[:, :3],
            turn(here.R, speeds[:, 3:]),
            recorder.alive[row, nodes],
            np.ones(len(nodes), dtype=bool),
        )
        if self.yields is not None:
            motion = _joined(motion, _some(self.yields.motion(), self._which))
        self.troupe.feel(motion)

    def push(self) -> None:
        """Hand on what those who yield were pushed by since they were felt."""
        if self.yields is None:
            return
        impulses, twists = self.troupe.pushed()
        count = len(self._which)
        pushed, twisted = np.zeros((count, 3)), np.zeros((count, 3))
        pushed[self._which] = impulses[len(self.nodes) :]
        twisted[self._which] = twists[len(self.nodes) :]
        self.yields.push(pushed, twisted)


def encounters_of(
    troupe: Bumps,
    recorder: Recorder,
    fixed: Sequence[Obstacle],
    yields: Yields | None,
    first: int,
    still: bool = False,
) -> Encounters | None:
    """Return who runs into what, None if there is nothing to run into.

    Args:
        troupe: who runs.
        recorder: where rows are written.
        fixed: solids that are not pushed.
        yields: whose solids are.
        first: number of the first of its nodes.
        still: whether all stay where they begin.
    """
    yielding = [] if yields is None else yields.solids()
    yielding = [replace(one, node=first + one.node) for one in yielding]
    if not fixed and not yielding:
        return None
    return Encounters(troupe, recorder, fixed, yielding, yields, still)


def _some(one: Motion, which: NDArray[np.bool_]) -> Motion:
    """Return the motion of those solids that count."""
    return Motion(
        *(one.p[which], one.R[which], one.v[which], one.w[which]),
        *(one.here[which], one.borne[which]),
    )


def _joined(one: Motion, other: Motion) -> Motion:
    """Return the motion of some solids and of others."""
    return Motion(
        np.concatenate([one.p, other.p]),
        np.concatenate([one.R, other.R]),
        np.concatenate([one.v, other.v]),
        np.concatenate([one.w, other.w]),
        np.concatenate([one.here, other.here]),
        np.concatenate([one.borne, other.borne]),
    )
