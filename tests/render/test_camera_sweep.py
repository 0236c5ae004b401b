"""Camera sweep: what stands still is blurred evenly while the camera travels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from render.camera_sweep import camera_sweep
from render.config import Film
from render.renderer import Renderer
from render.shot import CameraPose, Mesh, Moment, Shot

Make = Callable[..., Shot]


def pose(x: float, turn: float = 0.0) -> CameraPose:
    return CameraPose((x, 1.0, 0.0), (x + np.sin(turn), 1.0, -np.cos(turn)))


def test_a_camera_that_stands_still_has_no_sweep() -> None:
    assert camera_sweep([pose(1.0)], 0) is None
    assert camera_sweep([pose(1.0)] * 3, 1) is None


@pytest.mark.parametrize("k", [0, 1, 2])
def test_a_sweep_lasts_from_one_moment_to_the_next(k: int) -> None:
    sweep = camera_sweep([pose(0.2 * i, 0.01 * i) for i in range(3)], k)
    assert sweep is not None
    assert sweep.place == pytest.approx((0.2 * k, 1.0, 0.0))
    assert sweep.shift == pytest.approx((0.2, 0.0, 0.0))
    # To the right is about -Y.
    assert sweep.turn == pytest.approx((0.0, -0.01, 0.0), abs=1e-6)


def exposed(make_shot: Make, moments: int, *, is_still: bool) -> Shot:
    """Return an exposure of a thin post by a camera that travels past it."""
    film = Film(size=(64, 48), samples=128, depth=2, denoise="off")
    shot = make_shot(film=film, camera=pose(0.0))
    ground = shot.meshes[0]
    corners = np.array([[-0.02, 0, -2], [0.02, 0, -2], [0.02, 3, -2], [-0.02, 3, -2]], np.float32)
    post = Mesh("post", corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), "bone", smooth=False)
    things = {"scenery": (post,)} if is_still else {"meshes": (ground, post)}
    shot = replace(shot, **{"meshes": (ground,), **things})
    times = (np.arange(moments) + 0.5) / moments
    poses = [pose(0.6 * t - 0.3, 0.05 * t) for t in times]
    later = tuple(Moment(shot.meshes, camera) for camera in poses[1:])
    return replace(shot, camera=poses[0], later=later)


@pytest.mark.nightly
def test_a_post_beside_the_way_is_blurred_as_by_many_moments(
    renderer: Renderer, make_shot: Make
) -> None:
    if not renderer.backend.variant.startswith("llvm"):
        pytest.skip("on GPUs all is one scene, passed moment by moment")
    whole, few, jumping = (
        # The post is upright: means of columns have less noise.
        renderer.render(exposed(make_shot, moments, is_still=still)).light[4:20].mean(axis=0)
        for moments, still in ((32, True), (3, True), (3, False))
    )
    error = np.abs(few - whole).mean()
    assert np.abs(jumping - whole).mean() > 4 * error
