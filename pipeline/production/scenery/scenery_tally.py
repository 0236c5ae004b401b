"""Scenery tally: how many plants and stones are placed, and of how many triangles."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pipeline.production.scenery.expansion import triangle_counts
from pipeline.production.scenery.placement import Placed


@dataclass(frozen=True)
class SceneryTally:
    """What is scattered over the ground of a film.

    Attributes:
        counts: of the things of each species that has any.
        triangles: of all.
    """

    counts: Mapping[str, int]
    triangles: int

    @staticmethod
    def of(every: Sequence[Placed], detail: float) -> SceneryTally:
        """Count what is placed, in frames of a detail."""
        counts = Counter[str]()
        for placed in every:
            counts[placed.name] += len(placed.points)
        triangles = sum(int(triangle_counts(placed, detail).sum()) for placed in every)
        return SceneryTally({name: n for name, n in counts.items() if n}, triangles)
