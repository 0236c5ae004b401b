"""Outdoors summary: where the sun stands and what is scattered, as `pronk check` tells it."""

from __future__ import annotations

import pytest

from pipeline.production.run.outdoors_summary import scatter_text, sun_text
from pipeline.production.run.scene_check import check_scene
from pipeline.production.scenery.scenery_tally import SceneryTally
from pipeline.spec import read_scene
from render.config import Light

SCENE = """pronk: 1
frames: 4
terrain: {{kind: flat, material: grass, scatter: {scatter}}}
cast: [{{name: ball, prop: {{shape: ball}}, at: [0, 1, 0]}}]
light: {{sun: {{hour: 12, day: 172, latitude_deg: 45}}}}
"""


@pytest.mark.parametrize(
    ("sun", "told"),
    [
        # At noon in the south, 90 degrees less the latitude plus the tilt of the earth.
        ("hour: 12, day: 172, latitude_deg: 45", "12:00 on day 172: 68° high, azimuth 180°"),
        # At the equinox it rises in the east and sets in the west.
        ("hour: 6.25, day: 81, latitude_deg: 45", "6:15 on day 81: 3° high, azimuth 93°"),
        ("hour: 18, day: 81, latitude_deg: 45", "18:00 on day 81: 0° high, azimuth 270°"),
        ("hour: 12, day: 81, latitude_deg: -45", "12:00 on day 81: 45° high, azimuth 0°"),
        ("hour: 0, day: 172, latitude_deg: 45", "0:00 on day 172: 22° below the horizon"),
        # However the scene lies to the north.
        ("hour: 18, day: 81, latitude_deg: 45, north_deg: 70", "0° high, azimuth 270°"),
    ],
)
def test_a_compass_and_a_height_tell_where_the_sun_stands(sun: str, told: str) -> None:
    scene = read_scene(
        SCENE.format(scatter="none").replace("hour: 12, day: 172, latitude_deg: 45", sun)
    )
    assert told in sun_text(scene.light)


def test_a_light_without_a_sun_has_none() -> None:
    assert sun_text(Light.model_validate("studio")) == ""


def test_what_is_scattered_is_told_with_its_cost() -> None:
    preset = read_scene(SCENE.format(scatter="meadow"))
    assert "species of presets, up to 0." in scatter_text(preset)
    own = read_scene(
        SCENE.format(scatter="{preset: none, species: [{species: oak, density: 0.1}]}")
    )
    assert scatter_text(own) == "scattered: oak as dense as asked (--simulate counts them)"
    assert scatter_text(read_scene(SCENE.format(scatter="none"))) == ""
    tally = SceneryTally({"oak": 3, "short grass": 12_345, "daisy": 70, "fern": 5}, 1_234_567)
    told = scatter_text(preset, tally)
    assert told.startswith(
        "scattered: 12,345 short grass, 70 daisy, 5 fern and 3 others, 1.23 million"
    )


def test_check_tells_both_and_counts_after_simulation() -> None:
    scene = read_scene(
        SCENE.format(scatter="{preset: none, species: [{species: stone, density: 0.05}]}")
    )
    assert "; sun at 12:00 on day 172: 68° high" in check_scene(scene)
    counted = check_scene(scene, simulated=True)
    assert " stone, 0.0" in counted
    assert "million triangles" in counted
