"""Tests of people in crowds."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.crossing import cross
from pipeline.simulation.characters.characters import Characters
from tests.simulation.characters.scripted_people import STEPS, play_scene


def test_who_makes_way_goes_back_to_its_place() -> None:
    def squeeze(troupe: Characters, step: int) -> None:
        # Records are in the order of the names.
        walker = troupe.persons[0]
        walker.impatience = 1.0 if walker.at[0] < 0.3 else 0.0

    scene = """
duration: 7
cast:
  - {name: anna, character: adult, at: [-2, 0]}
  - {name: ben, character: adult, at: [0, 0.15], heading_deg: 90}
script:
  - {at: 0, who: anna, do: {go_to: [2.5, 0]}}
"""
    play = play_scene(scene, squeeze)
    assert play.when("anna")
    place = play.joint("ben", "pelvis")[:, [0, 2]]
    off = np.linalg.norm(place - place[0], axis=1)
    assert off.max() > 0.15
    assert off[-1] < 0.12


def test_walkers_in_a_crowd_keep_a_headway_by_their_speed() -> None:
    count, spacing = 10, 0.6
    cast = [
        f"  - {{name: w{k}, character: adult, at: [{-spacing * k:.2f}, 0]}}" for k in range(count)
    ]
    script = [
        f"  - {{at: 0, who: w{k}, do: {{go_to: [{9.0 - 1.2 * k:.2f}, 0]}}}}" for k in range(count)
    ]
    play = play_scene("\n".join(["duration: 3", "cast:", *cast, "script:", *script]))
    followed = 0
    # Later they have spread into lanes; those with fewer people ahead follow as in a pair.
    for now in play.records[STEPS :: STEPS // 4]:
        for k in range(4, count):
            speed = float(np.linalg.norm(now["velocity"][k]))
            way = now["velocity"][k] / speed
            offset = now["at"] - now["at"][k]
            ahead = offset @ way
            aside = np.abs(offset @ np.array([-way[1], way[0]]))
            near = ahead[(ahead > 0.0) & (aside < 0.2)]
            followed += len(near)
            assert (near > 0.2 + 0.8 * speed).all()
    assert followed > 10


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ["head-on", "corner"])
def test_two_groups_cross_without_a_blow(kind: str) -> None:
    out = cross(kind, 25, 1)
    assert out.is_good, out.text()
