"""Listener: the bearing of sounds from the camera or from a fixed place, over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from audio.score import Bearing
from pipeline.production.camera.cuts import first_frames
from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import UP, Array, normalized
from pipeline.simulation.take import Place
from render.config import Camera
from render.shot import CameraPose


class Listener:
    """Position and orientation of the listener over time.

    Between frames of one shot the listener moves in a straight line; at a cut it jumps.

    Args:
        at: "camera", or a fixed place [m].
        cuts: camera cuts in the order of time.
        clock: grid of frames and rows.
        poses: camera pose of each frame.
    """

    def __init__(
        self,
        at: Literal["camera"] | Place,
        cuts: Sequence[Camera],
        clock: Clock,
        poses: Sequence[CameraPose],
    ) -> None:
        eyes = np.array([pose.p_WC for pose in poses])
        self._clock = clock
        self._ears = eyes if at == "camera" else np.tile(np.array(at, dtype=float), (len(eyes), 1))
        self._forward = np.array([pose.p_WT for pose in poses]) - eyes
        self._up = np.array([pose.up for pose in poses])
        starts = np.array(first_frames(cuts, clock.rate))
        self._shots = np.searchsorted(starts, np.arange(1, len(poses) + 1), side="right")

    def bearing(self, frame: int, place: Place) -> Bearing:
        """Return the bearing of a place [m] at a frame."""
        row = float(self._clock.row_of_frame(frame))
        return self._bearings(np.array([row]), np.array([place], dtype=float))[0]

    def course(self, first: int, places: Sequence[Place]) -> tuple[Bearing, ...]:
        """Return the bearings of places [m], one for each row from `first` on."""
        if not places:
            return ()
        rows = np.arange(first, first + len(places), dtype=float)
        return self._bearings(rows, np.array(places, dtype=float))

    def _bearings(self, rows: Array, places: Array) -> tuple[Bearing, ...]:
        times = np.minimum(rows / self._clock.samples, len(self._ears) - 1.0)
        frames = times.astype(np.int64)
        following = np.minimum(frames + 1, len(self._ears) - 1)
        same_shot = self._shots[following] == self._shots[frames]
        fraction = np.where(same_shot, times - frames, 0.0)[:, None]
        ears = self._ears[frames] + fraction * (self._ears[following] - self._ears[frames])
        offsets = places - ears
        distances = np.linalg.norm(offsets, axis=1)
        approach = self._approach_speeds(distances, self._shots[frames])
        return tuple(
            Bearing(float(d), _azimuth(offset, self._forward[f], self._up[f]), float(v))
            for d, offset, f, v in zip(distances, offsets, frames, approach, strict=True)
        )

    def _approach_speeds(self, distances: Array, shots: NDArray[np.int64]) -> Array:
        """Return the rate at which distances shrink [m/s], without the jumps at cuts."""
        speeds = np.zeros_like(distances)
        dt = float(1 / (self._clock.rate * self._clock.samples))
        for shot in np.unique(shots):
            in_shot = shots == shot
            if np.count_nonzero(in_shot) > 1:
                speeds[in_shot] = -np.gradient(distances[in_shot], dt)
        return speeds


def _azimuth(offset: Array, forward: Array, up: Array) -> float:
    """Return the angle of `offset` from `forward` about `up` [rad], positive to the right."""
    right = normalized(np.cross(forward, up))
    if not right.any():
        right = normalized(np.cross(forward, UP))
    ahead = np.cross(up if right.any() else UP, right)
    return float(np.arctan2(offset @ right, offset @ normalized(ahead)))
