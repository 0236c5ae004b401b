"""Lamps carried by performers."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import matrix
from pipeline.spec import read_scene

SCENE = """\
pronk: 1
frames: 6
terrain: {kind: flat, size: [8, 8], cells: [8, 8]}
cast:
  - {name: bug, figure: beetle, scale: 0.6, walk: {speed: 0.6}}
light:
  preset: night
  lamps:
    - {parent: WHO, at: [0.1, 0.3, 0.05]}
    - {at: [1, 2, 3]}
    - {parent: bug, at: [0, 0.3, 0], spot: {toward: [1, 0, 0]}}
film: {shutter_deg: 180, samples: 2, moments: 2}
"""


@pytest.mark.nightly
def test_a_lamp_stays_on_its_parent_in_every_moment() -> None:
    scene = read_scene(SCENE.replace("WHO", "bug"))
    take = simulate(scene)
    shooting = ShotBuilder(scene, take)
    body = next(i for i, node in enumerate(take.nodes) if node.name == "bug.body")
    for frame in (1, 4):
        shot = shooting.shot(frame)
        moments = shot.moments
        assert len(moments) == 2
        for moment, part in zip(moments, (0.125, 0.375), strict=True):
            row = (frame - 1 + part) * take.header.samples
            low, share = int(row), row - int(row)
            p = take.positions[low, body] * (1 - share) + take.positions[low + 1, body] * share
            carried, standing, spot = moment.lamps
            # As far from the body as it was put, in every pose.
            assert np.linalg.norm(carried.p_WL - p) == pytest.approx(
                np.linalg.norm([0.1, 0.3, 0.05]), rel=1e-3
            )
            assert standing.p_WL == (1.0, 2.0, 3.0)
            assert spot.p_WS is not None
            forward = matrix(take.rotations[low, body])[:, 0]
            aimed = np.subtract(spot.p_WS, p)
            assert aimed @ forward == pytest.approx(1.0, abs=0.01)
        assert moments[0].lamps[0] != moments[1].lamps[0]


def test_an_unknown_parent_is_reported_with_its_place() -> None:
    scene = read_scene(SCENE.replace("WHO", "bug.haed"))
    with pytest.raises(SceneError, match=r"light\.lamps\[0\]\.parent.*no part 'haed'"):
        ShotBuilder(scene, simulate(scene))
