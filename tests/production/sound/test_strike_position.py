"""Strike positions: a plank that falls on its end, and a foot that lands on its tip."""

from __future__ import annotations

import pytest

from pipeline.production.sound.struck_bodies import StruckBodies
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene, read_scene
from pipeline.spec.scene_library import SUFFIX, library

PLANK = """\
pronk: 1
frames: 24
terrain: {{kind: flat, size: [8, 8], cells: [8, 8]}}
cast:
  - name: plank
    body: {{shape: box, size: [1.0, 0.1, 0.1], bounciness: 0}}
    at: [0, 0.8, 0]
    rotation_deg: [0, 0, {tilt}]
"""


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [30, -30, 60, -60])
def test_a_plank_that_falls_tilted_is_struck_at_its_lower_end(tilt: float) -> None:
    take = simulate(read_scene(PLANK.format(tilt=tilt)))
    first = next(event for event in take.events if event.cause == "collision")
    spot = StruckBodies(take, {}).body(first).spot
    assert spot is not None
    # The first end is at -x of the plank, which a rotation about +z lowers.
    assert spot == pytest.approx(0.0 if tilt > 0 else 1.0, abs=0.02)


def test_feet_are_struck_at_the_tips_of_their_last_links() -> None:
    take = simulate(load_scene(library() / f"first_steps{SUFFIX}"))
    bodies = StruckBodies(take, {})
    spots = [bodies.body(e).spot for e in take.events if e.cause == "footfall"]
    assert len(spots) > 20
    assert all(spot is not None and min(spot, 1 - spot) < 0.1 for spot in spots)
