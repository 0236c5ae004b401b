"""Bearing: what nodes do not say of people: where they look, and how their soles lie."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.characters.record import STANCE
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.spatial import Array, normalized
from pipeline.simulation.terrain import Ground


def gaze_of(persons: Records) -> Array:
    """Return (..., 3) the directions in which people look."""
    yaw, pitch = persons["gaze"][..., 0], persons["gaze"][..., 1]
    level = np.cos(pitch)
    return np.stack([level * np.cos(yaw), np.sin(pitch), -level * np.sin(yaw)], axis=-1)


def feet_of(persons: Records, ground: Ground) -> Array:
    """Return (..., 2, 3, 3) the rotations of feet: they lie on the ground, or are pitched.

    A foot that swings goes from the slope that it left to the one that it will stand on.
    """
    stood, left, land = persons["stood"], persons["left"], persons["land"]
    way, gone = land - left, persons["ankles"] - left
    far = np.maximum(way[..., 0] ** 2 + way[..., 2] ** 2, 1e-12)
    share = (gone[..., 0] * way[..., 0] + gone[..., 2] * way[..., 2]) / far
    share = np.where(persons["doing"] == STANCE, 0.0, np.clip(share, 0.0, 1.0))[..., None]
    below = (1.0 - share) * _normals(stood, ground) + share * _normals(land, ground)
    yaw, pitch = persons["yaw"], persons["pitch"][..., None]
    ahead = np.stack([np.cos(yaw), np.zeros_like(yaw), -np.sin(yaw)], axis=-1)
    up = normalized(below)
    ahead = normalized(ahead - (ahead * up).sum(axis=-1)[..., None] * up)
    x = np.cos(pitch) * ahead + np.sin(pitch) * up
    y = np.cos(pitch) * up - np.sin(pitch) * ahead
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def _normals(places: Array, ground: Ground) -> Array:
    """Return the normals (..., 2, 3) of the ground at places (..., 2, 3)."""
    result: Array = ground.field.normal(places[..., 0], places[..., 2])
    return result
