"""Ways of moving that follow one another: paths, falls, hands, throws and kicks."""

from __future__ import annotations

import re

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.bodies.body_guide import GuideState
from pipeline.simulation.bodies.collider_troupe import ColliderTroupe
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.order_outcome import GripChange
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Take
from pipeline.simulation.troupe import pushed_troupe
from pipeline.spec.handled_members import handled_members
from pipeline.spec.script import Instruction, Kick
from tests.simulation.conftest import scene_of

ROW_RATE = 96.0
"""Rows per second of these scenes."""

HAND = (
    "{name: hand, prop: {shape: ball, radius: 0.05}, keyframes: [{at: 0, position: [0, 2, 0]},"
    " {at: 2, position: [3, 2.5, 1], rotation_deg: [20, 90, 40]}]}"
)

STILL_HAND = "{name: hand, prop: {shape: ball, radius: 0.05}, at: [0, 3, 0]}"

CRATE = "name: crate, body: {shape: box, size: [0.2, 0.2, 0.2], collide: all}"


def pose(take: Take, node: str) -> tuple[Array, Array]:
    """Return R_WB (K, 3, 3) and p_WB (K, 3) of a node."""
    i = [one.name for one in take.nodes].index(node)
    return matrix(take.rotations[:, i]), take.positions[:, i]


def local_pose(take: Take, holder: str, node: str) -> tuple[Array, Array]:
    """Return R_HB (K, 3, 3) and p_HB (K, 3) of a node in another."""
    (R_WH, p_WH), (R_WB, p_WB) = pose(take, holder), pose(take, node)
    inverse = R_WH.swapaxes(-1, -2)
    return inverse @ R_WB, np.einsum("kij,kj->ki", inverse, p_WB - p_WH)


def assert_falls(p: Array, first: int, last: int, v: tuple[float, float, float]) -> None:
    """Assert that rows lie on the parabola that begins in the first of them with `v` [m/s]."""
    t = (np.arange(first, last) - first)[:, None] / ROW_RATE
    expected = p[first] + t * np.array(v) - 0.5 * t * t * np.array([0.0, GRAVITY, 0.0])
    np.testing.assert_allclose(p[first:last], expected, atol=1e-6)


def colliders(simulation: Simulation) -> ColliderTroupe:
    troupe = pushed_troupe(simulation.troupes)
    assert isinstance(troupe, ColliderTroupe)
    return troupe


def node_of(simulation: Simulation, name: str) -> int:
    return [node.name for node in simulation.recorder.nodes].index(name)


@pytest.mark.parametrize("falls", [1.0, 0.7512])
def test_a_prop_falls_with_the_velocity_that_it_has(falls: float) -> None:
    ball = (
        "{name: ball, prop: {shape: ball, radius: 0.1}, at: [0, 5, 0], velocity: [2, 0, 0],"
        f" spin_deg: [0, 90, 30], falls: {falls}}}"
    )
    take = simulate(scene_of(ball, duration=2.5))
    R, p = pose(take, "ball")
    t = np.arange(len(p)) / ROW_RATE
    drop = np.maximum(t - falls, 0.0)
    height = 5.0 - 0.5 * GRAVITY * drop**2
    flies = height > 0.1
    np.testing.assert_allclose(p[flies, 0], 2.0 * t[flies], atol=1e-6)
    np.testing.assert_allclose(p[flies, 1], height[flies], atol=1e-6)
    (contact, *_) = take.contacts
    impact = falls + np.sqrt(2 * 4.9 / GRAVITY)
    assert (contact.step + contact.fraction) / 96 == pytest.approx(impact, abs=2e-3)
    assert (contact.performer, contact.other, contact.kind) == ("ball", "terrain", "hit")
    assert "collision" in {event.cause for event in take.events}
    # It turns on as it did.
    turned = R[1:] @ R[:-1].swapaxes(-1, -2)
    angle = np.arccos(np.clip((np.trace(turned, axis1=1, axis2=2) - 1) / 2, -1, 1))
    np.testing.assert_allclose(
        angle[: flies.sum() - 1], np.radians(np.hypot(90, 30)) / 96, rtol=1e-4
    )


def test_a_body_falls_from_a_hand_at_rest() -> None:
    held = "held: [{by: hand, at: 0, until: 0.5}]"
    take = simulate(scene_of(f"{{{CRATE}, at: [0.5, 3, 0], {held}}}", STILL_HAND, duration=1))
    _, p = pose(take, "crate")
    np.testing.assert_allclose(p[:49], np.tile(p[0], (49, 1)), atol=1e-12)
    assert_falls(p, 48, 97, (0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    "thing",
    [
        f"{CRATE}, at: [0.3, 2, 0]",
        "name: crate, prop: {shape: cone, radius: 0.1, height: 0.3}, at: [0.3, 2, 0], falls: 5",
    ],
)
def test_a_thing_keeps_its_pose_in_the_hand(thing: str) -> None:
    hold = "{by: hand, at: 0.25, until: 1.5}"
    take = simulate(scene_of(HAND, f"{{{thing}, held: [{hold}]}}"))
    R, p = local_pose(take, "hand", "crate")
    np.testing.assert_allclose(R[24:145], np.tile(R[24], (121, 1, 1)), atol=1e-9)
    np.testing.assert_allclose(p[24:145], np.tile(p[24], (121, 1)), atol=1e-9)
    assert np.linalg.norm(p[24]) > 0.1


def test_a_released_body_has_the_velocity_of_the_hand() -> None:
    held = "held: [{by: hand, at: 0.25, until: 1.5}]"
    take = simulate(scene_of(HAND, f"{{{CRATE}, at: [0.3, 2, 0], {held}}}"))
    _, p = pose(take, "crate")
    v = (p[144] - p[143]) * ROW_RATE
    assert np.linalg.norm(v) > 1.0
    assert_falls(p, 144, 180, tuple(v))


def test_a_thrown_body_lands_at_the_ballistic_distance() -> None:
    later = "held: [{by: hand, at: 50}]"
    simulation = Simulation(scene_of(STILL_HAND, f"{{{CRATE}, at: [0.5, 3, 0], {later}}}"))
    troupe, hand = colliders(simulation), node_of(simulation, "hand")
    throw = np.array([3.0, 2.0, -1.0])
    for taken, velocity, step in ((True, None, 24), (False, throw, 48)):
        while simulation.step_number < step:
            simulation.step()
        simulation.last_row()
        troupe.change_grips([GripChange("kid", ("hand",), "crate", taken, velocity)], [(hand,)])
        assert troupe.solid_motion().is_present[0] == (not taken and velocity is None)
    while not simulation.finished:
        simulation.step()
    take = simulation.take()
    _, p = pose(take, "crate")
    np.testing.assert_allclose(p[24:49], np.tile(p[24], (25, 1)), atol=1e-12)
    assert_falls(p, 48, 120, (3.0, 2.0, -1.0))
    hit = next(contact for contact in take.contacts if contact.performer == "crate")
    fall = p[48, 1] - 0.1
    flight = (2.0 + np.sqrt(4.0 + 2 * GRAVITY * fall)) / GRAVITY
    middle = p[48, [0, 2]] + flight * np.array([3.0, -1.0])
    assert np.abs(np.array(hit.place)[[0, 2]] - middle).max() < 0.1 + 0.01
    # The whole time until people meet it again has passed.
    assert troupe.solid_motion().is_present[0]


CUP = (
    "{name: cup, prop: {shape: cylinder, radius: 0.1, height: 0.2}, keyframes:"
    " [{at: 0, position: [-1, 2, 0]}, {at: 0.5, position: [0, 2, 0], ease: linear}], falls: 0.5,"
    " held: [{by: hand, at: 0.75, until: 1.25}]}"
)

SWING = (
    "{name: hand, prop: {shape: ball, radius: 0.05}, keyframes: [{at: 1, position: [0.6, 1.2, 0]},"
    " {at: 1.25, position: [1.2, 2, 0], ease: in}]}"
)


def test_a_cup_follows_keyframes_falls_is_caught_and_thrown() -> None:
    take = simulate(scene_of(CUP, SWING, duration=3))
    _, p = pose(take, "cup")
    assert_falls(p, 48, 73, (2.0, 0.0, 0.0))
    _, local = local_pose(take, "hand", "cup")
    np.testing.assert_allclose(local[72:121], np.tile(local[72], (49, 1)), atol=1e-9)
    v = (p[120] - p[119]) * ROW_RATE
    assert v[1] > 3.0
    hit = next(contact for contact in take.contacts if contact.step > 120)
    assert_falls(p, 120, hit.step, tuple(v))
    assert hit.other == "terrain"


def test_the_order_of_the_cast_does_not_matter() -> None:
    first, second = (simulate(scene_of(*cast)) for cast in ((CUP, SWING), (SWING, CUP)))
    again = simulate(scene_of(CUP, SWING))
    assert first.digest == again.digest
    for name in ("cup", "hand"):
        for one, other in zip(pose(first, name), pose(second, name), strict=True):
            np.testing.assert_array_equal(one, other)


def test_a_held_prop_stays_or_falls_when_it_is_released() -> None:
    box = "{{name: {name}, prop: {{shape: box}}, at: {at}, held: [{{by: hand, at: 0.25, {more}}}]}}"
    take = simulate(
        scene_of(
            HAND,
            box.format(name="stays", at="[0, 3, 2]", more="until: 0.75"),
            box.format(name="falls", at="[0, 3, -2]", more="until: 0.75, then: fall"),
            box.format(name="waits", at="[0, 3, -4]", more="until: 0.75}], falls: 1.0, other: [{"
                       ).replace(", other: [{}]", ""),
            duration=1.25,
        )
    )  # fmt: skip
    _, stays = pose(take, "stays")
    _, falls = pose(take, "falls")
    _, waits = pose(take, "waits")
    np.testing.assert_allclose(stays[72:], np.tile(stays[72], (49, 1)), atol=1e-12)
    assert_falls(falls, 72, 110, tuple((falls[72] - falls[71]) * ROW_RATE))
    np.testing.assert_allclose(waits[72:97], np.tile(waits[72], (25, 1)), atol=1e-12)
    assert_falls(waits, 96, 120, (0.0, 0.0, 0.0))


def test_its_own_motion_ends_when_a_prop_is_taken() -> None:
    keys = "keyframes: [{at: 0, position: [0, 3, 0]}, {at: 2, position: [4, 3, 0], ease: linear}]"
    prop = f"{{name: a, prop: {{shape: ball}}, {keys}, held: [{{by: hand, at: 1, until: 1.5}}]}}"
    take = simulate(scene_of(prop, STILL_HAND))
    _, p = pose(take, "a")
    np.testing.assert_allclose(p[:97, 0], 2 * np.arange(97) / ROW_RATE, atol=1e-12)
    np.testing.assert_allclose(p[96:], np.tile([2.0, 3.0, 0.0], (97, 1)), atol=1e-12)


def test_a_prop_falls_off_its_parent_with_its_velocity() -> None:
    cart = "{name: cart, prop: {shape: box, size: [1, 0.1, 1]}, at: [0, 2, 0], velocity: [1, 0, 0]}"
    cup = "{name: cup, prop: {shape: ball, radius: 0.1}, parent: cart, at: [0, 1, 0], falls: 0.5}"
    take = simulate(scene_of(cup, cart, duration=1))
    _, p = pose(take, "cup")
    np.testing.assert_allclose(p[:49, 0], np.arange(49) / ROW_RATE, atol=1e-12)
    assert_falls(p, 48, 80, (1.0, 0.0, 0.0))


def test_a_thing_goes_with_a_falling_one_without_lag() -> None:
    tray = "{name: tray, prop: {shape: box, size: [1, 0.1, 1]}, at: [0, 3, 0], falls: 0.25}"
    cup = "{name: cup, prop: {shape: ball, radius: 0.1}, parent: tray, at: [0, 0.3, 0], falls: 5}"
    take = simulate(scene_of(cup, tray, duration=0.75))
    _, local = local_pose(take, "tray", "cup")
    np.testing.assert_allclose(local, np.tile([0.0, 0.3, 0.0], (73, 1)), atol=1e-9)
    assert pose(take, "cup")[1][-1, 1] < 2.5


def test_a_body_released_inside_its_holder_is_not_thrown() -> None:
    held = "held: [{by: hand, at: 0, until: 0.25}]"
    take = simulate(scene_of(f"{{{CRATE}, at: [0.02, 3, 0], {held}}}", STILL_HAND, duration=1))
    _, p = pose(take, "crate")
    assert_falls(p, 24, 90, (0.0, 0.0, 0.0))


def test_a_released_body_meets_its_holder_again() -> None:
    plate = "{name: plate, prop: {shape: box, size: [1, 0.1, 1]}, at: [0, 1, 0]}"
    held = "held: [{by: plate, at: 0, until: 0.25}]"
    take = simulate(scene_of(f"{{{CRATE}, at: [0, 1.5, 0], {held}}}", plate, duration=2))
    assert pose(take, "crate")[1][-1, 1] == pytest.approx(1.15, abs=2e-3)
    assert {contact.other for contact in take.contacts} == {"plate"}


def test_a_held_body_pushes_others_and_frees_what_lies_on_it() -> None:
    lower = f"{{{CRATE}, at: [0, 0], held: [{{by: lift, at: 1}}]}}"
    upper = (
        "{name: upper, body: {shape: box, size: [0.1, 0.1, 0.1], collide: all}, at: [0, 0.25, 0]}"
    )
    keys = "[{at: 1, position: [9, 1, 0]}, {at: 1.5, position: [9, 1, 4], ease: in}]"
    lift = f"{{name: lift, prop: {{shape: ball, radius: 0.1}}, keyframes: {keys}}}"
    take = simulate(scene_of(lower, upper, lift))
    _, p = pose(take, "upper")
    assert p[96, 1] == pytest.approx(0.25, abs=2e-3)
    assert p[-1, 1] == pytest.approx(0.05, abs=2e-3)
    ball = "{name: ball, body: {shape: sphere, radius: 0.1, collide: all}, at: [0, 1.5]}"
    take = simulate(scene_of(lower, ball, lift))
    _, p = pose(take, "ball")
    assert p[-1, 2] > 2.0
    assert ("ball", "crate") in {(contact.performer, contact.other) for contact in take.contacts}


def test_only_a_kick_that_was_ordered_sets_a_prop_free() -> None:
    prop = "{name: ball, prop: {shape: ball, radius: 0.1}, at: [0, 1, 0], falls: 50}"
    simulation = Simulation(scene_of(prop))
    troupe = colliders(simulation)
    (guide,) = troupe.guided.guides
    push, none = np.array([[2.0, 1.0, 0.0]]), np.zeros((1, 3))
    troupe.push_solids(push, none)
    simulation.step()
    simulation.last_row()
    assert guide.state is GuideState.ON_PATH
    assert not troupe.solid_motion().gives_way[0]
    troupe.read({"kid": [Kick(kick="ball")]})
    troupe.push_solids(none, none)
    assert guide.state is GuideState.ON_PATH
    assert troupe.solid_motion().gives_way[0]
    troupe.push_solids(push, none)
    assert guide.state is GuideState.FREE
    simulation.step()
    simulation.last_row()
    mass = troupe.bodies[0].model.mass.mass
    assert mass == pytest.approx(600 * 4 / 3 * np.pi * 1e-3)
    v = troupe.solid_motion().v[0]
    assert v[0] == pytest.approx(2.0 / mass, rel=0.05)
    assert v[1] == pytest.approx(1.0 / mass - GRAVITY / ROW_RATE, rel=0.05)


def test_a_prop_that_falls_looks_as_one_that_does_not() -> None:
    prop = "name: cone, prop: {shape: cone, radius: 0.2, height: 0.5}, at: [1, 2], heading_deg: 30"
    still, falling = (simulate(scene_of(f"{{{prop}{more}}}")) for more in ("", ", falls: 50"))
    for one, other in zip(still.meshes, falling.meshes, strict=True):
        np.testing.assert_array_equal(one.vertices, other.vertices)
        np.testing.assert_array_equal(one.faces, other.faces)
    assert still.parts == falling.parts
    assert still.nodes == falling.nodes
    for one, other in zip(pose(still, "cone"), pose(falling, "cone"), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


EVENTS = ("fell: pot", "at_rest: pot", "near: [pot, bug], within: 0.9", "touch: [pot, shelf]")


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("event", EVENTS)
def test_falling_props_are_events(event: str) -> None:
    pot = "{name: pot, prop: {shape: cylinder}, at: [0, 2, 0], falls: 0.25}"
    shelf = "{name: shelf, prop: {shape: box, size: [0.5, 0.1, 0.5]}, at: [0, 0.05, 0]}"
    script = f"script: [{{when: {{{event}}}, who: bug, do: {{look_at: pot}}}}]"
    bug = "{name: bug, figure: beetle, at: [1.6, 0], walk: {speed: 0.1}}"
    take = simulate(scene_of(pot, shelf, bug, duration=3, more=script))
    (order,) = take.orders
    assert order.outcome == "done"
    assert order.step > 24


@pytest.mark.parametrize(
    ("cast", "message", "path"),
    [
        (
            ["{name: a, prop: {shape: ball}, parent: b, falls: 1}",
             "{name: b, prop: {shape: ball}, parent: a, falls: 1, at: [5, 0]}"],
            "form a ring", "cast[0]",
        ),
        (["{name: a, prop: {shape: ball}, falls: 1, held: [{by: b.tip, at: 1}]}",
          "{name: b, figure: beetle}"], "no part 'tip'", "cast[0].held[0].by"),
        (
            ["{name: a, prop: {shape: ball}, falls: 1}",
             "{name: b, prop: {shape: ball}, parent: a}",
             "{name: c, prop: {shape: ball}, parent: b, falls: 1}"],
            "'b' goes with a body itself", "cast[2].parent",
        ),
        (["{name: a, body: {shape: sphere, soft: 0.1}, held: [{by: b, at: 1}]}",
          "{name: b, prop: {shape: ball}}"], "conflicts with soft", "cast[0].held"),
        (["{name: a, body: {shape: sphere}, held: [{by: b, at: 1}, {by: b, at: 2}]}",
          "{name: b, prop: {shape: ball}}"], "still holds it", "cast[0].held[1].at"),
    ],
)  # fmt: skip
def test_what_cannot_be_held_is_refused(cast: list[str], message: str, path: str) -> None:
    with pytest.raises(SceneError, match=re.escape(message)) as caught:
        Simulation(scene_of(*cast))
    (problem,) = caught.value.problems
    assert problem.path == path
    assert problem.line > 0


def test_hands_hold_no_prop_whose_size_changes() -> None:
    prop = "{name: a, prop: {shape: ball}, keyframes: [{at: 0, scale: 1}, {at: 1, scale: 2}]}"
    order = "script: [{at: 1, who: kid, do: {grab: a}}]"
    with pytest.raises(SceneError, match="hands hold what has one size"):
        scene_of(prop, "{name: kid, character: child}", more=order)


def test_a_directed_scene_with_people_lets_them_take_what_goes_with_nothing() -> None:
    names = {"table": "{shape: box}, at: [3, 0]", "lone": "{shape: ball}, at: [5, 0]"}
    cast = [f"{{name: {name}, prop: {keys}}}" for name, keys in names.items()]
    cup = "{name: cup, prop: {shape: ball}, parent: table, at: [0, 0.5, 0]}"
    body = "{name: soft, body: {shape: sphere, soft: 0.1}, at: [7, 0]}"
    scene = scene_of(*cast, cup, body, "{name: kid, character: child}")
    assert handled_members(scene, directed=False) == frozenset()
    simulation = Simulation(scene, directed=True)
    assert [one.name for one in colliders(simulation).bodies] == ["lone", "soft"]
    (note,) = simulation.recorder.notes
    assert (note.kind, note.part) == ("rigid", "soft")
    order = {"at": 1, "who": "kid"}
    simulation.add_instruction(Instruction(**order, do={"kick": "lone"}))
    with pytest.raises(SceneError, match="'cup' goes with others"):
        simulation.add_instruction(Instruction(**order, do={"grab": "cup"}))


def test_what_orders_name_is_simulated_as_bodies() -> None:
    ball = "{name: ball, prop: {shape: ball}, at: [3, 0]}"
    crate = "{name: crate, body: {shape: box}, at: [5, 0]}"
    wall = "{name: wall, many: {of: brick, rows: 2, columns: 2}, at: [7, 0]}"
    orders = "{do: {kick: ball}}", "{do: {carry: crate, to: [0, 0]}}", "{do: {grab: wall_2}}"
    script = ", ".join(order.replace("{", "{at: 1, who: kid, ", 1) for order in orders)
    kid = "{name: kid, character: child}"
    simulation = Simulation(scene_of(ball, crate, wall, kid, more=f"script: [{script}]"))
    troupe = colliders(simulation)
    guided = {troupe.bodies[guide.body].name for guide in troupe.guided.guides}
    assert guided == {"ball", "crate", "wall_2"}
    assert len(troupe.bodies) == 6
