"""Performers that begin inside of one another are noted."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from pipeline.simulation.obstacles import outermost
from pipeline.simulation.simulate import simulate
from pipeline.simulation.solid_overlaps import convex_depth, depth_bound

if TYPE_CHECKING:
    from pipeline.spec import Scene

    SceneOf = Callable[..., Scene]

CRATE = "{name: crate, prop: {shape: box, size: [0.6, 0.6, 0.6]}"
BUG = "{figure: beetle, name: bug"
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.5


def overlaps(scene: Scene) -> dict[str, str]:
    """Return the texts of the notes on overlaps, by performer."""
    notes = [note for note in simulate(scene).notes if note.kind == "overlaps"]
    assert all(note.step == 0 for note in notes)
    return {note.part: note.text for note in notes}


def test_a_creature_in_a_prop_is_noted(scene_of: SceneOf) -> None:
    found = overlaps(scene_of(BUG + "}", CRATE + "}", duration=0.1))
    assert list(found) == ["bug"]
    assert found["bug"].startswith("begins 0.")
    assert found["bug"].endswith(" m deep in 'crate'; move one of them")


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("{figure: beetle, name: a}", "{figure: beetle, name: b}"),
        ("{figure: kangaroo, name: a, pronk: {}}", "{figure: beetle, name: b, walk: {}}"),
        ("{dancer: torso, name: a}", "{figure: person, name: b}"),
        ("{prop: {shape: box}, name: a}", "{prop: {shape: box}, name: b}"),
        (
            "{body: {shape: sphere, radius: 0.01}, at: [0, 1, 0], name: a}",
            "{body: {shape: sphere, radius: 0.01}, at: [0, 1, 0], name: b}",
        ),
        ("{prop: {shape: box, size: [3, 3, 0.2]}, name: a}", "{figure: person, name: b}"),
    ],
)
def test_two_in_one_place_are_noted(scene_of: SceneOf, one: str, other: str) -> None:
    assert len(overlaps(scene_of(one, other, duration=0.1))) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "other",
    [
        "{character: child, name: b}",
        "{name: b, many: {of: brick, rows: 9, columns: 6}, heading_deg: 90}",
        "{prop: {shape: box, size: [0.1, 3, 3]}, name: b}",
    ],
)
def test_people_in_one_another_and_in_walls_are_noted(scene_of: SceneOf, other: str) -> None:
    found = overlaps(scene_of("{character: adult, name: a}", other, duration=0.1))
    assert len(found) == 1
    assert float(next(iter(found.values())).split()[1]) > 0.05


@pytest.mark.parametrize(
    "members",
    [
        # What a parent or a hand connects.
        [BUG + "}", "{name: hat, prop: {shape: box}, parent: bug}"],
        [
            "{figure: person, name: ann}",
            "{name: cup, prop: {shape: ball}, at: [0, 0.5, 0], held: [{by: ann.hand_r, at: 9}]}",
        ],
        [
            BUG + "}",
            "{name: a, prop: {shape: ball}, parent: bug}",
            "{name: b, prop: {shape: box}, parent: bug}",
        ],
        # What authors build of props.
        [CRATE + "}", "{name: lid, prop: {shape: box, size: [0.7, 0.1, 0.7]}, at: [0, 0.5, 0]}"],
        # What only touches: boxes on one another, side by side, and 1 cm deep.
        [
            "{name: a, body: {shape: box, size: [1, 1, 1]}, at: [0, 0.5, 0]}",
            CRATE + ", at: [0, 1.3, 0], falls: 0.05}",
        ],
        [CRATE + ", falls: 0.05}", "{name: b, body: {shape: box, size: [1, 1, 1]}, at: [0.8, 0]}"],
        [CRATE + "}", "{name: b, body: {shape: box, size: [1, 1, 1]}, at: [0.79, 0.5, 0]}"],
        # What stands between the teeth of a hollow thing.
        [
            "{name: a, body: {shape: sphere, radius: 0.02}, at: [0.97, 0.5, 0]}",
            "{name: b, prop: {shape: gear, teeth: 6, radius: 1}, at: [0, 0.5, 0]}",
        ],
        # Groups go where their rules say.
        ["{name: birds, group: {rule: flock, count: 9}, at: [0, 1, 0]}", BUG + "}"],
        # A limb that is posed on a thing.
        [
            "{figure: person, name: ann, pose: [{at: 0, limb: arm_r, reach: [0.3, 0.8, 0.2]}]}",
            "{name: table, prop: {shape: box, size: [0.6, 0.1, 1]}, at: [0.5, 0.8, 0]}",
        ],
    ],
)
def test_what_belongs_together_or_only_touches_is_not_noted(
    scene_of: SceneOf, members: list[str]
) -> None:
    assert overlaps(scene_of(*members, duration=0.1)) == {}


def test_all_that_a_performer_stands_in_is_told_in_one_note(scene_of: SceneOf) -> None:
    found = overlaps(scene_of(BUG + "}", CRATE + "}", STUMP, duration=0.1))
    assert list(found) == ["bug"]
    assert "'crate' and " in found["bug"]
    assert "'stump'" in found["bug"]


STUMP = "{name: stump, prop: {shape: cylinder, radius: 0.3, height: 0.5}}"


@pytest.mark.parametrize(("offset", "depth"), [(0.0, 1.0), (0.7, 0.3), (0.999, 0.001), (1.2, 0.0)])
def test_depth_of_boxes_is_exact(offset: float, depth: float) -> None:
    assert convex_depth(CORNERS, CORNERS + np.array([offset, 0.0, 0.0])) == pytest.approx(
        depth, abs=1e-6
    )


def test_bound_is_never_less_than_the_depth() -> None:
    rng = np.random.default_rng(4)
    for _ in range(30):
        a = outermost(rng.normal(size=(40, 3)))
        b = outermost(rng.normal(size=(40, 3)) + rng.normal(size=3))
        assert depth_bound(a, b) >= convex_depth(a, b) - 1e-9
