"""Backend: which variant of Mitsuba works on this machine, with which LLVM.

A library of LLVM that does not fit aborts the whole process instead of raising an
error, so every candidate first renders a tiny picture in a child process. The
outcome is remembered in the user's cache until a version, a library or the
processor changes.
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

from render.errors import BackendMissing

Choice = Literal["auto", "cuda", "llvm", "scalar"]

_VARIANTS = {"cuda": "cuda_ad_rgb", "llvm": "llvm_ad_rgb", "scalar": "scalar_rgb"}
_ENV = "DRJIT_LIBLLVM_PATH"
_OLDEST, _NEWEST = 16, 40
_PATIENCE_S = 120.0

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
class Finding:
    """What became of one candidate.

    Attributes:
        variant: of Mitsuba.
        library: path of LLVM's library, or empty.
        works: whether it rendered.
        why: the reason, in words.
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
        library: path of LLVM's library, or empty.
        version: of LLVM, or empty.
        why: why it was chosen.
        findings: what became of each candidate tried.
    """

    variant: str
    library: str
    version: str
    why: str
    findings: tuple[Finding, ...] = field(default=(), compare=False)

    @property
    def key(self) -> str:
        """All of the backend that pixels depend on."""
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
            # It is read only once: LLVM may have to go on where the GPU's memory ends.
            os.environ.setdefault(_ENV, found[0])
        import mitsuba as mi

        mi.set_variant(self.variant)
        # Its warnings go to standard output, where results are; what matters is raised.
        mi.set_log_level(mi.LogLevel.Error)

    def describe(self) -> list[str]:
        """Return the findings as lines for a person."""
        lines = [
            f"{f.variant} {f.library or '(no library)'}: {'works' if f.works else 'fails'}, {f.why}"
            for f in self.findings
        ]
        return [*lines, f"chosen: {self.variant} {self.version}: {self.why}", f"key: {self.key}"]


def choose(choice: Choice = "auto", fresh: bool = False) -> Backend:
    """Return the first backend that works: cuda, llvm, then scalar, or the one asked for.

    Args:
        choice: auto, or the one kind to try.
        fresh: probe again, whatever was remembered.

    Raises:
        BackendMissing: none works; the message says why for each.
    """
    kinds = list(_VARIANTS) if choice == "auto" else [choice]
    findings: list[Finding] = []
    for variant, library in _candidates(kinds):
        finding = _remembered(variant, library, fresh)
        findings.append(finding)
        if finding.works:
            why = finding.why if len(findings) == 1 else f"{finding.why}; first that works"
            return Backend(variant, library, finding.version, why, tuple(findings))
    reasons = "\n".join(f"  {f.variant} {f.library}: {f.why}" for f in findings)
    raise BackendMissing(
        f"no backend works for {choice!r}:\n{reasons or '  no library of LLVM was found'}\n"
        f"install karellen-llvm-core, or LLVM {_OLDEST} or later and set {_ENV}, or ask for scalar"
    )


def without_gpu() -> Backend:
    """Return the first backend that works and needs no graphics processor.

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
    """Return the libraries of LLVM to try, best first: told, of this environment, system."""
    found = [os.environ.get(_ENV, "")]
    found += sorted(map(str, Path(sys.prefix, "lib").glob("libLLVM.so.*")), reverse=True)
    folders = [Path("/usr/lib"), Path("/usr/lib64"), *Path("/usr/lib").glob("*-linux-gnu")]
    for version in range(_NEWEST, _OLDEST - 1, -1):
        names = (f"libLLVM-{version}.so", f"libLLVM.so.{version}", f"libLLVM.so.{version}.1")
        places = [*folders, Path(f"/usr/lib/llvm-{version}/lib")]
        found += [str(p / n) for p in places for n in names if (p / n).exists()][:1]
    if sys.platform != "linux":
        found.append(ctypes.util.find_library("LLVM") or "")
    return list(dict.fromkeys(path for path in found if path))


def _remembered(variant: str, library: str, fresh: bool) -> Finding:
    """Return what became of a candidate, from the cache where nothing has changed since."""
    place = cache_folder() / f"backend-{_fingerprint(variant, library)}.json"
    if not fresh:
        try:
            return Finding(**json.loads(place.read_text()))
        except (OSError, ValueError, TypeError):
            pass  # never probed, or not readable: probe
    finding = _probed(variant, library)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        beside = place.with_suffix(f".{os.getpid()}")
        beside.write_text(json.dumps(asdict(finding)))
        os.replace(beside, place)
    except OSError:
        pass  # the cache only saves time
    return finding


def _probed(variant: str, library: str) -> Finding:
    """Render a tiny picture in a child process."""
    environment = dict(os.environ)
    if library:
        environment[_ENV] = library
    try:
        child = subprocess.run(
            [sys.executable, "-c", _PROBE, variant],
            env=environment,
            capture_output=True,
            text=True,
            timeout=_PATIENCE_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Finding(variant, library, False, f"gave no answer in {_PATIENCE_S:g} s")
    version = next(
        (line[8:].replace(" ", ".") for line in child.stdout.splitlines() if line[:7] == "version"),
        "",
    )
    if child.returncode == 0:
        return Finding(variant, library, True, "rendered a tiny picture", version)
    last = (child.stderr.strip().splitlines() or ["no message"])[-1]
    if "CUDA backend hasn't been initialized" in last:
        last = "Dr.Jit found no NVIDIA GPU with a driver"
    if child.returncode < 0:
        why = f"died of signal {-child.returncode}: {last}"
        if library:
            why += "; Dr.Jit cannot use this LLVM"
        return Finding(variant, library, False, why)
    return Finding(variant, library, False, last)


def cache_folder() -> Path:
    """Return the folder in which this machine's findings are kept."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base, "pronk")


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
    """Return the class of processor, whose vector width decides how sums are rounded."""
    try:
        flags = next(
            line for line in Path("/proc/cpuinfo").read_text().splitlines() if line[:5] == "flags"
        ).split()
    except (OSError, StopIteration):
        return platform.machine()
    width = next((name for name in ("avx512f", "avx2", "avx", "sse4_2") if name in flags), "")
    return f"{platform.machine()} {width}".strip()
