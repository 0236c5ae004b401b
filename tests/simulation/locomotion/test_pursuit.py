"""Creatures that go to, follow, chase, flee from and avoid members of the cast."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import read_scene

SCENE = """
pronk: 1
duration: {duration}
terrain: {{kind: flat, size: [60, 60]}}
places: {{gate: [4, 2]}}
cast:
  - {{name: bug, figure: beetle, scale: 0.5, walk: {{}}}}
  - {{name: cart, prop: {{shape: box, size: [0.6, 0.4, 0.4]}}, {cart}}}
script:
  - {{at: 0.2, who: bug, do: {order}}}
"""


def take_of(order: str, cart: str = "at: [3, 0.2, 2]", duration: float = 12.0) -> Take:
    return simulate(read_scene(SCENE.format(order=order, cart=cart, duration=duration)))


def distances(take: Take, other: str = "cart") -> np.ndarray:
    """Returns the distance between the middles of bug and another, at every row [m]."""
    names = NodeNames.of(take)
    nodes = [names.find(name) for name in ("bug", other)]
    apart = take.positions[:, nodes[0]] - take.positions[:, nodes[1]]
    return np.hypot(apart[:, 0], apart[:, 2])


def outcome_of(take: Take) -> tuple[str, str]:
    (record,) = take.orders
    return record.outcome, record.reason


@pytest.mark.nightly
def test_go_to_a_member_stops_beside_it() -> None:
    take = take_of("{go_to: cart}")
    assert outcome_of(take)[0] == "done"
    apart = distances(take)
    # Half the cart and half the stance lie between the middles.
    assert 0.5 < apart[-1] < 1.4
    assert np.ptp(apart[-48:]) < 0.02


@pytest.mark.nightly
def test_go_to_keeps_the_asked_gap() -> None:
    near, far = (distances(take_of(f"{{go_to: cart, gap: {gap}}}"))[-1] for gap in (0.1, 0.9))
    assert far - near == pytest.approx(0.8, abs=0.15)


@pytest.mark.nightly
def test_go_to_a_place_by_name() -> None:
    take = take_of("{go_to: gate}")
    assert outcome_of(take)[0] == "done"
    at = take.positions[-1, NodeNames.of(take).find("bug")]
    assert np.hypot(at[0] - 4.0, at[2] - 2.0) < 0.9


@pytest.mark.nightly
def test_go_to_a_member_that_moves_goes_after_it() -> None:
    take = take_of("{go_to: cart}", "at: [1.5, 0.2, 1], velocity: [0.1, 0, 0]", 16.0)
    assert outcome_of(take)[0] == "done"
    assert distances(take).min() < 1.4


@pytest.mark.nightly
def test_follower_keeps_its_distance_from_who_walks_on() -> None:
    take = take_of("{follow: cart, gap: 0.5}", "at: [2, 0.2, 1], velocity: [0.15, 0, 0]", 20.0)
    assert outcome_of(take)[0] == "begun"
    assert np.all((distances(take)[-96:] > 0.8) & (distances(take)[-96:] < 2.4))


@pytest.mark.nightly
def test_chaser_catches_who_is_slower() -> None:
    take = take_of("{chase: cart}", "at: [2, 0.2, 1], velocity: [0.1, 0, 0]", 20.0)
    assert outcome_of(take)[0] == "done"


@pytest.mark.nightly
def test_chaser_of_who_is_faster_gives_up_with_a_note() -> None:
    take = take_of("{chase: cart}", "at: [2, 0.2, 1], velocity: [2, 0, 0]")
    outcome, reason = outcome_of(take)
    assert outcome == "given up"
    assert "is not fast enough" in reason


@pytest.mark.nightly
def test_flight_ends_far_enough_away() -> None:
    take = take_of("{flee: cart, distance: 3}", "at: [0.8, 0.2, 0.3]", 16.0)
    assert outcome_of(take)[0] == "done"
    assert distances(take)[-1] > 3.0


@pytest.mark.nightly
def test_who_avoids_something_steps_away_and_stays_there() -> None:
    take = take_of("{avoid: cart, distance: 1.5}", "at: [0.8, 0.2, 0.3]", 16.0)
    apart = distances(take)
    assert apart[0] < 1.0
    assert apart[-1] > 1.8


PASSING = """
pronk: 1
duration: 9
terrain: flat
cast:
  - {name: bug, figure: beetle, scale: 0.3, walk: {speed: 0.6}}
  - name: cart
    prop: {shape: box, size: [0.3, 0.4, 0.3]}
    keyframes:
      - {at: 0, position: [1.4, 0.2, -1.5]}
      - {at: 4, position: [1.4, 0.2, 3], ease: linear}
script:
  - {at: 0, who: bug, do: {go_to: [2.5, 0]}}
  - {at: 0, who: bug, do: {avoid: cart, distance: 0.3}}
"""


@pytest.mark.nightly
def test_who_avoids_something_that_passes_goes_on_to_its_goal() -> None:
    take = simulate(read_scene(PASSING))
    bug = take.positions[:, NodeNames.of(take).find("bug")][:, [0, 2]]
    going = next(record for record in take.orders if record.text == "go_to [2.5, 0]")
    assert going.outcome == "done"
    assert np.hypot(*(bug[-1] - [2.5, 0.0])) < 0.05
    # It stepped aside on its way, which is no arrival.
    assert bug[:, 1].max() > 0.2
    per_row = take.header.steps // take.header.samples
    assert np.hypot(*(bug[going.end // per_row] - [2.5, 0.0])) < 0.05


ROWS_PER_SECOND = 96

CART = "prop: {shape: box, size: [0.3, 0.3, 0.3]}"

AT_REST = "{at: 0, position: [9, 0.15, 0]}"

PURSUER = """
pronk: 1
duration: {duration}
terrain: {{kind: flat, size: [60, 60]}}
cast:
  - {{name: bug, figure: {figure}, walk: {walk}}}
{others}
script:
{script}
"""


def speeds_of(take: Take) -> np.ndarray:
    """Returns the speed of bug over the ground between rows [m/s]."""
    at = take.positions[:, NodeNames.of(take).find("bug")][:, [0, 2]]
    return np.hypot(*np.diff(at, axis=0).T) * ROWS_PER_SECOND


def pursuit_of(
    *orders: str,
    walk: str = "{}",
    figure: str = "beetle",
    keyframes: str = "",
    duration: float = 3.0,
) -> Take:
    script = "".join(f"  - {{who: bug, {order}}}\n" for order in orders)
    others = f"  - {{name: cart, {CART}, keyframes: [{keyframes}]}}" if keyframes else ""
    text = PURSUER.format(figure=figure, walk=walk, others=others, duration=duration, script=script)
    return simulate(read_scene(text))


@pytest.mark.slow
@pytest.mark.parametrize("walk", ["{speed: 0.5}", "{}"])
def test_who_flees_hurries(walk: str) -> None:
    take = pursuit_of("at: 0, do: {flee: [-1, 0, 0], distance: 9}", walk=walk)
    # As fast as cockroaches that hurry, whatever its walk was.
    assert speeds_of(take)[-1] == pytest.approx(2.93, abs=0.02)


@pytest.mark.nightly
@pytest.mark.parametrize("walk", ["{speed: 0.5}", "{}"])
def test_who_chases_hurries(walk: str) -> None:
    take = pursuit_of("at: 0, do: {chase: cart}", walk=walk, keyframes=AT_REST)
    assert speeds_of(take).max() == pytest.approx(2.93, abs=0.02)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("order", "at"),
    [
        ("{speed: 0.5}", 0.2),
        pytest.param("{speed: 0.5}", 1.2, marks=pytest.mark.nightly),
        pytest.param("{gait: tripod, speed: 0.5}", 0.2, marks=pytest.mark.nightly),
        pytest.param("{gait: tripod, speed: 0.5}", 1.2, marks=pytest.mark.nightly),
    ],
)
def test_speed_given_with_a_flight_or_after_it_holds(order: str, at: float) -> None:
    flight = "at: 0.2, do: {flee: [-1, 0, 0], distance: 9}"
    for orders in ((flight, f"at: {at}, do: {order}"), (f"at: {at}, do: {order}", flight)):
        # A change of gait takes two and a half cycles.
        duration = 1.5 if at == 0.2 and "gait" not in order else 4.0
        speeds = speeds_of(pursuit_of(*orders, walk="{speed: 0.6}", duration=duration))
        assert speeds[-10:] == pytest.approx(0.5, abs=0.05)
        assert at > 0.2 or speeds.max() < 0.62


@pytest.mark.nightly
def test_speed_before_a_flight_holds_again_after_it() -> None:
    orders = "at: 0, do: {speed: 0.5}", "at: 0.2, do: {flee: [0, 0, 0], distance: 1.5}"
    take = pursuit_of(*orders, "at: 4, do: {go_to: [9, 0]}", duration=6)
    speeds = speeds_of(take)
    assert speeds.max() > 1.0
    assert speeds[-10:] == pytest.approx(0.5, abs=0.02)


@pytest.mark.nightly
def test_who_goes_to_something_that_comes_near_stops_before_it() -> None:
    # At 3 m/s it would be behind the horse within the second that is foreseen.
    keyframes = "{at: 0, position: [6, 0.15, 0]}, {at: 1, position: [3, 0.15, 0], ease: linear}"
    take = pursuit_of("at: 0.2, do: {go_to: cart}", figure="horse", keyframes=keyframes, duration=5)
    assert outcome_of(take)[0] == "done"
    assert np.diff(distances(take)).max() < 1e-6
    assert 0.5 < distances(take)[-1] < 1.5


@pytest.mark.nightly
@pytest.mark.parametrize("order", ["go_to", "chase"])
@pytest.mark.parametrize("figure", ["beetle", "horse"])
def test_nobody_turns_away_from_what_comes_near(order: str, figure: str) -> None:
    keyframes = (
        "{at: 0, position: [9, 0.15, 0]}, {at: 2, position: [9, 0.15, 0]}, "
        "{at: 3, position: [6, 0.15, 0], ease: linear}"
    )
    take = pursuit_of(
        f"at: 2.2, do: {{{order}: cart}}", figure=figure, keyframes=keyframes, duration=8
    )
    assert outcome_of(take)[0] == "done"
    assert np.diff(take.positions[:, NodeNames.of(take).find("bug"), 0]).min() > -1e-6


@pytest.mark.nightly
def test_follower_that_is_near_enough_at_once_stops() -> None:
    keyframes = "{at: 0, position: [1.9, 0.15, 0]}"
    take = pursuit_of("at: 0, do: {follow: cart}", keyframes=keyframes, duration=1.5)
    assert speeds_of(take)[-10:].max() == 0.0
    assert distances(take)[-1] > 1.0


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("figure", "gait"), [("spider", "trot"), ("horse", "transverse gallop"), ("person", "run")]
)
def test_bodies_that_hurry_do_not_jerk_on_curves(figure: str, gait: str) -> None:
    for place in ([3, 0, 0], [2, 0, 2.5], [-1, 0, 2]):
        order = f"at: 1, do: {{flee: {place}, distance: 12}}"
        take = pursuit_of(order, walk=f"{{gait: {gait}}}", figure=figure, duration=4)
        at = take.positions[:, NodeNames.of(take).find("bug")]
        accelerations = np.diff(at, 2, axis=0) * ROWS_PER_SECOND**2
        assert np.abs(accelerations).max() < 60.0
