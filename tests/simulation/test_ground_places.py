"""Start places, paths, landings and destinations lie on the terrain."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

from pipeline.errors import SceneError
from pipeline.simulation.simulate import Simulation
from pipeline.spec.script import Instruction

if TYPE_CHECKING:
    from pipeline.spec import Scene

    SceneOf = Callable[..., Scene]

TERRAIN = "{kind: flat, size: [6, 8], at: [1, 0]}"
EXTENT = "the terrain, which reaches from [-2, -4] to [4, 4]"
BUG = "{figure: beetle, name: bug, walk: {}}"
ROO = "{figure: kangaroo, name: roo, pronk: {}}"
OFF = [
    ("{figure: beetle, at: [5, 0]}", "", "cast[0].at"),
    ("{figure: kangaroo, at: [5, 1, 0], pronk: {}}", "", "cast[0].at"),
    ("{dancer: torso, at: [0, 4.5]}", "", "cast[0].at"),
    ("{figure: beetle, walk: {path: [[2, 0], [120, 0]]}}", "", "cast[0].walk.path[1]"),
    ("{figure: kangaroo, pronk: {land_at: [[1, 0], [9, 0]]}}", "", "cast[0].pronk.land_at[1]"),
    (BUG, "{at: 1, who: bug, do: {go_to: [0, 70]}}", "script[0].do.go_to"),
    (BUG, "{at: 1, who: bug, do: {go_to: hill}}", "script[0].do.go_to"),
    (ROO, "{at: 1, who: roo, do: {jump: {land_at: [-3, 0]}}}", "script[0].do.jump.land_at"),
]
ON = [
    (BUG, "{at: 1, who: bug, do: {go_to: [4, 4]}}"),
    (BUG, "{at: 1, who: bug, do: {go_to: moon}}"),
    (BUG, "{at: 1, who: bug, do: {look_at: hill}}"),
    ("{name: birds, group: {rule: flock, count: 3}, at: [0, 3, 9]}", ""),
    (
        "{name: birds, group: {rule: flock, count: 3}, at: [0, 3, 0]}",
        "{at: 1, who: birds, do: {go_to: [90, 90]}}",
    ),
    ("{figure: beetle, parent: moon, at: [0, 7]}", ""),
    ("{body: {shape: sphere}, at: [9, 2, 9]}", ""),
]
PLACES = "places: {hill: [50, 60]}"
MOON = "{name: moon, prop: {shape: ball}, at: [40, 30, 40]}"


def script_of(order: str) -> str:
    """Return the places and the script of a scene."""
    return f"{PLACES}\nscript: [{order}]"


@pytest.mark.sample(3)
@pytest.mark.parametrize(("member", "order", "path"), OFF)
def test_places_off_the_terrain_are_refused(
    scene_of: SceneOf, member: str, order: str, path: str
) -> None:
    with pytest.raises(SceneError) as caught:
        Simulation(scene_of(member, terrain=TERRAIN, more=script_of(order)))
    (problem,) = caught.value.problems
    assert problem.path == path
    assert problem.line > 0
    assert EXTENT in problem.message
    assert problem.message.startswith("'hill', at [50, 60]," if "hill" in order else "[")


@pytest.mark.parametrize(("member", "order"), ON)
def test_places_that_need_no_ground_may_lie_anywhere(
    scene_of: SceneOf, member: str, order: str
) -> None:
    Simulation(scene_of(member, MOON, terrain=TERRAIN, more=script_of(order)))


def test_all_places_off_the_terrain_are_told_at_once(scene_of: SceneOf) -> None:
    path = "{figure: beetle, name: bug, at: [0, 9], walk: {path: [[9, 0], [1, 1], [0, -9]]}}"
    with pytest.raises(SceneError) as caught:
        Simulation(scene_of(path, terrain=TERRAIN))
    assert [problem.path for problem in caught.value.problems] == [
        "cast[0].at",
        "cast[0].walk.path[0]",
        "cast[0].walk.path[2]",
    ]


def test_a_turned_terrain_covers_what_it_turns_over(scene_of: SceneOf) -> None:
    terrain = "{kind: flat, size: [20, 2], heading_deg: 90}"
    Simulation(scene_of("{figure: beetle, at: [0, 8]}", terrain=terrain))
    with pytest.raises(SceneError, match=r"covers 20 x 2 m around \[0, 0\], turned by 90 degrees"):
        Simulation(scene_of("{figure: beetle, at: [8, 0]}", terrain=terrain))


def test_an_order_from_outside_that_leads_off_the_terrain_is_refused(scene_of: SceneOf) -> None:
    simulation = Simulation(scene_of(BUG, terrain=TERRAIN), directed=True)
    order = Instruction.model_validate({"at": 0.0, "who": "bug", "do": {"go_to": (9.0, 0.0)}})
    with pytest.raises(SceneError, match="lies outside the terrain"):
        simulation.add_instruction(order)
    simulation.step()
    assert not simulation.script.told
