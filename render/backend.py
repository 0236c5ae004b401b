"""Backend: the Mitsuba variant, and the LLVM library, that works on this machine.

An incompatible LLVM library aborts the whole process instead of raising an error, so every
candidate first renders a tiny image in a child process. The result is cached for the user until
a version, a library or the processor changes.
"""

from __future__ import annotations

import ctypes.util
import hashlib
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Literal

from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.user_cache import user_cache_folder
from render.errors import BackendMissing

Choice = Literal["auto", "cuda", "llvm", "scalar"]

_VARIANTS = {"cuda": "cuda_ad_rgb", "llvm": "llvm_ad_rgb", "scalar": "scalar_rgb"}
_ENV = "DRJIT_LIBLLVM_PATH"
_OLDEST_LLVM, _NEWEST_LLVM = 16, 40
_PROBE_TIMEOUT_S = 120.0

_PROBE = """
import sys, mitsuba as mi
mi.set_variant(sys.argv[1])
scene = mi.load_dict({
    'type': 'scene', 'light': {'type': 'constant'}, 'ball': {'type': 'sphere'},
    'camera': {'type': 'perspective', 'to_world': mi.ScalarTransform4f().look_at(
        [0, 0, 5], [0, 0, 0], [0, 1, 0]), 'film': {'type': 'hdrfilm', 'width': 4, 'height': 4}}})
image = mi.load_dict({'type': 'path', 'max_depth': 3}).render(scene, spp=2)
import numpy as np
assert np.isfinite(np.array(image)).all()
if 'llvm' in sys.argv[1]:
    import drjit as dr
    print('version', *dr.detail.llvm_version())
"""


@dataclass(frozen=True)
class ProbeResult:
    """Result of probing one candidate.

    Attributes:
        variant: of Mitsuba.
        library: path of the LLVM library, or empty.
        works: whether it rendered.
        why: the reason.
        version: of LLVM, or empty.
    """

    variant: str
    library: str
    works: bool
    why: str
    version: str = ""


@dataclass(frozen=True)
class Backend:
    """A variant of Mitsuba that has rendered on this machine.

    Attributes:
        variant: of Mitsuba, such as `llvm_ad_rgb`.
        library: path of the LLVM library, or empty.
        version: of LLVM, or empty.
        why: why it was chosen.
        probes: results of all candidates tried.
    """

    variant: str
    library: str
    version: str
    why: str
    probes: tuple[ProbeResult, ...] = field(default=(), compare=False)

    @property
    def key(self) -> str:
        """Everything in the backend that pixels depend on."""
        llvm = f" {self.version.split('.')[0]}" if self.version else ""
        return f"{self.variant}{llvm}; {_versions()}; {processor_class()}"

    def activate(self) -> None:
        """Import Mitsuba in this process with this backend.

        Raises:
            BackendMissing: Dr.Jit was imported before with another library.
        """
        if self.library and os.environ.get(_ENV) != self.library:
            if "drjit" in sys.modules:
                raise BackendMissing(
                    f"Dr.Jit was imported before the backend was chosen; set {_ENV}={self.library}"
                )
            os.environ[_ENV] = self.library
        if self.variant == _VARIANTS["cuda"] and (found := libraries()):
            # Read only once, and LLVM takes over when the GPU runs out of memory.
            os.environ.setdefault(_ENV, found[0])
        import mitsuba as mi

        mi.set_variant(self.variant)
        # Mitsuba's warnings go to standard output, where results are; errors are raised.
        mi.set_log_level(mi.LogLevel.Error)

    def describe(self) -> list[str]:
        """Return the probes and the choice as lines of text."""
        lines = [
            f"{f.variant} {f.library or '(no library)'}: {'works' if f.works else 'fails'}, {f.why}"
            for f in self.probes
        ]
        return [*lines, f"chosen: {self.variant} {self.version}: {self.why}", f"key: {self.key}"]


def choose(choice: Choice = "auto", fresh: bool = False) -> Backend:
    """Return the first backend that works of cuda, llvm and scalar, or the requested one.

    Args:
        choice: auto, or the only kind to try.
        fresh: whether to ignore the cache.

    Raises:
        BackendMissing: none works; the message says why for each.
    """
    kinds = list(_VARIANTS) if choice == "auto" else [choice]
    probes: list[ProbeResult] = []
    for variant, library in _candidates(kinds):
        result = _cached_probe(variant, library, fresh)
        probes.append(result)
        if result.works:
            why = result.why if len(probes) == 1 else f"{result.why}; first that works"
            return Backend(variant, library, result.version, why, tuple(probes))
    reasons = "\n".join(f"  {f.variant} {f.library}: {f.why}" for f in probes)
    raise BackendMissing(
        f"no backend works for {choice!r}:\n{reasons or '  no LLVM library was found'}\n"
        f"install karellen-llvm-core, or LLVM {_OLDEST_LLVM} or later and set {_ENV}; "
        "or choose scalar"
    )


def without_gpu() -> Backend:
    """Return the first backend that works without a GPU.

    Raises:
        BackendMissing: none works; the message says why for each.
    """
    try:
        return choose("llvm")
    except BackendMissing:
        return choose("scalar")


def _candidates(kinds: Sequence[str]) -> Iterator[tuple[str, str]]:
    for kind in kinds:
        for library in libraries() if kind == "llvm" else [""]:
            yield _VARIANTS[kind], library


def libraries() -> list[str]:
    """Return the LLVM libraries to try, best first: configured, of this environment, system."""
    found = [os.environ.get(_ENV, "")]
    found += sorted(map(str, Path(sys.prefix, "lib").glob("libLLVM.so.*")), reverse=True)
    folders = [Path("/usr/lib"), Path("/usr/lib64"), *Path("/usr/lib").glob("*-linux-gnu")]
    for version in range(_NEWEST_LLVM, _OLDEST_LLVM - 1, -1):
        names = (f"libLLVM-{version}.so", f"libLLVM.so.{version}", f"libLLVM.so.{version}.1")
        places = [*folders, Path(f"/usr/lib/llvm-{version}/lib")]
        found += [str(p / n) for p in places for n in names if (p / n).exists()][:1]
    if sys.platform != "linux":
        found.append(ctypes.util.find_library("LLVM") or "")
    return list(dict.fromkeys(path for path in found if path))


def _cached_probe(variant: str, library: str, fresh: bool) -> ProbeResult:
    """Return the result of a candidate, from the cache if nothing has changed since."""
    place = user_cache_folder() / f"backend-{_fingerprint(variant, library)}.json"
    if not fresh:
        try:
            return ProbeResult(**json.loads(place.read_text()))
        except (OSError, ValueError, TypeError):
            pass  # not cached, or not readable
    result = _probe(variant, library)
    try:
        make_folder(place.parent)
        write_if_changed(place, json.dumps(asdict(result)).encode())
    except OSError:
        pass  # the cache only saves time
    return result


def _probe(variant: str, library: str) -> ProbeResult:
    """Render a tiny image in a child process."""
    environment = dict(os.environ)
    if library:
        environment[_ENV] = library
    try:
        child = subprocess.run(
            [sys.executable, "-c", _PROBE, variant],
            env=environment,
            capture_output=True,
            text=True,
            timeout=_PROBE_TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return ProbeResult(variant, library, False, f"gave no answer in {_PROBE_TIMEOUT_S:g} s")
    version = next(
        (line[8:].replace(" ", ".") for line in child.stdout.splitlines() if line[:7] == "version"),
        "",
    )
    if child.returncode == 0:
        return ProbeResult(variant, library, True, "rendered a tiny image", version)
    last = (child.stderr.strip().splitlines() or ["no message"])[-1]
    if "CUDA backend hasn't been initialized" in last:
        last = "Dr.Jit found no NVIDIA GPU with a driver"
    if child.returncode < 0:
        why = f"was killed by signal {-child.returncode}: {last}"
        if library:
            why += "; Dr.Jit cannot use this LLVM"
        return ProbeResult(variant, library, False, why)
    return ProbeResult(variant, library, False, last)


def _fingerprint(variant: str, library: str) -> str:
    try:
        changed = os.stat(library).st_mtime_ns if library else 0
    except OSError:
        changed = 0
    gpu = os.path.exists("/dev/nvidiactl") if variant == _VARIANTS["cuda"] else None
    parts = (variant, library, changed, gpu, _versions(), processor_class(), sys.prefix, _PROBE)
    return hashlib.blake2b(repr(parts).encode(), digest_size=10).hexdigest()


def _versions() -> str:
    names = ("mitsuba", "drjit")
    return " ".join(f"{name} {importlib.metadata.version(name)}" for name in names)


def processor_class() -> str:
    """Return the class of processor: its vector width decides how sums are rounded."""
    try:
        flags = next(
            line for line in Path("/proc/cpuinfo").read_text().splitlines() if line[:5] == "flags"
        ).split()
    except (OSError, StopIteration):
        return platform.machine()
    width = next((name for name in ("avx512f", "avx2", "avx", "sse4_2") if name in flags), "")
    return f"{platform.machine()} {width}".strip()
