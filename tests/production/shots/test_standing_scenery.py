"""Standing scenery: what glows is apart from what only stands there."""

from __future__ import annotations

import pytest

from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene

SCENE = """
pronk: 1
frames: 1
terrain: {{kind: flat, size: [16, 12], material: concrete, surroundings: forest, edging: houses}}
cast:
  - {{figure: beetle}}
light: {{sun: {{hour: {hour}, day: 172, latitude_deg: 48}}}}
film: {{size: [320, 180]}}
"""


@pytest.mark.nightly
@pytest.mark.parametrize(("hour", "is_lit"), [(12, False), (22, True)])
def test_windows_are_lit_after_dark(hour: int, is_lit: bool) -> None:
    scene = read_scene(SCENE.format(hour=hour))
    shot = ShotBuilder(scene, simulate(scene)).shot(1)
    lit = {mesh.material for mesh in shot.meshes if shot.materials[mesh.material].glow > 0.0}
    assert ("edging lit pane" in lit) == is_lit
    standing = {mesh.material for mesh in shot.scenery}
    assert ("edging lit pane" in standing) != is_lit
    assert "edging pane" in standing
    assert all(shot.materials[name].glow == 0.0 for name in standing)
