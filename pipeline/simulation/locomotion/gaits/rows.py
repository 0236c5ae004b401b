"""Legs as a gait sees them: a left and a right row, each from front to back.

Source: Sims 1987, 10.3.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Rows:
    """The legs of one creature.

    Attributes:
        left, right: numbers of the legs, front to back.
    """

    left: tuple[int, ...]
    right: tuple[int, ...]

    @staticmethod
    def of(sides: Sequence[str], forward: Sequence[float]) -> Rows:
        """Sort legs into rows.

        A leg in the middle joins the shorter row, so that it has a neighbour to take
        turns with; the left one if they are even.

        Args:
            sides: "l", "r" or "m" of each leg.
            forward: how far to the front each one stands [m].
        """
        rows: dict[str, list[int]] = {side: [] for side in "lrm"}
        for leg in sorted(range(len(sides)), key=lambda leg: -forward[leg]):
            rows[sides[leg]].append(leg)
        left, right = rows["l"], rows["r"]
        for leg in rows["m"]:
            shorter = left if len(left) <= len(right) else right
            shorter.append(leg)
        return Rows(*(tuple(sorted(row, key=lambda leg: -forward[leg])) for row in (left, right)))

    @property
    def count(self) -> int:
        """How many legs there are."""
        return len(self.left) + len(self.right)

    def __iter__(self) -> Iterator[tuple[int, ...]]:
        """Give the left row, then the right one."""
        return iter((self.left, self.right))

    def __str__(self) -> str:
        """Return how many legs stand where."""
        number = f"{self.count} leg" + ("s" if self.count != 1 else "")
        return f"{number} ({len(self.left)} left, {len(self.right)} right)"
