"""Configuration of materials, light, camera and film."""

from __future__ import annotations

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from render.config import (
    LIGHTS,
    MATERIALS,
    Camera,
    Cuts,
    Film,
    Light,
    Material,
    Sun,
    cuts,
    light,
    material,
)
from render.lights.sun_position import sun_direction, sun_elevation_deg

PROMISED = (
    "green chitin|brown chitin|black chitin|red chitin|blue chitin|bone|wood|clay|brass|steel|"
    "rubber|skin|white plaster|grey plaster|eye|dry soil|grass|sand|snow|rock|moss"
).split("|")


@pytest.mark.parametrize("name", PROMISED)
def test_every_documented_material_exists(name: str) -> None:
    assert material(name) == MATERIALS[name]


@pytest.mark.parametrize("word", [*MATERIALS.values(), *LIGHTS.values(), Film().resolved()])
def test_serialised_models_are_equal(word: Material | Light | Film) -> None:
    assert type(word).model_validate(json.loads(word.model_dump_json())) == word


def test_an_unknown_name_suggests_the_nearest_one() -> None:
    with pytest.raises(ValueError, match="did you mean 'green chitin'"):
        material("gren chitin")
    with pytest.raises(ValueError, match="did you mean 'golden hour'"):
        light("goldenhour")


def test_an_adjusted_preset_keeps_its_other_values() -> None:
    adjusted = material({"preset": "green chitin", "roughness": 0.21})
    assert adjusted.roughness == 0.21
    assert adjusted.color == MATERIALS["green chitin"].color
    golden = light({"preset": "golden hour", "sun": {"turbidity": 5}})
    assert golden.sun is not None
    assert LIGHTS["golden hour"].sun is not None
    assert golden.sun.turbidity == 5
    assert golden.sun.hour == LIGHTS["golden hour"].sun.hour


def test_hexadecimal_colours_are_srgb() -> None:
    assert Material(color="#ff8000").color == pytest.approx((1.0, 128 / 255, 0.0))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("model", "config"),
    [
        (Material, {"roughness": math.nan}),
        (Material, {"roughness": 1.5}),
        (Material, {"color": "#12345"}),
        (Material, {"colour": "#123456"}),
        (Material, {"color": [0, 0, -1]}),
        (Light, {"sun": {"hour": 25}}),
        (Light, {"studio": {}, "moon": {}}),
        (Light, {"sun": {}, "studio": {}}),
        (Light, {"sun": {"turbidity": math.inf}}),
        (Camera, {"distance": 0}),
        (Camera, {"at": [1, 1, 1], "view": "side"}),
        (Camera, {"follow": "bug", "look_at": [0, 0, 0]}),
        (Camera, {"start": -1}),
        (Film, {"size": [641, 360]}),
        (Film, {"size": [640, 8]}),
        (Film, {"samples": 0}),
        (Film, {"shutter_deg": 400}),
        (Film, {"moments": 0}),
    ],
)
def test_invalid_values_are_rejected(model: type[Material], config: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        model.model_validate(config)


def test_cuts_start_at_zero_in_order_of_time() -> None:
    assert cuts({"follow": "bug"})[0].follow == "bug"
    assert [c.start for c in cuts([{}, {"start": 2, "view": "side"}])] == [0, 2]
    for bad in ([{"start": 1}], [{}, {"start": 2}, {"start": 2}], []):
        with pytest.raises(ValidationError):
            cuts(bad)  # type: ignore[arg-type]


def test_the_schema_accepts_a_preset_for_a_block() -> None:
    schema = TypeAdapter(Material).json_schema()
    assert "green chitin" in schema["anyOf"][0]["enum"]
    assert TypeAdapter(Cuts).json_schema()["anyOf"][-1]["type"] == "array"


def test_resolving_a_film_is_idempotent() -> None:
    film = Film(preset="final", samples=3).resolved()
    assert (film.samples, film.size, film.denoise) == (3, (1280, 720), "high")
    assert film.resolved() == film


@given(hour=st.floats(6.5, 17.5), day=st.integers(1, 366), turn=st.floats(-360, 360))
def test_the_sun_is_a_unit_vector_and_culminates_in_the_south(
    hour: float, day: int, turn: float
) -> None:
    sun = Sun(hour=hour, day=day, latitude_deg=10, north_deg=turn)
    x, y, z = sun_direction(sun)
    assert math.hypot(x, y, z) == pytest.approx(1)
    noon = Sun(hour=12, day=80, latitude_deg=48, north_deg=turn)
    # At the equinox the sun culminates at 90 - latitude; south is opposite to north.
    assert sun_elevation_deg(noon) == pytest.approx(42, abs=1)
    north = (math.cos(math.radians(turn)), -math.sin(math.radians(turn)))
    assert sun_direction(noon)[0] * north[0] + sun_direction(noon)[2] * north[1] < -0.7


def test_the_sun_sets_in_the_west() -> None:
    # North at -Z puts west at -X, east at +X.
    assert sun_direction(Sun(hour=17, north_deg=90))[0] < -0.5
    assert sun_direction(Sun(hour=7, north_deg=90))[0] > 0.5


def test_a_camera_names_the_other_key_for_a_point_and_a_name() -> None:
    with pytest.raises(ValidationError, match=r"write `follow: bug` for a camera"):
        Camera.model_validate({"look_at": "bug"})
    with pytest.raises(ValidationError, match=r"write `look_at: \[0, 1.5, 0\]` for a camera"):
        Camera.model_validate({"follow": [0, 1.5, 0]})
    assert Camera.model_validate({"follow": ["bug", "roo"]}).follow == ("bug", "roo")
