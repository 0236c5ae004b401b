"""Backend: probing, choice and cache."""

from __future__ import annotations

from pathlib import Path

import pytest

from render import backend as module
from render.backend import choose, libraries
from render.errors import BackendMissing


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def probe(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr(module, "_PROBE", "import os, sys\n" + text)


FAKE = "if 'fake' in os.environ.get('DRJIT_LIBLLVM_PATH', ''): os.abort()\nprint('version 23 1 4')"


@pytest.mark.usefixtures("own_cache")
def test_an_aborting_library_is_skipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake = tmp_path / "libLLVM.fake.so"
    fake.write_bytes(b"")
    probe(monkeypatch, FAKE)
    monkeypatch.setattr(module, "libraries", lambda: [str(fake), "/good.so"])
    chosen = choose("llvm")
    assert (chosen.library, chosen.version) == ("/good.so", "23.1.4")
    assert "signal 6" in chosen.probes[0].why
    assert any("signal 6" in line for line in chosen.describe())


@pytest.mark.usefixtures("own_cache")
def test_without_a_backend_all_reasons_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    probe(monkeypatch, "sys.exit('no such luck')")
    monkeypatch.setattr(module, "libraries", lambda: ["/a.so"])
    with pytest.raises(BackendMissing, match=r"(?s)/a.so: no such luck.*install"):
        choose("auto")


@pytest.mark.usefixtures("own_cache")
def test_a_cached_probe_is_reused(monkeypatch: pytest.MonkeyPatch) -> None:
    probe(monkeypatch, "print('version 23 1 4')")
    monkeypatch.setattr(module, "libraries", lambda: ["/a.so"])
    first = choose("llvm")
    monkeypatch.setattr(module.subprocess, "run", None)
    assert choose("llvm") == first


def test_a_damaged_probe_is_made_again(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    probe(monkeypatch, "print('version 23 1 4')")
    monkeypatch.setattr(module, "libraries", lambda: ["/a.so"])
    first = choose("llvm")
    (cached,) = (own_cache / "pronk").iterdir()
    whole = cached.read_bytes()
    for damaged in (whole.replace(b"/a.so", b"/b.so"), whole[:-3], b"", b"{}", b"[1]"):
        cached.write_bytes(damaged)
        assert choose("llvm") == first
        assert cached.read_bytes() == whole


def test_an_unwritable_cache_is_ignored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    probe(monkeypatch, "print('version 23 1 4')")
    monkeypatch.setattr(module, "libraries", lambda: ["/a.so"])
    assert choose("llvm").version == "23.1.4"


def test_a_configured_library_comes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", "/told.so")
    assert libraries()[0] == "/told.so"


@pytest.mark.slow
@pytest.mark.usefixtures("own_cache")
def test_a_file_that_is_no_library_is_skipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = tmp_path / "libLLVM.so"
    fake.write_bytes(b"this is no library")
    monkeypatch.setattr(module, "libraries", lambda: [str(fake)])
    with pytest.raises(BackendMissing, match="libLLVM"):
        choose("llvm")
    assert choose("scalar").variant == "scalar_rgb"
