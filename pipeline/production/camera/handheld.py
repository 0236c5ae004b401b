"""Handheld: the shake of a camera that a person holds.

Three bands of smooth noise turn the camera: breathing and sway of the body, corrections of the
arms, and tremor. They are functions of the time of the film alone, so that a frame shakes the same
way whoever renders it and at any frame rate. The eye stays where it is, so that it goes neither
into the ground nor into a body.

Source: Perlin 1985 (noise by interpolation of random numbers at integers). Stiles 1976
    (displacement falls with the square of the frequency).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.production.camera.camera_path import CameraPath
from pipeline.simulation.curves import ease
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array, normalized

BANDS = ((0.35, 1.0), (1.1, 0.4), (3.1, 0.07))
"""Frequency [Hz] and amplitude, relative to the first, of each band of the shake."""

AMPLITUDES = np.radians([0.85, 0.65, 0.5])
"""Greatest turn to the right, upward and about the viewing direction at a strength of 1 [rad].

A person who stands still sways by a few tenths of a degree; 1 is a camera that is carried at a run.
"""


def shaken(path: CameraPath, times: Array, strength: float, seed: int) -> CameraPath:
    """Return the path of a camera that a person holds.

    Args:
        path: of the camera, without shake.
        times: (F,) since the start of the film [s].
        strength: 0 to 1.
        seed: of the scene.
    """
    if strength == 0.0:
        return path
    ahead, right, upward = path.axes
    yaw, pitch, roll = (
        strength * amplitude * _noise(times, seed, axis)
        for amplitude, axis in zip(AMPLITUDES, ("yaw", "pitch", "roll"), strict=True)
    )
    away = np.linalg.norm(path.target - path.eye, axis=-1)[:, None]
    # Small angles: their sines and cosines are those of the first order, made unit again.
    aim = normalized(ahead + yaw[:, None] * right + pitch[:, None] * upward)
    up = normalized(upward + roll[:, None] * right)
    return replace(path, target=path.eye + away * aim, up=up)


def _noise(times: Array, seed: int, axis: str) -> Array:
    """Return smooth noise (F,) between -1 and 1."""
    total = sum(amplitude for _, amplitude in BANDS)
    value = np.zeros(len(times))
    for band, (frequency, amplitude) in enumerate(BANDS):
        # A band takes a new random value every half of its period.
        t = 2.0 * frequency * times
        cells = np.floor(t).astype(np.int64)
        random = generator(seed, f"handheld {axis} {band}")
        lattice = random.uniform(-1.0, 1.0, int(cells.max(initial=0)) + 2)
        s = ease(t - cells)
        value += amplitude * ((1.0 - s) * lattice[cells] + s * lattice[cells + 1])
    return value / total
