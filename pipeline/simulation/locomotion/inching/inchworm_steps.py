"""Steps of an inchworm: which end moves, from where, and where it comes down.

Stretched out, its front end is set down; drawn up, its rear end. Each time base and tip
of the chain are swapped.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import SimulationError
from pipeline.simulation.curves import bump
from pipeline.simulation.locomotion.inching.inchworm_chain import FRONT, REAR, InchwormChain
from pipeline.simulation.locomotion.inching.inchworm_pace import InchwormPace
from pipeline.simulation.locomotion.inching.inchworm_pose import (
    InchwormTrack,
    candidate_poses,
    foot_chord,
    ground_penetration,
    swing_poses,
)
from pipeline.simulation.spatial import Array

MIN_STEP = 0.05
"""A step shorter than this part of the stride is none."""

STEP_SAMPLES = np.linspace(0.0, 1.0, 34)[1:-1]
"""Parts of a step at which the ground under the moving foot is looked at."""

SEARCH_RANGE = np.linspace(0.0, 0.5, 26)
"""How far from where it is told to be a worm may lie down, as parts of its length."""

REST_CHORDS = (0.99, 0.975, 0.95, 0.92, 0.88)
"""How far apart the feet of a worm at rest may be, as parts of the chain between them: the
lowest arch that is clear of the ground is taken."""

PENETRATION_TOLERANCE = 0.001
"""How deep a chain may be in the ground without harm, as a part of its length."""

SPACING_ITERATIONS = 6
"""How often the ends of a worm that lies down are moved until they are as far apart on
sloping ground as they are to be."""

SPACING_TOLERANCE = 0.01
"""How far from that they may stay, as a part of the chain between them."""


@dataclass(frozen=True, eq=False)
class InchwormStep:
    """One end moves, the other one is planted.

    Attributes:
        end: which moves.
        planted: (3,) pose of the other foot.
        start: (3,) pose from which the foot lifts.
        finish: (3,) pose in which it comes down.
        height: of its arch [m].
        lifted: phase of the gait at which it lifts, whole cycles counted.
    """

    end: int
    planted: Array
    start: Array
    finish: Array
    height: float
    lifted: float

    @property
    def down(self) -> float:
        """Phase at which it comes down, whole cycles counted."""
        return self.lifted + 0.5

    @property
    def feet(self) -> tuple[Array, Array]:
        """Poses (3,) of the rear and the front foot when it is done."""
        return (self.finish, self.planted) if self.end == REAR else (self.planted, self.finish)


@dataclass(frozen=True, eq=False)
class Inchworm:
    """What does not change of one worm.

    Attributes:
        name: of it.
        chain: its joints and links.
        pace: how it goes.
        track: where it goes.
        walks: whether it goes anywhere.
    """

    name: str
    chain: InchwormChain
    pace: InchwormPace
    track: InchwormTrack
    walks: bool

    def laid_down(self) -> InchwormStep:
        """Return how it lies at the start, as the end of a step of its rear end.

        Raises:
            SimulationError: if there is no ground for its feet near its place.
        """
        chain, track = self.chain, self.track
        chords = self.pace.chords[:1] if self.walks else [part * chain.free for part in REST_CHORDS]
        shifts = chain.length * np.stack([SEARCH_RANGE, -SEARCH_RANGE], axis=-1).ravel()
        rear, front, good = (
            np.concatenate(some)
            for some in zip(*(self._apart(shifts, chord) for chord in chords), strict=True)
        )
        if not good.any():
            x, z = track.start
            raise SimulationError(
                f"{self.name}: finds no ground for both its ends around its start at "
                f"[{x:g}, {z:g}]: all is forbidden or too steep; "
                "place it elsewhere with `at`, or raise `unsteppable_slope_deg`"
            )
        back, fore = rear[good], front[good]
        # Rather a higher arch where it is told to be than a lower one elsewhere.
        order = np.argsort(np.tile(np.arange(len(shifts)), len(chords))[good], kind="stable")
        back, fore = back[order], fore[order]
        depth = np.maximum(
            ground_penetration(chain, track, back, fore), PENETRATION_TOLERANCE * chain.length
        )
        best = int(np.argmin(depth))
        return InchwormStep(REAR, fore[best], back[best], back[best], 0.0, -0.5)

    def _apart(self, shifts: Array, chord: float) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return poses (n, 3) of both feet so that `chord` is between them, and which will do.

        Args:
            shifts: (n,) ways of the worm's middle [m].
            chord: from one foot's inner end to the other's [m].
        """
        chain, track = self.chain, self.track
        apart = np.full(len(shifts), chord + chain.outside)
        for _ in range(SPACING_ITERATIONS):
            rear, front = (
                track.lie(foot, shifts + side * apart)
                for foot, side in zip(chain.feet, (-0.5, 0.5), strict=True)
            )
            chords, _ = foot_chord(chain, rear, front)
            apart += chord - chords
        good = np.abs(chords - chord) < SPACING_TOLERANCE * chain.free
        for foot, poses in zip(chain.feet, (rear, front), strict=True):
            good &= track.safe(foot, poses[:, 0])
        return rear, front, good

    def next(self, before: InchwormStep) -> InchwormStep | None:
        """Return the step after `before`: the other end's. None if it finds no foothold."""
        end = FRONT if before.end == REAR else REAR
        feet, pace = before.feet, self.pace
        planted, start = feet[1 - end], feet[end]
        apart = pace.chords[end] + self.chain.outside
        wished = float(planted[0]) + (apart if end == FRONT else -apart)
        poses = candidate_poses(self.chain, self.track, feet, end, wished, pace.bounds)
        poses = poses[poses[:, 0] - start[0] >= MIN_STEP * pace.stride]
        if not len(poses):
            return None
        beside = np.broadcast_to(planted, poses.shape)
        finish = self._clearest(poses, *((beside, poses) if end == FRONT else (poses, beside)))
        height = self._clear(end, start, finish)
        return InchwormStep(end, planted, start, finish, height, before.down)

    def _clearest(self, poses: Array, rear: Array, front: Array) -> Array:
        """Return the first of `poses` (n, 3) in which the chain is clear of the ground.

        If there is none, that in which it is sunk the least. Feet closer together raise a
        higher arch between them.

        Args:
            poses: of the foot that moves.
            rear: (n, 3) poses of the rear foot.
            front: (n, 3) poses of the front foot.
        """
        # Nearly always the first will do, and the others need not be looked at.
        for some in (slice(1), slice(None)):
            depth = ground_penetration(self.chain, self.track, rear[some], front[some])
            best = int(np.argmin(np.maximum(depth, PENETRATION_TOLERANCE * self.chain.length)))
            if depth[best] <= PENETRATION_TOLERANCE * self.chain.length:
                break
        result: Array = poses[best]
        return result

    def _clear(self, end: int, start: Array, finish: Array) -> float:
        """Return how high a step must arch to clear the ground [m]."""
        n, least = len(STEP_SAMPLES), self.pace.lifts[end]
        low = swing_poses(
            end, np.tile(start, (n, 1)), np.tile(finish, (n, 1)), np.zeros(n), STEP_SAMPLES
        )
        rise = self.track.rise(self.chain.feet[end], low)
        return float(np.maximum(rise / bump(STEP_SAMPLES) + 0.4 * least, least).max())


def feet_at(steps: list[InchwormStep], phases: Array, end: int) -> tuple[Array, Array]:
    """Return the poses (n, 3) of the rear and the front foot at n moments.

    Args:
        steps: in which the worm is, all of the same `end`.
        phases: (n,) of its gait, whole cycles counted.
        end: which foot moves.
    """
    planted, start, finish = (
        np.stack([getattr(step, name) for step in steps]) for name in ("planted", "start", "finish")
    )
    height, lifted = (np.array([getattr(s, name) for s in steps]) for name in ("height", "lifted"))
    s = np.clip(2.0 * (phases - lifted), 0.0, 1.0)
    moving = swing_poses(end, start, finish, height, s)
    return (moving, planted) if end == REAR else (planted, moving)
