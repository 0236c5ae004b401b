"""Listening: where a sound is for who stands at the camera, or at a place of the author's."""

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
    """Who hears a scene, at every moment of it.

    Between frames a camera goes straight on; at a cut it is at once elsewhere.

    Args:
        at: the author's word for where one listens.
        cuts: of the camera, in the order of time.
        clock: the grid of frames and rows.
        poses: of the camera, by frame.
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
        begins = np.array(first_frames(cuts, clock.rate))
        self._shots = np.searchsorted(begins, np.arange(1, len(poses) + 1), side="right")

    def bearing(self, frame: int, place: Place) -> Bearing:
        """Return where a place [m] is heard in a frame."""
        row = float(self._clock.row_of_frame(frame))
        return self._bearings(np.array([row]), np.array([place], dtype=float))[0]

    def course(self, first: int, places: Sequence[Place]) -> tuple[Bearing, ...]:
        """Return where places [m] are heard at rows from `first` on, one each."""
        if not places:
            return ()
        rows = np.arange(first, first + len(places), dtype=float)
        return self._bearings(rows, np.array(places, dtype=float))

    def _bearings(self, rows: Array, places: Array) -> tuple[Bearing, ...]:
        at = np.minimum(rows / self._clock.samples, len(self._ears) - 1.0)
        frames = at.astype(np.int64)
        after = np.minimum(frames + 1, len(self._ears) - 1)
        goes_on = self._shots[after] == self._shots[frames]
        part = np.where(goes_on, at - frames, 0.0)[:, None]
        ears = self._ears[frames] + part * (self._ears[after] - self._ears[frames])
        offsets = places - ears
        distances = np.linalg.norm(offsets, axis=1)
        nearing = self._nearing(distances, self._shots[frames])
        return tuple(
            Bearing(float(d), _azimuth(offset, self._forward[f], self._up[f]), float(v))
            for d, offset, f, v in zip(distances, offsets, frames, nearing, strict=True)
        )

    def _nearing(self, distances: Array, shots: NDArray[np.int64]) -> Array:
        """Return how fast distances shrink within a shot [m/s]; a cut brings nothing nearer."""
        nearing = np.zeros_like(distances)
        dt = float(1 / (self._clock.rate * self._clock.samples))
        for shot in np.unique(shots):
            own = shots == shot
            if np.count_nonzero(own) > 1:
                nearing[own] = -np.gradient(distances[own], dt)
        return nearing


def _azimuth(offset: Array, forward: Array, up: Array) -> float:
    """Return the direction of `offset` for one who looks `forward`, positive to the right."""
    right = normalized(np.cross(forward, up))
    if not right.any():
        right = normalized(np.cross(forward, UP))
    ahead = np.cross(up if right.any() else UP, right)
    return float(np.arctan2(offset @ right, offset @ normalized(ahead)))
