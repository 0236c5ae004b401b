"""Groups: invariants of their rules at every row and frame rate."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.bodies.groups.counter_random import CounterRandom
from pipeline.simulation.bodies.groups.group_troupe import GROUP_RULES
from pipeline.simulation.bodies.groups.steering import MAX_SPEED, MIN_SPEED, nearest_members
from pipeline.simulation.bodies.groups.swarm import oscillated
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Take
from pipeline.spec import library, load_scene, shipped_scenes
from pipeline.spec.group import Fire, Flock, Grass, Group, Rain, School, Swarm
from tests.simulation.conftest import scene_of

CONFIGS = {
    Flock: "rule: flock, count: 40, height: 1.2, spread: 2",
    School: "rule: school, count: 40",
    Swarm: "rule: swarm, count: 40, around: pole",
    Rain: "rule: rain, count: 40, splash: true",
    Fire: "rule: fire, count: 40",
    Grass: "rule: grass, count: 40, avoid: [pole]",
}

POLE = "{name: pole, prop: {shape: ball}, at: [0.4, 0.1, 0], velocity: [0.1, 0, 0]}"


@cache
def take_of(config: str, fps: int = 24, terrain: str = "hills", at: str = "0, 6, 0") -> Take:
    return simulate(
        scene_of(
            f"{{name: group, group: {{{config}}}, at: [{at}]}}",
            POLE,
            terrain=terrain,
            duration=4,
            more=f"fps: {fps}",
        )
    )


def member_places(take: Take) -> Array:
    """Return the positions (K, N, 3) of the members [m]."""
    which = [
        i
        for i, node in enumerate(take.nodes)
        if node.performer == "group" and node.name.count(".") == 1
    ]
    return take.positions[:, which]


def velocities(take: Take) -> Array:
    return np.diff(member_places(take), axis=0) * float(take.header.rate * take.header.samples)


@pytest.mark.slow
def test_every_rule_is_implemented_and_in_a_scene() -> None:
    assert set(CONFIGS) == set(GROUP_RULES)
    scenes = [load_scene(library() / f"{name}.yaml") for name in shipped_scenes()]
    groups = [m.group for s in scenes for m in s.cast if isinstance(m, Group)]
    assert {type(group) for group in groups} == set(GROUP_RULES)


@pytest.mark.slow
@pytest.mark.parametrize("rule", CONFIGS)
def test_motion_does_not_depend_on_other_performers(rule: type) -> None:
    take = take_of(CONFIGS[rule])
    beside = simulate(
        scene_of(
            POLE,
            "{name: more, group: {rule: swarm}, at: [3, 3, 3]}",
            f"{{name: group, group: {{{CONFIGS[rule]}}}, at: [0, 6, 0]}}",
            terrain="hills",
            duration=4,
            more="fps: 24",
        )
    )
    np.testing.assert_array_equal(member_places(beside), member_places(take))


@pytest.mark.parametrize("rule", CONFIGS)
def test_poses_are_rotations_and_none_is_under_the_ground(rule: type) -> None:
    take = take_of(CONFIGS[rule])
    R = matrix(take.rotations)
    np.testing.assert_allclose(R @ np.swapaxes(R, -1, -2), np.tile(np.eye(3), (*R.shape[:2], 1, 1)),
                               atol=1e-12)  # fmt: skip
    p = member_places(take)
    ground = Simulation(scene_of(POLE, terrain="hills")).world.ground
    assert (p[..., 1] >= ground.height(p[..., 0], p[..., 2]) - 1e-9).all()


@pytest.mark.parametrize("fps", [24, 60])
def test_birds_keep_their_limits_and_head_along_their_velocity(fps: int) -> None:
    take = take_of(CONFIGS[Flock], fps)
    v = velocities(take)
    speeds = np.linalg.norm(v, axis=-1)
    # 1 % more: birds lifted over the ground fly a little faster.
    assert speeds.min() > 0.99 * MIN_SPEED * 6
    assert speeds.max() < 1.01 * MAX_SPEED * 6
    dt = 1 / float(take.header.rate * take.header.samples)
    mean = np.linalg.norm(np.diff(v, axis=0), axis=-1).mean() / dt
    assert mean < 12 + 3 * 0.16 * 6 / math.sqrt(dt)
    # The beak points along the velocity; the back leans and never faces down.
    birds = [i for i, node in enumerate(take.nodes) if node.name.count(".") == 1][:40]
    R = matrix(take.rotations[1:, birds])
    np.testing.assert_allclose(R[..., 0], v / speeds[..., None], atol=1e-6)
    assert (R[..., 1, 1] > 0.25).all()


def test_birds_bank_into_their_turns() -> None:
    take = take_of(CONFIGS[Flock])
    v = velocities(take)
    birds = [i for i, node in enumerate(take.nodes) if node.name.count(".") == 1][:40]
    up = matrix(take.rotations[1:, birds])[..., 1]
    n = 24
    turning = np.cross(v[:-n], v[n:])[..., 1]
    # Leaning to the left of the way, in the ground plane.
    left = np.stack([v[..., 2], 0 * v[..., 0], -v[..., 0]], axis=-1)
    lean = np.sum(up * left, axis=-1)[n // 2 : -(n // 2)]
    strong = np.abs(turning) > np.quantile(np.abs(turning), 0.7)
    assert np.mean(np.sign(lean[strong]) == np.sign(turning[strong])) > 0.8


def test_a_flock_stays_together_without_crowding() -> None:
    p = member_places(take_of(CONFIGS[Flock]))
    far = np.linalg.norm(p[:, :, None] - p[:, None], axis=-1)
    far[:, np.arange(40), np.arange(40)] = np.inf
    near = far.min(axis=2)
    assert 0.4 < near[96:].mean() < 1.6
    assert np.linalg.norm(p - p.mean(axis=1, keepdims=True), axis=-1)[96:].max() < 9.0


def test_neighbours_fly_in_similar_directions() -> None:
    p, v = member_places(take_of(CONFIGS[Flock])), velocities(take_of(CONFIGS[Flock]))
    alike = []
    for row in range(96, len(v), 48):
        ways = v[row] / np.linalg.norm(v[row], axis=1, keepdims=True)
        alike.append((ways[nearest_members(p[row], 5)] * ways[:, None]).sum(axis=-1).mean())
    assert np.mean(alike) > 0.85


@pytest.mark.slow
@pytest.mark.parametrize(("rule", "rates"), [(Flock, (24, 60)), (School, (24, 60))])
def test_flock_statistics_do_not_depend_on_frame_rate(rule: type, rates: tuple[int, int]) -> None:
    measures = []
    for fps in rates:
        p, v = member_places(take_of(CONFIGS[rule], fps)), velocities(take_of(CONFIGS[rule], fps))
        some = slice(len(v) // 4, None, fps // 6)
        far = np.linalg.norm(p[some][:, :, None] - p[some][:, None], axis=-1)
        far[:, np.arange(40), np.arange(40)] = np.inf
        speed = np.linalg.norm(v[some], axis=-1)
        middle = p[some].mean(axis=1, keepdims=True)
        spread = np.sqrt(((p[some] - middle) ** 2).sum(axis=-1).mean())
        measures.append([far.min(axis=2).mean(), speed.mean(), spread])
    np.testing.assert_allclose(measures[0], measures[1], rtol=0.25)


def test_a_flock_follows_and_avoids() -> None:
    config = "rule: flock, count: 30, follow: walker, above: 1, avoid: [walker], spread: 1.5"
    walker = "{name: walker, prop: {shape: ball, radius: 0.8}, at: [0, 3, 0], velocity: [2, 0, 1]}"
    take = simulate(scene_of(f"{{name: group, group: {{{config}}}, at: [-3, 4, 0]}}", walker,
                             terrain="{kind: flat, size: [90, 90]}", duration=6))  # fmt: skip
    ball = take.positions[:, [node.name for node in take.nodes].index("walker")]
    far = np.linalg.norm(member_places(take) - ball[:, None], axis=-1)
    assert far.min() >= 0.8
    assert far[-96:].mean() < 9.0


def test_go_to_moves_a_flock() -> None:
    script = "script: [{at: 1, who: group, do: {go_to: [20, 30]}}]"
    flock = "{name: group, group: {rule: flock, count: 20}, at: [0, 5, 0]}"
    terrain = "{kind: flat, size: [200, 200]}"
    sent = simulate(scene_of(flock, terrain=terrain, duration=5, more=script))
    stays = simulate(scene_of(flock, terrain=terrain, duration=5))
    np.testing.assert_array_equal(member_places(sent)[:96], member_places(stays)[:96])
    goal = np.array([20, 30])
    away = [
        np.linalg.norm(member_places(t)[-1][:, [0, 2]] - goal, axis=1).mean() for t in (sent, stays)
    ]
    assert away[0] < away[1] - 10


def test_fish_stay_in_their_volume() -> None:
    take = take_of("rule: school, count: 60, volume: [3, 1, 2]", terrain="flat", at="0, 2, 0")
    p = member_places(take) - [0, 2, 0]
    assert (np.abs(p) <= np.array([1.5, 0.5, 1.0]) + 1e-9).all()


def test_a_swarm_has_its_configured_radius_and_speed() -> None:
    config = "rule: swarm, count: 500, radius: 0.5, speed: 1.4"
    for fps in (10, 60):
        take = take_of(config, fps, "flat", "0, 9, 0")
        p = member_places(take)[:: max(fps // 10, 1)] - [0, 9, 0]
        np.testing.assert_allclose(p.mean(axis=(0, 1)), 0.0, atol=0.04)
        assert np.sqrt((p**2).sum(axis=-1).mean()) == pytest.approx(0.5, rel=0.05)
    v = velocities(take_of(config, 60, "flat", "0, 9, 0"))
    assert np.sqrt((v**2).sum(axis=-1).mean()) == pytest.approx(1.4, rel=0.05)


def test_two_short_steps_of_a_swarm_equal_one_long_step() -> None:
    stationary = np.array([0.3, 0.7])
    short, spread = oscillated(2.3, 1.2, 0.05, stationary)
    long, wide = oscillated(2.3, 1.2, 0.1, stationary)
    np.testing.assert_allclose(short @ short, long, atol=1e-14)
    twice = short @ spread @ spread.T @ short.T + spread @ spread.T
    np.testing.assert_allclose(twice, wide @ wide.T, atol=1e-14)


def test_a_swarm_follows_a_link_without_lag() -> None:
    config = "{name: group, group: {rule: swarm, count: 300, around: bug.head, radius: 0.2}}"
    take = simulate(scene_of(config, "{name: bug, figure: beetle, walk: {}}", duration=2))
    names = [node.name for node in take.nodes]
    head = take.positions[:, [i for i, n in enumerate(names) if n.startswith("bug.")]]
    middle = member_places(take).mean(axis=1)
    nearest_link = np.linalg.norm(head - middle[:, None], axis=-1).min(axis=1)
    assert nearest_link.max() < 0.12


def test_rain_strikes_the_ground_at_its_rate_at_exact_times() -> None:
    config = "rule: rain, count: 60, height: 3, speed: 6, wind: [1, 0.5], splash: true"
    takes = [take_of(config, fps, at="0, 0") for fps in (24, 60)]
    hits = [
        [(c.part, *c.place, float(t.header.rate) ** -1 / t.header.steps * (c.step + c.fraction))
         for c in t.contacts]
        for t in takes
    ]  # fmt: skip
    # 60 drops fall for half a second, and are gone for 0.15 s.
    assert len(hits[0]) == pytest.approx(4 * 60 / 0.65, abs=2)
    assert [one[0] for one in hits[0]] == [one[0] for one in hits[1]]
    np.testing.assert_allclose(
        [one[1:] for one in hits[0]], [one[1:] for one in hits[1]], atol=1e-9
    )
    ground = Simulation(scene_of(POLE, terrain="hills")).world.ground
    for contact in takes[0].contacts:
        x, y, z = contact.place
        assert y == pytest.approx(float(ground.height(np.array(x), np.array(z))), abs=1e-12)
    times = [one[-1] for one in hits[0]]
    assert times == sorted(times)
    assert {event.cause for event in takes[0].events} == {"collision"}


def test_drops_fall_straight_and_are_hidden_between_lives() -> None:
    take = take_of("rule: rain, count: 50, wind: [2, 0]", terrain="flat", at="0, 0")
    v = velocities(take)
    alive = take.alive[:, : v.shape[1]]
    falling = v[..., 1] < -1.0
    steady = falling & (v[..., 1] > -7.5) & (np.abs(v[..., 1] + 7.0) < 1e-6)
    np.testing.assert_allclose(v[steady], np.tile([2.0, -7.0, 0.0], (int(steady.sum()), 1)),
                               atol=1e-6)  # fmt: skip
    assert steady.mean() > 0.7
    assert 0.0 < 1.0 - alive.mean() < 0.1


def test_flames_rise_shrink_and_are_replaced() -> None:
    take = take_of("rule: fire, count: 60, height: 2, life: 1", terrain="flat", at="0, 1, 0")
    p, scale = member_places(take), take.scales[..., 0]
    names = [node.name for node in take.nodes]
    alive = take.alive[:, [names.index(f"group.{i}") for i in range(60)]]
    up = np.diff(p[..., 1], axis=0)
    both = alive[1:] & alive[:-1]
    born = up < -0.05
    assert (up[both & ~born] > 0.0).all()
    # Each flame is replaced about once a second.
    assert born.sum() == pytest.approx(60 * 4, rel=0.1)
    assert p[..., 1].max() <= 3.0 + 1e-9
    high = p[..., 1] > 2.5
    assert scale[high & alive].max() < 0.5 < scale[~high & alive].max()


def test_a_fire_follows_its_torch() -> None:
    fire = "{name: group, group: {rule: fire, count: 80, height: 0.3, radius: 0.02}, parent: torch,"
    torch = "{name: torch, prop: {shape: ball}, at: [0, 2, 0], velocity: [1, 0, 0]}"
    take = simulate(scene_of(f"{fire} at: [0, 0.5, 0]}}", torch, duration=3))
    p = member_places(take)
    where = take.positions[:, [node.name for node in take.nodes].index("torch")]
    low = p[..., 1] < 2.52
    behind = (where[:, None, 0] - p[..., 0])[low]
    assert np.abs(behind).max() < 0.2
    # Higher flames left it a while ago.
    assert (where[:, None, 0] - p[..., 0])[p[..., 1] > 2.65].mean() > 0.15


def test_grass_bends_away_from_feet_and_stands_elsewhere() -> None:
    grass = "{name: group, group: {rule: grass, count: 400, wind: [0, 0], avoid: [foot]}}"
    foot = "{name: foot, prop: {shape: ball, radius: 0.05}, at: [0, 0.05, 0]}"
    take = simulate(scene_of(grass, foot, duration=0.1))
    p = member_places(take)[0]
    blades = [i for i, node in enumerate(take.nodes) if node.name.startswith("group.")]
    tip = matrix(take.rotations[0, blades])[..., 1]
    away = p[:, [0, 2]]
    far = np.linalg.norm(away, axis=1)
    near = far < 0.15
    assert ((tip[:, [0, 2]] * away).sum(axis=1)[near] > 0.0).all()
    assert (tip[near, 1] < 0.97).all()
    np.testing.assert_allclose(tip[far > 0.4], np.tile([0, 1, 0], ((far > 0.4).sum(), 1)))


def test_nearest_members_match_a_full_sort() -> None:
    p = np.random.default_rng(4).random((600, 3))
    far = np.linalg.norm(p[:, None] - p[None], axis=-1)
    np.fill_diagonal(far, np.inf)
    expected = np.sort(np.argsort(far, axis=1)[:, :7], axis=1)
    np.testing.assert_array_equal(nearest_members(p, 7), expected)


def test_counter_random_is_uniform_and_independent_between_keys() -> None:
    rng, slots = CounterRandom(3, "a"), np.arange(20_000)
    draws = [rng.uniform(slots, life, draw) for life in (0, 1) for draw in (0, 1)]
    for one in draws:
        # Uniform: the largest gap of the distribution stays below Kolmogorov's bound.
        gap = np.abs(np.sort(one) - (slots + 0.5) / len(slots)).max()
        assert gap < 1.7 / math.sqrt(len(slots))
    assert np.abs(np.corrcoef(draws) - np.eye(4)).max() < 0.03
    np.testing.assert_array_equal(rng.uniform(slots[:9], 1, 1), draws[3][:9])


@pytest.mark.parametrize("count", [1, 2, 3])
def test_groups_of_one_to_three_members_work(count: int) -> None:
    for rule in ("flock", "school"):
        take = simulate(scene_of(f"{{group: {{rule: {rule}, count: {count}}}, at: [0, 4, 0]}}"))
        assert np.isfinite(take.positions).all()


@pytest.mark.parametrize(
    ("cast", "message"),
    [
        (["{group: {rule: flok}}"], "no rule is called 'flok', did you mean 'flock'"),
        (["{group: {count: 3}}"], "needs the key 'rule'"),
        (["{group: {rule: flock, cuont: 3}}"], "did you mean 'count'"),
        (["{group: {rule: flock, count: 5001}}"], "at most 5000"),
        (["{group: {rule: flock, follow: bgu}}", "{name: bug, figure: beetle}"], "mean 'bug'"),
        (["{group: {rule: flock, follow: bug.tip}}", "{name: bug, figure: beetle}"], "no part 't"),
        (["{group: {rule: flock, follow: b, path: [[0, 1, 0]]}}", POLE], "either path or follow"),
        (["{group: {rule: swarm, around: pole.x}}", POLE], "no part 'x'"),
        (["{group: {rule: grass, avoid: [poel]}}", POLE], "did you mean 'pole'"),
        (["{name: a, group: {rule: flock, avoid: [a]}}"], "cannot go along with itself"),
        (["{group: {rule: flock}, parent: pole}", POLE], "only a fire"),
        (["{name: a, group: {rule: flock}}", "{prop: {shape: ball}, parent: a}"], "is a group"),
    ],
)  # fmt: skip
def test_invalid_groups_are_refused(cast: list[str], message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        Simulation(scene_of(*cast))
    assert all(problem.line > 0 for problem in caught.value.problems)


@pytest.mark.parametrize(
    ("rule", "script", "message"),
    [
        ("rain", "{at: 1, who: group, do: {go_to: [1, 1]}}", "no script moves"),
        ("flock", "{at: 1, who: group, do: stop}", "for which stop is no order; write go_to"),
        ("flock", "{when: {arrived: group}, who: group, do: {go_to: [1, 1]}}", "never arrives"),
    ],
)
def test_unsupported_orders_are_refused(rule: str, script: str, message: str) -> None:
    member = f"{{name: group, group: {{rule: {rule}}}}}"
    with pytest.raises(SceneError, match=message):
        scene_of(member, more=f"script: [{script}]")


BUG = "{name: bug, figure: beetle, at: [3, 0], walk: {}}"
CAMPFIRE = "{name: camp, group: {rule: fire, radius: 0.3, height: 1.2}, at: [0, 0]}"


def test_a_fire_is_a_target_that_stays_where_it_burns() -> None:
    simulation = Simulation(
        scene_of(
            CAMPFIRE,
            "{name: torch, group: {rule: fire, height: 0.4}, at: [0, 1, 0], parent: pole}",
            *(BUG, POLE),
            more="script: [{at: 0, who: bug, do: {look_at: camp}}]",
        )
    )
    states = []
    for _ in range(12):
        simulation.step()
        simulation._members.update(simulation.last_row())
        states.append([simulation._members.state(name) for name in ("camp", "torch")])
    camps, torches = zip(*states, strict=True)
    for camp in camps:
        assert camp.centre == pytest.approx([0, camps[0].low[1] + 0.6, 0])
        assert (camp.radius, *camp.v) == (0.3, 0, 0, 0)
    # On the ground, and not where the flames of a moment are.
    assert abs(camps[0].low[1]) < 1e-9
    # The torch goes along with what carries it, at 0.1 m/s.
    assert torches[-1].v == pytest.approx([0.1, 0, 0], abs=1e-9)
    assert torches[-1].centre[1] == pytest.approx(0.1 + 1.0 + 0.2)


def test_a_flock_as_a_target_is_where_its_members_are() -> None:
    simulation = Simulation(
        scene_of(
            "{name: birds, group: {rule: flock, count: 30}, at: [0, 5, 0]}",
            BUG,
            more="script: [{at: 0, who: bug, do: {follow: birds}}]",
        )
    )
    for _ in range(8):
        simulation.step()
    simulation._members.update(row := simulation.last_row())
    recorder, state = simulation.recorder, simulation._members.state("birds")
    birds = recorder.positions[row, list(recorder.nodes_by_performer["birds"])]
    assert state.centre == pytest.approx(birds.mean(axis=0))
    assert state.v == pytest.approx(
        (birds - recorder.positions[row - 1, list(recorder.nodes_by_performer["birds"])]).mean(0)
        * 24
        * recorder.clock.samples
    )


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("{at: 1, who: kid, do: {grab: camp}}", "'camp' is a group; name a prop, a body or"),
        ("{when: {fell: camp}, who: kid, do: stop}", "name a member of the cast that is no group"),
        ("{when: {touch: [kid, camp]}, who: kid, do: stop}", "name one of them, such as camp.0"),
        ("{at: 1, who: bug, do: {hop_over: camp}}", "'camp' is a group; name a prop, a body or"),
        ("{at: 1, who: kid, do: {look_at: camp.x}}", "has no part 'x'"),
    ],
)
def test_groups_that_are_no_targets_are_refused(script: str, message: str) -> None:
    kid = "{name: kid, character: child, at: [-3, 0]}"
    with pytest.raises(SceneError, match=message):
        Simulation(scene_of(CAMPFIRE, kid, BUG, more=f"script: [{script}]"))


@pytest.mark.parametrize(
    "do", ["{go_to: camp}", "{look_at: camp}", "{flee: camp}", "{greet: camp}", "{point: camp.3}"]
)
def test_groups_are_targets_of_orders(do: str) -> None:
    kid = "{name: kid, character: child, at: [-3, 0]}"
    scene_of(CAMPFIRE, kid, more=f"script: [{{at: 1, who: kid, do: {do}}}]")
