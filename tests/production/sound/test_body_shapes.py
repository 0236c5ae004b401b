"""Shapes that parts ring like, from the bodies of a scene."""

from __future__ import annotations

import pytest

from audio.body_shape import BodyShape
from pipeline.errors import SceneError
from pipeline.production.sound.struck_bodies import StruckBodies, hollow_walls
from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene

BODIES = {
    "plank": ("{shape: box, size: [1.0, 0.02, 0.1]}", "oak"),
    "ball": ("{shape: sphere, radius: 0.05}", "steel"),
    "cube": ("{shape: cube, size: 0.1}", "marble"),
    "cup": ("{shape: prism, sides: 24, radius: 0.04, height: 0.09}", "porcelain"),
    "log": ("{shape: prism, sides: 24, radius: 0.04, height: 0.3}", "oak"),
}
EXPECTED = {
    "plank": ("box", 1.0, 0.1, 0.02),
    "ball": ("ellipsoid", 0.1, 0.1, 0.1),
    "cube": ("box", 0.1, 0.1, 0.1),
    "cup": ("vessel", 0.08, 0.09, 0.004),
    "log": ("cylinder", 0.3, 0.08, 0.08),
}
SCENE = """\
pronk: 1
frames: 16
terrain: {kind: flat, size: [8, 8], cells: [8, 8]}
cast:
"""


@pytest.mark.slow
def test_bodies_ring_like_what_they_are_and_the_ground_has_no_shape() -> None:
    cast = "".join(
        f"  - {{name: {name}, body: {body}, material: {material}, at: [{1.2 * i - 3}, 0.4, 0]}}\n"
        for i, (name, (body, material)) in enumerate(BODIES.items())
    )
    take = simulate(read_scene(SCENE + cast))
    bodies = StruckBodies(take, {})
    found = {event.who: bodies.body(event) for event in take.events}
    assert found.keys() == EXPECTED.keys()
    for name, (kind, *extents) in EXPECTED.items():
        shape = found[name].shape
        assert shape is not None
        assert shape.kind == kind, name
        lengths = [shape.length, shape.width, shape.thickness]
        assert lengths == pytest.approx(extents, rel=0.03), name
        assert found[name].struck_shape is None


def test_a_body_that_is_struck_has_a_shape() -> None:
    low = "{shape: box, size: [0.4, 0.1, 0.3], collide: all}"
    ball = "{shape: sphere, radius: 0.05, collide: all}"
    cast = (
        f"  - {{name: low, body: {low}, at: [0, 0.05, 0]}}\n"
        f"  - {{name: ball, body: {ball}, at: [0, 0.3, 0]}}\n"
    )
    take = simulate(read_scene(SCENE + cast))
    bodies = StruckBodies(take, {})
    struck = [bodies.body(e) for e in take.events if {e.who, e.other} == {"low", "ball"}]
    assert struck
    for body in struck:
        assert body.shape is not None
        assert body.struck_shape is not None
        assert {body.shape.kind, body.struck_shape.kind} == {"box", "ellipsoid"}


CAN = "{shape: prism, sides: 24, radius: 0.05, height: 0.12, hollow: 0.001}"
HOLLOW = f"""
  - {{name: box, body: {{shape: box, size: [0.4, 0.3, 0.2], hollow: 0.004}}, at: [0, 0.4, 0]}}
  - {{name: can, body: {CAN}, material: steel, at: [1, 0.4, 0]}}
  - {{name: ball, prop: {{shape: ball, radius: 0.1, hollow: 0.003}}, at: [2, 1, 0]}}
  - {{name: cans, many: {{layout: row, count: 2, of: {{shape: cube, size: 0.1, hollow: 0.002}}}},
     at: [-2, 0]}}
"""


def test_walls_of_hollow_bodies_and_props_are_found_by_name() -> None:
    walls = hollow_walls(read_scene(SCENE + HOLLOW).cast)
    assert walls == {"box": 0.004, "can": 0.001, "ball": 0.003, "cans": 0.002}


@pytest.mark.parametrize(
    "what",
    ["body: {shape: cube, size: 0.1, hollow: 0.05}", "prop: {shape: ball, radius: 1, hollow: 2}"],
)
def test_a_wall_that_leaves_no_cavity_is_refused(what: str) -> None:
    with pytest.raises(SceneError, match="leaves no cavity; write less than"):
        read_scene(SCENE + f"  - {{name: it, {what}}}\n")


@pytest.mark.slow
def test_hollow_bodies_ring_with_their_walls() -> None:
    scene = read_scene(SCENE + HOLLOW)
    take = simulate(scene)
    bodies = StruckBodies(take, hollow_walls(scene.cast))
    found = {event.who: bodies.body(event).shape for event in take.events}
    assert found["box"] == BodyShape("box", 0.4, 0.3, 0.2, 0.004)
    can = found["can"]
    assert can is not None
    assert (can.kind, can.length, can.wall) == ("cylinder", 0.12, 0.001)
    assert can.width == pytest.approx(0.1, rel=0.02)
