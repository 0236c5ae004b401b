"""Lamps: how much light they give, and where."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from render.backend import Backend
from render.color import linear, luminance
from render.config import Film, Lamp, Light, light, material
from render.errors import ShotError
from render.renderer import Renderer
from render.shot import CameraPose, LampPlace, Mesh, Moment, Shot

Make = Callable[..., Shot]

FILM = Film(size=(48, 36), samples=64, depth=2, denoise="off")


def card(lamps: list[dict[str, object]], distance: float = 1.0) -> Shot:
    """Return a grey card with a lamp above its middle, seen from above, and no other light."""
    corners = np.array([[-5, 0, -5], [5, 0, -5], [5, 0, 5], [-5, 0, 5]], np.float32)
    mesh = Mesh("card", corners, np.array([[0, 2, 1], [0, 3, 2]], np.uint32), "card", smooth=False)
    config = material({"color": [0.4613561] * 3, "roughness": 1.0})
    lit = Light.model_validate({"studio": {"fill": 0, "rim": 0, "backdrop": [0, 0, 0]}})
    lamp = [{"at": [0, distance, 0], "radius": 0.0, "color": [1, 1, 1], **one} for one in lamps]
    lit = Light.model_validate({**lit.model_dump(), "lamps": lamp})
    pose = CameraPose((0.0, 0.6, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_deg=10)
    return Shot((mesh,), {"card": config}, lit, pose, FILM)


def middle(renderer: Renderer, shot: Shot) -> float:
    """Return the light of the lamps alone in the middle of the picture."""
    dark = replace(shot, light=shot.light.model_copy(update={"lamps": ()}))
    seen = renderer.render(shot).light - renderer.render(dark).light
    return float(luminance(seen)[16:20, 20:28].mean())


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", [{}, {"radius": 0.04}, {"spot": {"toward": [0, 0, 0]}, "radius": None}]
)
def test_brightness_one_shows_a_grey_card_as_middle_grey_a_metre_away(
    renderer: Renderer, kind: dict[str, object]
) -> None:
    """Inverse square law for visible and hidden bulbs and for spots."""
    near = middle(renderer, card([{"brightness": 1, **kind}], 1.0))
    assert near == pytest.approx(0.18 * 1.25, rel=0.12)
    assert middle(renderer, card([{"brightness": 4, **kind}], 2.0)) == pytest.approx(near, rel=0.04)


@pytest.mark.slow
def test_lamps_add_up(renderer: Renderer) -> None:
    one = middle(renderer, card([{"brightness": 1}]))
    assert middle(renderer, card([{"brightness": 1}, {"brightness": 2}])) == pytest.approx(
        3 * one, rel=0.02
    )


@pytest.mark.nightly
@pytest.mark.parametrize("kind", [{}, {"radius": 0}, {"spot": {"toward": [0, 0, 0]}}])
def test_a_lamp_moved_in_place_equals_a_fresh_build(
    renderer: Renderer, backend: Backend, make_shot: Make, kind: dict[str, object]
) -> None:
    shot = make_shot(lit=light({"lamps": [{"at": [0, 1.5, 1], **kind}]}))
    renderer.render(shot)
    built = renderer.timings.build
    aim = (0.5, 0.0, 0.0) if "spot" in kind else None
    moved = replace(shot, lamps=(LampPlace((1.0, 1.2, 1.0), aim),))
    light_moved = renderer.render(moved).light
    assert renderer.timings.build == built
    np.testing.assert_array_equal(light_moved, Renderer(backend).render(moved).light)
    assert not np.array_equal(light_moved, renderer.render(shot).light)
    assert shot.digest != moved.digest
    assert shot.build == moved.build


@pytest.mark.nightly
def test_a_lamp_moves_while_the_shutter_is_open(renderer: Renderer, make_shot: Make) -> None:
    film = Film(size=(48, 36), samples=256, depth=2, denoise="off")
    shot = make_shot(film=film, lit=light({"lamps": [{"at": [-1, 1.5, 1], "radius": 0}]}))
    a, b = LampPlace((-1.0, 1.5, 1.0)), LampPlace((1.0, 1.5, 1.0))
    each = [renderer.render(replace(shot, lamps=(place,))).light for place in (a, b)]
    both = replace(shot, lamps=(a,), later=(Moment(shot.meshes, shot.camera, (b,)),))
    np.testing.assert_allclose(
        renderer.render(both).light.mean(axis=(0, 1)),
        np.mean(each, axis=(0, 1, 2)),
        rtol=0.02,
    )


def test_lamps_alone_at_night_are_neither_black_nor_burnt(
    renderer: Renderer, make_shot: Make
) -> None:
    lit = light({"lamps": [{"at": [0.5, 1.6, 1.2]}], "moon": {"phase": 0}, "stars": 0})
    film = Film(size=(64, 48), samples=16, depth=3, denoise="off")
    frame = renderer.render(make_shot(lit=lit, film=film))
    assert np.isfinite(frame.light).all()
    assert 25 < frame.srgb8.mean() < 150
    assert (frame.srgb8.min(axis=-1) > 245).mean() < 0.03


def test_colours_follow_the_temperature() -> None:
    from render.lights.lamps import blackbody, radiant_intensity

    # White of 6500 K is nearly that of the screen; the cooler, the redder.
    np.testing.assert_allclose(blackbody(6500), np.ones(3), atol=0.06)
    reds = [
        blackbody(k)[0] / max(blackbody(k)[2], 1e-6) for k in (1700, 2200, 2700, 4000, 6500, 10000)
    ]
    assert (np.diff(reds) < 0).all()
    for k in (1000, 2221, 2223, 3999, 4001, 20000):
        assert float(luminance(blackbody(k))) == pytest.approx(1.0)
    for edge in (2222, 4000):
        np.testing.assert_allclose(blackbody(edge - 0.01), blackbody(edge + 0.01), atol=0.01)
    own = radiant_intensity(Lamp(color=(1.0, 0.5, 0.0)))
    np.testing.assert_allclose(own / own[0], linear([1.0, 0.5, 0.0]), atol=1e-9)


def test_conflicting_lamps_are_rejected(renderer: Renderer, make_shot: Make) -> None:
    for config in (
        {"radius": 0.1, "spot": {"toward": [0, 0, 0]}},
        {"at": [1, 1, 1], "spot": {"toward": [1, 1, 1]}},
        {"brightness": -1},
        {"temperature_k": 0},
    ):
        with pytest.raises(ValidationError):
            Lamp.model_validate(config)
    nowhere = replace(
        make_shot(lit=light({"lamps": [{}]})), lamps=(LampPlace((0.0, float("nan"), 0.0)),)
    )
    with pytest.raises(ShotError, match="not finite"):
        renderer.render(nowhere)
