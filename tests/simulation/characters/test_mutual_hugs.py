"""Mutual hugs: two who are told to hug each other meet half-way, gently, and hold."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.simulate import simulate
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
