"""Steps of an inchworm: which end moves, from where, and where it lands.

Stretched out it sets its front end down, drawn up its rear end; base and tip of the chain are then
swapped.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
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
from pipeline.simulation.locomotion.stepping.initial_stance import ELSEWHERE
from pipeline.simulation.spatial import Array

MIN_STEP = 0.05
"""Shortest step, as a fraction of the stride."""

STEP_SAMPLES = np.linspace(0.0, 1.0, 34)[1:-1]
"""Fractions of a step at which the ground under the moving foot is tested."""

SEARCH_RANGE = np.linspace(0.0, 0.5, 26)
"""Distances from its start at which a worm may lie down, in its length."""

REST_CHORDS = (0.99, 0.975, 0.95, 0.92, 0.88)
"""Chords of a worm at rest, in the length between its feet: the lowest arch clear of the ground
is used."""

PENETRATION_TOLERANCE = 0.001
"""Harmless depth of a chain in the ground, in its length."""

SPACING_ITERATIONS = 6
"""Iterations that bring the feet to a given chord on sloping ground."""

SPACING_TOLERANCE = 0.01
"""Tolerance of that chord, in the length between the feet."""


@dataclass(frozen=True, eq=False)
class InchwormStep:
    """A step: one end moves, the other one is planted.

    Attributes:
        end: number of the moving foot.
        planted: (3,) pose of the other foot.
        start: (3,) pose from which the foot lifts.
        finish: (3,) pose in which it lands.
        height: of its arch [m].
        lifted: gait phase at which it lifts, whole cycles included.
    """

    end: int
    planted: Array
    start: Array
    finish: Array
    height: float
    lifted: float

    @property
    def down(self) -> float:
        """Gait phase at which it lands, whole cycles included."""
        return self.lifted + 0.5

    @property
    def feet(self) -> tuple[Array, Array]:
        """Poses (3,) of the rear and the front foot at the end of the step."""
        return (self.finish, self.planted) if self.end == REAR else (self.planted, self.finish)


@dataclass(frozen=True, eq=False)
class Inchworm:
    """The constants of one worm.

    Attributes:
        name: of the performer.
        number: of the performer in the cast of the scene.
        chain: its joints and links.
        pace: how it walks.
        track: that it walks on.
        walks: whether it walks or rests.
    """

    name: str
    number: int
    chain: InchwormChain
    pace: InchwormPace
    track: InchwormTrack
    walks: bool

    def lie_down(self) -> InchwormStep:
        """Return the initial pose as the end of a step of the rear foot.

        Raises:
            SceneError: no ground near its start fits its feet.
        """
        chain, track = self.chain, self.track
        chords = self.pace.chords[:1] if self.walks else [part * chain.free for part in REST_CHORDS]
        shifts = chain.length * np.stack([SEARCH_RANGE, -SEARCH_RANGE], axis=-1).ravel()
        rear, front, good = (
            np.concatenate(poses)
            for poses in zip(*(self._spaced_feet(shifts, chord) for chord in chords), strict=True)
        )
        if not good.any():
            x, z = track.start
            message = (
                f"'{self.name}' finds no ground for both its ends around its start at "
                f"[{x:g}, {z:g}]: all is forbidden or too steep; {ELSEWHERE}"
            )
            raise SceneError([Problem(f"cast[{self.number}].at", message)])
        back, fore = rear[good], front[good]
        # A higher arch at the start is better than a lower one elsewhere.
        order = np.argsort(np.tile(np.arange(len(shifts)), len(chords))[good], kind="stable")
        back, fore = back[order], fore[order]
        depth = np.maximum(
            ground_penetration(chain, track, back, fore), PENETRATION_TOLERANCE * chain.length
        )
        best = int(np.argmin(depth))
        return InchwormStep(REAR, fore[best], back[best], back[best], 0.0, -0.5)

    def _spaced_feet(self, shifts: Array, chord: float) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return poses (n, 3) of both feet with a chord between them, and which of them are valid.

        Args:
            shifts: (n,) distances of the worm's middle from its start [m].
            chord: between the feet's inner ends [m].
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

    def next(self, step: InchwormStep) -> InchwormStep | None:
        """Return the next step, of the other end; None without a foothold."""
        end = FRONT if step.end == REAR else REAR
        feet, pace = step.feet, self.pace
        planted, start = feet[1 - end], feet[end]
        distance = pace.chords[end] + self.chain.outside
        wished = float(planted[0]) + (distance if end == FRONT else -distance)
        poses = candidate_poses(self.chain, self.track, feet, end, wished, pace.bounds)
        poses = poses[poses[:, 0] - start[0] >= MIN_STEP * pace.stride]
        if not len(poses):
            return None
        other = np.broadcast_to(planted, poses.shape)
        finish = self._clearest_pose(poses, *((other, poses) if end == FRONT else (poses, other)))
        height = self._arch_height(end, start, finish)
        return InchwormStep(end, planted, start, finish, height, step.down)

    def _clearest_pose(self, poses: Array, rear: Array, front: Array) -> Array:
        """Return the first of `poses` (n, 3) with the chain clear of the ground, or the least deep.

        Feet closer together raise a higher arch between them.

        Args:
            poses: of the moving foot.
            rear: (n, 3) poses of the rear foot.
            front: (n, 3) poses of the front foot.
        """
        # Nearly always the first one clears the ground.
        for tested in (slice(1), slice(None)):
            depth = ground_penetration(self.chain, self.track, rear[tested], front[tested])
            best = int(np.argmin(np.maximum(depth, PENETRATION_TOLERANCE * self.chain.length)))
            if depth[best] <= PENETRATION_TOLERANCE * self.chain.length:
                break
        return poses[best]

    def _arch_height(self, end: int, start: Array, finish: Array) -> float:
        """Return the least arch height of a step that clears the ground [m]."""
        n, least = len(STEP_SAMPLES), self.pace.lifts[end]
        low = swing_poses(
            end, np.tile(start, (n, 1)), np.tile(finish, (n, 1)), np.zeros(n), STEP_SAMPLES
        )
        rise = self.track.rise(self.chain.feet[end], low)
        return float(np.maximum(rise / bump(STEP_SAMPLES) + 0.4 * least, least).max())


def feet_at(steps: list[InchwormStep], phases: Array, end: int) -> tuple[Array, Array]:
    """Return the poses (n, 3) of the rear and the front foot at n moments.

    Args:
        steps: of the worm at these moments, all of the same end.
        phases: (n,) gait phases, whole cycles included.
        end: number of the moving foot.
    """
    planted, start, finish = (
        np.stack([getattr(step, name) for step in steps]) for name in ("planted", "start", "finish")
    )
    height, lifted = (np.array([getattr(s, name) for s in steps]) for name in ("height", "lifted"))
    s = np.clip(2.0 * (phases - lifted), 0.0, 1.0)
    moving = swing_poses(end, start, finish, height, s)
    return (moving, planted) if end == REAR else (planted, moving)
