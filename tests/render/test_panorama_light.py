"""Panoramas as light."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from render.color import luminance
from render.config import Film, Light, light
from render.errors import ShotError
from render.panorama_file import file_digest, panorama_fault
from render.renderer import Renderer
from render.shot import Shot

Make = Callable[..., Shot]


def sky(sun: float = 0.0, width: int = 256) -> np.ndarray:
    """Return a bluish sky over dark ground, with a sun of some pixels towards +X, 40 degrees up."""
    from render.lights.environment_map import direction_of, pixel_directions

    d = pixel_directions(width, width // 2)
    image = np.where(d[..., 1:2] > 0, np.array([0.4, 0.5, 0.8]), 0.1) * np.ones(3)
    spot = d @ direction_of(0.0, np.radians(40.0)) > np.cos(np.radians(1.5))
    image[spot] += sun * np.array([1.0, 0.9, 0.7])
    return image.astype(np.float32)


def written(path: Path, image: np.ndarray) -> str:
    import mitsuba as mi

    mi.Bitmap(np.ascontiguousarray(image, np.float32)).write(str(path))
    return str(path)


@pytest.mark.parametrize("name", ["place.exr", "place.hdr"])
@pytest.mark.parametrize("normal", [(0, 1, 0), (0.77, 0.64, 0), (0.3, 0.2, 0.93)])
def test_sky_and_sun_sum_to_the_panorama(
    tmp_path: Path, name: str, normal: tuple[float, float, float]
) -> None:
    from render.lights.environment_map import irradiance, normalized
    from render.lights.panorama_light import panorama_light

    image = sky(sun=2000.0)
    lit = light({"hdr": {"file": written(tmp_path / name, image)}})
    assert lit.hdr is not None
    rest, key = panorama_light(lit.hdr)
    n = normalized(np.array(normal, float))
    sent = irradiance(rest, n) + key.irradiance * max(float(n @ key.direction), 0.0)
    # RGBE keeps eight bits; a disc of three degrees is not quite one direction.
    np.testing.assert_allclose(sent, irradiance(image, n), rtol=0.01)
    assert rest.max() < 1.0
    assert key.diameter_deg == pytest.approx(3.0, abs=0.3)


def test_a_sky_without_sun_has_no_key_light(tmp_path: Path) -> None:
    from render.lights.environment_emitters import surroundings

    for sun in (0.0, 3.0):
        lit = light({"hdr": {"file": written(tmp_path / "a.exr", sky(sun))}})
        assert set(surroundings(lit, (0.2, 0.2, 0.2)).emitters) == {"sky"}
    dark = light({"hdr": {"file": written(tmp_path / "b.exr", 0 * sky())}})
    assert np.array(surroundings(dark, (0.2, 0.2, 0.2)).emitters["sky"]["bitmap"]).max() == 0


def test_a_panorama_turns_about_the_vertical(tmp_path: Path) -> None:
    """A sun towards +X, turned by a quarter, stands towards -Z, as headings do."""
    from render.lights.panorama_light import panorama_light

    file = written(tmp_path / "a.exr", sky(2000.0))
    for turn, xz in ((0, (1, 0)), (90, (0, -1)), (180, (-1, 0)), (-45, (0.707, 0.707))):
        config = light({"hdr": {"file": file, "turn_deg": turn}}).hdr
        assert config is not None
        toward = panorama_light(config)[1].direction
        flat = toward[[0, 2]] / np.hypot(*toward[[0, 2]])
        np.testing.assert_allclose(flat, xz, atol=0.02)


@pytest.mark.nightly
def test_a_reduced_panorama_gives_the_same_light(tmp_path: Path) -> None:
    from render.lights.environment_map import UP, irradiance
    from render.panorama_reader import reduced

    image = sky(100.0, width=4096).astype(np.float64)
    small = reduced(image)
    assert small.shape == (1024, 2048, 3)
    np.testing.assert_allclose(irradiance(small, UP), irradiance(image, UP), rtol=1e-3)


@pytest.mark.nightly
def test_strength_scales_the_exposed_panorama(
    renderer: Renderer, make_shot: Make, tmp_path: Path
) -> None:
    file = written(tmp_path / "a.exr", sky(2000.0) * 37.0)
    film = Film(size=(64, 48), samples=16, depth=3, denoise="off")

    def seen(strength: float) -> np.ndarray:
        lit = Light.model_validate({"hdr": {"file": file, "strength": strength}})
        return np.asarray(renderer.render(make_shot(lit=lit, film=film)).light)

    once = seen(1.0)
    np.testing.assert_allclose(seen(2.0), 2 * once, rtol=1e-3, atol=1e-5)
    assert 0.1 < float(luminance(once).mean()) < 0.6


@pytest.mark.nightly
def test_a_cut_out_sun_lights_the_scene_as_the_full_panorama(
    renderer: Renderer, make_shot: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from render.lights import panorama_light

    lit = Light.model_validate({"hdr": {"file": written(tmp_path / "a.exr", sky(600.0))}})
    film = Film(size=(32, 24), samples=1024, depth=3, denoise="off")
    parted = Renderer(renderer.backend).render(make_shot(lit=lit, film=film)).light
    monkeypatch.setattr(panorama_light, "_SUN", panorama_light.SunDetection(min_share=2.0))
    whole = Renderer(renderer.backend).render(make_shot(lit=lit, film=film)).light
    # Both are exposed by a card, which is turned to the key light where there is one.
    ratio = parted / whole
    scale = float(np.median(ratio))
    np.testing.assert_allclose(parted.mean() / whole.mean(), scale, rtol=0.02)
    assert np.abs(ratio / scale - 1).mean() < 0.05


def test_the_digest_of_a_panorama_is_of_its_content(make_shot: Make, tmp_path: Path) -> None:
    a, b = tmp_path / "a.exr", tmp_path / "b.exr"
    written(a, sky())
    b.write_bytes(a.read_bytes())

    def build(file: Path) -> str:
        return make_shot(lit=light({"hdr": {"file": str(file)}})).build

    first = build(a)
    assert build(b) == first
    written(b, sky(5.0))
    assert build(b) != first
    assert file_digest(tmp_path / "none.exr") == ""


def test_an_unusable_panorama_is_reported(tmp_path: Path) -> None:
    good = Path(written(tmp_path / "good.hdr", sky()))
    assert panorama_fault(good) is None
    written(tmp_path / "square.exr", sky()[:, :128])
    assert "128 by 128" in str(panorama_fault(tmp_path / "square.exr"))
    for name, content in {
        "torn.exr": b"v/1\x01\x02",
        "torn.hdr": b"#?RADIANCE\n",
        "a.hdr": b"",
    }.items():
        (tmp_path / name).write_bytes(content)
        assert "cannot be read" in str(panorama_fault(tmp_path / name))
    assert "is no .exr or .hdr file" in str(panorama_fault(tmp_path / "a.png"))
    torn = tmp_path / "half.exr"
    torn.write_bytes(Path(written(tmp_path / "whole.exr", sky())).read_bytes()[:3000])
    from render.lights.environment_emitters import surroundings

    with pytest.raises(ShotError, match=r"half\.exr"):
        surroundings(light({"hdr": {"file": str(torn)}}), (0.2, 0.2, 0.2))
