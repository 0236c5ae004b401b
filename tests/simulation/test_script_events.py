"""Events that instructions wait for, and what becomes of orders."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.production.run.notes import take_notes
from pipeline.simulation.clock import Clock
from pipeline.simulation.convex_distance import convex_distance
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import read_scene

CLOCK = Clock(Fraction(24), 48)

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)


def take_of(cast: list[str], script: list[str], more: str = "", duration: float = 2.0) -> Take:
    lines = "".join(f"\n  - {line}" for line in cast)
    orders = "".join(f"\n  - {line}" for line in script)
    text = f"pronk: 1\nduration: {duration}\n{more}\ncast:{lines}\nscript:{orders}\n"
    return simulate(read_scene(text))


def given_at(take: Take, text: str) -> float:
    (step,) = [record.step for record in take.orders if record.text == text]
    return step / (take.header.steps * float(take.header.rate))


BUG = "{name: bug, figure: beetle, walk: {}}"


@pytest.mark.parametrize(
    ("offset", "distance"),
    [
        ((3.0, 0.0, 0.0), 2.0),
        ((2.0, 3.0, 0.0), np.hypot(1.0, 2.0)),
        ((2.0, 2.0, 2.0), np.sqrt(3.0)),
        ((0.5, 0.5, 0.5), 0.0),
    ],
)
def test_convex_distance_of_cubes(offset: tuple[float, ...], distance: float) -> None:
    assert convex_distance(CUBE, CUBE + offset) == pytest.approx(distance, abs=2e-5)


def test_convex_distance_of_edge_and_face_is_not_that_of_corners() -> None:
    edge = np.array([[0.2, 1.5, 0.5], [0.8, 2.5, 0.5]])
    assert convex_distance(CUBE, edge) == pytest.approx(0.5, abs=2e-5)


def test_near_happens_at_the_asked_distance() -> None:
    cast = [
        "{name: cart, prop: {shape: box, size: [1, 1, 1]}, at: [0, 0.5, 0], velocity: [1, 0, 0]}",
        "{name: post, prop: {shape: box, size: [1, 1, 1]}, at: [3, 0.5, 0]}",
        "{name: bug, figure: beetle, at: [0, 5], walk: {}}",
    ]
    script = ["{when: {near: [post, cart], within: 0.5}, who: bug, do: stop}"]
    # The surfaces are 2 m apart, and 0.5 m after 1.5 s.
    assert given_at(take_of(cast, script), "stop") == pytest.approx(1.5, abs=0.03)


def test_touch_of_two_props_is_an_event() -> None:
    cast = [
        "{name: cart, prop: {shape: box, size: [1, 1, 1]}, at: [0, 0.5, 0], velocity: [1, 0, 0]}",
        "{name: post, prop: {shape: box, size: [1, 1, 1]}, at: [2, 0.5, 0]}",
        "{name: bug, figure: beetle, at: [0, 5], walk: {}}",
    ]
    take = take_of(cast, ["{when: {touch: [cart, post]}, who: bug, do: stop}"])
    assert given_at(take, "stop") == pytest.approx(1.0, abs=0.03)


def test_prop_that_stops_comes_to_rest_once() -> None:
    keys = "[{at: 0, position: [0, 1, 0]}, {at: 1, position: [1, 1, 0], ease: linear}]"
    cast = [f"{{name: cart, prop: {{shape: box}}, keyframes: {keys}}}", BUG]
    script = ["{when: {at_rest: cart}, who: bug, do: stop}"]
    assert 1.2 < given_at(take_of(cast, script), "stop") < 1.4


def test_prop_that_sinks_has_fallen() -> None:
    keys = (
        "[{at: 0, position: [0, 2, 0]}, {at: 1, position: [0, 2, 0], ease: linear}, "
        "{at: 1.4, position: [0, 0.2, 0], ease: linear}]"
    )
    cast = [f"{{name: crate, prop: {{shape: box}}, keyframes: {keys}}}", BUG]
    take = take_of(cast, ["{when: {fell: crate}, who: bug, do: stop}"])
    assert 1.0 < given_at(take, "stop") < 1.2


@pytest.mark.nightly
def test_settling_is_no_coming_to_rest() -> None:
    # The crate drops by 1 cm, rests, and is kicked by the cart.
    cast = [
        "{name: crate, body: {shape: box, size: [0.4, 0.4, 0.4], collide: all}, at: [0, 0.21, 0]}",
        "{name: cart, prop: {shape: box, size: [1, 0.6, 1]}, at: [-2, 0.3, 0], "
        "keyframes: [{at: 0.8, position: [-2, 0.3, 0]}, "
        "{at: 1.8, position: [-0.4, 0.3, 0], ease: linear}]}",
        "{name: bug, figure: beetle, at: [0, 5], walk: {}}",
    ]
    script = ["{when: {at_rest: crate}, who: bug, do: stop}"]
    take = take_of(cast, script, "terrain: {kind: flat, size: [20, 20]}", duration=4.0)
    assert given_at(take, "stop") > 1.8


DOMINOES = (
    "{name: row, many: {layout: row, count: 3, spacing: 0.14, "
    "of: {shape: box, size: [0.03, 0.24, 0.12]}}}"
)
BALL = (
    "{name: ball, body: {shape: sphere, radius: 0.05, collide: all}, at: [-0.5, 0.2, 0], "
    "velocity: [2, 1, 0]}"
)


@pytest.mark.nightly
def test_events_of_many_bodies() -> None:
    cast = [DOMINOES, BALL, "{name: kid, figure: person, at: [0, 3], walk: {}}"]
    script = [
        "{when: {touch: [ball, row]}, who: kid, do: {wait: 1}}",
        "{when: {fell: row}, who: kid, do: {wait: 2}}",
        "{when: {fell: row_3}, who: kid, do: {wait: 3}}",
        "{when: {fell: row}, who: kid, do: {wait: 4}}",
        "{when: {fell: row}, who: kid, do: {wait: 5}}",
        "{when: {fell: row}, who: kid, do: {wait: 6}}",
        "{when: {at_rest: row}, who: kid, do: {wait: 7}}",
    ]
    take = take_of(cast, script, "terrain: flat", duration=4.0)
    touch, first, third, second, last, rest = (
        given_at(take, f"wait {n}") for n in (1, 2, 3, 4, 5, 7)
    )
    assert 0.0 < touch < first < second < last == third < rest
    (never,) = [order for order in take.orders if order.outcome == "never given"]
    assert (never.text, never.reason) == ("wait 6", "row never fell again")


@pytest.mark.slow
def test_order_that_waits_in_vain_is_noted() -> None:
    take = take_of(
        [BUG, "{name: post, prop: {shape: box}, at: [9, 9]}"],
        [
            "{when: {near: [bug, post]}, who: bug, do: stop}",
            "{at: 0.1, who: bug, do: {go_to: [50, 0]}}",
        ],
        "terrain: {kind: flat, size: [200, 200]}",
    )
    texts = {note.kind: note.text for note in take_notes(take, CLOCK)}
    assert "bug and post never came within 1 m" in texts["order_never_given"]
    assert texts["order_cut_off"] == "has not finished go_to [50, 0] at the end of the film"


def test_a_script_goes_on_after_an_order_of_the_awaited_kind_fails() -> None:
    cast = [
        "{name: kid, character: child}",
        "{name: rock, body: {shape: box, size: [0.6, 0.6, 0.6]}, at: [2, 0.3, 0]}",
        "{name: pal, character: child, at: [0, 2]}",
    ]
    script = [
        "{at: 0.2, who: kid, do: {grab: rock}}",
        "{when: {failed: kid, act: hug}, who: pal, do: sit}",
        "{when: {failed: kid, act: grab}, who: pal, do: freeze}",
        "{when: {failed: kid}, who: kid, do: stand}",
    ]
    take = take_of(cast, script, "terrain: flat", duration=1.0)
    outcomes = {record.text: record for record in take.orders}
    assert outcomes["grab rock"].outcome == "given up"
    assert outcomes["freeze"].step == outcomes["stand"].step == outcomes["grab rock"].end
    assert outcomes["sit"].outcome == "never given"
    assert outcomes["sit"].reason == "kid never failed to hug"


def test_finished_order_is_done_and_leaves_no_note() -> None:
    take = take_of([BUG], ["{at: 0.1, who: bug, do: {go_to: [1.2, 0]}}"], duration=6.0)
    (record,) = take.orders
    assert record.outcome == "done"
    assert record.end > record.step
    assert not take_notes(take, CLOCK)


@pytest.mark.nightly
def test_jumps_replace_no_order_and_are_done_one_after_the_other() -> None:
    cast = [
        "{name: roo, figure: hopper, scale: 0.5, pronk: {jumps: 1, height: 0.1}}",
        "{name: mare, figure: horse, scale: 0.3, at: [0, 4], walk: {}}",
    ]
    script = [
        "{at: 0.5, who: roo, do: {jump: {distance: 0.2, height: 0.1}}}",
        "{at: 0.5, who: roo, do: {jump: {distance: 0.3, height: 0.1}}}",
        "{at: 0.1, who: mare, do: {go_to: [9, 4]}}",
        "{at: 0.2, who: mare, do: {jump: {height: 0.1}}}",
        "{at: 0.3, who: mare, do: stop}",
    ]
    take = take_of(cast, script, "terrain: flat", duration=3.5)
    outcomes = {record.text: record.outcome for record in take.orders if record.who == "roo"}
    assert list(outcomes.values()) == ["done", "done"]
    assert [r.outcome for r in take.orders if r.who == "mare"] == ["replaced", "replaced", "begun"]


def test_orders_to_a_hopper_do_not_wait_for_its_own_start() -> None:
    cast = ["{name: roo, figure: hopper, scale: 0.5, pronk: {start: 3, height: 0.1}}"]
    script = ["{at: 0.5, who: roo, do: {jump: {distance: 0.3, height: 0.1}}}"]
    take = take_of(cast, script, "terrain: flat", duration=3.6)
    rows = 96
    x = take.positions[:, 0, 0]
    (record,) = take.orders
    assert record.outcome == "done"
    assert record.end < 2 * rows
    assert np.ptp(x[2 * rows : 3 * rows]) < 1e-6 < np.ptp(x[3 * rows :])


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("{when: {near: [bug, bug]}, who: bug, do: stop}", "cannot come near itself"),
        ("{when: {fell: nobody}, who: bug, do: stop}", "nobody in the cast is called 'nobody'"),
        ("{when: {touch: [bug, post], within: 2}, who: bug, do: stop}", "belongs to near"),
        ("{when: {arrived: bug, act: chase}, who: bug, do: stop}", "belongs to failed"),
        ("{when: {failed: bugg}, who: bug, do: stop}", "did you mean 'bug'"),
        ("{when: {failed: post}, who: bug, do: stop}", "people can carry, throw or kick it"),
        ("{when: {failed: bug, act: hug}, who: bug, do: stop}", "for which hug is no order"),
        ("{when: {failed: bug, act: chace}, who: bug, do: stop}", "did you mean 'chase'"),
        ("{at: 0, who: post, do: stop}", "people can carry, throw or kick it"),
        (
            "{at: 0, who: bug, do: {sit: post}}",
            "for which sit is no order; write go_to, follow, chase",
        ),
        (
            "{at: 0, who: bug, do: {grab: post}}",
            r"for which grab is no order; write `pose: .* \(`pronk figure beetle` lists its limbs",
        ),
        (
            "{at: 0, who: arm, do: {reach: post}}",
            r"'arm' is a creature, and no order moves its limbs; write `pose: ",
        ),
        ("{at: 0, who: bug, do: {chase: bug}}", "cannot do that to itself"),
        ("{at: 0, who: bug, do: {go_to: gat}}", "did you mean 'gate'"),
        ("{at: 0, who: bug, do: {go_to: post.top}}", r"do\.go_to: 'post' has no part 'top'"),
        ("{when: {near: [bug, post.top]}, who: bug, do: stop}", r"near\[1\]: 'post' has no part"),
    ],
)
def test_impossible_conditions_and_orders_are_refused(script: str, message: str) -> None:
    arm = "{name: arm, figure: robot_arm, at: [-4, 0]}"
    cast = [BUG, arm, "{name: post, prop: {shape: box}, at: [9, 9]}"]
    with pytest.raises(SceneError, match=message):
        take_of(cast, [script], "places: {gate: [1, 2]}")


def test_one_of_many_bodies_is_a_target() -> None:
    cast = [BUG, "{name: wall, many: {of: brick, rows: 1, columns: 2}, at: [1.5, 0]}"]
    take = take_of(cast, ["{at: 0.1, who: bug, do: {go_to: wall_1}}"], duration=6.0)
    assert [order.outcome for order in take.orders] == ["done"]


CHILD = "{name: kid, character: child, at: [0.8, 0.1], heading_deg: 180}"


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    "ball",
    [
        "{name: ball, prop: {shape: ball, radius: 0.06}, at: [0, 0.06, 0]}",
        "{name: ball, character: ball, scale: 0.2, at: [0, 0]}",
    ],
    ids=["prop", "character"],
)
def test_hands_that_close_around_something_touch_it(ball: str) -> None:
    orders = [
        "{at: 0, who: kid, do: {grab: ball}}",
        "{when: {near: [kid, ball], within: 0.15}, who: kid, do: {look_at: ball}}",
        "{when: {touch: [kid, ball]}, who: kid, do: {look_at: [3, 1, 0]}}",
    ]
    take = take_of([ball, CHILD], orders, duration=4.0)
    near, touch = given_at(take, "look_at ball"), given_at(take, "look_at [3, 1, 0]")
    (grab,) = [order for order in take.orders if order.text == "grab ball"]
    assert grab.outcome == "done"
    # The hand comes near before it closes, while the trunk is farther away.
    assert 1.0 < near < touch < 4.0
