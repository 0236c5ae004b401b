"""Every gait on every figure of the library that has it, on level ground."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.named_gaits import LegRows, available_gaits
from pipeline.simulation.locomotion.gaits.stride_limits import MAX_REACH
from tests.simulation.conftest import Walk, scene_of, walk_through

LEGS = {
    "horse": (2, 2),
    "camel": (2, 2),
    "antelope": (2, 2),
    "person": (1, 1),
    "ostrich": (1, 1),
    "kangaroo": (1, 1),
    "beetle": (3, 3),
    "spider": (4, 4),
    "centipede": (10, 10),
    "tripod": (2, 1),
    "hopper": (0, 1),
}
PAIRS = [
    (figure, gait)
    for figure, (left, right) in LEGS.items()
    for gait in available_gaits(LegRows(tuple(range(left)), tuple(range(left, left + right))))
]
RUNS = [("horse", "canter"), ("antelope", "rotary gallop"), ("person", "run"), ("kangaroo", "hop")]
UNEVEN = (
    "figures: {odd: {style: insect, nodes: {a: [0, -1], b: [0, 1], k1: [-0.6, -0.8],"
    " f1: [-1.2, -0.9], k2: [-0.6, 0], f2: [-1.2, 0], k3: [-0.6, 0.8], f3: [-1.2, 0.9],"
    " k4: [0.6, -0.3], f4: [1.2, -0.3], k5: [0.6, 0.5], f5: [1.2, 0.6]},"
    " chains: [[a, b], [a, k1, f1], [a, k2, f2], [b, k3, f3], [a, k4, f4], [b, k5, f5]]}}"
)


@cache
def walk_in_gait(figure: str, gait: str, more: str = "", options: str = "") -> Walk:
    member = f"{{figure: {figure}, at: [-30, 0], walk: {{gait: {gait}{options}}}}}"
    # Horses that gallop stride over seven metres.
    terrain = "{kind: flat, size: [80, 30]}"
    return walk_through(scene_of(member, terrain=terrain, duration=1.5, more=more))


def gait_of(walk: Walk) -> Gait:
    return Gait(walk.walkers.herd.up, walk.walkers.herd.down)


def assert_walking_invariants(walk: Walk) -> None:
    """Check that stance feet hold, legs reach, soles stay above ground and joints are smooth."""
    herd, recorder = walk.walkers.herd, walk.simulation.recorder
    # Notes on drawings are about the figure, not about its walk.
    assert not [note for note in walk.take.notes if note.kind != "drawn"]
    down = walk.standing[1:] & walk.standing[:-1]
    assert np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)[down].max() < 1e-5
    assert (walk.tips[..., 1] - herd.foot_radius).min() > -1e-6
    hips = recorder.positions[:, 0, None] + np.einsum(
        "kij,lj->kli", recorder.rotations[:, 0], herd.hips
    )
    stretch = np.linalg.norm(walk.tips - hips, axis=-1) / herd.legs.lengths
    assert stretch.max() < MAX_REACH + 0.005
    dt = walk.simulation.world.clock.dt
    # The body falls in flight and is accelerated upward in stance: up to 2 g in a hop.
    # The film begins within a step, for which the feet were not placed.
    bent = np.diff(recorder.positions[:, 0], 2, axis=0)[2:]
    assert np.abs(bent).max() < 2.0 * GRAVITY * dt**2


@pytest.mark.nightly
@pytest.mark.parametrize(("figure", "gait"), PAIRS)
def test_invariants_of_walking_hold_for_every_gait_of_every_figure(figure: str, gait: str) -> None:
    assert_walking_invariants(walk_in_gait(figure, gait))


@pytest.mark.sample(2)
@pytest.mark.parametrize(("figure", "gait"), RUNS)
def test_invariants_of_walking_hold_in_running_gaits(figure: str, gait: str) -> None:
    assert_walking_invariants(walk_in_gait(figure, gait))


@pytest.mark.parametrize("gait", ["trot", "wave", "ripple", "trot, duty: 0.8"])
def test_figures_with_uneven_legs_walk(gait: str) -> None:
    walk = walk_in_gait("odd", gait, more=UNEVEN)
    assert len(walk.walkers.herd.up) == 5
    assert_walking_invariants(walk)
    assert walk.standing.any(axis=1).all()


@pytest.mark.parametrize(("figure", "gait"), RUNS)
def test_body_falls_freely_in_flight(figure: str, gait: str) -> None:
    walk = walk_in_gait(figure, gait)
    phases = np.array(walk.phases)[:, 0]
    flying = ~gait_of(walk).standing(phases).any(axis=-1)
    inner = flying[:-2] & flying[1:-1] & flying[2:]
    assert inner.any()
    height = walk.simulation.recorder.positions[:, 0, 1]
    dt = walk.simulation.world.clock.dt
    fall = np.diff(height, 2)[inner] / dt**2
    # Samples strictly within one flight; its first and last may include a contact.
    assert np.median(fall) == pytest.approx(-GRAVITY, rel=0.02)
    clear = walk.tips[..., 1] - walk.walkers.herd.foot_radius
    assert (clear[flying] >= -1e-9).all()
    assert not walk.standing[1:-1][inner].any()


@pytest.mark.parametrize("duty", [0.4, 0.7])
def test_feet_are_down_for_the_duty_factor(duty: float) -> None:
    walk: Callable[..., Walk] = walk_in_gait
    seen = walk("horse", "trot", options=f", duty: {duty}, cycle: 0.75")
    # 1.5 s are two whole cycles.
    assert abs(seen.standing[:-1].mean() - duty) < 0.02
    assert_walking_invariants(seen)


def test_people_walk_with_nearly_straight_knees() -> None:
    """And come down with the toe up, whose heel rises before the foot leaves the ground."""
    walk = walk_in_gait("person", "walk", options=", speed: 1.3")
    herd, knee, leg = walk.walkers.herd, 3, 0
    bent = np.degrees(np.abs(walk.q[:, leg, knee] - herd.legs.extended[leg, knee]))
    down = walk.standing[:, leg]
    assert np.median(bent[down]) < 36.0
    lands = np.flatnonzero(down[1:] & ~down[:-1]) + 1
    assert bent[lands].max() < 30.0
    node = herd.figures[0].skeleton.legs[leg].links[-1]
    heel = walk.simulation.recorder.positions[:, node, 1]
    lifts = np.flatnonzero(~down[1:] & down[:-1])
    ankle = np.median(heel[down])
    assert (heel[lands] < ankle).all()
    assert (heel[lifts] > ankle + 0.04).all()
