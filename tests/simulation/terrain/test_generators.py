"""Terrain generators: treads, slopes, depths, tops and shares as configured."""

from __future__ import annotations

import math
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import build_ground
from pipeline.simulation.terrain.constructed_terrain import stone_layout
from pipeline.simulation.terrain.generators import GENERATORS
from pipeline.simulation.terrain.natural_terrain import scattered_boulders
from pipeline.spec import Terrain
from pipeline.spec.terrain.base import TERRAIN_PRESETS, GridTerrain, TerrainConfig
from pipeline.spec.terrain.kinds import (
    IRREGULAR,
    BouldersTerrain,
    DitchesTerrain,
    HillsTerrain,
    RampTerrain,
    StairsTerrain,
    StonesTerrain,
    SumTerrain,
)

KINDS = get_args(get_args(Terrain)[0])
SEEDED = ("fractal", "hills", "boulders", "ditches", "stones")
GRIDS = [kind for kind in KINDS if issubclass(kind, GridTerrain) and kind is not SumTerrain]


def terrain(config: Any) -> TerrainConfig:
    return TypeAdapter(Terrain).validate_python(config)


def test_every_model_has_a_generator_and_every_preset_a_model() -> None:
    assert set(KINDS) == set(GENERATORS)
    kinds = {kind.model_fields["kind"].default for kind in KINDS}
    assert len(kinds) == len(KINDS)
    for name in TERRAIN_PRESETS:
        assert np.isfinite(build_ground(terrain(name), 1).field.heights).all()
    # Every kind without a file has a preset of its name.
    assert kinds - {"image", "mesh", "sum"} <= TERRAIN_PRESETS.keys()


@pytest.mark.parametrize("kind", GRIDS, ids=lambda kind: kind.__name__)
def test_a_seed_changes_random_terrains_only(kind: type[GridTerrain]) -> None:
    config = kind()
    heights = build_ground(config, 4).field.heights
    assert heights.shape == (config.cells[1] + 1, config.cells[0] + 1)
    assert (build_ground(config, 4).field.heights == heights).all()
    differs = bool((build_ground(config, 5).field.heights != heights).any())
    assert differs == (config.kind in SEEDED)


def test_treads_of_stairs_are_level_and_have_the_step_height() -> None:
    config = StairsTerrain(start=1, steps=8, step_height=0.12, step_depth=0.4, landing=1.5)
    ground = build_ground(config, 1)
    # Every vertex of a tread, up to the one before the next riser: cells of 0.05 m.
    run = np.arange(8)[:, None] * 0.05
    for k in range(1, 8):
        x = 1 + 0.4 * (k - 1) + run
        assert np.abs(ground.height(x, 0.3 * x) - 0.12 * k).max() < 1e-12
        # And down on the other side, mirrored about the middle of the landing.
        down = 2 * (1 + 0.4 * 7 + 0.75) - x
        assert np.abs(ground.height(down, x) - 0.12 * k).max() < 1e-12
    x = np.linspace(1 + 0.4 * 7, 1 + 0.4 * 7 + 1.5, 50)
    assert np.abs(ground.height(x, x) - 0.12 * 8).max() < 1e-12
    assert not ground.height(np.linspace(-15, 0.9, 50), np.zeros(50)).any()


def test_treads_are_steppable_and_risers_are_not() -> None:
    ground = build_ground(StairsTerrain(), 1)
    # Riser k stands in the cell before its tread; 0.08 m and a cell below it is forbidden.
    risers = 1 + 0.4 * np.arange(8) - 0.025
    z = np.zeros(8)
    assert not ground.steppable(risers, z).any()
    assert not ground.steppable(risers - 0.025 - 0.08, z).any()
    # Above the riser, from its edge on, a tread is good for at least a third of its depth.
    for along in np.linspace(0.001, 0.4 / 3, 9):
        assert ground.steppable(risers + 0.025 + along, z).all()


@pytest.mark.parametrize(("course", "sign"), [("up", 1), ("down", -1)])
def test_one_way_stairs_stay_at_their_last_height(course: str, sign: int) -> None:
    config = StairsTerrain(course=course, steps=5, step_height=0.2)
    heights = build_ground(config, 1).field.heights
    assert (np.diff(sign * heights, axis=1) >= 0).all()
    assert heights[:, -1] == pytest.approx(sign * 1.0)
    assert not heights[:, 0].any()


@pytest.mark.parametrize("course", ["up", "down", "up and down"])
def test_a_ramp_has_its_slope(course: str) -> None:
    config = RampTerrain(course=course, slope_deg=24, height=1.3, start=-2, level=1)
    field = build_ground(config, 1).field
    run = 1.3 / math.tan(math.radians(24))
    sign = -1 if course == "down" else 1
    x = np.linspace(-2 + 0.05, -2 + run - 0.05, 40)
    rise = math.tan(math.radians(24)) * sign
    assert field.gradient(x, x) == pytest.approx(np.tile([rise, 0.0], (40, 1)))
    assert field.height(x, x) == pytest.approx((x + 2) * rise)
    top = np.linspace(-2 + run + 0.05, -2 + run + 0.95, 20)
    assert field.height(top, top) == pytest.approx(sign * 1.3)
    ends = -2 + 2 * run + 1.05
    assert float(field.height(np.array(ends), np.array(0.0))) == pytest.approx(
        0.0 if course == "up and down" else sign * 1.3
    )


def test_a_ramp_steeper_than_the_unsteppable_slope_is_forbidden() -> None:
    for slope, forbidden in ((39.9, False), (40.1, True)):
        ground = build_ground(RampTerrain(slope_deg=slope), 1)
        assert bool(ground.forbidden.any()) is forbidden


def test_ditches_without_variation_are_equal() -> None:
    config = DitchesTerrain(width=0.5, depth=0.7, spacing=2, variation=0, start=0)
    ground = build_ground(config, 1)
    middles = np.arange(1, 15, 2.0)
    floor = middles[:, None] + np.linspace(-0.2, 0.2, 9)
    assert np.abs(ground.height(floor, floor) + 0.7).max() < 1e-12
    level = middles[:, None] + np.linspace(0.3001, 1.6999, 9)
    assert np.abs(ground.height(level, level)).max() < 1e-12
    assert not ground.field.heights[:, :300].any()


def test_walls_of_a_ditch_and_the_floor_beside_them_are_forbidden() -> None:
    config = DitchesTerrain(width=1, depth=0.7, spacing=3, variation=0, start=0, foot_radius=0.15)
    ground = build_ground(config, 1)
    for side in (-1, 1):
        # The wall takes the cell outside of the edge, at 0.5 m from the middle at 1.5 m.
        wall = 1.5 + side * np.linspace(0.5, 0.55, 5)[1:-1]
        foot = 1.5 + side * np.linspace(0.351, 0.5, 9)
        floor = 1.5 + side * np.linspace(0.0, 0.5 - 0.15 - 2 * 0.05, 9)
        # No place above a wall lies downhill of it.
        rim = 1.5 + side * np.linspace(0.5501, 0.9, 9)
        assert not ground.steppable(wall, wall).any()
        assert not ground.steppable(foot, foot).any()
        assert ground.steppable(floor, floor).all()
        assert ground.steppable(rim, rim).all()


@given(st.floats(0, 1), st.floats(0.3, 1), st.floats(0.4, 3), st.floats(-3, 3), st.integers(0, 999))
def test_ditches_vary_within_their_bounds(
    variation: float, width: float, between: float, start: float, seed: int
) -> None:
    config = DitchesTerrain(
        width=width, spacing=width + between, variation=variation, start=start, depth=0.5
    )
    row = build_ground(config, seed).field.heights[0]
    deep = row < 0
    edges = np.flatnonzero(np.diff(deep.astype(int)))
    assert not deep[0]
    expected = math.floor((15 - start) / config.spacing + 1e-9)
    assert len(edges) // 2 == expected
    for low, high in zip(edges[::2], edges[1::2], strict=False):
        floor = row[low + 1 : high + 1]
        assert np.ptp(floor) == 0
        assert 0.5 * (1 - 0.5 * variation) - 1e-12 <= -floor[0] <= 0.5 + 1e-12
        assert width * (1 - variation / 2) - 0.11 < (high - low) * 0.05 < width + 0.06
    ground = np.diff(edges)[1::2] * 0.05
    assert (ground > between * (1 - variation / 2) - 0.11).all()


@given(st.floats(0, 1), st.integers(0, 999))
def test_stones_keep_half_their_gap(jitter: float, seed: int) -> None:
    config = StonesTerrain(jitter=jitter)
    stand = stone_layout(config, generator(seed, "terrain"))
    xz = np.stack([stand.x, stand.z], axis=-1).reshape(-1, 2)
    apart = np.linalg.norm(xz[:, None] - xz, axis=-1) + 99.0 * np.eye(len(xz))
    free = apart.min() - config.diameter
    assert free >= config.gap * (1 - jitter / 2) - 1e-9
    assert (stand.x.min() - stand.pit[0]) - config.diameter / 2 >= config.gap * (
        1 - jitter / 4
    ) - 1e-9
    assert np.abs(stand.tops).max() <= config.height_variation / 2
    if jitter == 0:
        assert free == pytest.approx(config.gap)


def test_irregular_stones_are_narrower_and_no_two_alike() -> None:
    def widths(irregularity: float) -> Array:
        config = StonesTerrain(
            rows=1, length=9, size=(24, 4), cells=(1200, 200), irregularity=irregularity, jitter=0
        )
        ground = build_ground(config, 5)
        stand = stone_layout(config, generator(5, "terrain"))
        assert stand.x.shape[0] == 1
        across = np.linspace(-0.4, 0.4, 401)
        return np.array(
            [(ground.height(np.full(401, x), across) > -0.1).sum() * 0.002 for x in stand.x[0]]
        )

    round_ones, others = widths(0.0), widths(1.0)
    assert np.ptp(round_ones) < 0.05
    assert np.ptp(others) > 0.08
    assert others.max() < round_ones.max() + 1e-9
    assert others.min() > (1.0 - IRREGULAR) * 0.5 - 0.05


def test_stones_in_few_rows_lie_along_the_middle() -> None:
    ground = build_ground(StonesTerrain(rows=3), 7)
    assert float(ground.height(np.array([2.5]), np.array([5.0]))[0]) == -0.6
    with pytest.raises(ValidationError, match="take 5"):
        StonesTerrain(rows=4)


def test_tops_of_stones_are_level_and_the_pit_is_deep() -> None:
    config = StonesTerrain(jitter=1, diameter=0.6, gap=0.3, depth=0.9, height_variation=0.2)
    ground = build_ground(config, 7)
    stand = stone_layout(config, generator(7, "terrain"))
    whole = (np.abs(stand.z) < 5.5).ravel()
    x, z, tops = stand.x.ravel()[whole], stand.z.ravel()[whole], stand.tops.ravel()[whole]
    assert len(x) > 20
    # Cells across the rim are walls; the top is level from a cell's diagonal inward.
    diagonal = math.hypot(0.04, 0.04)
    inner = 0.3 - diagonal
    for angle in np.linspace(0, 6, 13):
        for r in (0.0, 0.5 * inner, inner):
            at = x + r * math.cos(angle), z + r * math.sin(angle)
            assert np.abs(ground.height(*at) - tops).max() < 1e-12
            # The corner of one more cell may lie downhill of a wall that runs across cells.
            assert r > 0.3 - 2 * diagonal or ground.steppable(*at).all()
    # In the middle between four stones is the pit.
    pitch = 0.9
    between = stand.pit[0] + 0.3 + 0.3 + pitch / 2 + pitch * np.arange(3)
    assert ground.height(between, np.full(3, pitch / 2)) == pytest.approx(-0.9)
    assert not ground.height(
        np.array([stand.pit[0] - 0.05, stand.pit[1] + 0.05]), np.zeros(2)
    ).any()


def test_boulders_cover_their_share_and_leave_the_clearing() -> None:
    config = BouldersTerrain(cover=0.3, height=0, buried=0.5, clearing=2)
    field = build_ground(config, 3).field
    x, _, z = field.vertices.T
    stands = field.heights.ravel() > 0
    outside = np.hypot(x, z) > 3.5
    assert stands[outside].mean() == pytest.approx(0.3, abs=0.03)
    assert not stands[np.hypot(x, z) < 2].any()
    # Half of the tallest that there may be is out of the ground.
    assert 0.5 * 1.2 * 0.5 < field.heights.max() <= 0.5 * 1.2 * 0.9


def test_a_boulder_is_an_ellipsoid() -> None:
    config = BouldersTerrain(
        size=(8, 8), cells=(400, 400), cover=0.01, height=0, buried=0.25, diameters=(1, 1),
        clearing=0,
    )  # fmt: skip
    heap = scattered_boulders(config, generator(5, "terrain").spawn(2)[1])
    assert len(heap.xz) == 1
    field = build_ground(config, 5).field
    (centre,), (axes,), ((c, s),) = heap.xz, heap.axes, heap.turn
    assert (np.abs(centre) < 4 - axes[0]).all()
    # A quarter of it is in the ground, so its middle is half its third axis up.
    t, r = np.meshgrid(np.linspace(0, 6.2, 40), np.linspace(0, 0.95, 20))
    u, v = r * axes[0] * np.cos(t), r * axes[1] * np.sin(t)
    x, z = centre[0] + c * u - s * v, centre[1] + s * u + c * v
    surface = axes[2] * (0.5 + np.sqrt(1 - r**2))
    # Linear between vertices of 0.02 m: bent by the curvature only.
    assert np.abs(field.height(x, z) - surface).max() < 0.02
    assert np.abs(field.height(x, z) - surface)[r < 0.5].max() < 4e-4


def test_a_sum_adds_its_terms_on_its_own_grid() -> None:
    config = terrain(
        {"kind": "sum", "size": (12, 8), "cells": (240, 80), "of": ("stairs", {"kind": "ramp"})}
    )
    parts = [StairsTerrain, RampTerrain]
    heights = [build_ground(p(size=(12, 8), cells=(240, 80)), 1).field.heights for p in parts]
    assert build_ground(config, 1).field.heights == pytest.approx(heights[0] + heights[1])


def test_equal_terms_of_a_sum_have_different_seeds() -> None:
    one = {"preset": "rocks", "height": 1}
    twice = build_ground(terrain({"kind": "sum", "of": (one, one)}), 1).field.heights
    once = build_ground(terrain({"kind": "sum", "of": (one,)}), 1).field.heights
    assert np.abs(twice - 2 * once).max() > 0.1
    # Another term does not change the others.
    assert np.ptp(twice - once) == pytest.approx(1.0)


SIDE = st.floats(0.5, 60)
COUNT = st.integers(2, 40)
VALUES: dict[str, Any] = {
    "course": st.sampled_from(["up", "down", "up and down"]),
    "start": st.floats(-40, 40),
    "steps": st.integers(1, 50),
    "slope_deg": st.floats(0.01, 85),
    "cover": st.floats(0, 0.9),
    "buried": st.floats(0, 0.95),
    "variation": st.floats(0, 1),
    "jitter": st.floats(0, 1),
    "roughness": st.floats(0, 1),
    "scale": st.none() | st.floats(0.1, 100),
    "diameters": st.tuples(st.floats(0.1, 9), st.floats(0.1, 9)).map(lambda d: tuple(sorted(d))),
}


def test_hills_much_wider_than_the_ground_have_full_height_or_none() -> None:
    for spacing in np.arange(5.0, 20.0, 0.25):
        config = {"size": (0.5, 0.5), "cells": (9, 10), "spacing": float(spacing), "height": 1.0}
        heights = build_ground(HillsTerrain.model_validate(config), 2).field.heights
        assert np.ptp(heights) in (0.0, pytest.approx(1.0))


@pytest.mark.parametrize("kind", GRIDS, ids=lambda kind: kind.__name__)
@given(data=st.data())
def test_any_config_gives_a_finite_ground_or_is_refused(kind: type[GridTerrain], data: Any) -> None:
    config: dict[str, Any] = {"size": data.draw(st.tuples(SIDE, SIDE))}
    config["cells"] = data.draw(st.tuples(COUNT, COUNT))
    for name in kind.model_fields.keys() - GridTerrain.model_fields.keys() - {"kind"}:
        config[name] = data.draw(VALUES.get(name, st.floats(0.01, 20)), label=name)
    try:
        made = kind(**config)
    except ValidationError:
        # Features finer than the grid, as others say in detail.
        return
    ground = build_ground(made, 2)
    n_x, n_z = made.cells
    assert ground.field.heights.shape == (n_z + 1, n_x + 1)
    assert np.isfinite(ground.field.heights).all()
    assert ground.forbidden.shape == (n_z, n_x)
