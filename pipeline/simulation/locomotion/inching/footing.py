"""Footing: where the feet of an inchworm lie, and where they are put next.

A worm keeps to the vertical plane through its heading. In it a foot's pose is three
numbers: the way of its middle from the start, its height, and its elevation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.inching.chain import FRONT, REAR, Chain, Foot
from pipeline.simulation.spatial import Array, heading, rotation
from pipeline.simulation.terrain import Ground

NEARER = np.linspace(0.0, 1.0, 41)
"""Places looked at from the wished one back to the present one."""

UNDER = np.linspace(-0.5, 0.5, 5)
"""Where the ground under a foot is looked at, as parts of its length."""

SIDEWAYS = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Track:
    """The plane in which one worm goes.

    Attributes:
        ground: what it goes on.
        start: (2,) x and z where its way begins [m].
        heading: where it goes [rad].
    """

    ground: Ground
    start: Array
    heading: float

    def places(self, ways: Array) -> tuple[Array, Array]:
        """Return x and z (...) at `ways` (...) [m]."""
        return (
            self.start[0] + ways * math.cos(self.heading),
            self.start[1] - ways * math.sin(self.heading),
        )

    def height(self, ways: Array) -> Array:
        """Return the height of the ground (...) at `ways` (...) [m]."""
        return self.ground.height(*self.places(ways))

    def pose(self, feet: Array) -> tuple[Array, Array]:
        """Return the rotations (n, 3, 3) and the middles (n, 3) [m] of `feet` (n, 3)."""
        x, z = self.places(feet[:, 0])
        R = heading(self.heading) @ rotation(SIDEWAYS, feet[:, 2])
        return R, np.stack([x, feet[:, 1], z], axis=-1)

    def rise(self, foot: Foot, poses: Array) -> Array:
        """Return how far feet (n, 3) would have to be raised to clear the ground (n,) [m].

        Less than zero where there is room under them.
        """
        R, p = self.pose(poses)
        solid = (foot.solid - foot.middle) @ R.transpose(0, 2, 1) + p[:, None]
        over = self.ground.height(solid[..., 0], solid[..., 2]) - solid[..., 1]
        result: Array = over.max(axis=-1)
        return result

    def lie(self, foot: Foot, ways: Array) -> Array:
        """Return the poses (n, 3) of a foot that lies along the ground at `ways` (n,) [m].

        Its underside takes on the slope of the ground under it and touches it.
        """
        under = self.height(ways[:, None] + foot.length * UNDER)
        middle = under - under.mean(axis=1, keepdims=True)
        slope = (middle * UNDER).sum(axis=1) / ((UNDER**2).sum() * foot.length)
        poses = np.stack([ways, under.mean(axis=1), np.arctan(slope) + foot.taper], axis=-1)
        poses[:, 1] += self.rise(foot, poses)
        return poses

    def safe(self, foot: Foot, ways: Array) -> NDArray[np.bool_]:
        """Say where (n,) all of the ground under a foot may be stepped on."""
        x, z = self.places(ways[:, None] + foot.length * UNDER)
        result: NDArray[np.bool_] = np.all(self.ground.steppable(x, z), axis=1)
        return result


def chord_of(chain: Chain, rear: Array, front: Array) -> tuple[Array, Array]:
    """Return length [m] and elevation [rad] of the way between the feet's inner ends (n,)."""
    back, fore = 0.5 * chain.feet[REAR].length, 0.5 * chain.feet[FRONT].length
    along = front[:, 0] - rear[:, 0] - fore * np.cos(front[:, 2]) - back * np.cos(rear[:, 2])
    up = front[:, 1] - rear[:, 1] - fore * np.sin(front[:, 2]) - back * np.sin(rear[:, 2])
    return np.hypot(along, up), np.arctan2(up, along)


def next_poses(
    chain: Chain,
    track: Track,
    feet: tuple[Array, Array],
    end: int,
    wished: float,
    bounds: tuple[float, float],
) -> Array:
    """Return poses (n, 3) in which a foot may be put down next, the best first.

    That is the wished one, then those on the way back to where the foot is.

    Args:
        chain: the worm.
        track: where it goes.
        feet: (3,) poses of the rear and the front foot.
        end: which foot is to move.
        wished: way at which it would best lie [m].
        bounds: shortest and longest way between the feet's inner ends [m].
    """
    ways = wished + NEARER * (float(feet[end][0]) - wished)
    poses = track.lie(chain.feet[end], ways)
    other = np.broadcast_to(feet[1 - end], poses.shape)
    chords, _ = chord_of(chain, *((other, poses) if end == FRONT else (poses, other)))
    good = track.safe(chain.feet[end], ways) & (chords >= bounds[0]) & (chords <= bounds[1])
    result: Array = poses[good]
    return result
