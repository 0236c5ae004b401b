"""The edge of the shade of a coarse mesh is that of the round body it stands for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from render.config import Film, light, material
from render.renderer import Renderer
from render.shot import CameraPose, Mesh, Shot


def ball(around: int) -> Mesh:
    """Return a ball of radius 1 of so many faces around, with smooth normals."""
    rings = around // 2
    up = np.linspace(-0.5 * np.pi, 0.5 * np.pi, rings + 1)[1:-1, None]
    turn = np.arange(around) * (2.0 * np.pi / around)
    rows = np.stack(
        [np.cos(up) * np.cos(turn), np.sin(up) + 0.0 * turn, np.cos(up) * np.sin(turn)], axis=-1
    )
    vertices = np.concatenate([rows.reshape(-1, 3), [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]])
    i = np.arange(around)
    j, low, high = (i + 1) % around, len(vertices) - 2, len(vertices) - 1
    faces = [np.stack([i, np.full(around, low), j], 1)]
    for k in range(rings - 2):
        a, b = k * around + i, k * around + j
        faces += [np.stack([a, b, b + around], 1), np.stack([a, b + around, a + around], 1)]
    last = (rings - 2) * around
    faces.append(np.stack([last + i, last + j, np.full(around, high)], 1))
    return Mesh(
        "ball", vertices.astype(np.float32), np.concatenate(faces).astype(np.uint32), "bone"
    )


def test_faces_of_a_coarse_ball_throw_no_shade_on_it(renderer: Renderer) -> None:
    from render.mitsuba_scene import MitsubaScene

    sun = light({"sun": {"hour": 9, "clouds": "clear", "north_deg": 90}, "haze": 0.0})
    film = Film(size=(64, 64), samples=4, depth=2, soft_light="full", denoise="off")
    camera = CameraPose((0.0, 0.0, 6.0), (0.0, 0.0, 0.0), fov_deg=22.0)
    looks = {"bone": material("bone")}
    coarse, fine = (
        MitsubaScene(Shot((ball(n),), looks, sun, camera, film, 0))
        .trace(0, range(4), 4)
        .direct.mean(axis=-1)
        for n in (12, 96)
    )
    y, x = np.mgrid[-1.0:1.0:64j, -1.0:1.0:64j]
    inside = np.hypot(x, y) < 0.75
    grazed = inside & (fine > 0.05 * fine.max()) & (fine < 0.5 * fine.max())
    assert np.count_nonzero(grazed) > 100
    # Light stays beyond the edge of the faces' own shade, and none comes where the ball has shade.
    assert np.count_nonzero(coarse[grazed] < 0.3 * fine[grazed]) < 0.005 * np.count_nonzero(grazed)
    dark = inside & (fine == 0.0)
    assert np.count_nonzero(dark) > 100
    assert coarse[dark].mean() < 0.01 * fine.max()


@pytest.mark.parametrize(("lift", "is_lit"), [(0.0, False), (1.5, True)])
def test_shadow_rays_start_above_a_sheet_by_what_its_normals_are_longer_than_1(
    renderer: Renderer, lift: float, is_lit: bool
) -> None:
    """Under a card half way to the lamp, 1 m up: rays that start above it meet nothing."""
    corners = np.array([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    up = np.tile(np.array([0.0, 1.0 + lift, 0.0], np.float32), (4, 1))
    sheet = Mesh("sheet", 0.1 * corners, faces, "leaf", normals=up)
    above = np.array([1.0, 1.0, 0.0], np.float32)
    card = Mesh("card", 0.3 * corners + above, faces, "bone", smooth=False)
    lit = light(
        {
            "studio": {"fill": 0, "rim": 0, "backdrop": [0, 0, 0]},
            "lamps": [{"at": [2, 2, 0], "radius": 0, "brightness": 40}],
        }
    )
    film = Film(size=(16, 16), samples=4, depth=2, denoise="off")
    camera = CameraPose((-1.0, 1.0, 0.0), (0.0, 0.0, 0.0), fov_deg=4.0)
    looks = {
        "leaf": material({"color": "#ffffff", "roughness": 1, "translucency": 0.3}),
        "bone": material("bone"),
    }
    shot = Shot((sheet, card), looks, lit, camera, film, 0)
    dark = replace(shot, light=lit.model_copy(update={"lamps": ()}))
    light_of_lamp = renderer.render(shot).light - renderer.render(dark).light
    assert (light_of_lamp.mean() > 1.0) == is_lit
