"""Texture coordinates of bodies: no stretch, few seams, no swimming."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from render.backend import Backend
from render.config import Film, light, material
from render.renderer import Renderer
from render.shot import CameraPose, Mesh, Shot

Make = Callable[..., Shot]


def ball() -> trimesh.Trimesh:
    return trimesh.creation.icosphere(subdivisions=3, radius=0.5)


def test_no_triangle_is_stretched() -> None:
    """The singular values of the map from triangle to pattern lie between 1 / sqrt 3 and 1."""
    from render.meshes import unwrap

    solid = ball()
    rest, faces = solid.vertices.astype(np.float32), solid.faces.astype(np.uint32)
    unwrapped = unwrap(rest, faces, np.zeros(len(rest), int))
    assert (unwrapped.source[unwrapped.faces] == faces).all()
    corners, uv = rest[faces].astype(float), unwrapped.uv[unwrapped.faces].astype(float)
    along = corners[:, 1] - corners[:, 0]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along = along / length
    across = np.cross(solid.face_normals, along)
    edges = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    flat = np.stack([along, across], axis=1) @ edges
    shown = np.stack([uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]], axis=2)
    stretch = np.linalg.svd(shown @ np.linalg.inv(flat), compute_uv=False)
    assert stretch.max() <= 1 + 1e-4
    assert stretch.min() >= 1 / np.sqrt(3) - 1e-3


def test_only_vertices_on_seams_are_doubled() -> None:
    from render.meshes import unwrap

    solid = ball()
    rest, faces = solid.vertices.astype(np.float32), solid.faces.astype(np.uint32)
    unwrapped = unwrap(rest, faces, np.zeros(len(rest), int))
    counts = np.bincount(unwrapped.source)
    assert counts.min() == 1
    assert counts.max() <= 3
    assert len(unwrapped.source) < 1.4 * len(solid.vertices)


def test_rows_run_along_the_longest_side_of_each_body() -> None:
    """So that creases of sleeves lie alike on all sides, and grain runs up a stump."""
    from render.meshes import unwrap

    solid = ball()
    each = [solid.vertices * np.where(np.arange(3) == k, 2.0, 1.0) for k in range(3)]
    rest = np.concatenate(each).astype(np.float32)
    n = len(solid.vertices)
    faces = np.concatenate([solid.faces + k * n for k in range(3)]).astype(np.uint32)
    longest = np.repeat(np.arange(3), n)
    unwrapped = unwrap(rest, faces, longest)
    corners, axis = unwrapped.faces, longest[unwrapped.source]
    along = np.take_along_axis(rest[unwrapped.source], axis[:, None], axis=1)[:, 0]
    runs = (np.abs(unwrapped.uv[corners][..., 0] - along[corners]) < 1e-6).all(axis=1)
    a, b, c = (rest[faces[:, k]].astype(float) for k in range(3))
    side = np.abs(np.cross(b - a, c - a)).argmax(axis=1)
    # All triangles but those that face along it.
    assert (runs | (side == axis[corners[:, 0]])).all()
    assert not runs.all()


@pytest.mark.nightly
def test_a_pattern_moves_with_the_body(backend: Backend) -> None:
    """Body and camera moved together show the same frame, under a sky without a sun."""
    solid = ball()
    rest = solid.vertices.astype(np.float32)
    faces = solid.faces.astype(np.uint32)
    materials = {"m": material({"preset": "walnut", "roughness": 1.0, "clearcoat": 0.0})}
    film = Film(size=(48, 48), samples=16, depth=2, denoise="off")

    def seen(x: float) -> np.ndarray:
        mesh = Mesh("ball", rest + np.float32([x, 0, 0]), faces, "m", rest=rest)
        pose = CameraPose((x, 0.4, 2.0), (x, 0.0, 0.0), fov_deg=30)
        shot = Shot((mesh,), materials, light("overcast"), pose, film)
        return Renderer(backend).render(shot).light

    here, there = seen(0.0), seen(8.0)
    inside = slice(16, 32)
    here, there = here[inside, inside], there[inside, inside]
    # Single rays may fall to either side of a vein; the veins must not move.
    assert np.abs(here - there).mean() < 0.05 * here.std(axis=(0, 1)).mean()


def test_bodies_without_a_pattern_are_not_unwrapped(renderer: Renderer, make_shot: Make) -> None:
    del renderer
    from render.meshes import group_meshes

    shot = make_shot(look="red plastic")
    body = replace(shot.meshes[1], rest=shot.meshes[1].vertices)
    plain, patterned = (
        group_meshes([body], {"bone": material(name)})[0] for name in ("red plastic", "walnut")
    )
    assert plain.unwrapped is None
    assert patterned.unwrapped is not None
