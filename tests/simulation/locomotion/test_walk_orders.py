"""Walk orders: paths through waypoints, and orders of a script."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene
from tests.simulation.conftest import Walk, scene_of, walk_through

pytestmark = pytest.mark.slow

ROW = 1 / 96

BEETLE = "{{name: b, figure: beetle, scale: 0.6, at: [0, 0], {}}}"


def walk_with_orders(options: str, script: str = "", duration: float = 6) -> Walk:
    """Return a beetle's walk."""
    more = f"script: [{script}]" if script else ""
    return walk_through(scene_of(BEETLE.format(options), duration=duration, more=more))


def positions(walk: Walk) -> Array:
    """Return the positions of the body on the plane (K, 2) [m]."""
    i = [node.name for node in walk.take.nodes].index("b.body")
    return walk.take.positions[:, i][:, [0, 2]]


def headings(walk: Walk) -> Array:
    """Return the headings of the body (K,) [rad], continuous."""
    R = walk.simulation.recorder.rotations[:, 0]
    return np.unwrap(np.arctan2(-R[:, 2, 0], R[:, 0, 0]))


def speeds(walk: Walk) -> Array:
    """Return the speeds of the body (K - 1,) [m/s]."""
    return np.linalg.norm(np.diff(positions(walk), axis=0), axis=-1) / ROW


def test_walk_passes_its_waypoints_and_ends_with_closed_feet() -> None:
    waypoints = [[1.2, 0.2], [1.8, 1.2], [1.0, 1.8]]
    walk = walk_with_orders(f"walk: {{path: {waypoints}}}", duration=8)
    p = positions(walk)
    for waypoint in waypoints:
        assert np.linalg.norm(p - waypoint, axis=-1).min() < 0.02
    np.testing.assert_allclose(p[-1], waypoints[-1], atol=1e-6)
    assert speeds(walk)[-10:].max() == 0.0
    assert walk.standing[-1].all()
    walkers = walk.walkers
    for leg, tip in enumerate(walk.tips[-1]):
        rest = walkers.sequencer.planner.search.neutral_place(
            leg, float(walkers.travelled[0]), float(walkers.phase[0])
        )
        assert np.linalg.norm(tip[[0, 2]] - rest) < 0.1 * walkers.herd.legs.lengths[leg]
    # Slowing down causes no jolt.
    assert np.abs(np.diff(speeds(walk))).max() / ROW < 6.0


def test_body_heads_along_its_route() -> None:
    walk = walk_with_orders("walk: {path: [[1.2, 0.2], [1.8, 1.2], [1.0, 1.8]]}", duration=4)
    way = np.diff(positions(walk), axis=0)
    moves = np.linalg.norm(way, axis=-1) > 1e-3
    ahead = np.unwrap(np.arctan2(-way[moves, 1], way[moves, 0]))
    assert np.abs(np.degrees(ahead - headings(walk)[:-1][moves])).max() < 4.0


@pytest.mark.nightly
def test_walk_goes_back_and_forth() -> None:
    walk = walk_with_orders("walk: {path: [[0.8, 0]], repeat: back and forth}", duration=13)
    x = positions(walk)[:, 0]
    assert x.max() == pytest.approx(0.8, abs=0.01)
    turns = np.flatnonzero(np.abs(x - 0.8) < 1e-3)
    assert x[turns[-1] :].min() < 0.05
    assert np.abs(headings(walk)).max() > np.pi - 0.05


def test_walker_turns_in_place_at_a_sharp_corner() -> None:
    walk = walk_with_orders("walk: {path: [[0.8, 0], [0.1, 0.1]]}", duration=10)
    assert np.linalg.norm(positions(walk) - [0.8, 0], axis=-1).min() < 1e-3
    np.testing.assert_allclose(positions(walk)[-1], [0.1, 0.1], atol=1e-6)
    assert np.abs(np.diff(headings(walk))).max() / ROW < 2.0


def test_walk_follows_a_loop() -> None:
    walk = walk_with_orders(
        "walk: {path: [[0.8, 0], [0.8, 0.8], [0, 0.8]], repeat: loop}", duration=10
    )
    p = positions(walk)
    home = np.linalg.norm(p, axis=-1) < 0.05
    assert (np.diff(np.flatnonzero(home)) > 100).sum() >= 1
    # Slowly round the corners, which are narrower than the beetle is long.
    assert speeds(walk)[96:].min() > 0.1


def test_standing_feet_do_not_slip_on_curves() -> None:
    walk = walk_with_orders(
        "walk: {path: [[0.8, 0], [0.8, 0.8], [0, 0.8]], repeat: loop}", duration=5
    )
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)
    assert moved[walk.standing[1:] & walk.standing[:-1]].max() < 1e-6
    assert walk.standing.sum(axis=1).min() >= 3


def test_go_to_is_followed_by_the_order_on_arrival() -> None:
    script = (
        "{at: 0.5, who: b, do: {go_to: [1, 0.6]}},"
        " {when: {arrived: b}, who: b, do: {go_to: [0.2, 0.9]}}"
    )
    walk = walk_with_orders("walk: {}", script, duration=14)
    p = positions(walk)
    first = int(np.linalg.norm(p - [1, 0.6], axis=-1).argmin())
    np.testing.assert_allclose(p[first], [1, 0.6], atol=1e-3)
    np.testing.assert_allclose(p[-1], [0.2, 0.9], atol=1e-6)


@pytest.mark.nightly
def test_orders_for_one_event_are_queued() -> None:
    script = (
        "{at: 0, who: b, do: {go_to: [0.6, 0]}},"
        " {when: {arrived: b}, who: b, do: {go_to: [1.0, 0.3]}},"
        " {when: {arrived: b}, who: b, do: {go_to: [1.6, 0.3]}}"
    )
    p = positions(walk_with_orders("walk: {}", script, duration=12))
    first, second = (
        int(np.linalg.norm(p - goal, axis=-1).argmin()) for goal in ([0.6, 0], [1.0, 0.3])
    )
    np.testing.assert_allclose(p[[first, second, -1]], [[0.6, 0], [1, 0.3], [1.6, 0.3]], atol=2e-3)
    assert first < second


def test_stop_and_wait_pause_the_walk() -> None:
    walk = walk_with_orders("walk: {}", "{at: 1, who: b, do: {wait: 2}}", duration=6)
    v = speeds(walk)
    assert v[192:280].max() == 0.0
    assert v[-1] > 0.9 * v[48:90].mean()
    stopped = walk_with_orders("walk: {}", "{at: 1, who: b, do: stop}", duration=5)
    assert speeds(stopped)[192:].max() == 0.0


@pytest.mark.nightly
@pytest.mark.parametrize("angle", [90, -60])
def test_turn_order_turns_by_its_angle(angle: int) -> None:
    walking = walk_with_orders(
        "walk: {}", f"{{at: 0.5, who: b, do: {{turn_deg: {angle}}}}}", duration=8
    )
    assert np.degrees(headings(walking)[-1]) == pytest.approx(angle, abs=1.0)
    standing = walk_with_orders(
        "walk: {}",
        f"{{at: 0, who: b, do: stop}}, {{when: {{arrived: b}}, who: b, do: {{turn_deg: {angle}}}}}",
    )
    assert np.degrees(headings(standing)[-1]) == pytest.approx(angle, abs=1.0)
    assert np.linalg.norm(positions(standing)[-1] - positions(standing)[250]) < 1e-6


@pytest.mark.nightly
@pytest.mark.parametrize(
    "figure", [pytest.param("horse", marks=pytest.mark.nightly), "antelope", "person", "spider"]
)
def test_every_foot_follows_at_a_restart(figure: str) -> None:
    """A body that sinks after a restart is pulled down by a foot left behind."""
    script = "script:\n- {at: 1, who: b, do: stop}\n- {at: 3.2, who: b, do: walk}\n"
    cast = f"cast: [{{name: b, figure: {figure}, walk: {{}}}}]\n"
    take = simulate(read_scene(f"pronk: 1\nduration: 7\nterrain: flat\n{cast}{script}"))
    height = take.positions[:, 0, 1]
    assert height.min() > 0.9 * np.median(height[:96])
    assert not take.notes
    assert take.positions[-1, 0, 0] > take.positions[300, 0, 0] + 0.5


@pytest.mark.parametrize(
    ("figure", "times"),
    [
        ("spider", (1.6,)),
        ("person", (1.6,)),
        pytest.param("spider", np.arange(1.1, 3.7, 0.1), marks=pytest.mark.nightly),
        pytest.param("horse", np.arange(1.1, 3.7, 0.1), marks=pytest.mark.nightly),
        pytest.param("person", np.arange(1.1, 3.7, 0.1), marks=pytest.mark.nightly),
    ],
)
def test_no_foot_is_left_behind_while_others_close_up(figure: str, times: Sequence[float]) -> None:
    """Feet that were placed for a body that brakes hold one back that goes on."""
    cast, script = "", ""
    for i, time in enumerate(times):
        cast += (
            f"- {{name: b{i}, figure: {figure}, at: [0, {5 * i - 2 * len(times)}], walk: {{}}}}\n"
        )
        script += f"- {{at: 1, who: b{i}, do: stop}}\n- {{at: {time:.2f}, who: b{i}, do: walk}}\n"
    end = max(times) + 1.5
    terrain = f"{{kind: flat, size: [{12 * len(times)}, {12 * len(times)}]}}"
    text = f"pronk: 1\nduration: {end}\nterrain: {terrain}\ncast:\n{cast}script:\n{script}"
    take = simulate(read_scene(text))
    owners = [node.name.split(".")[0] for node in take.nodes]
    height = take.positions[:, [owners.index(f"b{i}") for i in range(len(times))], 1]
    assert (height.min(axis=0) > 0.8 * np.median(height[:96], axis=0)).all()
    assert not take.notes


def test_speed_order_changes_the_speed() -> None:
    walk = walk_with_orders("walk: {speed: 0.5}", "{at: 1, who: b, do: {speed: 0.3}}", duration=4)
    v = speeds(walk)
    assert v[40:90].mean() == pytest.approx(0.5, rel=0.02)
    assert v[-60:].mean() == pytest.approx(0.3, rel=0.02)


@pytest.mark.parametrize(("faster", "going"), [(0.4, 0.2), (0.2, 0.4)])
def test_speed_order_holds_on_the_way_to_a_place(faster: float, going: float) -> None:
    script = (
        f"{{at: {faster}, who: b, do: {{speed: 0.6}}}},"
        f" {{at: {going}, who: b, do: {{go_to: [9, 0]}}}}"
    )
    v = speeds(walk_with_orders("walk: {speed: 0.4}", script, duration=3))
    assert v[-40:] == pytest.approx(0.6, rel=0.01)


@pytest.mark.nightly
def test_speed_order_holds_in_another_mood() -> None:
    script = "{at: 0.1, who: b, do: {speed: 0.3}}, {at: 0.4, who: b, do: {mood: {}}}"
    v = speeds(walk_with_orders("walk: {}", script, duration=1.8))
    assert v[-40:] == pytest.approx(0.3, rel=0.01)


def test_speed_order_is_followed_up_to_a_run() -> None:
    walk = walk_with_orders("walk: {speed: 0.6}", "{at: 0, who: b, do: {speed: 2.5}}", duration=4)
    assert speeds(walk)[-40:] == pytest.approx(2.5, rel=0.01)
    assert not walk.take.notes


def test_speed_that_is_not_reached_is_told() -> None:
    walk = walk_with_orders("walk: {}", "{at: 0, who: b, do: {speed: 900}}", duration=0.1)
    (note,) = [note.text for note in walk.take.notes if note.text.startswith("goes at")]
    progress = walk.walkers.progress
    wanted = float(progress.requested_fraction[0]) * progress.paces.last(0).speed
    assert note.startswith(f"goes at {wanted:.3g} m/s")
    assert "instead of 900" in note


@pytest.mark.parametrize(
    ("options", "script", "message"),
    [
        ("walk: {}", "{at: 1, who: x, do: stop}", "nobody in the cast is called 'x'"),
        ("heading_deg: 0", "{at: 1, who: b, do: stop}", "'b' neither walks nor hops"),
        ("walk: {}", "{who: b, do: stop}", "should have either at or when"),
        ("walk: {}", "{at: 1, when: {arrived: b}, who: b, do: stop}", "either at or when"),
        ("walk: {}", "{at: 1, who: b, do: {go_too: [0, 0]}}", "did you mean 'go_to'"),
        ("walk: {}", "{at: 1, who: b, do: halt}", "halt"),
        ("walk: {path: [[1, 1], [1, 1]]}", "", "repeats the place before it"),
        ("walk: {repeat: loop}", "", "needs a path"),
        ("walk: {path: [[1]]}", "", "must hold 2 values"),
    ],
)
def test_invalid_orders_are_refused(options: str, script: str, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        walk_with_orders(options, script)
    assert all(problem.line > 0 for problem in caught.value.problems)


def test_inchworm_refuses_script_and_path() -> None:
    worm = "{name: w, figure: inchworm, walk: {}}"
    with pytest.raises(SceneError, match="follows no script"):
        Simulation(scene_of(worm, more="script: [{at: 1, who: w, do: stop}]"))
    with pytest.raises(SceneError, match="path"):
        Simulation(scene_of(worm.replace("walk: {}", "walk: {path: [[1, 1]]}")))


@pytest.mark.nightly
@pytest.mark.parametrize("place", [(2, 0.3), (1, 2), (0.6, -2), (-2, 0.5), (1.2, 0.4), (-1, 0)])
def test_feet_do_not_slip_on_the_way_to_any_place(place: tuple[float, float]) -> None:
    script = f"{{at: 1.2, who: b, do: {{go_to: {list(place)}}}}},"
    walk = walk_with_orders("walk: {}", script, duration=14)
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)
    assert moved[walk.standing[1:] & walk.standing[:-1]].max() < 1e-6
    assert not walk.take.notes
    assert np.abs(np.diff(walk.take.positions[:, 0], 2, axis=0)).max() / ROW**2 < 30.0
    np.testing.assert_allclose(positions(walk)[-1], place, atol=1e-6)
