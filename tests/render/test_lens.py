"""Depth of field: the size of the circle of confusion, by closed form."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from render.config import Film, light, material
from render.renderer import Renderer
from render.shot import CameraPose, Lens, Mesh, Moment, Shot

SIZE = (96, 96)
FOV = 30.0
FOCUS, RADIUS = 2.0, 0.04
TAN = math.tan(math.radians(FOV) / 2)


def plate(depth: float, half: float) -> Mesh:
    """Return a small square that faces a camera at the origin, which looks along +X."""
    corners = np.array([[0, -1, -1], [0, -1, 1], [0, 1, 1], [0, 1, -1]]) * half + [depth, 0, 0]
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    return Mesh("plate", corners.astype(np.float32), faces, "white", smooth=False)


def seen_through(lens: Lens | None, depth: float, half: float = 0.02) -> Shot:
    film = Film(size=SIZE, samples=1024, depth=1, soft_light="full", denoise="off")
    pose = CameraPose((0, 0, 0), (1, 0, 0), fov_deg=FOV, lens=lens)
    white = material({"color": [1, 1, 1], "roughness": 1.0})
    return Shot(
        (plate(depth, half),),
        {"white": white},
        light({"preset": "studio", "haze": 0.0}),
        pose,
        film,
    )


def coverage(renderer: Renderer, shot: Shot) -> NDArray[np.float64]:
    """Return how much of each pixel the plate covers: its colour, whatever lights it."""
    scene = renderer.scene_for(shot)
    # Four looks for each path make as many samples.
    return scene.trace(3, range(256), 256).albedo[..., 0].astype(float)


def spread(picture: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return the sum, and the standard deviations across and up of a picture [pixels]."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    total = picture.sum()
    mean_x, mean_y = (picture * x).sum() / total, (picture * y).sum() / total
    return (
        total,
        math.sqrt((picture * (x - mean_x) ** 2).sum() / total),
        math.sqrt((picture * (y - mean_y) ** 2).sum() / total),
    )


@pytest.mark.nightly
@pytest.mark.parametrize(
    "depth", [1.0, *(pytest.param(d, marks=pytest.mark.nightly) for d in (1.5, 2.0, 3.0)), 6.0]
)
def test_the_circle_of_confusion_has_its_closed_form(renderer: Renderer, depth: float) -> None:
    """Of a lens of radius A focused at f, a point at d has a disc of A·|d - f| / (d·f)."""
    half = 0.02
    picture = coverage(renderer, seen_through(Lens(RADIUS, FOCUS), depth, half))
    pixels = SIZE[1] / 2 / TAN
    disc = RADIUS * abs(depth - FOCUS) / (depth * FOCUS) * pixels
    side = 2 * half / depth * pixels
    # The second moments of a disc, of the plate and of a pixel add up.
    expected = math.sqrt(disc**2 / 4 + side**2 / 12 + 1 / 12)
    total, across, up = spread(picture)
    assert across == pytest.approx(expected, abs=0.15)
    assert up == pytest.approx(expected, abs=0.15)
    assert total == pytest.approx(side**2 * _white(renderer), rel=0.06)


def _white(renderer: Renderer) -> float:
    """Return the colour of a plate that fills the picture."""
    return float(coverage(renderer, seen_through(None, 1.0, half=2.0)).mean())


@pytest.mark.nightly
def test_the_focal_plane_is_as_sharp_as_a_pinhole(renderer: Renderer) -> None:
    sharp = coverage(renderer, seen_through(None, FOCUS, half=0.2))
    through = coverage(renderer, seen_through(Lens(RADIUS, FOCUS), FOCUS, half=0.2))
    np.testing.assert_allclose(through, sharp, atol=0.12)
    assert abs(through - sharp).mean() < 0.003


@pytest.mark.nightly
def test_focus_changes_without_a_build(renderer: Renderer) -> None:
    """A lens moved in place gives the picture of a fresh build."""
    near, far = (seen_through(Lens(r, f), 4.0) for r, f in ((0.04, 2.0), (0.02, 4.0)))
    assert near.build == far.build
    scene = renderer.scene_for(near)
    pulled = coverage(renderer, far)
    assert renderer.scene_for(far) is scene
    np.testing.assert_array_equal(pulled, coverage(Renderer(renderer.backend), far))


def test_a_pinhole_and_a_lens_do_not_share_a_scene() -> None:
    assert seen_through(None, 1.0).build != seen_through(Lens(0.01, 1.0), 1.0).build


@pytest.mark.nightly
def test_each_moment_has_its_own_lens(renderer: Renderer, make_shot: Callable[..., Shot]) -> None:
    shot = seen_through(Lens(RADIUS, 2.0), 4.0)
    other = replace(shot.camera, lens=Lens(RADIUS, 4.0))
    both = replace(shot, later=(Moment(shot.meshes, other),))
    alone = [
        renderer.render(
            replace(
                shot, camera=pose, seed=seed, film=shot.film.model_copy(update={"samples": 512})
            )
        ).light
        for pose, seed in ((shot.camera, 0), (other, 7919))
    ]
    seen = renderer.render(both).light
    assert np.abs(seen - np.mean(alone, axis=0)).mean() < 0.002
    assert min(np.abs(seen - one).max() for one in alone) > 0.02


@pytest.mark.slow
def test_pixels_are_soft_where_a_circle_of_confusion_reaches(renderer: Renderer) -> None:
    """A plate too near is soft, and so is as much of what is sharp around it as its disc covers."""
    shot = seen_through(Lens(RADIUS, FOCUS), 1.0, half=0.05)
    wall = replace(plate(FOCUS, 3.0), name="wall")
    shot = replace(shot, meshes=(*shot.meshes, wall))
    blur = renderer.scene_for(shot).lens_blur(shot.camera)
    assert blur is not None
    soft = blur.soft
    disc = RADIUS / (2.0 * FOCUS) * 2 * SIZE[1] / 2 / TAN
    y, x = np.mgrid[: SIZE[1], : SIZE[0]] - (SIZE[0] - 1) / 2
    side = 0.05 * SIZE[1] / 2 / TAN
    beyond = np.maximum(abs(x), abs(y)) - side
    assert soft[beyond < 0.5 * disc].min() == 1.0
    # The reach is doubled step by step, so that it is exact within a factor of two.
    assert soft[beyond > 1.1 * disc].max() == 0.0
    # A smaller picture is enough where the blur is wide, but nowhere on what is sharp.
    half, quarter = blur.coarse
    assert max(half[beyond > 0.5].max(), quarter[beyond > 0.5].max()) == 0.0
    assert (half >= quarter).all()
    assert half[beyond < -4].min() > 0.4
    assert half.max() > 0.0 == quarter.max()
    wide = replace(shot.camera, lens=Lens(4.0 * RADIUS, FOCUS))
    near = renderer.scene_for(shot).lens_blur(wide)
    assert near is not None
    assert near.coarse[1].max() > 0.5
    pinhole = seen_through(None, 1.0)
    assert renderer.scene_for(pinhole).lens_blur(pinhole.camera) is None


@pytest.mark.slow
def test_the_denoiser_cleans_what_is_out_of_focus(renderer: Renderer) -> None:
    """With four samples, against very many."""
    shot = seen_through(Lens(RADIUS, FOCUS), 0.9, half=0.1)
    few = shot.film.model_copy(update={"samples": 4})
    noisy, clean, true = (
        renderer.render(replace(shot, film=film)).light
        for film in (few, few.model_copy(update={"denoise": "fast"}), shot.film)
    )
    blur = renderer.scene_for(shot).lens_blur(shot.camera)
    assert blur is not None
    soft = blur.soft[..., 0] == 1.0
    errors = [((picture - true)[soft] ** 2).mean() for picture in (clean, noisy)]
    assert errors[0] < 0.3 * errors[1]
