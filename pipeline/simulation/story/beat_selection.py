"""Beat selection: which of several beats, or ways to play one, comes next.

Those of the highest priority compete. Each has a score: its weight, times how near its tension is
to the wanted one; one is drawn by the scores.

Source: Mateas and Stern 2005, "Structuring content in the Façade interactive drama architecture":
    preconditions, priority, scores by an inverse exponential of the distance to the arc, weights,
    and a weighted draw.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

TENSION_TOLERANCE = 0.15
"""Distance from the wanted tension at which a score falls to 37 %."""

FAR_TENSION = 0.25
"""Distance from the wanted tension from which a beat is put off."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A beat or choice that can be picked.

    Attributes:
        name: of it.
        weight: of the author.
        tension: that it leads to.
        priority: of a beat.
        reason: the conditions that hold.
    """

    name: str
    weight: float
    tension: float
    priority: int = 0
    reason: str = ""


def highest(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Returns the candidates of the highest priority, in their order."""
    top = max((one.priority for one in candidates), default=0)
    return [one for one in candidates if one.priority == top]


def shares(candidates: Sequence[Candidate], wanted: float | None) -> list[float]:
    """Returns the probabilities of candidates, for a wanted tension if there is one."""
    scores = [
        one.weight * math.exp(-tension_gap(one, wanted) / TENSION_TOLERANCE) for one in candidates
    ]
    total = sum(scores)
    return [score / total for score in scores]


def draw(candidates: Sequence[Candidate], wanted: float | None, chance: float) -> int:
    """Returns the index of the candidate that a chance from 0 to 1 draws by the scores."""
    left = chance
    odds = shares(candidates, wanted)
    for k, share in enumerate(odds):
        if left < share:
            return k
        left -= share
    return max(k for k, share in enumerate(odds) if share > 0.0)


def tension_gap(candidate: Candidate, wanted: float | None) -> float:
    """Returns how far the tension of a candidate is from the wanted one, 0 without one."""
    return 0.0 if wanted is None else abs(candidate.tension - wanted)
