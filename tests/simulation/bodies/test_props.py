"""Props: keyframes, parents, and hands."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.bodies.prop_shapes import prop_solid
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array, heading, matrix
from pipeline.simulation.take import Take
from pipeline.spec.prop import BallShape, BoxShape, ConeShape, CylinderShape, GearShape, Shape
from tests.simulation.conftest import scene_of

PLATE = (
    "{name: plate, prop: {shape: cylinder, radius: 1}, at: [1, 0.2, 0], keyframes:"
    " [{at: 0, rotation_deg: [0, 0, 0]}, {at: 2, rotation_deg: [0, 90, 0], ease: linear}]}"
)


def pose(take: Take, node: str) -> tuple[Array, Array]:
    """Return R_WB (K, 3, 3) and p_WB (K, 3) of a node."""
    i = [one.name for one in take.nodes].index(node)
    return matrix(take.rotations[:, i]), take.positions[:, i]


def test_a_prop_follows_its_keyframes() -> None:
    keys = "[{at: 0, position: [0, 1, 0]}, {at: 1, position: [2, 1, 0], ease: linear}]"
    take = simulate(scene_of(f"{{name: a, prop: {{shape: ball}}, keyframes: {keys}}}"))
    _, p = pose(take, "a")
    times = np.arange(len(p)) / 96
    np.testing.assert_allclose(p[:, 0], 2 * np.clip(times, 0, 1), atol=1e-12)


def test_a_prop_without_height_stands_on_the_ground() -> None:
    member = "{name: a, prop: {shape: box, size: [1, 0.5, 1]}, at: [2, 3], heading_deg: 20}"
    take = simulate(scene_of(member, terrain="hills"))
    R, p = pose(take, "a")
    ground = Simulation(scene_of(member, terrain="hills")).world.ground
    lift = p[0, 1] - float(ground.height(np.array(2.0), np.array(3.0)))
    assert lift == pytest.approx(0.25, abs=1e-12)
    np.testing.assert_allclose(R[0], heading(np.radians(20)), atol=1e-12)


@pytest.mark.parametrize("order", [0, 1])
def test_a_child_follows_its_parent_without_lag(order: int) -> None:
    child = "{name: cup, prop: {shape: ball}, parent: plate, at: [0.5, 0.3, 0]}"
    take = simulate(scene_of(*[PLATE, child][:: 1 - 2 * order]))
    R, p = pose(take, "plate")
    np.testing.assert_allclose(pose(take, "cup")[1], p + R @ [0.5, 0.3, 0], atol=1e-12)


def test_a_creature_stands_on_its_parent() -> None:
    take = simulate(
        scene_of(PLATE, "{figure: beetle, scale: 0.2, parent: plate, at: [0, 0.2, 0.3]}")
    )
    alone = simulate(scene_of("{figure: beetle, scale: 0.2, at: [0, 0.3]}"))
    R, p = pose(take, "plate")
    for name in ("beetle.body", "beetle.l1.2"):
        local = pose(alone, name)[1] + [0, 0.2, 0]
        here = np.einsum("kij,kj->ki", R, local) + p
        # Each beetle draws its own idle movements, by its name.
        np.testing.assert_allclose(pose(take, name)[1], here, atol=1e-9)
    hangs = {node.name: node.parent for node in take.nodes}
    assert take.nodes[hangs["beetle.body"]].name == "plate"


def test_a_hand_picks_up_and_puts_down_a_prop() -> None:
    box = (
        "{name: box, prop: {shape: box}, at: [0, 2, 0],"
        " held: [{by: plate, at: 0.5, until: 1}, {by: cart, at: 1}]}"
    )
    cart = (
        "{name: cart, prop: {shape: ball}, keyframes:"
        " [{at: 1, position: [0, 0, 0]}, {at: 2, position: [0, 0, 4], ease: linear}]}"
    )
    take = simulate(scene_of(box, PLATE, cart))
    p = pose(take, "box")[1]
    np.testing.assert_allclose(p[:49], np.tile([0.0, 2.0, 0.0], (49, 1)), atol=1e-12)
    R_plate, p_plate = pose(take, "plate")
    held = np.einsum("kji,kj->ki", R_plate[48:97], p[48:97] - p_plate[48:97])
    np.testing.assert_allclose(held, np.tile(held[0], (49, 1)), atol=1e-12)
    np.testing.assert_allclose(
        p[96:] - pose(take, "cart")[1][96:], np.tile(p[96], (97, 1)), atol=1e-9
    )
    # Nothing jumps: neither where it is taken nor where it changes hands.
    assert np.linalg.norm(np.diff(p, axis=0), axis=1).max() < 4 / 96 + 1e-9


def test_a_released_prop_stays_with_its_parent() -> None:
    box = (
        "{name: box, prop: {shape: box}, parent: plate, at: [0.5, 0.3, 0],"
        " held: [{by: hand, at: 0.5, until: 1}]}"
    )
    hand = "{name: hand, prop: {shape: ball}, at: [0, 3, 0]}"
    take = simulate(scene_of(box, PLATE, hand))
    R, p = pose(take, "plate")
    local = np.einsum("kji,kj->ki", R, pose(take, "box")[1] - p)
    np.testing.assert_allclose(local[96:], np.tile(local[96], (97, 1)), atol=1e-12)
    assert np.linalg.norm(local[96] - local[0]) > 0.1


@pytest.mark.parametrize(
    ("cast", "message"),
    [
        (["{prop: {shape: ball}, parent: plat}"], "nobody in the cast is called 'plat'"),
        (["{prop: {shape: ball}, name: a, parent: a}"], "'a' cannot go along with itself"),
        (["{name: a, parent: b, prop: {shape: ball}}", "{name: b, parent: a, prop: {shape: ball}}"],
         "form a ring"),
        (["{parent: bug.tip, prop: {shape: ball}}", "{figure: beetle, name: bug}"],
         "no part 'tip'"),
        (
            ["{figure: beetle, parent: a, walk: {}}", "{prop: {shape: ball}, name: a}"],
            "conflicts with parent",
        ),
        (["{figure: beetle, at: [0, 1, 0]}"], "a creature stands on the ground"),
        (["{prop: {shape: ball}, keyframes: [{at: 0}]}"], "should say a position"),
        (
            ["{prop: {shape: ball}, keyframes: [{at: 1, position: [0, 0, 0]},"
             " {at: 0, position: [0, 0, 0]}]}"],
            "write them in order",
        ),
        (
            ["{prop: {shape: ball}, held: [{by: b, at: 1}, {by: b, at: 2}]}",
             "{prop: {shape: box}, name: b}"],
            "still holds it",
        ),
        (["{prop: {shape: bal}}"], "bal"),
    ],
)  # fmt: skip
def test_invalid_props_are_refused(cast: list[str], message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        Simulation(scene_of(*cast))
    assert all(problem.line > 0 for problem in caught.value.problems)


@pytest.mark.parametrize(
    "config",
    [
        BoxShape(shape="box", size=(0.4, 0.2, 1.0)),
        CylinderShape(shape="cylinder", radius=0.5, height=0.1),
        BallShape(shape="ball", radius=0.3),
        ConeShape(shape="cone", radius=0.3, height=0.7),
        ConeShape(shape="cone", radius=0.3, top=0.5, height=0.2),
        GearShape(shape="gear", teeth=9, radius=0.3),
    ],
)
def test_solids_are_closed_and_face_outward(config: Shape) -> None:
    solid = prop_solid(config)
    edges = np.concatenate([solid.faces[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    there = {(int(a), int(b)) for a, b in edges}
    assert len(there) == len(edges)
    assert all((b, a) in there for a, b in there)
    a, b, c = (solid.vertices[solid.faces[:, k]] for k in range(3))
    assert (np.einsum("fi,fi->f", np.cross(b - a, c - a), (a + b + c)) > 0.0).all()
