"""Mutual hugs: two who are told to hug each other meet half-way, gently, and hold."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters.hug_tasks import wrapped
from pipeline.simulation.people.proportions import BACK_DEPTH, TRUNK_BREADTH
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import matrix
from pipeline.spec import read_scene

SCENE = """\
pronk: 1
duration: 6
cast:
  - {{name: a, character: adult, at: [0, 0], heading_deg: {turns[0]}, scale: {scales[0]}}}
  - {{name: b, character: adult, at: [{way}, 0], heading_deg: {turns[1]}, scale: {scales[1]}}}
script:
  - {{at: 0.3, who: a, do: {{hug: b}}}}
  - {{at: 0.3, who: b, do: {{hug: a}}}}
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("way", "scales", "turns"),
    [
        (3.5, (1.14, 1.24), (90, -20)),
        (3.6, (0.86, 1.01), (0, 180)),
        (2.6, (1.03, 1.12), (170, 30)),
        (2.0, (0.97, 0.75), (-60, 120)),
    ],
)
def test_two_who_are_told_at_once_hold_each_other_unhurt(
    way: float, scales: tuple[float, float], turns: tuple[float, float]
) -> None:
    take = simulate(read_scene(SCENE.format(way=way, scales=scales, turns=turns)))
    pelvises = [k for k, node in enumerate(take.nodes) if node.name.endswith(".pelvis")]
    a, b = (np.asarray(take.positions)[:, k][:, [0, 2]] for k in pelvises)
    late = len(a) * 2 // 3
    gap = np.linalg.norm(a - b, axis=-1)[late:]
    assert gap.max() < 0.075 * 1.75 * sum(scales) + 0.2
    assert not [event for event in take.events if event.cause == "cry"]
    assert {event.who for event in take.events if event.cause == "hug"} == {"a", "b"}


def test_a_string_goes_around_an_oval_as_far_as_it_reaches() -> None:
    oval, start = (0.1, 0.16), (-0.3, 0.15)
    lengths = (0.1, 0.3, 0.35, 0.4, 0.45, 2.0)
    ends = np.array([wrapped(start, oval, math.radians(70.0), length) for length in lengths])
    sizes = np.hypot(ends[:, 0] / oval[0], ends[:, 1] / oval[1])
    # Too short a string ends before the oval, all others on it; none goes through it.
    assert sizes.min() > 0.98
    np.testing.assert_allclose(sizes[1:], 1.0, atol=0.02)
    assert math.dist(ends[0], start) == pytest.approx(0.1)
    assert (np.diff(ends[:, 0]) > 0.0).all()
    last = oval[0] * math.sin(math.radians(70.0)), oval[1] * math.cos(math.radians(70.0))
    assert ends[-1] == pytest.approx(last)
    # From beside the middle it goes to the back, and not to the front; from inside, too.
    assert wrapped((0.0, 0.2), oval, math.radians(70.0), 0.25)[0] > 0.05
    inside = np.array(wrapped((0.02, 0.12), oval, math.radians(70.0), 0.2))
    assert inside[0] > 0.05
    assert np.hypot(*(inside / oval)) == pytest.approx(1.0, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("scales", [(1.0, 1.05), (1.2, 0.85)])
def test_palms_lie_flat_on_the_other_ones_back(scales: tuple[float, float]) -> None:
    take = simulate(read_scene(SCENE.format(way=2.0, scales=scales, turns=(0, 180))))
    number = {node.name: k for k, node in enumerate(take.nodes)}
    row, rotations = -2, matrix(take.rotations[-2])
    for name, other, scale in (("a", "b", scales[1]), ("b", "a", scales[0])):
        chest = rotations[number[f"{other}.chest"]]
        places = []
        for side, way in (("l", -1.0), ("r", 1.0)):
            hand = number[f"{name}.hand_{side}"]
            spine = take.positions[row, number[f"{other}.chest"]]
            offset = (take.positions[row, hand] - spine) @ chest
            size = np.array([BACK_DEPTH, TRUNK_BREADTH]) * 1.72 * scale
            # The wrist lies on the oval of the trunk, behind its middle.
            assert 0.8 < np.hypot(*(offset[[0, 2]] / size)) < 1.75
            assert offset[0] < 0.0
            # The back of the hand looks away from the trunk, and fingers go on around it.
            outward = chest @ np.array([-1.0, 0.0, 0.0])
            assert way * rotations[hand, :, 2] @ outward > 0.75
            places.append(take.positions[row, hand] - 0.08 * rotations[hand, :, 1])
        # Both hands lie above one another, and not in one another.
        assert math.dist(*places) > 0.05
