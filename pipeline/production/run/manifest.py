"""Manifest: the record of a scene's outputs, carried on from run to run."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from pipeline.production.run.file_records import FileRecord

FORMAT = 1

LIBRARIES = ("mitsuba", "drjit", "mitsuba-oidn", "mido", "imageio", "av", "zarr", "pydantic")
"""Libraries that outputs depend on."""

FILES = "files"
"""Name of the entry with a record of every file."""

SEAL = "seal"
"""Name of the entry with the digest of all others."""


@dataclass(slots=True)
class Manifest:
    """The record of a scene's outputs.

    Attributes:
        entries: everything but the times and the files.
        seconds: time of each stage, from the last run in which it had something to do.
        files: by their paths from the folder of the outputs.
        is_sealed: whether it is as it was written. Records of files in another are left out, and
            `files` is empty.
    """

    entries: dict[str, Any] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    files: Mapping[str, FileRecord] = field(default_factory=dict)
    is_sealed: bool = True

    @staticmethod
    def read(path: Path) -> Manifest:
        """Return the manifest in `path`; an empty one if none can be read."""
        try:
            entries = json.loads(path.read_text(encoding="utf-8"))
            # Earlier versions wrote neither seal nor records.
            is_sealed = entries.keys().isdisjoint({SEAL, FILES})
            seal = entries.pop(SEAL, "")
            is_sealed = is_sealed or seal == _seal(entries)
            seconds, files = dict(entries.pop("seconds")), entries.pop(FILES, {})
            entries.pop("manifest", None)
            records = {n: r for n, f in files.items() if (r := FileRecord.read(f)) is not None}
            return Manifest(entries, seconds, records if is_sealed else {}, is_sealed)
        except FileNotFoundError:
            return Manifest()
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return Manifest(is_sealed=False)

    def encoded(self) -> bytes:
        """Return the manifest as JSON, with a line for each file."""
        members = {"manifest": FORMAT, **self.entries, "seconds": self.seconds}
        files = {name: self.files[name].facts for name in sorted(self.files)}
        lines = [f"    {_json(name)}: {_json(facts)}" for name, facts in files.items()]
        text = json.dumps(members, indent=2, ensure_ascii=False).removesuffix("\n}")
        table = "{\n" + ",\n".join(lines) + "\n  }" if lines else "{}"
        seal = _seal({**members, FILES: files})
        return f'{text},\n  "{FILES}": {table},\n  "{SEAL}": "{seal}"\n}}\n'.encode()


def _seal(members: Mapping[str, Any]) -> str:
    return hashlib.blake2b(_json(members).encode(), digest_size=10).hexdigest()


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


def library_versions() -> dict[str, str]:
    """Return the versions of the libraries that outputs depend on."""
    found = {}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "missing"
    return found
