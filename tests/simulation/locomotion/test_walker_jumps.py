"""Walkers that jump over obstacles and walk on, and scripted orders of hoppers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.locomotion.leaping.walker_jumps import HANDOVER_TIME
from pipeline.simulation.locomotion.pronking.hurdle_jump import hurdle_profile
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array, heading, matrix
from pipeline.simulation.take import Take
from pipeline.spec import Scene, find_scene, load_scene
from pipeline.spec.prop import BoxShape, Prop
from tests.simulation.conftest import scene_of, tips_of
from tests.simulation.locomotion.hop_recorder import HopRecording, hop_through

pytestmark = pytest.mark.slow

MILLIMETRE = 1e-3

BOXES = {
    "antelope": (0.5, 0.55),
    "person": (0.3, 0.3),
    "beetle": (0.2, 0.2),
}
"""Length and height of each figure's box [m]."""

HARDEST = 60.0
"""Bound of the body's acceleration [m/s²]."""

QUICKEST = 40.0
"""Bound of the speed of leg joints [rad/s]."""

AT = 4.0
"""Place of the box [m]."""


def hurdle_scene(figure: str, length: float, high: float, duration: float = 14) -> Scene:
    """Return a scene of a walker that has an order to jump over a box."""
    return scene_of(
        f"{{name: a, figure: {figure}, walk: {{path: [[{AT + 4}, 0]]}}}}",
        f"{{name: box, prop: {{shape: box, size: [{length}, {high}, 3]}}, at: [{AT}, 0]}}",
        duration=duration,
        more="script: [{at: 0.5, who: a, do: {hop_over: box}}]",
    )


@dataclass
class Leap:
    """A walk with a jump, and its state at every step."""

    simulation: Simulation
    length: float
    high: float
    down: list[Array] = field(default_factory=list)
    stages: list[str] = field(default_factory=list)

    @property
    def walkers(self) -> WalkerTroupe:
        """The walking creatures."""
        return next(t for t in self.simulation.troupes if isinstance(t, WalkerTroupe))

    @property
    def take(self) -> Take:
        """The take of the simulation."""
        return self.simulation.take()

    def record_step(self) -> None:
        """Record the state of this step."""
        walkers = self.walkers
        trip = walkers.leaps.trips.get(0)
        leaping = trip is not None and trip.stage == "leaping" and trip.simulation is not None
        self.stages.append("walking" if trip is None else trip.stage)
        hopping = trip.simulation if trip is not None and leaping else None
        self.down.append(
            ~walkers.sequencer.feet.swinging if hopping is None else hopping.state.down.copy()
        )

    @property
    def changes(self) -> list[int]:
        """Rows at which walking changes to jumping and back."""
        return [k for k in range(1, len(self.stages)) if self.stages[k] != self.stages[k - 1]]

    def tips(self) -> Array:
        """(K, L, 3) tips of the legs, by the poses of the last links alone [m]."""
        return tips_of(self.simulation, self.walkers.herd)


@pytest.fixture(
    scope="module",
    params=[
        "antelope",
        *(pytest.param(name, marks=pytest.mark.nightly) for name in list(BOXES)[1:]),
    ],
)
def leap(request) -> Leap:
    length, high = BOXES[request.param]
    return record_leap(hurdle_scene(request.param, length, high), length, high)


def record_leap(scene: Scene, length: float, high: float) -> Leap:
    """Simulate a scene of one walker and record every step."""
    one = Leap(Simulation(scene), length, high)
    one.record_step()
    while not one.simulation.finished:
        one.simulation.step()
        one.record_step()
    return one


def lowest_over(take: Take, performer: str, first: float, last: float) -> float:
    """Return the height of the lowest vertex of a performer between two places along x [m]."""
    lowest = math.inf
    for part in (part for part in take.parts if part.performer == performer):
        mesh = take.meshes[part.mesh]
        # A skin over many nodes is taken for solids about each of them.
        nearest = np.take_along_axis(mesh.nodes, mesh.weights.argmax(axis=1)[:, None], axis=1)
        for node in np.unique(nearest):
            own = mesh.vertices[nearest[:, 0] == node].astype(float) - take.nodes[node].rest
            for rows in np.array_split(np.arange(len(take.positions)), 24):
                R, p = matrix(take.rotations[rows, node]), take.positions[rows, node]
                v = p[:, None] + own @ R.transpose(0, 2, 1)
                inside = (v[..., 0] > first) & (v[..., 0] < last)
                lowest = min(lowest, float(np.where(inside, v[..., 1], np.inf).min()))
    return lowest


# --- walkers that jump ----------------------------------------------------------------


def test_walker_jumps_and_walks_to_the_end_of_its_route(leap: Leap) -> None:
    order = [leap.stages[k] for k in leap.changes]
    assert order == ["coming", "leaping", "landed", "walking"]
    np.testing.assert_allclose(leap.take.positions[-1, 0, [0, 2]], [AT + 4, 0], atol=1e-3)
    assert not leap.take.notes
    legs = len(leap.walkers.herd.owner)
    assert sum(one.kind == "lift" for one in leap.take.contacts) == legs


def test_jump_clears_the_box(leap: Leap) -> None:
    half = 0.5 * leap.length
    assert lowest_over(leap.take, "a", AT - half, AT + half) > leap.high + 0.02


def test_planted_feet_do_not_slip(leap: Leap) -> None:
    moved = np.linalg.norm(np.diff(leap.tips(), axis=0), axis=-1)
    down = np.array(leap.down)
    assert moved[down[1:] & down[:-1]].max() < 1e-2 * MILLIMETRE


def test_handover_has_no_jolt(leap: Leap) -> None:
    take, dt = leap.take, leap.simulation.world.clock.dt
    v = np.diff(take.positions, axis=0) / dt
    jolts = np.linalg.norm(np.diff(v, axis=0), axis=-1).max(axis=-1)
    R = matrix(take.rotations)
    cosines = ((R[1:] * R[:-1]).sum(axis=(-1, -2)) - 1.0) / 2.0
    turned = np.arccos(np.clip(cosines, -1.0, 1.0)).max(axis=-1) / dt
    rows = int(HANDOVER_TIME / dt)
    for k in leap.changes[1:]:
        near = slice(k - 3, k + rows)
        assert jolts[near].max() < 0.35
        assert turned[near].max() < 8.0


def test_leg_joint_rates_are_bounded(leap: Leap) -> None:
    q, herd = leap.simulation.recorder.values, leap.walkers.herd
    legs = q[:, 2 * len(herd.names) :][:, : int(herd.legs.is_joint.sum())]
    rates = np.abs(np.diff(legs, axis=0)) / leap.simulation.world.clock.dt
    assert rates.max() < QUICKEST


@pytest.mark.nightly
def test_shipped_antelope_clears_its_box() -> None:
    scene = load_scene(find_scene("over_the_box"))
    box = next(member for member in scene.cast if isinstance(member, Prop))
    assert isinstance(box.prop, BoxShape)
    leap = record_leap(scene, box.prop.size[0], box.prop.size[1])
    take, walkers = leap.take, leap.walkers
    dt, ground = leap.simulation.world.clock.dt, leap.simulation.world.ground
    assert not take.notes
    tips, down = leap.tips(), np.array(leap.down)
    assert np.linalg.norm(np.diff(tips, axis=0), axis=-1)[down[1:] & down[:-1]].max() < 1e-5
    low = tips[..., 1] - ground.height(tips[..., 0], tips[..., 2]) - walkers.herd.foot_radius
    assert low.min() > -MILLIMETRE
    middle = [node.name for node in take.nodes].index("box")
    X = matrix(take.rotations[:, middle]), take.positions[:, middle]
    half = 0.5 * np.array(box.prop.size)
    for part in (one for one in take.parts if one.performer == "ante"):
        mesh = take.meshes[part.mesh]
        node = int(mesh.nodes[0, 0])
        own = mesh.vertices.astype(float) - take.nodes[node].rest
        for k in range(0, len(take.positions), 2):
            v = take.positions[k, node] + own @ matrix(take.rotations[k, node]).T
            inside = (np.abs((v - X[1][k]) @ X[0][k]) < half + 0.02)[:, [0, 2]].all(axis=-1)
            assert v[inside, 1].min(initial=np.inf) > X[1][k, 1] + half[1] + 0.02
    jerked = np.diff(take.positions[:, 0], 2, axis=0) / dt**2
    assert np.linalg.norm(jerked, axis=-1).max() < HARDEST
    np.testing.assert_allclose(take.positions[-1, 0, [0, 2]], [5, 0.3], atol=0.3)


@pytest.mark.nightly
def test_takes_are_reproducible() -> None:
    digests = set[str]()
    for _ in range(2):
        simulation = Simulation(hurdle_scene("antelope", *BOXES["antelope"], duration=9))
        while not simulation.finished:
            simulation.step()
        digests.add(simulation.take().digest)
    assert len(digests) == 1


def take_of(scene: Scene) -> Take:
    simulation = Simulation(scene)
    while not simulation.finished:
        simulation.step()
    return simulation.take()


@pytest.mark.nightly
@pytest.mark.parametrize(("size", "cause"), [((0.4, 2.5), "too high"), ((9.0, 0.5), "too long")])
def test_impossible_jump_is_noted(size: tuple[float, float], cause: str) -> None:
    scene = hurdle_scene("antelope", *size, duration=3)
    take = take_of(scene)
    (order,) = take.orders
    assert order.outcome == "given up"
    assert cause in order.reason
    # The long hurdle reaches to where it starts.
    assert {note.kind for note in take.notes} <= {"overlaps", "passes_through"}
    assert not any(one.kind == "lift" for one in take.contacts)
    assert take.positions[-1, 0, 0] > 2.0


@pytest.mark.nightly
def test_hurdle_too_near_to_stop_is_not_jumped() -> None:
    config = "{name: a, figure: antelope, at: [3.2, 0], walk: {path: [[9, 0]]}}"
    box = "{name: box, prop: {shape: box, size: [0.4, 0.4, 2]}, at: [4, 0]}"
    more = "script: [{at: 0.2, who: a, do: {hop_over: box}}]"
    take = take_of(scene_of(config, box, duration=2, more=more))
    (order,) = take.orders
    assert (order.outcome, order.end) == ("given up", order.step + 1)
    assert "too near" in order.reason


@pytest.mark.nightly
@pytest.mark.parametrize("way", ["walk", "pronk"])
def test_jump_is_done_when_it_has_landed(way: str) -> None:
    more = "script: [{at: 0.2, who: a, do: {jump: {height: 0.2}}}]"
    take = take_of(scene_of(f"{{name: a, figure: antelope, {way}: {{}}}}", duration=8, more=more))
    assert [order.outcome for order in take.orders] == ["done"]
    lifts = [one.step for one in take.contacts if one.kind == "lift"]
    assert min(lifts) < take.orders[0].end < 4 * 24 * 8


@pytest.mark.nightly
def test_orders_to_a_fallen_hopper_are_given_up() -> None:
    config = "{name: a, figure: antelope, at: [0, 3, 0], pronk: {balance: 0}}"
    more = "script: [{at: 2.5, who: a, do: {jump: {}}}, {at: 2.6, who: a, do: stop}]"
    take = take_of(scene_of(config, duration=3, more=more))
    assert any(note.kind == "toppled" for note in take.notes)
    given_up = [order.text for order in take.orders if order.outcome == "given up"]
    assert given_up == ["jump {}", "stop"]


@pytest.mark.nightly
def test_detour_to_a_box_returns_to_the_route() -> None:
    config = "{name: a, figure: antelope, walk: {path: [[12, 0]]}}"
    box = "{name: box, prop: {shape: box, size: [0.4, 0.4, 1]}, at: [4, 2], heading_deg: -25}"
    more = "script: [{at: 0.1, who: a, do: {hop_over: box}}]"
    take = take_of(scene_of(config, box, duration=20, more=more))
    assert sum(one.kind == "lift" for one in take.contacts) == 4
    np.testing.assert_allclose(take.positions[-1, 0, [0, 2]], [12, 0], atol=1e-3)


@pytest.mark.nightly
def test_jump_to_a_point_is_followed_by_the_next_order() -> None:
    config = "{name: a, figure: antelope, walk: {}, pronk: {max_force: 4}}"
    more = (
        "script: [{at: 1, who: a, do: {jump: {land_at: [2.5, -0.5], height: 0.3}}},"
        " {at: 4.3, who: a, do: {go_to: [4, 1]}}]"
    )
    scene = scene_of(config, duration=14, more=more)
    simulation, landed = Simulation(scene), None
    while not simulation.finished:
        simulation.step()
        walkers = simulation.troupes[0]
        assert isinstance(walkers, WalkerTroupe)
        trip = walkers.leaps.trips.get(0)
        if trip is not None and trip.stage == "landed" and landed is None:
            landed = walkers.sequencer.feet.end[:, [0, 2]].mean(axis=0)
    assert landed is not None
    assert np.linalg.norm(landed - [2.5, -0.5]) < 0.02
    np.testing.assert_allclose(simulation.take().positions[-1, 0, [0, 2]], [4, 1], atol=1e-3)


@pytest.mark.nightly
def test_walker_jumps_over_a_fallen_body() -> None:
    config = "{name: a, figure: antelope, walk: {path: [[8, 0]]}}"
    box = "{name: box, body: {shape: box, size: [0.4, 0.4, 1.2]}, at: [4, 0.9, 0]}"
    more = "script: [{at: 1.5, who: a, do: {hop_over: box}}]"
    take = take_of(scene_of(config, box, duration=8, more=more))
    assert sum(one.kind == "lift" for one in take.contacts) == 4
    assert lowest_over(take, "a", 3.8, 4.2) > 0.42


# --- hoppers ---------------------------------------------------------------------------

ROO = "{{name: roo, figure: kangaroo, pronk: {{distance: 1.6, height: 0.5{}}}}}"


def hop_with_script(
    script: str, duration: float = 8, config: str = "", *others: str
) -> HopRecording:
    more = f"script: [{script}]"
    return hop_through(scene_of(ROO.format(config), *others, duration=duration, more=more))


def test_hopper_clears_a_crate_and_hops_on() -> None:
    crate = "{name: crate, prop: {shape: box, size: [0.5, 0.5, 1.5]}, at: [5, 0]}"
    hops = hop_with_script("{at: 1, who: roo, do: {hop_over: crate}}", 6, "", crate)
    assert lowest_over(hops.take, "roo", 4.75, 5.25) > 0.52
    assert hops.take.positions[-1, 0, 0] > 8.0
    assert not [one for one in hops.take.notes if one.kind != "misplaced"]


def test_go_to_order_ends_at_the_place() -> None:
    hops = hop_with_script("{at: 1, who: roo, do: {go_to: [4, 3]}}", 9)
    state = hops.troupe.simulations[0].state
    assert state.phase == "standing"
    assert np.linalg.norm(state.tips[:, [0, 2]].mean(axis=0) - [4, 3]) < 0.05
    assert hops.states[0][-1].tilt < math.radians(3)


def test_stop_order_ends_and_hop_order_resumes_the_hops() -> None:
    script = "{at: 1.6, who: roo, do: stop}, {at: 5, who: roo, do: hop}"
    hops = hop_with_script(script, 8)
    jumps = {seen.jumps for seen in hops.states[0] if 3.5 < seen.time < 5.0}
    assert len(jumps) == 1
    assert {seen.phase for seen in hops.states[0] if 4.2 < seen.time < 5.0} == {"standing"}
    assert hops.states[0][-1].jumps > max(jumps) + 1


@pytest.mark.nightly
@pytest.mark.parametrize("at", [1.5, 2.2, 2.5, 2.8, 3.1])
def test_stop_cancels_go_to_in_any_phase(at: float) -> None:
    script = f"{{at: 0.5, who: roo, do: {{go_to: [14, 0]}}}}, {{at: {at}, who: roo, do: stop}}"
    hops = hop_with_script(script, 7)
    before = max(seen.jumps for seen in hops.states[0] if seen.time <= at)
    assert hops.states[0][-1].jumps <= before + 1
    assert hops.states[0][-1].phase == "standing"


@pytest.mark.nightly
def test_jump_does_not_affect_other_walkers() -> None:
    beside = "{name: b, figure: beetle, at: [0, 3], walk: {}}"
    jumps = "{name: a, figure: antelope, at: [0, -3], walk: {}}"
    more = "script: [{at: 0.5, who: a, do: {jump: {}}}]"
    alone, both = (
        take_of(scene_of(beside, duration=6)),
        take_of(scene_of(jumps, beside, duration=6, more=more)),
    )
    nodes = [i for i, node in enumerate(both.nodes) if node.performer == "b"]
    rows = len(alone.positions)
    assert any(one.kind == "lift" for one in both.contacts)
    assert (both.positions[:rows, nodes] == alone.positions).all()


@pytest.mark.nightly
def test_wait_order_pauses_the_hops() -> None:
    hops = hop_with_script("{at: 1.5, who: roo, do: {wait: 3}}", 8)
    standing = [seen.time for seen in hops.states[0] if seen.phase == "standing" and seen.time > 2]
    assert standing
    assert hops.states[0][-1].jumps > 2


@pytest.mark.nightly
@pytest.mark.parametrize("angle", [40, -160])
def test_turn_order_turns_by_its_angle(angle: float) -> None:
    hops = hop_with_script(f"{{at: 1.5, who: roo, do: {{turn_deg: {angle}}}}}", 10)
    v = hops.lifts[-1][1]
    went = math.degrees(math.atan2(-v[2], v[0]))
    assert abs(math.remainder(went - angle, 360)) < 2.0
    assert max(seen.tilt for seen in hops.states[0]) < math.radians(15)


@pytest.mark.nightly
def test_speed_order_changes_the_speed() -> None:
    hops = hop_with_script("{at: 2, who: roo, do: {speed: 4.5}}", 6)
    assert np.linalg.norm(hops.lifts[-1][1]) == pytest.approx(4.5, rel=1e-6)


def test_single_jump_order_has_its_height_and_distance() -> None:
    hops = hop_with_script("{at: 1.3, who: roo, do: {jump: {height: 0.8, distance: 1.0}}}", 6)
    apexes = [float(v[1] ** 2) / (2 * 9.81) for _, v in hops.lifts]
    assert max(apexes) == pytest.approx(0.8, rel=1e-3)
    assert sum(abs(one - 0.5) < 1e-3 for one in apexes) == len(apexes) - 1


def test_arrival_of_a_hopper_triggers_orders() -> None:
    script = (
        "{at: 0.5, who: roo, do: {go_to: [2, 0]}},"
        "{when: {arrived: roo}, who: roo, do: {jump: {land_at: [3, 0]}}}"
    )
    hops = hop_with_script(script, 12)
    state = hops.troupe.simulations[0].state
    assert np.linalg.norm(state.tips[:, [0, 2]].mean(axis=0) - [3, 0]) < 0.05


# --- refusals ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("member", "do", "message"),
    [
        ("pronk: {}", "walk", "for which walk is no order; write .* hop, "),
        ("pronk: {}", "{gait: trot}", "is a creature that hops, for which"),
        ("pronk: {}", "{mood: proud}", "is a creature that hops, for which"),
        ("walk: {}", "hop", "for which hop is no order; write .* walk, "),
        ("walk: {}", "{hop_over: bxo}", "did you mean 'box'"),
        ("walk: {}", "{hop_over: a}", "cannot do that to itself"),
        ("walk: {}", "{hop_over: wall}", "is many bodies; name one of them, such as wall_1"),
        ("walk: {}", "{jump: {land_at: [1, 0], distance: 2}}", "conflicts with land_at"),
        ("walk: {}", "{jump: {distance: 4, speed: 2}}", "has a height only if"),
        ("pronk: {}", "{jump: {distance: 4, speed: 2}}", "has a height only if"),
        ("walk: {}, pose: [{at: 1, limb: arm_r, reach: [0, 1, 0]}]", "{jump: {}}", "has a pose"),
        ("walk: {}, pronk: {jumps: 3}", "stop", "which jumps by script"),
        ("walk: {}, pronk: {max_force: 0.1}", "{jump: {}}", "leave the ground"),
        ("at: [0, 0]", "{jump: {}}", "neither walks nor hops"),
    ],
)
def test_invalid_orders_are_refused(member: str, do: str, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        Simulation(
            scene_of(
                f"{{name: a, figure: person, {member}}}",
                "{name: box, prop: {shape: box}, at: [3, 0]}",
                "{name: wall, many: {of: brick, rows: 2, columns: 2}, at: [6, 0]}",
                more=f"script: [{{at: 1, who: a, do: {do}}}]",
            )
        )
    assert all(problem.line > 0 for problem in caught.value.problems)


# --- hurdles ---------------------------------------------------------------------------


def corners(size: tuple[float, float, float], middle: tuple[float, float, float], deg: float):
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return middle + 0.5 * signs * size @ heading(math.radians(deg)).T


@pytest.mark.parametrize("deg", [0.0, 30.0, 45.0, 80.0])
def test_hurdle_profile_of_a_box_in_a_strip(deg: float) -> None:
    """The sides of a rotated box cut the edges of the strip at closed-form points."""
    long, wide, half = 0.4, 6.0, 0.3
    box = corners((long, 0.5, wide), (3.0, 0.25, 0.0), deg)
    one = hurdle_profile([box], np.zeros(2), 0.0, half)
    assert one is not None
    angle = math.radians(deg)
    reach = 0.5 * long / math.cos(angle) + half * math.tan(angle)
    end = 0.5 * (long * math.cos(angle) + wide * math.sin(angle))
    assert one.near == pytest.approx(3.0 - min(reach, end), abs=1e-9)
    assert one.far == pytest.approx(3.0 + min(reach, end), abs=1e-9)
    np.testing.assert_allclose(one.top, 0.5, atol=1e-9)


def test_hurdle_profile_is_the_maximum_of_its_solids() -> None:
    low = corners((1.0, 0.2, 1.0), (2.0, 0.1, 0.0), 0.0)
    high = corners((0.2, 0.6, 1.0), (2.3, 0.3, 0.0), 0.0)
    one = hurdle_profile([low, high], np.zeros(2), 0.0, 0.2)
    assert one is not None
    inside = (one.along > 2.2) & (one.along < 2.4)
    np.testing.assert_allclose(one.top[inside], 0.6)
    np.testing.assert_allclose(one.top[one.along < 2.2 - 1e-6], 0.2)
    assert hurdle_profile([low], np.array([0.0, 5.0]), 0.0, 0.2) is None
