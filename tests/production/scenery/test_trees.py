"""Trees: variants differ, birch bark has no rings, far trees stand in clumps."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.scenery import clumps
from pipeline.production.scenery.birch_bark import SLIT, bark_colors
from pipeline.production.scenery.branches import add_bark
from pipeline.production.scenery.crown_habits import CROWNS, HABITS, habit
from pipeline.production.scenery.furrowed_bark import RINGS, SIDES
from pipeline.production.scenery.prototype import Shape
from pipeline.production.scenery.species import prototype
from pipeline.production.scenery.trees import crown_tree, grown_crown


@pytest.mark.parametrize("kind", HABITS)
def test_variants_of_a_species_have_habits_of_their_own(kind: str) -> None:
    found = [habit(kind, 101 * v + 7) for v in range(len(HABITS[kind]))]
    assert len(set(found)) == len(found)
    assert habit("scrub", 108) == CROWNS["scrub"]


def test_a_leaning_tree_stands_on_its_foot() -> None:
    kind, seed = "acacia", 3 * 101 + 7
    assert habit(kind, seed).lean > 0.1
    nodes = grown_crown(kind, seed)[0].nodes
    assert np.hypot(*nodes[0, [0, 2]]) < 0.05
    top = nodes[nodes[:, 1] > 0.8 * nodes[:, 1].max()]
    assert np.hypot(*top[:, [0, 2]].mean(axis=0)) > 0.3


def test_birch_bark_is_white_above_its_foot_and_no_mark_goes_round() -> None:
    (skeleton, _), config = grown_crown("birch", 7), CROWNS["birch"]
    color = bark_colors(skeleton, config.foot, config.bark, np.random.default_rng(1))
    light = color.mean(axis=1)
    trunk = (skeleton.radii > 0.5 * config.foot) & (skeleton.nodes[:, 1] > 1.2)
    assert light[trunk].min() > 0.4
    assert light[skeleton.radii < 0.14 * config.foot].max() < 0.15
    assert light[skeleton.nodes[:, 1] < 0.1].max() < 0.3
    tree = crown_tree("birch", 7, 0)
    dark = np.abs(tree.colors - np.array(SLIT, np.float32)).max(axis=1) < 1e-5
    corners = tree.solid[dark[tree.solid].all(axis=1)]
    normals = tree.normals[corners]
    # Corners of one mark look about the same way.
    assert len(corners) > 100
    assert (normals[:, 0] * normals[:, 2]).sum(axis=1).min() > 0.1


def test_a_far_tree_is_a_clump_of_smaller_ones() -> None:
    one, several = crown_tree("oak", 7, clumps.FAR), prototype("oak", 0, clumps.FAR)
    assert np.ptp(several.vertices[:, 0]) > 1.05 * np.ptp(one.vertices[:, 0])
    assert several.triangles < 1.4 * one.triangles
    assert several.vertices[:, 1].max() < 1.3 * one.vertices[:, 1].max()
    near = clumps.tree(lambda seed, level: crown_tree("oak", seed, level), 3, 7, 2)
    assert near.triangles == crown_tree("oak", 7, 2).triangles


def test_near_trunks_have_furrows_and_pieces_that_meet() -> None:
    skeleton, _ = grown_crown("oak", 7)
    shape = Shape()
    colors = np.ones((len(skeleton.nodes), 3))
    add_bark(shape, skeleton, colors, 0.9 * skeleton.radii.max(), 7, 0.0)
    bark = shape.prototype()
    rings = bark.vertices.reshape(-1, RINGS, SIDES, 3)
    # A round trunk of one tone would have the same distance, and tone, all around.
    middle = rings.mean(axis=2, keepdims=True)
    out = np.linalg.norm(rings - middle, axis=-1)
    assert (out.std(axis=-1) / out.mean(axis=-1)).min() > 0.02
    tones = bark.colors.reshape(rings.shape)[..., 0]
    assert (tones.max(axis=-1) > 1.5 * tones.min(axis=-1)).all()
    ends, starts = rings[:-1, -1], rings[1:, 0]
    above = np.abs(ends.mean(axis=1) - starts.mean(axis=1)).max(axis=-1) < 1e-3
    assert above.any()
    assert np.abs(ends - starts)[above].max() < 0.02 * skeleton.radii.max()


def test_a_lobe_of_a_crown_faces_away_from_its_own_middle() -> None:
    _, lobes = grown_crown("oak", 7)
    assert len(lobes.middles) == habit("oak", 7).lobes
    places = lobes.middles + lobes.radii[:, None] * [0.0, 0.5, 0.0]
    np.testing.assert_allclose(lobes.out(places)[:, 1], 0.5, atol=0.25)
    leaves = crown_tree("oak", 7, 2)
    corners = leaves.vertices[leaves.foliage].mean(axis=1).astype(float)
    way = lobes.out(corners)
    normals = leaves.normals[leaves.foliage[:, 0]].astype(float)
    sides = np.abs(way[:, 1]) < 0.3
    # Leaves beside the middle of a lobe face sideways, out of it, wherever they are in the crown.
    assert (normals[sides] * way[sides]).sum(axis=1).mean() > 0.4
