"""Our tracer shows what Mitsuba's own shows."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from render.config import Film, Light, Material, light, material
from render.exposure import GLEAM
from render.renderer import Renderer
from render.shot import Shot
from render.strata import grid

Make = Callable[..., Shot]

RECORDED = ("_looked", "_begun", "_shaded", "_shining", "_ended")
"""What a wavefront has played back."""

LAMPS = light({"preset": "night", "lamps": [{"at": [0.8, 1.2, 0.6], "radius": 0.2}]})
LOOKS: dict[str, tuple[str | Light, str | Material]] = {
    "sun and sky": ("day", "bone"),
    "a sky without sun": ("overcast", "clay"),
    "a large light and a glossy body": ("studio", "red plastic"),
    "bare metal": ("studio", "brass"),
    "a body that gives off light": ("golden hour", material({"preset": "flame", "glow": 3})),
    "lamps by night": (LAMPS, "green chitin"),
}
DAILY = ("a large light and a glossy body",)
"""The others are looked at by night."""


def light_of_both(
    shot: Shot, samples: int, rounds: int = 1
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what ours and Mitsuba's own see of a shot, each the mean of many samples."""
    from render.mitsuba_scene import Stage
    from render.tracing.path_tracer import PathTracer

    stage = Stage(shot)
    assert stage.handed_over == ""
    judge = PathTracer(stage.scene, shot.film.resolved().depth)
    ours, theirs = [], []
    for seed in range(rounds):
        ours.append(stage.expose(seed, range(samples), samples).light)
        exposure = judge.expose(stage.sensor, 100_000 * seed, range(samples), samples)
        theirs.append(exposure.light)
    return np.mean(ours, axis=0, dtype=float), np.mean(theirs, axis=0, dtype=float)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [name if name in DAILY else pytest.param(name, marks=pytest.mark.nightly) for name in LOOKS],
)
def test_the_mean_is_that_of_path(renderer: Renderer, make_shot: Make, name: str) -> None:
    lit, look = LOOKS[name]
    film = Film(size=(64, 48), depth=5, soft_light="full", denoise="off")
    ours, theirs = light_of_both(make_shot(film=film, lit=lit, look=look), 64, 4)
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.004)
    # Nowhere is light lost or doubled: blocks of pixels agree as well as their noise lets them.
    blocks = [x.reshape(6, 8, 8, 8, 3).mean(axis=(1, 3)) for x in (ours, theirs)]
    np.testing.assert_allclose(blocks[0], blocks[1], rtol=0.06, atol=0.01)


@pytest.mark.parametrize("depth", [1, 2, 3])
def test_paths_end_where_those_of_path_end(renderer: Renderer, make_shot: Make, depth: int) -> None:
    film = Film(size=(64, 48), samples=64, depth=depth, denoise="off")
    ours, theirs = light_of_both(make_shot(film=film, lit="studio"), 64)
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.01)


def test_a_white_furnace_is_exact(renderer: Renderer) -> None:
    """In a sky of radiance 1 a white body cannot be seen, at any depth that lets light out."""
    import mitsuba as mi

    from render.tracing.wavefront import Wavefront

    scene = mi.load_dict(
        {
            "type": "scene",
            "ball": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": 1.0}},
            "sky": {"type": "constant", "sampling_weight": 0.0},
            # Rays are sent to lamps only, and there must be one.
            "lamp": {"type": "point", "position": [0, 9, 0], "intensity": 0.0},
            "camera": {
                "type": "perspective",
                "fov": 30,
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
                "film": {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}},
            },
        }
    )
    seen = Wavefront(scene, (16, 16), 3).expose(scene.sensors()[0], 0, range(4), 4)
    inside = np.isclose(seen.dye[..., 0], 1.0 + GLEAM)
    outside = seen.color[..., 0] == 0.0
    assert inside.sum() > 20
    assert outside.sum() > 20
    np.testing.assert_allclose(
        seen.light[inside & np.isclose(seen.color[..., 0], 1.0 + GLEAM)], 1.0, rtol=1e-5
    )
    np.testing.assert_allclose(seen.direct[outside], 1.0, rtol=1e-5)
    # At its edge the paths may see more of the body or less than the looks do; light that is
    # parted from colours does not know of it.
    # Where they have seen nothing of it, it is as beside.
    fallen = np.full_like(seen.dye, 1.0 / (1.0 + GLEAM))
    np.divide(seen.indirect, seen.dye, where=seen.dye > 0.0, out=fallen)
    np.testing.assert_allclose(seen.direct + seen.color * fallen, 1.0, rtol=1e-5)
    np.testing.assert_allclose(seen.color[8, 8], 1.0 + GLEAM, rtol=1e-5)
    np.testing.assert_allclose(seen.color[0, 0], 0.0)


def test_a_frame_is_played_back_from_one_recording(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import Stage

    stage = Stage(make_shot())
    for i in range(4):
        stage.move(make_shot(x=0.2 * i).moments[0])
        stage.expose(i, range(4), 4)
    tracer = vars(stage._tracer)
    # Few paths end at a lamp, or none.
    assert all(tracer[name].n_recordings == 1 for name in RECORDED[:-1])
    assert tracer["_ended"].n_recordings <= 1


def test_passes_in_parts_are_the_whole(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import Stage

    stage = Stage(make_shot())
    whole = stage.expose(5, range(6), 6)
    plate = stage.plate()
    for k in (0, 2, 4):
        plate.expose(stage.sensor, 5, range(k, k + 2), 6)
    parts = plate.exposure()
    for name in ("direct", "color", "indirect", "dye"):
        np.testing.assert_allclose(getattr(parts, name), getattr(whole, name), rtol=1e-4, atol=1e-6)


@pytest.mark.slow
def test_another_number_of_passes_is_recorded_anew(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import Stage

    stage, fresh = Stage(make_shot()), Stage(make_shot())
    stage.expose(5, range(2), 2)
    np.testing.assert_array_equal(
        stage.expose(5, range(6), 6).light, fresh.expose(5, range(6), 6).light
    )


@pytest.mark.nightly
def test_samples_are_spread_better_than_by_chance(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import Stage

    stage = Stage(replace(make_shot(), film=Film(size=(64, 48), depth=2, denoise="off")))
    spread = [stage.expose(seed, range(16), 16).light for seed in range(8)]
    chance = [
        np.mean([stage.expose(1000 + 16 * seed + k, range(1), 1).light for k in range(16)], axis=0)
        for seed in range(8)
    ]
    assert np.std(spread, axis=0).mean() < 0.7 * np.std(chance, axis=0).mean()


def test_a_medium_is_handed_over(renderer: Renderer) -> None:
    import mitsuba as mi

    from render.tracer import tracer
    from render.tracing.path_tracer import PathTracer

    fog = {"type": "homogeneous", "albedo": 0.5, "sigma_t": 1.0}
    scene = mi.load_dict(
        {"type": "scene", "ball": {"type": "sphere", "bsdf": {"type": "null"}, "interior": fog}}
    )
    found, why = tracer(scene, Film(size=(16, 16)).resolved(), 3)
    assert isinstance(found, PathTracer)
    assert "medium" in why


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 12, 16, 30, 64])
def test_a_grid_has_a_cell_for_every_pass(count: int) -> None:
    columns, rows = grid(count)
    assert columns * rows == count
    assert rows <= math.sqrt(count) <= columns
