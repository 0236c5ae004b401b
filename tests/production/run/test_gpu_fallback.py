"""GPU fallback: a GPU with too little memory is replaced by the processor."""

from __future__ import annotations

import io
from unittest.mock import Mock

import pytest

from pipeline.errors import FilmingError
from pipeline.production.run import workers
from pipeline.production.run.reporters import LogReporter
from pipeline.production.shots.frame_rendering import render_frames
from render.backend import Backend
from render.errors import DeviceMemoryShort, ShotError, device_memory_errors

CUDA = Backend("cuda_ad_rgb", "", "", "for a test")
LLVM = Backend("llvm_ad_rgb", "", "23.1", "for a test")
SAID = "jit_malloc(): out of memory! Could not allocate 2147483648 bytes of device memory."


def test_a_drjit_message_becomes_a_typed_error() -> None:
    with pytest.raises(DeviceMemoryShort, match="2147483648 bytes"), device_memory_errors():
        raise RuntimeError(SAID)
    loop = RuntimeError("dr.while_loop(): encountered an exception.")
    loop.__cause__ = RuntimeError(SAID)
    with pytest.raises(DeviceMemoryShort, match="2147483648 bytes"), device_memory_errors():
        raise loop
    for other in ("nonsense", SAID.replace("device", "host")):
        with pytest.raises(RuntimeError, match=other[:10]) as error, device_memory_errors():
            raise RuntimeError(other)
        assert not isinstance(error.value, DeviceMemoryShort)


def test_the_processor_goes_on_and_it_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[str] = []

    def work(backend: Backend) -> str:
        tried.append(backend.variant)
        if backend is CUDA:
            with device_memory_errors():
                raise RuntimeError(SAID)
        return "film"

    monkeypatch.setattr(workers, "choose", lambda choice: CUDA)
    monkeypatch.setattr(workers, "without_gpu", lambda: LLVM)
    stream = io.StringIO()
    assert workers.with_gpu_fallback("auto", LogReporter(stream), work) == "film"
    assert tried == ["cuda_ad_rgb", "llvm_ad_rgb"]
    assert "too little memory" in stream.getvalue()
    assert "going on with llvm_ad_rgb" in stream.getvalue()


def test_rendering_passes_only_the_lack_of_memory_through() -> None:
    for error, seen in (
        (DeviceMemoryShort("short"), DeviceMemoryShort),
        (ShotError("x"), FilmingError),
    ):
        renderer, shooting = Mock(), Mock()
        renderer.render.side_effect = error
        with pytest.raises(seen):
            list(render_frames(renderer, shooting, Mock(), {1: "key"}))
