"""A denoiser that is missing or does not start is told to who wants one, and to nobody else."""

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
from render.exposure import GLEAM, Exposure
from render.renderer import Renderer
from render.shot import Shot

BLACK = Exposure(*(np.zeros((4, 4, 3), np.float32) for _ in range(4)))


def test_a_missing_denoiser_names_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    denoiser = Denoiser()
    np.testing.assert_array_equal(denoiser.clean(BLACK, "off"), BLACK.light)
    with pytest.raises(DenoiseError, match=r"is missing: .*install mitsuba-oidn.*denoise: off"):
        denoiser.clean(BLACK, "fast")


def test_a_device_that_does_not_start_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    real = importlib.import_module("mitsuba_oidn")

    def device(kind: object) -> object:
        raise real.Error("unsupported hardware: SSE4.1 support is required at minimum")

    fake = types.SimpleNamespace(Device=device, DeviceType=real.DeviceType, Error=real.Error)
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", fake)  # type: ignore[arg-type]
    with pytest.raises(DenoiseError, match=r"does not start: .*SSE4\.1.*denoise: off"):
        Denoiser().clean(BLACK, "high")


def test_without_a_denoiser_nothing_is_traced_in_vain(
    backend: Backend, make_shot: Callable[..., Shot], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    renderer = Renderer(backend)
    with pytest.raises(DenoiseError, match="install mitsuba-oidn"):
        renderer.render(make_shot(film=Film(size=(64, 48), samples=1, denoise="fast")))
    assert renderer.split.build == 0
    assert np.isfinite(renderer.render(make_shot()).light).all()


def test_sharp_colours_and_shadows_are_kept_and_soft_light_is_cleaned() -> None:
    """Ground of two colours in one light: its noise goes, and the checks stay as they are."""
    rng = np.random.default_rng(3)
    y, x = np.mgrid[:64, :64]
    color = np.where(((x + y) % 2 == 0)[..., None], 0.6, 0.1).astype(np.float32).repeat(3, axis=2)
    shadow = np.where(x > 40, 0.0, 0.5).astype(np.float32)[..., None]
    noise = rng.gamma(4.0, 0.25, (64, 64, 1)).astype(np.float32)
    exposure = Exposure(color * shadow, color, color * noise, color)
    truth = color * (shadow + 1.0)
    cleaned = Denoiser().clean(exposure, "fast")
    assert np.abs(cleaned - truth).mean() < 0.5 * np.abs(exposure.light - truth).mean()
    # A check that were blurred would be of one colour with its neighbour.
    lit, dark = cleaned[(x + y) % 2 == 0].mean(), cleaned[(x + y) % 2 == 1].mean()
    assert lit / dark > 4.0


def test_soft_shadows_of_a_wide_light_are_cleaned_and_the_sky_is_kept() -> None:
    """Half-shadow as one sample finds it, lit or not, on checks before a bright backdrop."""
    rng = np.random.default_rng(4)
    y, x = np.mgrid[:96, :96]
    sky = (y < 16)[..., None]
    checks = np.where(((x + y) % 2 == 0)[..., None], 0.6, 0.1).repeat(3, axis=2)
    color = np.where(sky, 0.0, checks + GLEAM).astype(np.float32)
    share = np.clip((x - 24.0) / 48.0, 0.0, 1.0)[..., None]
    lit = rng.random((96, 96, 1)) < share
    nothing = np.zeros_like(color)
    truth = np.where(sky, 0.7, color * share)
    exposure = Exposure(np.where(sky, 0.7, color * lit).astype(np.float32), color, nothing, nothing)
    cleaned = Denoiser().clean(exposure, "fast", wide=True)
    grainy = Denoiser().clean(exposure, "fast")
    assert np.abs(cleaned - truth).mean() < 0.35 * np.abs(grainy - truth).mean()
    np.testing.assert_array_equal(cleaned[:16], exposure.direct[:16])
    ground = cleaned[20:]
    even = ((x + y) % 2 == 0)[20:]
    assert ground[even].mean() / ground[~even].mean() > 3.0


@pytest.mark.slow
def test_a_sky_that_surfaces_ask_for_is_wide_and_its_grain_is_cleaned(
    renderer: Renderer, make_shot: Callable[..., Shot]
) -> None:
    """Few samples of an overcast sky, as rendered, against many; of a sun, all is as it was."""
    from render.mitsuba_scene import Stage

    stages = {lit: Stage(make_shot(lit=lit)) for lit in ("day", "overcast", "studio")}
    assert {lit: stage.wide for lit, stage in stages.items()} == {
        "day": False,
        "overcast": True,
        "studio": True,
    }
    stage = stages["overcast"]
    truth = stage.expose(3, range(512), 512).light
    few = Film(size=(64, 48), samples=4, depth=3, denoise="fast", soft_light="full")
    shown = renderer.render(make_shot(film=few, lit="overcast")).light
    exposure = stage.expose(0, range(1), 1)
    grainy = Denoiser().clean(exposure, "fast")
    assert np.abs(shown - truth).mean() < 0.7 * np.abs(grainy - truth).mean()


@pytest.mark.slow
def test_softboxes_are_asked_for(renderer: Renderer, make_shot: Callable[..., Shot]) -> None:
    """A studio without a key light nearly: what its fill and rim do is no grain of a few hits."""
    from render.config import light
    from render.mitsuba_scene import Stage

    stage = Stage(make_shot(lit=light({"studio": {"softness_deg": 5, "fill": 1, "rim": 1}})))
    whole = stage.expose(5, range(256), 256).light
    rounds = np.stack([stage.expose(10 + k, range(2), 2).light for k in range(16)])
    ground = whole[-16:]
    spread = rounds.std(axis=0)[-16:].mean() / ground.mean()
    assert spread < 0.33
