"""Doctor: what this machine has, what will be used, and what to do about the rest."""

from __future__ import annotations

import importlib
import os
import platform
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from pipeline.production.run.manifest import LIBRARIES


@dataclass(frozen=True, slots=True)
class Finding:
    """One check of this machine.

    Attributes:
        what: name of the check, such as "LLVM".
        ok: whether it passed.
        text: finding, and what to do about a failure.
        needed: whether rendering needs it.
    """

    what: str
    ok: bool
    text: str
    needed: bool = True


def examine(fresh: bool) -> list[Finding]:
    """Return the findings of all checks.

    Args:
        fresh: whether to probe backends again.
    """
    checks: tuple[Callable[[], Iterator[Finding]], ...] = (
        _python,
        _installation,
        _packages,
        _codecs,
        lambda: _backend(fresh),
        _library,
        _code,
        _machine,
    )
    return [finding for check in checks for finding in check()]


def _python() -> Iterator[Finding]:
    found = platform.python_version()
    right = sys.version_info >= (3, 11)
    yield Finding("Python", right, found if right else f"{found}; pronk needs 3.11 or newer")


def _installation() -> Iterator[Finding]:
    """Check that the three packages of pronk are from one installation."""
    packages = [importlib.import_module(name) for name in ("pipeline", "render", "audio")]
    places = {Path(p.__file__ or "").parent.parent for p in packages}
    versions = {p.__name__: getattr(p, "__version__", "none") for p in packages}
    if len(places) == 1 and len(set(versions.values())) == 1:
        yield Finding("pronk", True, f"{versions['pipeline']}, in {places.pop()}")
        return
    found = ", ".join(f"{p.__name__} {versions[p.__name__]} in {p.__file__}" for p in packages)
    yield Finding(
        "pronk",
        False,
        f"its packages do not belong together: {found}; give pronk an "
        "environment of its own and install it there",
    )


def _packages() -> Iterator[Finding]:
    for name in LIBRARIES:
        try:
            yield Finding(name, True, version(name))
        except PackageNotFoundError:
            yield Finding(name, False, f"missing; install it with: pip install {name}")


def _codecs() -> Iterator[Finding]:
    """Report the codecs of films, and the encoders that the installed PyAV lacks."""
    from render.film_codecs import CODECS

    there = [name for name, codec in CODECS.items() if not codec.missing_encoders]
    yield Finding("codecs", bool(there), ", ".join(there) or "none; install another PyAV")
    for name, codec in CODECS.items():
        if name not in there:
            text = f"PyAV lacks {' and '.join(codec.missing_encoders)}; use another codec"
            yield Finding(name, False, text, needed=False)


def _backend(fresh: bool) -> Iterator[Finding]:
    from render.backend import choose
    from render.errors import BackendMissing

    try:
        backend = choose("auto", fresh)
    except BackendMissing as error:
        yield Finding("backend", False, str(error))
        return
    for tried in backend.probes:
        # A missing GPU is no fault.
        where = f" ({tried.library})" if tried.library else ""
        yield Finding(tried.variant, tried.works, tried.why + where, needed=False)
    yield Finding("backend", True, f"{backend.variant} will be used: {backend.why}")
    if backend.variant == "scalar_rgb":
        advice = "rendering is about twice as slow without LLVM: pip install karellen-llvm-core"
        yield Finding("speed", False, f"{advice}, or install LLVM 16 or newer", needed=False)


def _library() -> Iterator[Finding]:
    from pipeline.spec import library, shipped_scenes

    scenes = shipped_scenes()
    if scenes:
        yield Finding("scenes", True, f"{len(scenes)} shipped, in {library()}")
    else:
        yield Finding("scenes", False, f"none in {library()}; install pronk again")


def _code() -> Iterator[Finding]:
    """Report what is compiled for people and bodies."""
    from pipeline.simulation.code_samples import code_folder

    folder = code_folder()
    count = sum(1 for _ in folder.glob("*")) if folder.is_dir() else 0
    text = f"{count} files in {folder}" if count else f"none in {folder}"
    advice = "" if count else "; the first scene with people or bodies makes it, or pronk compile"
    yield Finding("compiled code", bool(count), text + advice, needed=False)


def _machine() -> Iterator[Finding]:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    yield Finding("machine", True, f"{platform.system()} {platform.machine()}, {cores} cores")
