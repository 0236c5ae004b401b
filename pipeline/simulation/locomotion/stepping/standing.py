"""Standing: whether walkers rest on closed feet at the end of their routes, and how they stand."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.locomotion.foot_state import FootState, present_lowering
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
from pipeline.simulation.spatial import Array


def is_standing(progress: RouteProgress, feet: FootState, c: int) -> bool:
    """Return whether creature `c` stands at the end of its route, on closed feet."""
    own = progress.herd.owner == c
    if not progress.arrived[c]:
        return False
    closed = progress.halted[c] or progress.phase[c] >= progress.closing_phase[c]
    return bool(closed and not feet.swinging[own].any() and progress.smoothed_fraction[c] == 0.0)


def standing_pose(progress: RouteProgress, feet: FootState, c: int) -> tuple[Array, Array]:
    """Return the pose (3, 3), (3,) of the body of creature `c` at the end of its route [m]."""
    place = np.array([c]), progress.distance[c : c + 1], progress.phase[c : c + 1]
    R, p = progress.trajectory.pose(*place, progress.smoothed_fraction[c : c + 1])
    low = present_lowering(feet, progress.phase[progress.herd.owner])
    lowering = (low[progress.herd.owner == c] ** 4).sum() ** 0.25
    return R[0], p[0] - [0.0, lowering, 0.0]
