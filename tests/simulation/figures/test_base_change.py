"""Base changes: any link as the base and any two points as a limb keep all poses."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from pipeline.errors import SimulationError
from pipeline.simulation.figures.base_change import (
    base_pose,
    displacement,
    limb_between,
    link_poses,
    reroot,
)
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import JointTree, LimbBatch
from pipeline.simulation.figures.skeleton import BODY, Skeleton
from pipeline.simulation.spatial import Array, rotation

Maker = Callable[[np.random.Generator, int], Skeleton]


def _somewhere(rng: np.random.Generator) -> Array:
    X = np.eye(4)
    axis = rng.normal(size=3)
    X[:3, :3] = rotation(axis / np.linalg.norm(axis), rng.uniform(-3, 3))
    X[:3, 3] = rng.normal(size=3)
    return X


def _values(skeleton: Skeleton, rng: np.random.Generator) -> Array:
    return skeleton.lower + rng.random(len(skeleton.lower)) * (skeleton.upper - skeleton.lower)


def _same_poses(skeleton: Skeleton, link: int, rng: np.random.Generator) -> Skeleton:
    q, X_WB = _values(skeleton, rng), _somewhere(rng)
    rooted = reroot(skeleton, link)
    before = X_WB @ link_poses(skeleton, q)
    after = base_pose(skeleton, link, q, X_WB) @ link_poses(rooted, q)
    assert np.abs(after - before).max() < 1e-12
    return rooted


def test_every_library_link_can_be_the_base(shipped: Figure) -> None:
    rng = np.random.default_rng(1)
    for link in range(len(shipped.skeleton.links)):
        rooted = _same_poses(shipped.skeleton, link, rng)
        assert rooted.links[link].joint == BODY
        # A second change of base, as in the walk of an inchworm.
        _same_poses(rooted, int(rng.integers(len(rooted.links))), rng)


def test_base_changes_of_random_figures_move_nothing(random_skeleton: Maker) -> None:
    rng = np.random.default_rng(2)
    for _ in range(100):
        skeleton = random_skeleton(rng, int(rng.integers(1, 13)))
        for link in rng.integers(0, len(skeleton.links), 3):
            skeleton = _same_poses(skeleton, int(link), rng)


def test_base_change_is_reversible(shipped: Figure) -> None:
    skeleton = shipped.skeleton
    for link in range(len(skeleton.links)):
        back = reroot(reroot(skeleton, link), 0)
        assert np.array_equal(back.parents, skeleton.parents)
        assert np.array_equal(back.axes, skeleton.axes)
        assert [x.joint for x in back.links] == [x.joint for x in skeleton.links]


def test_limbs_agree_with_their_tree(shipped: Figure) -> None:
    for link in range(len(shipped.skeleton.links)):
        rooted = reroot(shipped.skeleton, link)
        for limb in rooted.limbs:
            inner = [int(rooted.parents[j]) for j in limb.joints[1:]]
            assert inner == list(limb.joints[:-1])
            assert limb.length > 0.0


def test_limb_across_the_old_base(shipped: Figure) -> None:
    """Tip and Jacobian of a limb are those of the whole figure seen from the base link."""
    skeleton = shipped.skeleton
    ends = [limb.links[-1] for limb in skeleton.limbs]
    rng = np.random.default_rng(4)
    tree = JointTree.of(skeleton)
    for a, b in itertools.pairwise(ends):
        base, tip = skeleton.links[a], skeleton.links[b]
        rooted, limb = limb_between(skeleton, base.name, tip.name)
        q = _values(skeleton, rng)
        place = np.append(tip.ends[1], 1.0)
        X_BN, X_BT = displacement(tree, q, base.joint), displacement(tree, q, tip.joint)
        there = np.linalg.inv(X_BN) @ X_BT @ place
        pose = LimbBatch.of([(rooted, limb)]).pose(q[list(limb.joints)][None])
        assert np.allclose(pose.tips[0], there[:3], atol=1e-12)


def test_limb_between_joints_excludes_its_tip_joint(beetle: Figure) -> None:
    skeleton = beetle.skeleton
    _, limb = limb_between(skeleton, "l1.base_yaw", "l1.joint1_bend")
    assert [skeleton.joint_names[j] for j in limb.joints] == [
        "l1.base_yaw",
        "l1.base_pitch",
        "l1.base_roll",
    ]
    _, back = limb_between(skeleton, "l1.joint1_bend", "l1.base_yaw")
    assert [skeleton.joint_names[j] for j in back.joints] == [
        "l1.joint1_bend",
        "l1.base_roll",
        "l1.base_pitch",
    ]
    _, across = limb_between(skeleton, "l1.joint1_bend", "r2.joint1_bend")
    assert len(across.joints) == 7
    assert np.allclose(across.tip, skeleton.places[skeleton.joint_names.index("r2.joint1_bend")])


def test_limb_between_its_own_ends_is_the_limb(shipped: Figure) -> None:
    skeleton = shipped.skeleton
    for limb in skeleton.limbs:
        _, same = limb_between(skeleton, "body", skeleton.links[limb.links[-1]].name)
        # A limb on another limb, such as horns on a head, includes that limb.
        assert same.joints[-len(limb.joints) :] == limb.joints
        assert np.allclose(same.tip, limb.tip)


def test_limb_between_unknown_links_is_refused(beetle: Figure) -> None:
    with pytest.raises(SimulationError, match="no link or joint 'wing'"):
        limb_between(beetle.skeleton, "wing", "l1.1")
    with pytest.raises(SimulationError, match="there is no joint"):
        limb_between(beetle.skeleton, "l1.1", "l1.1")
