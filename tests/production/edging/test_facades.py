"""Facades and stalls: houses of a street and stalls of a market are unlike."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pipeline.production.edging.carpentry import Carpentry
from pipeline.production.edging.cords import APART, PENNANT_SAG, pennant, pennants
from pipeline.production.edging.facade import RAILED, WINDOWS, bays
from pipeline.production.edging.house import House
from pipeline.production.edging.house_materials import (
    AFTER_DARK,
    DRESSINGS,
    MATERIALS_OF_HOUSES,
)
from pipeline.production.edging.stall import Stall
from pipeline.production.scenery.stones import KINDS, stone
from render.color import linear, luminance


def house(**others: Any) -> dict[str, np.ndarray]:
    """Return the corners (N, 3) of a house's boxes by material [m]."""
    carpentry = Carpentry()
    place, rng = np.zeros(2), np.random.default_rng(3)
    built = House(carpentry, place, 0.0, (8.0, 8.0), 3, 0.3, -0.1, rng, 1, **others)
    built.build()
    return {mesh.name: mesh.vertices for mesh in carpentry.meshes()}


def test_tall_windows_have_rails_and_others_have_none() -> None:
    for number, (_, low, _) in enumerate(WINDOWS):
        assert ("edging iron" in house(windows=number)) == (low < RAILED)


class Boxes(Carpentry):
    """Keeps the boxes that it is given."""

    def __init__(self) -> None:
        super().__init__()
        self.given: list[tuple[str, np.ndarray, np.ndarray]] = []

    def add(self, material: str, at: Any, size: Any, *others: Any) -> None:
        """Keep one box."""
        self.given.append((material, np.asarray(at), np.asarray(size)))
        super().add(material, at, size, *others)


@pytest.mark.parametrize("windows", range(len(WINDOWS)))
@pytest.mark.parametrize("width", [7.0, 8.3, 9.2])
def test_open_shutters_leave_those_of_neighbours_alone(windows: int, width: float) -> None:
    boxes, tall = Boxes(), WINDOWS[windows][2] - WINDOWS[windows][1]
    rng = np.random.default_rng(3)
    more = {"windows": windows, "shuttered": 1.0}
    House(boxes, np.zeros(2), 0.0, (width, 8.0), 2, 0.3, -0.1, rng, 1, **more).build()
    leaves = [
        (at, size)
        for material, at, size in boxes.given
        if "shutter" in material and np.isclose(size[1], tall) and at[2] > 0.0
    ]
    if width / bays(width) - WINDOWS[windows][0] < 0.8:
        # There is no room for any.
        assert not leaves
        return
    assert len(leaves) >= 4
    edges = sorted((at[0] - 0.5 * size[0], at[0] + 0.5 * size[0]) for at, size in leaves)
    assert all(low - high > 0.05 for (_, high), (low, _) in pairwise(edges))
    assert -0.5 * width < edges[0][0]
    assert edges[-1][1] < 0.5 * width


def test_dormers_stand_out_of_the_roof_above_the_wall() -> None:
    plain, with_dormers = (house(has_dormers=k)["edging pane"] for k in (False, True))
    top = 3.35 + 2 * 2.95 + 0.3
    before = [panes[:, 2] > -2.0 for panes in (plain, with_dormers)]
    assert plain[before[0], 1].max() < top < with_dormers[before[1], 1].max() < top + 3.5


def test_a_gutter_has_a_pipe_down_to_the_ground() -> None:
    zinc = house()["edging zinc"]
    assert zinc[:, 1].min() < 0.0
    assert np.ptp(zinc[:, 0]) > 8.0


def test_no_two_stalls_are_alike() -> None:
    sizes = set()
    for seed in range(4):
        carpentry = Carpentry()
        border: Any = SimpleNamespace(carpentry=carpentry, leaves=[])
        rng = np.random.default_rng(seed)
        Stall(border, np.zeros(3), 0.0, np.array([0.0, 0.0, 1.0]), rng).build()
        corners = np.concatenate([mesh.vertices for mesh in carpentry.meshes()])
        sizes.add(tuple(np.round(np.ptp(corners, axis=0), 2)))
        assert np.ptp(corners[:, 0]) < 3.6
        assert corners[:, 1].min() > -0.01
        fruit = np.concatenate([copies.points for copies in border.leaves])
        # It lies in crates, on the ground and in two rows on the table.
        high = fruit[:, 1]
        assert high.min() > 0.3
        assert high.max() < 1.2
        assert not ((high > 0.55) & (high < 0.85)).any()
    assert len(sizes) == 4


def test_pennants_hang_evenly_from_a_cord_that_sags() -> None:
    border: Any = SimpleNamespace(leaves=[])
    start, end = np.array([1.0, 4.0, 2.0]), np.array([1.0, 4.0, -6.0])
    pennants(border, start, end, np.random.default_rng(2))
    cord, hung = border.leaves
    assert cord.shape.vertices[:, 1].max() < 4.02
    points = hung.points
    assert len(points) == round(8.0 / APART)
    assert np.ptp(np.diff(points[:, 2])) < 1e-9
    assert 4.0 - 8.0 * PENNANT_SAG <= points[:, 1].min() < points[:, 1].max() < 4.0
    # They hang below the cord, in its plane.
    sized = hung.scales[:, None] * pennant().vertices
    extents = np.ptp(np.einsum("nij,nkj->nki", hung.turns, sized), axis=1)
    assert (extents[:, 2] > 1.5 * extents[:, 0]).all()
    assert (sized[..., 1] <= 1e-9).all()
    corner = np.cross(*(hung.tints[k] for k in (0, 1)))
    assert np.linalg.norm(corner) > 0.02


def test_kinds_of_stone_differ_in_tone_and_height() -> None:
    shapes = [stone(seed, 2) for seed in range(len(KINDS))]
    tones = [float(shape.colors.mean()) for shape in shapes]
    assert np.ptp(tones) > 0.03
    assert all(0.2 < np.ptp(shape.vertices[:, 1]) < 1.8 for shape in shapes)


def test_no_curtain_outshines_the_light_behind_it() -> None:
    def shown(name: str) -> float:
        return float(luminance(linear(AFTER_DARK[name].color))) * AFTER_DARK[name].glow

    for name, by_night in AFTER_DARK.items():
        assert by_night.glow > 0.0 == MATERIALS_OF_HOUSES[name].glow
    for light in ("lit", "dim"):
        for hung in DRESSINGS:
            assert shown(f"{light} {hung}") < 0.7 * shown(f"{light} pane")
