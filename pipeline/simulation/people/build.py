"""Build: a person's measures in metres, on which flesh and clothes are drawn.

Outlines are given once, as parts of the height of a grown-up (`ADULT`), and are fitted to others
between the same landmarks: soles, ankles, knees, hips, waist, shoulders, chin and crown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.people.proportions import ADULT, Proportions
from pipeline.simulation.spatial import Array

STOUTNESS = {"slim": 0.93, "medium": 1.0, "sturdy": 1.09}
"""Girth by build."""


@dataclass(frozen=True)
class Build:
    """Measures of one person.

    Attributes:
        proportions: where its joints lie.
        stoutness: girth as a part of that of a person of its weight.
    """

    proportions: Proportions
    stoutness: float

    @cached_property
    def girth(self) -> float:
        """What a grown-up's breadths, as parts of its height, are multiplied by [m]."""
        own, grown = self.proportions, ADULT
        dense = own.mass / own.height**3 / (grown.mass / grown.height**3)
        return self.stoutness * own.height * float(np.sqrt(dense))

    @property
    def childish(self) -> float:
        """How large the head is: 0 a grown-up's, 1 a child's of six."""
        part = self.proportions.head_size
        return float(np.clip((part - ADULT.head_size) / 0.05, 0.0, 1.0))

    def level(self, part: float) -> float:
        """Return the height of what a grown-up has at `part` of its height [m]."""
        return float(self.levels(np.array([part]))[0])

    def levels(self, parts: Array) -> Array:
        """Return the heights (n,) of what a grown-up has at `parts` (n,) of its height [m]."""
        own = np.interp(parts, _landmarks(ADULT), _landmarks(self.proportions))
        result: Array = own * self.proportions.height
        return result

    @property
    def hips(self) -> float:
        """Half the distance of the hips [m]."""
        return self.proportions.hips * self.proportions.height

    @property
    def shoulders(self) -> float:
        """Half the distance of the shoulders [m]."""
        return self.proportions.shoulders * self.proportions.height

    def outline(self, rows: Sequence[Sequence[float]], breadth: float | Array = 1.0) -> Array:
        """Return the rows of a `stack` in metres.

        Args:
            rows: (n, 5) as parts of a grown-up's height.
            breadth: what reaches to either side is multiplied by, of all rows or (n,) of each.
        """
        table = np.array(rows, dtype=float)
        table[:, 0] = self.levels(table[:, 0])
        table[:, 1:] *= self.girth
        table[:, 4] *= breadth
        return table

    @property
    def hip_breadth(self) -> float:
        """How much wider its pelvis is for its girth than a grown-up's."""
        return self.hips / (ADULT.hips * self.girth / self.stoutness)

    @property
    def shoulder_breadth(self) -> float:
        """How much wider its chest is for its girth than a grown-up's."""
        return self.shoulders / (ADULT.shoulders * self.girth / self.stoutness)


def _landmarks(p: Proportions) -> list[float]:
    return [0.0, p.ankle, p.knee, p.hip, p.spine, p.shoulder, 1.0 - p.head_size, 1.0]
