"""The denoiser: faults, and what it removes and keeps."""

from __future__ import annotations

import importlib
import sys
import types
from collections.abc import Callable

import numpy as np
import pytest

from render.backend import Backend
from render.config import Film
from render.denoiser import Denoiser
from render.errors import DenoiseError
from render.frame import ALBEDO_BIAS, LightLayers
from render.renderer import Renderer
from render.shot import Shot

BLACK = LightLayers(*(np.zeros((4, 4, 3), np.float32) for _ in range(5)))


def test_a_missing_denoiser_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    denoiser = Denoiser()
    np.testing.assert_array_equal(denoiser.clean(BLACK, "off"), BLACK.light)
    with pytest.raises(DenoiseError, match=r"is missing: .*install mitsuba-oidn.*denoise: off"):
        denoiser.clean(BLACK, "fast")


def test_a_device_that_does_not_start_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    real = importlib.import_module("mitsuba_oidn")

    def device(kind: object) -> object:
        raise real.Error("unsupported hardware: SSE4.1 support is required at minimum")

    fake = types.SimpleNamespace(Device=device, DeviceType=real.DeviceType, Error=real.Error)
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", fake)  # type: ignore[arg-type]
    with pytest.raises(DenoiseError, match=r"does not start: .*SSE4\.1.*denoise: off"):
        Denoiser().clean(BLACK, "high")


def test_a_missing_denoiser_raises_before_tracing(
    backend: Backend, make_shot: Callable[..., Shot], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    renderer = Renderer(backend)
    with pytest.raises(DenoiseError, match="install mitsuba-oidn"):
        renderer.render(make_shot(film=Film(size=(64, 48), samples=1, denoise="fast")))
    assert renderer.timings.build == 0
    assert np.isfinite(renderer.render(make_shot()).light).all()


def test_albedo_and_hard_shadows_are_kept_and_indirect_light_is_denoised() -> None:
    """A checkerboard in uniform light loses its noise and stays sharp."""
    rng = np.random.default_rng(3)
    y, x = np.mgrid[:64, :64]
    color = np.where(((x + y) % 2 == 0)[..., None], 0.6, 0.1).astype(np.float32).repeat(3, axis=2)
    shadow = np.where(x > 40, 0.0, 0.5).astype(np.float32)[..., None]
    noise = rng.gamma(4.0, 0.25, (64, 64, 1)).astype(np.float32)
    layers = LightLayers(color * shadow, color, color * noise, color, 0 * color)
    truth = color * (shadow + 1.0)
    cleaned = Denoiser().clean(layers, "fast")
    assert np.abs(cleaned - truth).mean() < 0.5 * np.abs(layers.light - truth).mean()
    # Blurred checks would have one colour.
    lit, dark = cleaned[(x + y) % 2 == 0].mean(), cleaned[(x + y) % 2 == 1].mean()
    assert lit / dark > 4.0


def test_soft_shadows_are_denoised_and_the_sky_is_kept() -> None:
    """A penumbra of one sample per pixel on a checkerboard, in front of a bright backdrop."""
    rng = np.random.default_rng(4)
    y, x = np.mgrid[:96, :96]
    sky = (y < 16)[..., None]
    checks = np.where(((x + y) % 2 == 0)[..., None], 0.6, 0.1).repeat(3, axis=2)
    color = np.where(sky, 0.0, checks + ALBEDO_BIAS).astype(np.float32)
    share = np.clip((x - 24.0) / 48.0, 0.0, 1.0)[..., None]
    lit = rng.random((96, 96, 1)) < share
    nothing = np.zeros_like(color)
    truth = np.where(sky, 0.7, color * share)
    air = np.where(sky, 0.7, nothing).astype(np.float32)
    layers = LightLayers((color * lit).astype(np.float32), color, nothing, nothing, air)
    cleaned = Denoiser().clean(layers, "fast", has_soft_lights=True)
    grainy = Denoiser().clean(layers, "fast")
    assert np.abs(cleaned - truth).mean() < 0.35 * np.abs(grainy - truth).mean()
    np.testing.assert_array_equal(cleaned[:16], layers.air[:16])
    ground = cleaned[20:]
    even = ((x + y) % 2 == 0)[20:]
    assert ground[even].mean() / ground[~even].mean() > 3.0


@pytest.mark.nightly
def test_a_sampled_sky_is_denoised(renderer: Renderer, make_shot: Callable[..., Shot]) -> None:
    """Few denoised samples of an overcast sky against many."""
    from render.mitsuba_scene import MitsubaScene

    scenes = {lit: MitsubaScene(make_shot(lit=lit)) for lit in ("day", "overcast", "studio")}
    assert {lit: scene.has_soft_lights for lit, scene in scenes.items()} == {
        "day": False,
        "overcast": True,
        "studio": True,
    }
    scene = scenes["overcast"]
    truth = scene.trace(3, range(512), 512).light
    few = Film(size=(64, 48), samples=4, depth=3, denoise="fast", soft_light="full")
    shown = renderer.render(make_shot(film=few, lit="overcast")).light
    layers = scene.trace(0, range(1), 1)
    grainy = Denoiser().clean(layers, "fast")
    assert np.abs(shown - truth).mean() < 0.7 * np.abs(grainy - truth).mean()


@pytest.mark.slow
def test_softboxes_are_sampled(renderer: Renderer, make_shot: Callable[..., Shot]) -> None:
    """A studio lit by fill and rim light has little noise at few samples."""
    from render.config import light
    from render.mitsuba_scene import MitsubaScene

    scene = MitsubaScene(make_shot(lit=light({"studio": {"softness_deg": 5, "fill": 1, "rim": 1}})))
    whole = scene.trace(5, range(256), 256).light
    rounds = np.stack([scene.trace(10 + k, range(2), 2).light for k in range(16)])
    ground = whole[-16:]
    spread = rounds.std(axis=0)[-16:].mean() / ground.mean()
    assert spread < 0.33
