"""Figure frames: where a figure is in n rows, and the frames of its author's values.

Source: Sims 1987, 3.2.2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.pose_plan import PointRun
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.spatial import Array, normalized, turn, turn_inverse
from pipeline.spec.keyframes import Frame


@dataclass(frozen=True, eq=False)
class FigureFrames:
    """The place of a figure in n rows, and the frames of its author's values.

    Attributes:
        times: (n,) [s].
        dt: between two rows [s].
        R_WB, p_WB: (n, 3, 3) and (n, 3) pose of its body [m].
        R_WG, p_WG: (n, 3, 3) and (n, 3) of the ground below it, x along its heading [m].
    """

    times: Array
    dt: float
    R_WB: Array
    p_WB: Array
    R_WG: Array
    p_WG: Array

    def frame(self, name: Frame) -> tuple[Array, Array]:
        """Return the pose in the world of a frame named by the author."""
        if name == "body":
            return self.R_WB, self.p_WB
        if name == "feet":
            return self.R_WG, self.p_WG
        return np.broadcast_to(np.eye(3), self.R_WB.shape), np.zeros_like(self.p_WB)


@dataclass(frozen=True, eq=False)
class LimbParent:
    """What a limb hangs on, relative to the body, in n rows; the body itself is the identity.

    Attributes:
        R_BP: (n, 3, 3) turned from how it was drawn.
        p_BP: (n, 3) [m].
    """

    R_BP: Array
    p_BP: Array

    @staticmethod
    def body(rows: int) -> LimbParent:
        """Return the body."""
        return LimbParent(np.broadcast_to(np.eye(3), (rows, 3, 3)), np.zeros((rows, 3)))

    def repeated(self, row: int, count: int) -> LimbParent:
        """Return one row `count` times."""
        return LimbParent(
            np.broadcast_to(self.R_BP[row], (count, 3, 3)),
            np.broadcast_to(self.p_BP[row], (count, 3)),
        )


Foresight = Callable[[int, Array], FigureFrames]
"""Frames of the figure at times (k,), as they are foreseen in a row."""


def point_targets(point_run: PointRun, frames: FigureFrames, parent: LimbParent) -> Array:
    """Return the targets of a node in n rows, relative to what its limb hangs on.

    Returns:
        Places (n, 3) [m], directions (n, 3), or rotations (n, 3, 3).
    """
    values = point_run.run.track(frames.times)
    R_WG, p_WG = frames.frame(point_run.frame)
    R_WP = frames.R_WB @ parent.R_BP
    if point_run.goal == "reach":
        p_WP = frames.p_WB + turn(frames.R_WB, parent.p_BP)
        return turn_inverse(R_WP, p_WG + turn(R_WG, values) - p_WP)
    if point_run.goal == "aim":
        return normalized(turn_inverse(R_WP, turn(R_WG, values)))
    return R_WP.transpose(0, 2, 1) @ R_WG @ rotation_from_angles(values)
