"""Control: what people do with their nodes before each sub-step."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.characters.layout import Crowd
from pipeline.simulation.dynamics.compiled import Records, compiled
from pipeline.simulation.dynamics.grid import Grid

PERSON = np.dtype(
    [
        # Its number among the crowd's owners, and its first node.
        ("owner", "i8"),
        ("node", "i8"),
        # Its first grip: left hand, right hand, and both hands together.
        ("grip", "i8"),
    ],
    align=True,
)
"""What a person is told and does."""


@compiled
def steer(crowd: Crowd, persons: Records, ground: Grid, h: float) -> None:
    """Let everybody act for a sub-step of `h` [s], see `layout`."""
