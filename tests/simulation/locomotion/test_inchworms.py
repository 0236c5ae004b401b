"""Inchworms: the planted end stays, steps are smooth, and footholds are allowed."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.errors import SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.inching.inchworm_chain import (
    FRONT,
    MAX_AMPLITUDE,
    MIN_AMPLITUDE,
    REAR,
    InchwormChain,
    is_inchworm,
    loop_amplitude,
    loop_chord,
)
from pipeline.simulation.locomotion.inching.inchworm_pose import solve_pose
from pipeline.simulation.locomotion.inching.inchworm_steps import Inchworm, InchwormStep, feet_at
from pipeline.simulation.locomotion.inching.inchworm_troupe import InchwormTroupe
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Take
from pipeline.spec import find_scene, load_scene

if TYPE_CHECKING:
    from pipeline.spec import Scene

    SceneOf = Callable[..., Scene]

MILLIMETRE = 1e-3

WORM = "{{figure: inchworm, name: {name}, at: {at}, heading_deg: {heading}, walk: {walk}}}"
GENTLE = "{kind: fractal, height: 0.8, size: [14, 14]}"
ZONES = "{kind: hills, height: 1.5, spacing: 3, size: [14, 14], unsteppable_slope_deg: 27}"
SPECKLES = (
    "{kind: fractal, height: 1.2, roughness: 0.5, size: [14, 14], cells: [90, 90],"
    " unsteppable_slope_deg: 25, foot_radius: 0.02}"
)

WALKS = {
    "shipped": "",
    "flat": ("flat", WORM.format(name="w", at=[0, 0], heading=0, walk="{}")),
    "flat, short steps": (
        "flat",
        WORM.format(name="w", at=[0, 0], heading=200, walk="{stride: 0.2, cycle: 1.7}"),
    ),
    "gentle": ("gentle", WORM.format(name="w", at=[-2, 1], heading=30, walk="{}")),
    "gentle, quick": (
        "gentle",
        WORM.format(name="w", at=[2, 1], heading=215, walk="{cycle: 1.1, step_height: 0.3}"),
    ),
    "hills": ("hills", WORM.format(name="w", at=[1, -1], heading=100, walk="{}")),
    "zones": ("zones", WORM.format(name="w", at=[-4, 0], heading=0, walk="{}")),
    "speckles": ("speckles", WORM.format(name="w", at=[-4, 1], heading=0, walk="{}")),
}
TERRAINS = {
    "flat": "flat",
    "gentle": GENTLE,
    "hills": "{kind: hills, height: 1.2, spacing: 5}",
    "zones": ZONES,
    "speckles": SPECKLES,
}


@dataclass(frozen=True)
class Crawl:
    """A simulation of one inchworm, with its step at every row."""

    simulation: Simulation
    steps: list[InchwormStep]

    @property
    def troupe(self) -> InchwormTroupe:
        """The worms."""
        return _worms(self.simulation)

    @property
    def worm(self) -> Inchworm:
        """The inchworm."""
        return self.troupe.worms[0]

    @cached_property
    def take(self) -> Take:
        """The take of the simulation."""
        return self.simulation.take()

    @cached_property
    def q(self) -> Array:
        """(K, J) joint values [rad]."""
        return self.simulation.recorder.values[:, 2:]

    @cached_property
    def ends(self) -> NDArray[np.int64]:
        """(K,) which end moves."""
        return np.array([step.end for step in self.steps])

    def pose(self, end: int) -> tuple[Array, Array]:
        """Return rotations (K, 3, 3) and positions (K, 3) of an end link."""
        node, recorder = self.worm.chain.feet[end].number, self.simulation.recorder
        return recorder.rotations[:, node], recorder.positions[:, node]

    @cached_property
    def gaps(self) -> dict[str, Array]:
        """Least height of the parts above the ground (K,) [m]."""
        ground, result = self.simulation.world.ground, {}
        for part in self.take.parts:
            mesh = self.take.meshes[part.mesh]
            node = int(mesh.nodes[0, 0])
            own = mesh.vertices - np.array(self.take.nodes[node].rest)
            R, p = matrix(self.take.rotations[:, node]), self.take.positions[:, node]
            v = own @ R.transpose(0, 2, 1) + p[:, None]
            result[part.name] = (v[..., 1] - ground.height(v[..., 0], v[..., 2])).min(axis=1)
        return result


def _worms(simulation: Simulation) -> InchwormTroupe:
    return next(troupe for troupe in simulation.troupes if isinstance(troupe, InchwormTroupe))


def _crawl(scene: Scene) -> Crawl:
    simulation = Simulation(scene)
    steps = [_worms(simulation).steps[0]]
    while not simulation.finished:
        simulation.step()
        steps.append(_worms(simulation).steps[0])
    return Crawl(simulation, steps)


@pytest.fixture(scope="module", params=list(WALKS))
def crawl(request: pytest.FixtureRequest, scene_of: SceneOf) -> Crawl:
    """Return each of several walks in turn."""
    if request.param == "shipped":
        return _crawl(load_scene(find_scene("inchworm")))
    terrain, member = WALKS[request.param]
    return _crawl(scene_of(member, terrain=TERRAINS[terrain], duration=5, seed=5))


@pytest.fixture(scope="module")
def chain(figure: Callable[..., Figure]) -> InchwormChain:
    """Return a chain of uneven links, one of which is the body."""
    nodes = {"a": -0.9, "b": -0.65, "c": -0.5, "d": -0.3, "e": -0.15, "f": 0.05, "g": 0.3}
    nodes |= {"h": 0.55, "i": 0.7, "j": 0.95}
    drawn = ", ".join(f"{name}: [0, {y}]" for name, y in nodes.items())
    names = ("base_pitch", "joint1_bend", "joint2_bend", "joint3_bend")
    wide = ", ".join(f"{name}: {{limits_deg: [-110, 110]}}" for name in names)
    found = figure(
        f"{{radius: 0.04, nodes: {{{drawn}}}, chains: [[{', '.join(nodes)}]],"
        f" joints: {{head: {{{wide}}}, tail: {{{wide}}}}}}}"
    )
    assert is_inchworm(found)
    return InchwormChain.of(found)


# --- invariants of every row ------------------------------------------------------


@pytest.mark.slow
def test_planted_end_does_not_move(crawl: Crawl) -> None:
    moved = 0
    for end in (REAR, FRONT):
        R, p = crawl.pose(end)
        for a, b in itertools.pairwise(range(len(p))):
            if crawl.ends[a] == crawl.ends[b] == 1 - end:
                assert np.array_equal(p[a], p[b])
                assert np.array_equal(R[a], R[b])
                moved += 1
    assert moved > 100


def test_swapping_base_and_tip_moves_nothing(crawl: Crawl) -> None:
    """The last pose of one base equals the first of the other in all links and joints."""
    worm, swaps = crawl.worm, 0
    for before, after in itertools.pairwise(crawl.steps):
        if before is not after:
            phase = np.array([before.down])
            one = solve_pose(
                worm.chain, worm.track, 1 - before.end, *feet_at([before], phase, before.end)
            )
            two = solve_pose(
                worm.chain, worm.track, 1 - after.end, *feet_at([after], phase, after.end)
            )
            assert after.end == 1 - before.end
            assert np.abs(one.positions - two.positions).max() < 1e-9
            assert np.abs(one.rotations - two.rotations).max() < 1e-9
            assert np.abs(one.q - two.q).max() < 1e-9
            swaps += 1
    assert swaps >= 1


def test_joints_are_within_limits(crawl: Crawl) -> None:
    skeleton = crawl.worm.chain.figure.skeleton
    assert (crawl.q >= skeleton.lower).all()
    assert (crawl.q <= skeleton.upper).all()
    assert not [note for note in crawl.take.notes if note.kind == "clamped"]


def test_joint_rates_and_their_changes_are_bounded(crawl: Crawl) -> None:
    """Rates and their changes are bounded, also where base and tip swap."""
    dt = crawl.simulation.world.clock.dt
    assert np.abs(np.diff(crawl.q, axis=0)).max() / dt < 6.0
    assert np.abs(np.diff(crawl.q, 2, axis=0)).max() / dt**2 < 90.0


def test_worm_stays_in_its_plane(crawl: Crawl) -> None:
    names = crawl.worm.chain.figure.skeleton.joint_names
    sideways = [i for i, name in enumerate(names) if name.endswith(("yaw", "roll"))]
    assert np.abs(crawl.q[:, sideways]).max() < 1e-9
    across = np.array([np.sin(crawl.worm.track.heading), 0.0, np.cos(crawl.worm.track.heading)])
    assert np.ptp(crawl.simulation.recorder.positions @ across) < 1e-9


def test_links_stay_connected(crawl: Crawl) -> None:
    """Each link starts at the end of the one before, with either base."""
    recorder = crawl.simulation.recorder
    skeleton = crawl.worm.chain.figure.skeleton
    for limb in skeleton.limbs:
        for a, b in itertools.pairwise(limb.links):
            span = skeleton.links[a].ends[1] - skeleton.links[a].ends[0]
            end = recorder.positions[:, a] + recorder.rotations[:, a] @ span
            assert np.allclose(end, recorder.positions[:, b], atol=1e-9)


@pytest.mark.sample(2)
@pytest.mark.slow
def test_feet_follow_the_slope_of_the_ground(crawl: Crawl) -> None:
    ground, gaps = crawl.simulation.world.ground, crawl.gaps
    for end, foot in enumerate(crawl.worm.chain.feet):
        gap = gaps[f"{crawl.worm.name}.{foot.link.name}"]
        assert np.abs(gap[crawl.ends == 1 - end]).max() < 1e-3 * MILLIMETRE
        assert gap.min() > -MILLIMETRE
        _, p = crawl.pose(end)
        R = crawl.pose(end)[0][crawl.ends == 1 - end]
        tip = p[crawl.ends == 1 - end] + R @ (foot.link.ends[1] - foot.link.ends[0])
        for q, radius in (
            (p[crawl.ends == 1 - end], foot.link.radii[0]),
            (tip, foot.link.radii[1]),
        ):
            height = q[:, 1] - ground.height(q[:, 0], q[:, 2])
            assert np.abs(height - radius).max() < 0.35 * foot.length


def test_no_part_penetrates_gentle_ground(crawl: Crawl) -> None:
    assert min(gap.min() for gap in crawl.gaps.values()) > -6.0 * MILLIMETRE


def test_moving_foot_lifts_and_pitches_up(crawl: Crawl) -> None:
    gaps, worm = crawl.gaps, crawl.worm
    phases = crawl.simulation.recorder.values[:, 0]
    for end, foot in enumerate(worm.chain.feet):
        middle = (crawl.ends == end) & (np.abs(np.mod(phases, 0.5) - 0.25) < 0.08)
        assert (gaps[f"{worm.name}.{foot.link.name}"][middle] > 0.3 * worm.pace.lifts[end]).all()
    late = (crawl.ends == FRONT) & (np.abs(phases - 0.32) < 0.02)
    nose = crawl.pose(FRONT)[0][late, 1, 0]
    planted = np.array([step.finish[2] for step in crawl.steps])[late]
    assert (np.arcsin(nose) > planted + 0.3).all()


def test_ends_avoid_forbidden_zones(crawl: Crawl) -> None:
    ground = crawl.simulation.world.ground
    for end, foot in enumerate(crawl.worm.chain.feet):
        _, p = crawl.pose(end)
        still = crawl.ends == 1 - end
        R = crawl.pose(end)[0][still]
        for part in (0.0, 0.5, 1.0):
            at = p[still] + R @ (part * (foot.link.ends[1] - foot.link.ends[0]))
            # The checked places are under the foot as it lies on level ground.
            near = [ground.steppable(at[:, 0] + d, at[:, 2]) for d in (-0.01, 0.0, 0.01)]
            assert np.any(near, axis=0).all()
    places = np.array([contact.place for contact in crawl.take.contacts])
    assert ground.steppable(places[:, 0], places[:, 2]).all()
    assert np.allclose(places[:, 1], ground.height(places[:, 0], places[:, 2]), atol=1e-12)


def test_ends_land_at_half_and_whole_cycles(crawl: Crawl) -> None:
    clock, worm = crawl.simulation.world.clock, crawl.worm
    assert crawl.take.contacts
    parts = itertools.cycle([f"{worm.name}.head", f"{worm.name}.tail"])
    for number, (contact, part) in enumerate(zip(crawl.take.contacts, parts, strict=False)):
        cycles = float(clock.time_of(contact.step, contact.fraction)) / worm.pace.cycle
        assert abs(cycles - 0.5 * (number + 1)) < 1e-9
        assert contact.part == part
        assert contact.speed > 0.005
    heard = [event for event in crawl.take.events if event.cause == "footfall"]
    assert len(heard) == len(crawl.take.contacts)


# --- laws ---------------------------------------------------------------------------


def test_loop_amplitude_inverts_the_chord(chain: InchwormChain) -> None:
    chords = np.linspace(*loop_chord(chain, np.array([MAX_AMPLITUDE, MIN_AMPLITUDE])), 200)
    assert np.allclose(loop_chord(chain, loop_amplitude(chain, chords)), chords, atol=1e-12)


def test_loop_chord_tends_to_the_bessel_function(figure: Callable[..., Figure]) -> None:
    nodes = ", ".join(f"n{i}: [0, {0.01 * i}]" for i in range(123))
    names = ", ".join(f"n{i}" for i in range(123))
    long = InchwormChain.of(figure(f"{{radius: 0.003, nodes: {{{nodes}}}, chains: [[{names}]]}}"))
    A = np.linspace(MIN_AMPLITUDE, MAX_AMPLITUDE, 7)
    t = (np.arange(4000) + 0.5) * (2.0 * np.pi / 4000)
    J0 = np.cos(A[:, None] * np.sin(t)).mean(axis=1)
    assert np.allclose(loop_chord(long, A) / long.free, J0, atol=1e-9)


def test_pose_does_not_depend_on_the_base(chain: InchwormChain, scene_of: SceneOf) -> None:
    rng = np.random.default_rng(6)
    worm = _worms(Simulation(scene_of("{figure: inchworm}"))).worms[0]
    n = 40
    rear = np.stack([rng.uniform(-1, 1, n), rng.uniform(0, 1, n), rng.uniform(-0.2, 0.2, n)], -1)
    away = (rng.uniform(0.55, 0.9, n) * chain.free + chain.outside, rng.uniform(-0.1, 0.1, n))
    front = rear + np.stack([*away, rng.uniform(-0.2, 0.2, n)], axis=-1)
    one, two = (solve_pose(chain, worm.track, base, rear, front) for base in (REAR, FRONT))
    assert max(one.residual.max(), two.residual.max()) < 1e-12
    assert np.abs(one.positions - two.positions).max() < 1e-9
    for end, poses in ((REAR, rear), (FRONT, front)):
        R, p = worm.track.pose(poses)
        foot = chain.feet[end]
        middle = foot.link.ends[0] - foot.middle
        for some in (one, two):
            assert np.allclose(some.rotations[:, foot.number], R, atol=1e-10)
            assert np.allclose(some.positions[:, foot.number], p + R @ middle, atol=1e-10)


def test_level_walk_covers_one_stride_a_cycle(scene_of: SceneOf) -> None:
    member = WORM.format(name="w", at=[0, 0], heading=0, walk="{speed: 0.25, cycle: 1.5}")
    take = simulate(scene_of(member, duration=10))
    heads = np.array([c.place for c in take.contacts if c.part == "w.head"])
    assert np.allclose(np.diff(heads[:, 0]), 0.375, atol=1e-9)
    assert np.allclose(heads[:, 1:], 0.0, atol=1e-12)


def test_pose_does_not_depend_on_the_time_step(scene_of: SceneOf) -> None:
    member = WORM.format(name="w", at=[0, 0], heading=30, walk="{}")
    coarse, fine = (simulate(scene_of(member, terrain=GENTLE, more=f"steps: {n}")) for n in (4, 16))
    assert np.abs(coarse.positions - fine.positions).max() < 1e-9


# --- stops, rest and refusals ---------------------------------------------------------


def test_worm_stops_before_forbidden_ground(scene_of: SceneOf) -> None:
    terrain = "{kind: flat, size: [8, 8]}"
    member = WORM.format(name="w", at=[2, 0], heading=0, walk="{cycle: 1}")
    crawl = _crawl(scene_of(member, terrain=terrain, duration=8))
    notes = [note for note in crawl.take.notes if note.kind == "stopped"]
    assert [note.part for note in notes] == ["w.head"]
    x, z = map(float, re.findall(r"-?[0-9.]+", notes[0].text))
    assert 4.0 - 2.0 * crawl.worm.pace.stride < x < 4.0
    assert abs(z) < 0.01
    tips = [x for _, p in map(crawl.pose, (REAR, FRONT)) for x in p[:, 0]]
    assert max(tips) < 4.0
    assert max(c.place[0] for c in crawl.take.contacts) > 4.0 - 1.5 * crawl.worm.pace.stride
    # The worm rests in the pose of its stop.
    assert np.ptp(crawl.take.positions[-100:], axis=0).max() == 0.0
    speed = crawl.simulation.recorder.values[:, 1]
    assert speed[0] > 0.0
    assert speed[-1] == 0.0


@pytest.mark.parametrize("terrain", ["flat", GENTLE])
def test_resting_worm_lies_in_a_low_arch(scene_of: SceneOf, terrain: str) -> None:
    crawl = _crawl(scene_of("{figure: inchworm, name: w, at: [1, 1]}", terrain=terrain))
    take = crawl.take
    assert np.ptp(take.positions, axis=0).max() == 0.0
    assert not take.contacts
    gaps = crawl.gaps
    assert abs(gaps["w.head.8"][0]) < 1e-3 * MILLIMETRE
    assert abs(gaps["w.tail.8"][0]) < 1e-3 * MILLIMETRE
    assert -2.0 * MILLIMETRE < min(gap[0] for gap in gaps.values())
    assert max(gap[0] for gap in gaps.values()) < 0.2 * crawl.worm.chain.length


FIGURES = (
    "figures: {stiff: {nodes: {a: [0, 0], b: [0, 1], c: [0, 2], d: [0, 3], e: [0, 4], f: [0, 5]},"
    " chains: [[a, b, c, d, e, f]], joints: {head: {joint1_bend: {limits_deg: [-1, 1]}},"
    " tail: {joint1_bend: {limits_deg: [-1, 1]}}}},"
    " stub: {nodes: {a: [0, 0], b: [0, 1], c: [0, 2]}, chains: [[a, b, c]]},"
    " bow: {nodes: {a: [0, 0], b: [0.5, 1], c: [0.7, 2], d: [0.5, 3], e: [0, 4]},"
    " chains: [[a, b, c, d, e]]}}"
)


@pytest.mark.parametrize(
    ("member", "path", "phrases"),
    [
        ("{figure: inchworm, walk: {gait: wave}}", "walk.gait", ["no legs", "`gait`"]),
        ("{figure: inchworm, walk: {body_height: 1}}", "walk.body_height", ["`body_height`"]),
        ("{figure: inchworm, walk: {body_bob: 0}}", "walk.body_bob", ["`body_bob`"]),
        ("{figure: inchworm, walk: {stride: 3}}", "walk", ["stride", "3", "at most"]),
        ("{figure: inchworm, walk: {speed: 9, cycle: 2}}", "walk", ["stride", "18", "at most"]),
        ("{figure: stiff, walk: {}}", "walk", ["'stiff'", "joints"]),
        ("{figure: stub, walk: {}}", "walk", ["no legs", "'stub'"]),
        ("{figure: bow, walk: {}}", "walk", ["no legs", "'bow'"]),
    ],
)
@pytest.mark.parametrize("number", [0, 1])
def test_unsupported_keys_are_refused(
    scene_of: SceneOf, member: str, path: str, phrases: list[str], number: int
) -> None:
    cast = ["{figure: inchworm, name: other, at: [5, 5]}"] * number + [member]
    with pytest.raises(SceneError) as caught:
        Simulation(scene_of(*cast, more=FIGURES))
    (problem,) = caught.value.problems
    assert problem.path == f"cast[{number}].{path}"
    for phrase in phrases:
        assert phrase in problem.message


def test_stride_suggested_by_the_error_works(scene_of: SceneOf) -> None:
    with pytest.raises(SceneError) as caught:
        Simulation(scene_of("{figure: inchworm, walk: {stride: 3}}"))
    most = float(caught.value.problems[0].message.split("at most ")[1].split(" ")[0])
    member = f"{{figure: inchworm, walk: {{stride: {0.995 * most}}}}}"
    take = simulate(scene_of(member, duration=5))
    assert not take.notes
    assert len(take.contacts) >= 4


def test_start_without_allowed_ground_is_refused(scene_of: SceneOf) -> None:
    scene = scene_of(
        "{figure: inchworm, name: w, at: [0.5, 0]}",
        terrain="{kind: fractal, height: 8, roughness: 0.7, size: [20, 20]}",
    )
    with pytest.raises(SceneError) as caught:
        Simulation(scene)
    (problem,) = caught.value.problems
    assert problem.path == "cast[0].at"
    for phrase in ("'w' finds no ground", "[0.5, 0]", "`at`"):
        assert phrase in problem.message


def test_only_straight_chains_are_inchworms(shipped: Figure) -> None:
    assert is_inchworm(shipped) == (shipped.name == "inchworm")


# --- other performers ------------------------------------------------------------------


def _of(take: Take, name: str) -> tuple[bytes, ...]:
    nodes = [i for i, node in enumerate(take.nodes) if node.performer == name]
    channels = [i for i, c in enumerate(take.channels) if c.name.startswith(f"{name}.")]
    lines = [repr(c) for c in take.contacts if c.performer == name]
    return (
        take.positions[:, nodes].tobytes(),
        take.rotations[:, nodes].tobytes(),
        take.values[:, channels].tobytes(),
        "\n".join(lines).encode(),
    )


@pytest.mark.nightly
def test_cast_order_does_not_matter(scene_of: SceneOf) -> None:
    cast = [
        WORM.format(name="one", at=[0, 0], heading=10, walk="{}"),
        WORM.format(name="two", at=[1, 3], heading=190, walk="{cycle: 1.2, stride: 0.3}"),
        "{figure: beetle, name: bug, scale: 0.5, at: [-3, 0], walk: {}}",
    ]
    there = simulate(scene_of(*cast, terrain=GENTLE, duration=3))
    back = simulate(scene_of(*cast[::-1], terrain=GENTLE, duration=3))
    alone = simulate(scene_of(cast[1], terrain=GENTLE, duration=3))
    for name in ("one", "two", "bug"):
        assert _of(there, name) == _of(back, name)
    assert _of(alone, "two") == _of(there, "two")
    assert {c.performer for c in there.contacts} == {"one", "two", "bug"}
    assert len({n.name for n in there.nodes}) == len(there.nodes)


def test_takes_are_reproducible(scene_of: SceneOf) -> None:
    scene = scene_of(WORM.format(name="w", at=[0, 0], heading=10, walk="{}"), terrain=GENTLE)
    assert simulate(scene).digest == simulate(scene).digest
