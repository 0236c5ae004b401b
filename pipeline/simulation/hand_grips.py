"""Hand grips: when the hands of performers hold props, so that their fingers close."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.attachment import Attachment
from pipeline.simulation.spatial import Array

CARRIED_GRIP = 1.0
"""How far fingers close about a thing that is carried all along: it was placed in the hand."""


class HandGrips:
    """When each hand of P performers holds something.

    Args:
        hands: numbers of the nodes (P, 2) of left and right hands.
    """

    def __init__(self, hands: Sequence[Sequence[int]]) -> None:
        self._hands = np.array(hands, dtype=np.int64).reshape(-1, 2)
        self._spans: list[tuple[int, int, tuple[int, int], float]] = []

    def bind(self, attachments: Sequence[Attachment]) -> None:
        """Take the grips of props that hands hold for a while or carry all the time."""
        for attachment in attachments:
            held = [(grip.node, grip.rows, grip.closure) for grip in attachment.grips]
            if not held:
                held = [(attachment.parent, (0, np.iinfo(np.int64).max), CARRIED_GRIP)]
            for node, rows, share in held:
                for performer, side in np.argwhere(self._hands == node).tolist():
                    self._spans.append((performer, side, rows, share))

    def at(self, first: int, count: int) -> Array:
        """Return how far hands grip (count, P, 2) in rows from `first` on, 0 to 1."""
        rows = np.arange(first, first + count)
        found = np.zeros((count, len(self._hands), 2))
        for performer, side, (start, end), share in self._spans:
            found[(rows >= start) & (rows < end), performer, side] = share
        return found
