"""Lens of a camera at each frame of a cut: aperture and focus distance."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_path import CameraPath
from pipeline.production.camera.camera_target import follow
from pipeline.simulation.keyframe_track import Track
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from render.config import Camera
from render.config.camera import Focus
from render.shot import Lens

# A sensor 24 mm high has a vertical field of view φ with a focal length f = 12 mm / tan(φ/2); an
# f-number N gives an aperture of radius f / 2N.
HALF_SENSOR = 0.012
"""Half the height of the sensor [m]."""

MIN_FOCUS, MAX_FOCUS = 0.02, 1e5
"""Range of the focus distance [m]."""


def lenses(
    take: Take,
    cut: Camera,
    rows: NDArray[np.int64],
    path: CameraPath,
    place: Array,
    nodes: Mapping[str, int],
) -> tuple[Lens | None, ...]:
    """Return the lens of a cut at each frame, None where all is sharp.

    Args:
        take: that is filmed.
        cut: its configuration.
        rows: (F,) of its frames.
        path: of its camera.
        place: (F, 3) what it looks at [m].
        nodes: number of each node that a focus names.
    """
    if cut.aperture is None:
        return (None,) * len(rows)

    def distance(focus: Focus) -> Array:
        if isinstance(focus, float | int):
            return np.full(len(rows), float(focus))
        if not isinstance(focus, str):
            return _depth(path, np.tile(focus, (len(rows), 1)))
        if focus in nodes:
            return _depth(path, take.positions[rows, nodes[focus]])
        return _depth(path, follow(take, focus, rows).place)

    if any(key.focus is not None for key in cut.keyframes):
        times = rows / float(take.header.rate * take.header.samples)
        focus = _focus_pull(cut, times, distance)
    else:
        focus = _depth(path, place) if cut.focus is None else distance(cut.focus)
    radius = HALF_SENSOR / path.tangent / (2.0 * cut.aperture)
    # To a micrometre, like the camera path.
    return tuple(
        Lens(float(round(r, 7)), round(d, 6)) for r, d in zip(radius, focus.tolist(), strict=True)
    )


def _focus_pull(cut: Camera, times: Array, distance: Callable[[Focus], Array]) -> Array:
    """Return the focus distance (F,) interpolated between keyframes.

    Reciprocals are interpolated, because blur is proportional to the reciprocal of a distance.
    """
    keyed = [(key, key.focus) for key in cut.keyframes if key.focus is not None]
    shares = np.eye(len(keyed))
    weights = Track.of([(key.at, shares[k].tolist(), key.ease) for k, (key, _) in enumerate(keyed)])
    near = np.stack([1.0 / distance(focus) for _, focus in keyed], axis=-1)
    mixed = (weights(times) * near).sum(axis=-1)
    return 1.0 / mixed.clip(1.0 / MAX_FOCUS, 1.0 / MIN_FOCUS)


def _depth(path: CameraPath, places: Array) -> Array:
    """Return the depth (F,) of points (F, 3) along the viewing direction [m]."""
    ahead, _, _ = path.axes
    depth: Array = np.einsum("fk,fk->f", places - path.eye, ahead)
    return depth.clip(MIN_FOCUS, MAX_FOCUS)
