"""Small shots for the tests of the renderer."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from render.backend import Backend, choose
from render.config import Film, Light, Material, light, material
from render.renderer import Renderer
from render.shot import CameraPose, Mesh, Shot

SMALL = Film(size=(64, 48), samples=2, depth=3, denoise="off")


@pytest.fixture(scope="session", autouse=True)
def backend() -> Backend:
    """Return the backend, active before any test of the renderer can import Dr.Jit."""
    found = choose()
    found.activate()
    return found


@pytest.fixture(scope="session")
def renderer(backend: Backend) -> Renderer:
    return Renderer(backend)


def plane(half: float = 20.0, name: str = "dry soil", cells: int = 1) -> Mesh:
    c = np.linspace(-half, half, cells + 1)
    x, z = (a.ravel() for a in np.meshgrid(c, c))
    i = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c4, d = (q.ravel() for q in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    faces = np.concatenate([np.stack([a, d, c4], 1), np.stack([a, c4, b], 1)])
    vertices = np.stack([x, np.zeros_like(x), z], axis=1).astype(np.float32)
    return Mesh("ground", vertices, faces.astype(np.uint32), name, vertices[:, [0, 2]].copy())


def tetrahedron(at: tuple[float, float, float], name: str = "t", look: str = "bone") -> Mesh:
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * 0.4 + at
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], np.uint32)
    return Mesh(name, corners.astype(np.float32), faces, look, smooth=False)


@pytest.fixture
def make_shot() -> Callable[..., Shot]:
    ground = plane()

    def make(
        x: float = 0.0,
        film: Film = SMALL,
        lit: str | Light = "day",
        camera: CameraPose | None = None,
        look: str | Material = "bone",
        seed: int = 0,
    ) -> Shot:
        things = (ground, tetrahedron((x, 0.5, 0.0)), tetrahedron((1.5, 0.5, 0.3), "u"))
        materials = {"dry soil": material("dry soil"), "bone": material(look)}
        pose = camera or CameraPose((3.0, 2.0, 4.0), (0.0, 0.3, 0.0))
        return Shot(things, materials, light(lit), pose, film, seed)

    return make


@pytest.fixture
def make_ground() -> Callable[..., Mesh]:
    return plane
