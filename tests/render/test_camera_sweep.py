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


@pytest.mark.parametrize("count", [1, 2, 4, 16])
def test_few_passes_go_through_the_same_places_of_all_pixels(
    renderer: Renderer, count: int
) -> None:
    import mitsuba as mi

    from render.tracing.camera_rays import even_place
    from render.tracing.stratification import PassStrata, stratum_grid

    column, row = mi.UInt32([0, 1, 4]), mi.UInt32([0, 0, 2])
    places = np.array(
        [
            np.array(even_place(column, row, PassStrata(7, k, stratum_grid(count)).step(0)))
            for k in range(count)
        ]
    )
    # An edge along either axis has as many steps as there are passes.
    strips = (np.arange(count) + 0.5) / count
    for axis in (0, 1):
        np.testing.assert_allclose(np.sort(places[:, axis], axis=0).T, [strips] * 3, atol=1e-6)
    np.testing.assert_array_equal(places[..., 0], places[..., 2])
    np.testing.assert_allclose(places[:, 1, 0], 1.0 - places[:, 1, 1], atol=1e-6)
