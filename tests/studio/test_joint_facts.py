"""Joints and masses of a figure as the page gets them."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.figure_analysis import Figure, JointTree, build_figure
from pipeline.spec import library
from pipeline.studio.figure_text import figure_of_text
from pipeline.studio.joint_facts import MIRROR, posed_facts


def built(name: str) -> Figure:
    text = (library() / "figures" / f"{name}.yaml").read_text(encoding="utf-8")
    return build_figure("it", figure_of_text(text), 1.0)


@pytest.mark.parametrize("name", ["beetle", "horse"])
def test_values_of_a_twin_pose_it_as_the_mirror_image(name: str) -> None:
    figure = built(name)
    skeleton = figure.skeleton
    facts = posed_facts(figure)
    assert sum(facts["masses"].values()) > 0.0
    links = {link["name"]: link for link in facts["links"]}
    assert links["l1.1"]["twin"] == "r1"
    assert links["head.1"]["twin"] is None
    number = {joint: j for j, joint in enumerate(skeleton.joint_names)}
    q = np.zeros(len(number))
    rng = np.random.default_rng(1)
    for link in facts["links"]:
        if link["limb"] != "l1":
            continue
        for joint in link["joints"]:
            value = rng.uniform(-0.4, 0.4)
            q[number[f"l1.{joint['name']}"]] = value
            q[number[f"r1.{joint['name']}"]] = joint["twin_sign"] * value
    tree = JointTree.of(skeleton)
    X_BJ = tree.pose(q)
    tips = {}
    for limb in skeleton.limbs:
        last = limb.joints[-1]
        away = limb.tip - skeleton.places[last]
        tips[limb.name] = X_BJ[last][:3, :3] @ away + X_BJ[last][:3, 3]
    assert np.abs(tips["l1"] - skeleton.limbs[0].tip).max() > 0.05
    assert MIRROR @ tips["l1"] == pytest.approx(tips["r1"], abs=1e-9)
