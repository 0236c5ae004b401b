"""Wading: who is told to go through the water."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.wading import Wading, waders
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Part

CLOCK = Clock(Fraction(24), 24)


@dataclass
class Sinking:
    """Three parts of two vertices; the legs of the first sink by a metre within the film."""

    starts: NDArray[np.int64]

    def posed(self, take: object, row: float) -> NDArray[np.float64]:
        """Return vertices at heights in a row of the take."""
        heights = [1.0 - row / 96.0, 1.0 - row / 96.0, 1.4, 1.5, -0.5, -0.4]
        return np.array([[0.0, y, 0.0] for y in heights])


def test_who_is_partly_under_water_wades_from_the_frame_that_shows_it() -> None:
    parts = [
        Part(name, performer, 0, "bone", 0.1, (0, 1000))
        for name, performer in (("cow.leg", "cow"), ("cow.body", "cow"), ("fish.body", "fish"))
    ]
    take = cast("Any", SimpleNamespace(parts=parts))
    skin = cast("Any", Sinking(np.array([0, 2, 4, 6])))
    # At a level of 0.5 the legs are in the water from the middle; the fish never comes out.
    assert waders(take, skin, CLOCK, 0.5) == [Wading("cow", 19, 0.25)]
    assert waders(take, skin, CLOCK, -2.0) == []
