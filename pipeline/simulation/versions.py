"""Versions that decide every bit of a take, and the header that records them."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

import pipeline
from pipeline.processor import class_name
from pipeline.simulation.take import Header
from pipeline.spec.scene import VERSION, Scene


def versions() -> dict[str, str]:
    """Returns the versions of all that the bits of a take depend on."""
    return {
        "pronk": pipeline.__version__,
        "simulation": code_digest(),
        "language": str(VERSION),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "machine": processor_class(),
    }


@cache
def code_digest() -> str:
    """Returns a digest of the simulation's source code."""
    here = Path(__file__).parent
    sources = [path.read_bytes() for path in sorted(here.rglob("*.py"))]
    return hashlib.blake2b(b"".join(sources), digest_size=6).hexdigest()


def processor_class() -> str:
    """Returns the class of processor; within one, equal scenes give equal bytes."""
    simd = np.show_config(mode="dicts")["SIMD Extensions"]
    return class_name(simd.get("found", []), pipeline.HELD)


def header_of(scene: Scene, key: str) -> Header:
    """Returns the header of the take of `scene`; `key` is a digest of what the take depends on."""
    return Header(
        key=key,
        title=scene.title,
        rate=scene.rate,
        frames=scene.n_frames,
        samples=scene.rows_per_frame,
        steps=scene.steps,
        seed=scene.seed,
        versions=versions(),
    )
