"""Thing circles: the circles on the ground that hold characters, for those who walk around them."""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.dynamics.compiled import Records, entry
from pipeline.simulation.spatial import Array


@entry
def find_circles(
    nodes: Records, owners: Records, numbers: IntArray, middles: Array, radii: Array
) -> None:
    """Find the circles around characters, of which each middle is the mean of the nodes.

    Args:
        nodes: of all characters.
        owners: (C,) all characters.
        numbers: (n,) of the characters asked for.
        middles: (n, 2) set to x and z [m].
        radii: (n,) set [m].
    """
    for k in range(len(numbers)):
        first, count = owners[numbers[k]].nodes[0], owners[numbers[k]].nodes[1]
        x = z = farthest = 0.0
        for i in range(first, first + count):
            x += nodes[i].p[0]
            z += nodes[i].p[2]
        x, z = x / count, z / count
        for i in range(first, first + count):
            off_x, off_z = nodes[i].p[0] - x, nodes[i].p[2] - z
            farthest = max(farthest, off_x * off_x + off_z * off_z)
        middles[k, 0], middles[k, 1] = x, z
        radii[k] = math.sqrt(farthest) + nodes[first].radius
