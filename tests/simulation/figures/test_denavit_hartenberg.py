"""Denavit-Hartenberg parameters reproduce the poses of their skeleton."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipeline.simulation.figures.base_change import reroot
from pipeline.simulation.figures.denavit_hartenberg import denavit_table, from_denavit, to_denavit
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import Skeleton

Maker = Callable[[np.random.Generator, int], Skeleton]


def _round_trip(skeleton: Skeleton, rng: np.random.Generator) -> None:
    q = rng.uniform(-3, 3, (4, len(skeleton.parents)))
    rebuilt = from_denavit(to_denavit(skeleton), q)
    assert np.abs(rebuilt - JointTree.of(skeleton).pose(q)).max() < 1e-9


def test_library_figures_round_trip(shipped: Figure) -> None:
    rng = np.random.default_rng(1)
    _round_trip(shipped.skeleton, rng)
    _round_trip(reroot(shipped.skeleton, len(shipped.skeleton.links) - 1), rng)


def test_random_figures_round_trip(random_skeleton: Maker) -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        _round_trip(random_skeleton(rng, int(rng.integers(1, 13))), rng)


def test_a_and_alpha_are_distance_and_angle_between_axes(random_skeleton: Maker) -> None:
    """Two axes are the distance a and the angle α apart."""
    rng = np.random.default_rng(3)
    for _ in range(50):
        skeleton = random_skeleton(rng, 2)
        if skeleton.parents[1] != 0:
            continue
        figure = to_denavit(skeleton)
        u, v = skeleton.axes
        apart = skeleton.places[1] - skeleton.places[0]
        normal = np.cross(u, v)
        size = np.linalg.norm(normal)
        distance = abs(apart @ normal) / size if size else np.linalg.norm(np.cross(u, apart))
        assert np.isclose(figure.a[1], distance, atol=1e-12)
        assert np.isclose(np.cos(figure.alpha[1]), u @ v, atol=1e-12)
        assert figure.a[1] >= 0.0


def test_table_has_one_row_a_joint(beetle: Figure) -> None:
    rows = denavit_table(beetle.skeleton)
    assert [row.joint for row in rows] == list(beetle.skeleton.joint_names)
    assert rows[0].parent == "body"
    assert {row.kind for row in rows} == {"revolute"}
    hip, knee = rows[2], rows[3]
    assert hip.a == 0.0  # the joints of a ball cross
    assert knee.parent == hip.joint
