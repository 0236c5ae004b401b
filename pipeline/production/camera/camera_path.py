"""Seen: where a camera is at every frame of a cut, where it looks, and how wide it sees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.spatial import Array, normalized
from render.shot import CameraPose, Lens


@dataclass(frozen=True, eq=False)
class Seen:
    """Where a camera is at F frames, where it looks, and how wide it sees.

    Attributes:
        eye: (F, 3) [m].
        target: (F, 3) point that it looks at [m].
        up: (F, 3) what is up in the picture.
        fov_deg: (F,) vertical field of view [degrees].
    """

    eye: Array
    target: Array
    up: Array
    fov_deg: Array

    @property
    def tangent(self) -> Array:
        """Half the height of the picture (F,) at a distance of one."""
        result: Array = np.tan(np.radians(self.fov_deg) / 2.0)
        return result

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """What is ahead, to the right and upward in the picture, each (F, 3)."""
        ahead = normalized(self.target - self.eye)
        right = normalized(np.cross(ahead, self.up))
        return ahead, right, np.cross(right, ahead)

    def smoothed(self, smooth: Callable[[Array], Array]) -> Seen:
        """Return the same with its paths evened out by `smooth`, (F, 3) -> (F, 3)."""
        return Seen(smooth(self.eye), smooth(self.target), smooth(self.up), self.fov_deg)

    def raised(self, lift: Array, target: bool = False) -> Seen:
        """Return the same with its eye, and perhaps its target, `lift` (F,) higher [m]."""
        rise = np.zeros_like(self.eye)
        rise[:, 1] = lift
        return replace(self, eye=self.eye + rise, target=self.target + rise * target)

    def poses(self, lenses: tuple[Lens | None, ...]) -> list[CameraPose]:
        """Return the pose of every frame, with its lens."""
        return [
            CameraPose(_plain(e), _plain(t), _plain(u), float(fov), lens)
            for e, t, u, fov, lens in zip(
                self.eye, self.target, self.up, self.fov_deg.tolist(), lenses, strict=True
            )
        ]


def _plain(v: Array) -> tuple[float, float, float]:
    # Rounded to a micrometre: the last bits of a processor's arithmetic are no
    # reason to render a frame again.
    x, y, z = (round(float(c), 6) + 0.0 for c in v)
    return x, y, z
