"""Camera subjects: the performers that the picture of a cut is about."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.take import Take
from render.config import Camera

LEAST_MOTION = 0.02
"""Displacement from which a performer counts as moving [m]."""

MOTION_SAMPLES = 64
"""Rows of a cut that are compared to tell which performers move."""


def camera_subjects(
    take: Take, camera: Camera, rows: NDArray[np.int64]
) -> tuple[frozenset[str], ...]:
    """Return groups of performers; something is wrong with a group only if it is with all of it.

    Each performer that the author follows is a group of its own. Without names those with joints
    are one group, because of a crowd somebody is always out of sight; else those that move, or the
    whole cast. A camera carried by a part of the cast that follows nobody shows what comes, and
    has no subject.

    Args:
        take: that is filmed.
        camera: configuration of the cut.
        rows: of its frames.
    """
    cast = list(dict.fromkeys(part.performer for part in take.parts))
    if camera.follow is not None:
        named = (camera.follow,) if isinstance(camera.follow, str) else camera.follow
        return tuple(frozenset({name}) for name in named if name in cast)
    if camera.parent is not None or not cast:
        return ()
    jointed = {
        node.performer
        for node in take.nodes
        if node.parent >= 0 and take.nodes[node.parent].performer == node.performer
    }
    return (frozenset(jointed & set(cast) or _moving(take, rows) & set(cast) or cast),)


def _moving(take: Take, rows: NDArray[np.int64]) -> set[str]:
    """Return the performers that move."""
    some = rows[:: -(-len(rows) // MOTION_SAMPLES)]
    places = np.where(take.alive[some][..., None], take.positions[some], np.nan)
    span = np.fmax.reduce(places, axis=0) - np.fmin.reduce(places, axis=0)
    moving = (span > LEAST_MOTION).any(axis=-1)
    return {node.performer for node, moves in zip(take.nodes, moving, strict=True) if moves}
