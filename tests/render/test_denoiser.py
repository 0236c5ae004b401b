"""A denoiser that is missing or does not start is told to who wants one, and to nobody else."""

from __future__ import annotations

import importlib
import sys
import types
from collections.abc import Callable

import numpy as np
import pytest

from render.backend import Backend
from render.denoiser import Denoiser
from render.errors import DenoiseError
from render.renderer import Renderer
from render.shot import Shot
from render.words import Film

BLACK = np.zeros((4, 4, 3), np.float32)


def test_a_missing_denoiser_names_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    denoiser = Denoiser()
    assert denoiser.clean(BLACK, BLACK, "off") is BLACK
    with pytest.raises(DenoiseError, match=r"is missing: .*install mitsuba-oidn.*denoise: off"):
        denoiser.clean(BLACK, BLACK, "fast")


def test_a_device_that_does_not_start_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    real = importlib.import_module("mitsuba_oidn")

    def device(kind: object) -> object:
        raise real.Error("unsupported hardware: SSE4.1 support is required at minimum")

    fake = types.SimpleNamespace(Device=device, DeviceType=real.DeviceType, Error=real.Error)
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", fake)  # type: ignore[arg-type]
    with pytest.raises(DenoiseError, match=r"does not start: .*SSE4\.1.*denoise: off"):
        Denoiser().clean(BLACK, BLACK, "high")


def test_without_a_denoiser_nothing_is_traced_in_vain(
    backend: Backend, make_shot: Callable[..., Shot], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    renderer = Renderer(backend)
    with pytest.raises(DenoiseError, match="install mitsuba-oidn"):
        renderer.render(make_shot(film=Film(size=(64, 48), samples=1, denoise="fast")))
    assert renderer.split.build == 0
    assert np.isfinite(renderer.render(make_shot()).light).all()
