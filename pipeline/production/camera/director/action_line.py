"""Action line: the line that cameras stay on one side of, so that directions keep in the picture.

It runs between two who act together, or along the motion of one that travels.

Source: Arijon 1976, ch. 4 and 5 (triangle principle).
"""

from __future__ import annotations

import numpy as np

from pipeline.production.camera.director.performer_tracks import PerformerTracks
from pipeline.simulation.spatial import Array

NEUTRAL = 0.26
"""Sine of the angle between line and sight below which a view is neutral, along the line."""

TRAVELLING = 0.3
"""Speed from which a performer has a line, relative to its radius [1/s]."""


def line_of(tracks: PerformerTracks, line: tuple[str, ...], time: float) -> Array | None:
    """Return the level unit direction (3,) of a line of action, None where there is none.

    Args:
        tracks: of all performers.
        line: two who act together, one that travels, or nobody.
        time: since the start of the film [s].
    """
    if len(line) == 2:
        way = tracks.center(line[1], time) - tracks.center(line[0], time)
    elif len(line) == 1:
        way = tracks.velocity(line[0], time)
        if np.linalg.norm(way) < TRAVELLING * tracks.radii[tracks.number(line[0])]:
            return None
    else:
        return None
    way = way * [1.0, 0.0, 1.0]
    length = float(np.linalg.norm(way))
    return way / length if np.isfinite(length) and length > 1e-6 else None


def crossing(direction: Array, before: Array, after: Array) -> float:
    """Return whether a cut crosses a line: 1 if it does, 0.5 if a view is neutral, else 0.

    Args:
        direction: (3,) of the line.
        before: (3,) direction to the right in the picture before the cut.
        after: (3,) likewise after it.
    """
    a, b = float(direction @ before), float(direction @ after)
    if a * b < 0.0 and max(abs(a), abs(b)) > NEUTRAL:
        return 1.0
    return 0.5 if min(abs(a), abs(b)) < NEUTRAL else 0.0
