"""Row slice: the part of some rows of the take that one troupe writes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array


@dataclass(frozen=True, eq=False)
class Rows:
    """Writable slice of n rows of the take, for one troupe.

    Attributes:
        positions: (n, J, 3) node positions [m].
        rotations: (n, J, 3, 3) matrices; the take stores quaternions.
        alive: (n, J) whether a node exists.
        values: (n, C) channel values.
        scales: (n, N, 3) scales of the scaled nodes.
        expressions: (n, F, 21) of faces and hands, in the order of `face_units.COLUMNS`.
    """

    positions: Array
    rotations: Array
    alive: NDArray[np.bool_]
    values: Array
    scales: Array
    expressions: NDArray[np.float32]
