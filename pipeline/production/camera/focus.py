"""Focusing: the lens of a camera at every frame, and the pull of its focus.

Source of the lens: a sensor 24 mm high sees a vertical field of view φ through a focal length
of 12 mm / tan(φ/2); an f-number N gives that an aperture of radius f / 2N.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.camera_path import Seen
from pipeline.production.camera.camera_target import follow
from pipeline.simulation.keyframe_track import Track
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from render.config import Camera
from render.config.camera import Focus
from render.shot import Lens

HALF_SENSOR = 0.012
"""Half the height of the sensor [m]."""

CLOSEST = 0.02
"""Least distance of what is sharp [m]."""

FARTHEST = 1e5
"""Greatest distance of what is sharp [m]."""


def lenses(
    take: Take,
    cut: Camera,
    rows: NDArray[np.int64],
    seen: Seen,
    place: Array,
    nodes: Mapping[str, int],
) -> tuple[Lens | None, ...]:
    """Return the lens of a cut at the rows of its frames, None where all is sharp.

    Args:
        take: what is filmed.
        cut: its words.
        rows: (F,) of its frames.
        seen: where the camera is.
        place: (F, 3) what it looks at [m].
        nodes: number of each node that a focus names.
    """
    if cut.aperture is None:
        return (None,) * len(rows)

    def distance(focus: Focus) -> Array:
        if isinstance(focus, float | int):
            return np.full(len(rows), float(focus))
        if not isinstance(focus, str):
            return _depth(seen, np.tile(focus, (len(rows), 1)))
        if focus in nodes:
            return _depth(seen, take.positions[rows, nodes[focus]])
        return _depth(seen, follow(take, focus, rows).place)

    if any(key.focus is not None for key in cut.keyframes):
        times = rows / float(take.header.rate * take.header.samples)
        focus = _pulled(cut, times, distance)
    else:
        focus = _depth(seen, place) if cut.focus is None else distance(cut.focus)
    radius = HALF_SENSOR / seen.tangent / (2.0 * cut.aperture)
    # To a micrometre, as all that a frame depends on.
    return tuple(
        Lens(round(r, 7), round(d, 6)) for r, d in zip(radius, focus.tolist(), strict=True)
    )


def _pulled(cut: Camera, times: Array, distance: Callable[[Focus], Array]) -> Array:
    """Return the distance (F,) of a focus that goes from key to key.

    Blur grows with the reciprocal of a distance: it is that which is mixed.
    """
    said = [(key, key.focus) for key in cut.keyframes if key.focus is not None]
    shares = np.eye(len(said))
    weights = Track.of([(key.at, shares[k].tolist(), key.ease) for k, (key, _) in enumerate(said)])
    near = np.stack([1.0 / distance(focus) for _, focus in said], axis=-1)
    mixed = (weights(times) * near).sum(axis=-1)
    result: Array = 1.0 / mixed.clip(1.0 / FARTHEST, 1.0 / CLOSEST)
    return result


def _depth(seen: Seen, places: Array) -> Array:
    """Return the distance (F,) of places (F, 3) along the direction of the camera [m]."""
    ahead, _, _ = seen.axes
    depth: Array = np.einsum("fk,fk->f", places - seen.eye, ahead)
    return depth.clip(CLOSEST, FARTHEST)
