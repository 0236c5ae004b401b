"""Broad phase: near links of one body, against all of them measured anew."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.characters.body_arrays import CharacterArrays
from pipeline.simulation.characters.body_plan import character_arrays
from pipeline.simulation.characters.broad_phase import (
    OWN_MARGIN,
    Workspace,
    find_own_pairs,
    update_bounds,
    workspace_for,
)
from pipeline.simulation.characters.character_plans import person_plan
from pipeline.simulation.dynamics.compiled import entry
from pipeline.simulation.people.proportions import ADULT, CHILD
from pipeline.simulation.spatial import Array
from tests.simulation.characters.character_yard import link_overlap

LIMP = [person_plan(ADULT), person_plan(CHILD)]


@entry
def find_pairs(arrays: CharacterArrays, workspace: Workspace) -> int:
    nodes, links, _, _, own, _, owners = arrays
    known = workspace.travel, workspace.due, workspace.is_near
    for c in range(len(owners)):
        workspace.travel[c] += update_bounds(nodes, owners[c], workspace.measured)
    return find_own_pairs(nodes, links, owners, own, *known, workspace.pairs)


@entry
def measure_overlaps(arrays: CharacterArrays, overlaps: Array) -> None:
    for n in range(len(arrays.pairs)):
        one, other = arrays.links[arrays.pairs[n, 0]], arrays.links[arrays.pairs[n, 1]]
        overlaps[n] = link_overlap(arrays.nodes, one, other)


def two_people() -> tuple[CharacterArrays, Workspace]:
    arrays = character_arrays(LIMP, [LIMP[0].rest, LIMP[1].rest + np.array([2.0, 0.0, 0.0])])
    return arrays, workspace_for(arrays)


def near_pairs(arrays: CharacterArrays) -> set[tuple[int, int]]:
    """Return all own pairs that are near."""
    overlaps = np.zeros(len(arrays.pairs))
    measure_overlaps(arrays, overlaps)
    return {(a, b) for a, b in arrays.pairs[overlaps >= -OWN_MARGIN].tolist()}


@pytest.mark.parametrize("speed", [1e-4, 0.004, 0.05])
def test_all_near_links_of_bodies_are_found_however_these_move(speed: float) -> None:
    arrays, workspace = two_people()
    rng, found = np.random.default_rng(3), set[tuple[int, int]]()
    ways: Array = np.zeros_like(arrays.p)
    for step in range(300):
        if step % 20 == 0:
            ways = rng.normal(scale=speed, size=arrays.p.shape)
        # Limbs about the body, which goes along as a whole.
        arrays.nodes["p"] += ways * np.cos(0.31 * step) + [0.01, 0.0, -0.02]
        count = find_pairs(arrays, workspace)
        pairs = {(a, b) for a, b in workspace.pairs[:count, :2].tolist()}
        assert pairs == near_pairs(arrays)
        found |= pairs
    assert len(found) > 2


def test_links_that_keep_apart_are_not_measured_again() -> None:
    arrays, workspace = two_people()
    find_pairs(arrays, workspace)
    first = workspace.due.copy()
    for _ in range(50):
        arrays.nodes["p"] += [0.02, 0.001, -0.03]
        find_pairs(arrays, workspace)
    assert (workspace.due == first).all()
    # A limb that swings has those measured that it may come near.
    arrays.nodes["p"][arrays.links[1].ends[1]] += [0.15, 0.0, 0.0]
    find_pairs(arrays, workspace)
    changed = workspace.due != first
    assert 0 < changed.sum() < len(changed)
