"""Coarse people: small ones have fewer triangles, and keep their place and their moves."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.shots.coarse_people import FINE_PIXEL, PAINTED, with_coarse_people
from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.simulation.take import Take
from tests.simulation.characters.scripted_people import run_scene

CAST = "  - {name: ann, character: adult}\n  - {name: ben, character: child, at: [2, 0]}\n"


@pytest.fixture(scope="module")
def take() -> Take:
    return run_scene(CAST, 0.5, "  - {at: 0, who: ann, do: {express: joy}}\n").take()


def heads(take: Take) -> list[int]:
    return [k for k, p in enumerate(visible_parts(take)) if len(take.meshes[p.seen].targets)]


def test_heads_are_as_fine_as_their_pixels(take: Take) -> None:
    count = len(visible_parts(take))
    fine = with_coarse_people(take, np.full(count, FINE_PIXEL))
    assert all(a is b for a, b in zip(fine.meshes, take.meshes, strict=True))
    sizes = [
        sum(len(mesh.faces) for mesh in with_coarse_people(take, np.full(count, pixel)).meshes)
        for pixel in (0.003, 0.005, 0.008, np.inf)
    ]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] < 0.75 * sizes[0]


def test_coarse_heads_stand_and_act_as_fine_ones(take: Take) -> None:
    pixel = 0.006
    coarse = with_coarse_people(take, np.full(len(visible_parts(take)), pixel))
    row = len(take.positions) - 1
    fine_skin, skin = Skin.of(take), Skin.of(coarse)
    before, after = fine_skin.posed(take, row), skin.posed(coarse, row)
    for k in heads(take):
        a = before[fine_skin.starts[k] : fine_skin.starts[k + 1]]
        b = after[skin.starts[k] : skin.starts[k + 1]]
        assert len(b) <= len(a)
        # All that is left are vertices of the fine head, in the same place.
        nearest = np.linalg.norm(a[:, None] - b[None], axis=-1).min(axis=0)
        assert nearest.max() < 1e-6
        np.testing.assert_allclose(np.ptp(a, axis=0), np.ptp(b, axis=0), atol=2.5 * pixel)


def test_nothing_small_vanishes() -> None:
    take = run_scene("  - {name: doll, character: ragdoll, scale: 0.3}\n", 0.05, "").take()
    coarse = with_coarse_people(take, np.full(len(visible_parts(take)), np.inf))
    assert all(len(coarse.meshes[part.seen].faces) for part in visible_parts(coarse))
    assert sum(len(m.faces) for m in coarse.meshes) < sum(len(m.faces) for m in take.meshes)


@pytest.mark.parametrize(("layer", "pixel", "most"), [("skin", 0.009, 0.4), ("eyes", 0.006, 0.2)])
def test_lips_and_irises_keep_their_size(take: Take, layer: str, pixel: float, most: float) -> None:
    coarse = with_coarse_people(take, np.full(len(visible_parts(take)), pixel))
    found = [part for part in visible_parts(coarse) if part.name.endswith(f".{layer}")]
    assert len(found) == 2
    for part in found:
        fine, mesh = take.meshes[part.seen], coarse.meshes[part.seen]
        areas = [_painted_area(one.vertices, one.faces, one.paint) for one in (fine, mesh)]
        assert areas[1] == pytest.approx(areas[0], rel=most)


def _painted_area(vertices: np.ndarray, faces: np.ndarray, paint: np.ndarray) -> float:
    """Return the area of the faces of which all corners are painted [m²]."""
    inside = (paint[:, 3] > PAINTED)[faces].all(axis=1)
    a, b, c = (vertices[faces[inside, k]].astype(float) for k in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=-1).sum())
