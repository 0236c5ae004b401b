"""Manifest: what was made, from what, by what, and how long it took."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

FORMAT = 1


@dataclass(slots=True)
class Manifest:
    """The record of a scene's outputs, carried on from run to run.

    Attributes:
        words: everything but the seconds.
        seconds: of each stage, from the last run that had something to do in it.
    """

    words: dict[str, Any] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)

    @staticmethod
    def read(path: Path) -> Manifest:
        """Return the manifest in `path`; an empty one if there is none that can be read."""
        try:
            words = json.loads(path.read_text(encoding="utf-8"))
            seconds = words.pop("seconds")
            return Manifest(words, dict(seconds))
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return Manifest()

    def encoded(self) -> bytes:
        """Return the manifest as JSON."""
        words = {"manifest": FORMAT, **self.words, "seconds": self.seconds}
        return (json.dumps(words, indent=2, ensure_ascii=False) + "\n").encode()


WORKED_WITH = ("mitsuba", "drjit", "mitsuba-oidn", "mido", "imageio", "av", "zarr", "pydantic")


def packages() -> dict[str, str]:
    """Return the versions of the libraries that outputs depend on."""
    found = {}
    for name in WORKED_WITH:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "missing"
    return found
