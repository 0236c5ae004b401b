"""Creatures and people that go through things, and over edges, are noted."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

from pipeline.simulation.simulate import simulate

if TYPE_CHECKING:
    from pipeline.simulation.take import TakeNote
    from pipeline.spec import Scene

    SceneOf = Callable[..., Scene]

BUG = "{name: bug, figure: beetle, scale: 0.3, walk: {speed: 0.8}}"
CRATE = "name: crate, prop: {shape: box, size: [0.4, 0.6, 0.4]}, at: [1.2, 0]"


def passages(scene: Scene) -> list[TakeNote]:
    """Return the notes on passages through other performers."""
    notes = [note for note in simulate(scene).notes if note.kind == "passes_through"]
    return [note for note in notes if note.part in {m.name for m in scene.cast}]


def test_a_creature_that_walks_through_a_prop_is_noted_once(scene_of: SceneOf) -> None:
    (note,) = passages(scene_of(BUG, f"{{{CRATE}}}", duration=3))
    assert note.part == "bug"
    assert note.text.startswith("goes 0.")
    assert note.text.endswith("'crate', which no creature avoids by itself; lead its way around it")
    # Its head is 0.4 m ahead of its middle, and the crate 1 m.
    assert 0.5 < note.step / 96 < 1.5


def test_a_body_that_meets_the_ground_alone_is_told_with_its_key(scene_of: SceneOf) -> None:
    body = "name: crate, body: {shape: box, size: [0.4, 0.6, 0.4]}, at: [1.2, 0]"
    (note,) = passages(scene_of(BUG, f"{{{body}}}", duration=2))
    assert note.text.endswith("collides with the ground alone; give it `collide: all`")
    solid = body.replace("shape: box", "shape: box, collide: all")
    assert not passages(scene_of(BUG, f"{{{solid}}}", duration=2))


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    "members",
    [
        [BUG, "{" + CRATE.replace("[1.2, 0]", "[1.2, 1.2]") + "}"],
        [BUG, "{name: rug, prop: {shape: box, size: [2, 0.02, 2]}, at: [1.5, 0]}"],
        [BUG, "{name: hat, prop: {shape: box}, parent: bug, at: [0, 0.2, 0]}"],
        [BUG.replace("walk: {speed: 0.8}", "look_at: crate"), f"{{{CRATE}}}"],
        # Those that begin in one another are told as such.
        [BUG, "{" + CRATE.replace("[1.2, 0]", "[0.1, 0]") + "}"],
    ],
    ids=["aside", "on a rug", "with a hat", "still", "from the start"],
)
def test_what_is_no_passage_is_not_told(scene_of: SceneOf, members: list[str]) -> None:
    assert passages(scene_of(*members, duration=1.5)) == []


def test_of_two_creatures_that_meet_one_is_told(scene_of: SceneOf) -> None:
    other = BUG.replace("bug,", "bee,").replace("walk:", "at: [2, 0], heading_deg: 180, walk:")
    (note,) = passages(scene_of(BUG, other, duration=2))
    assert {note.part, note.text.split("'")[1]} == {"bug", "bee"}


def test_a_ball_that_rolls_off_the_terrain_is_noted(scene_of: SceneOf) -> None:
    rolling = "{name: ball, character: ball, at: [1, 0.12, 0], velocity: [3, 0, 0]}"
    resting = "{name: rest, character: ball, at: [-1, 0.12, 0]}"
    scene = scene_of(rolling, resting, terrain="{kind: flat, size: [4, 4]}", duration=1)
    (note,) = [note for note in simulate(scene).notes if note.kind == "leaves_terrain"]
    assert note.part == "ball"
    # The edge is a metre away.
    assert 0.3 < note.step / 96 < 0.45


@pytest.mark.slow
def test_a_person_who_walks_into_a_pit_is_noted(scene_of: SceneOf) -> None:
    stones = "{kind: stones, start: 0.5, length: 3, size: [8, 4], cells: [200, 100]}"
    scene = scene_of(
        "{name: kid, character: child}",
        "{name: ann, character: child, at: [-3, 1]}",
        terrain=stones,
        duration=3.5,
        more="script: [{at: 0, who: kid, do: {go_to: [3, 0]}}, "
        "{at: 0, who: ann, do: {go_to: [-1, 1]}}]",
    )
    (note,) = [note for note in simulate(scene).notes if note.kind == "climbs"]
    assert note.part == "kid"
    assert note.text.startswith("goes down a step of 0.")


STACK = "{name: pile, many: {layout: stack, count: 5, of: {shape: box, size: [0.3, 0.2, 0.3]}}}"


def collapses(scene: Scene) -> list[TakeNote]:
    return [note for note in simulate(scene).notes if note.kind == "collapses"]


@pytest.mark.slow
def test_a_stack_that_falls_by_itself_is_noted(scene_of: SceneOf) -> None:
    wall = STACK.replace("layout: stack, count: 5", "layout: wall, rows: 6, columns: 2")
    hills = "{kind: fractal, size: [24, 24], height: 3, roughness: 0.6}"
    (note,) = collapses(scene_of(wall, terrain=hills, seed=3, duration=1))
    assert note.part == "pile"
    assert re.match(r"falls by itself: the ground under it rises by 0\.[0-9]+ m; let it", note.text)
    assert 0 < note.step < 96
    assert collapses(scene_of(STACK, duration=1)) == []


@pytest.mark.slow
def test_a_stack_that_is_knocked_over_is_not_noted(scene_of: SceneOf) -> None:
    ball = "{shape: sphere, radius: 0.2, density: 4000, collide: all}"
    thrown = f"{{name: ball, body: {ball}, at: [-1, 0.8, 0], velocity: [6, 1, 0]}}"
    take = simulate(scene_of(STACK, thrown, duration=1.5))
    top = [node.name for node in take.nodes].index("pile_5")
    assert take.positions[0, top, 1] > 0.85
    assert take.positions[-1, top, 1] < 0.5
    assert [note for note in take.notes if note.kind == "collapses"] == []
