"""Manifest: the record of a scene's outputs, carried on from run to run."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

FORMAT = 1

LIBRARIES = ("mitsuba", "drjit", "mitsuba-oidn", "mido", "imageio", "av", "zarr", "pydantic")
"""Libraries that outputs depend on."""


@dataclass(slots=True)
class Manifest:
    """The record of a scene's outputs, carried on from run to run.

    Attributes:
        entries: everything but the times.
        seconds: time of each stage, from the last run in which it had something to do.
    """

    entries: dict[str, Any] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)

    @staticmethod
    def read(path: Path) -> Manifest:
        """Return the manifest in `path`; an empty one if none can be read."""
        try:
            entries = json.loads(path.read_text(encoding="utf-8"))
            seconds = entries.pop("seconds")
            entries.pop("manifest", None)
            return Manifest(entries, dict(seconds))
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return Manifest()

    def encoded(self) -> bytes:
        """Return the manifest as JSON."""
        members = {"manifest": FORMAT, **self.entries, "seconds": self.seconds}
        return (json.dumps(members, indent=2, ensure_ascii=False) + "\n").encode()


def library_versions() -> dict[str, str]:
    """Return the versions of the libraries that outputs depend on."""
    found = {}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "missing"
    return found
