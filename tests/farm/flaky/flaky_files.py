"""A store that fails a tenth of its calls: like an object store, whole objects by one call each."""

from __future__ import annotations

import os
import random
import uuid
from pathlib import Path
from typing import Any

from fsspec.implementations.local import LocalFileSystem

SHARE = 0.1
"""Of the calls that fail."""

_CHANCE = random.SystemRandom()


class FlakyFiles(LocalFileSystem):
    """Files of this machine that are written whole, or not at all."""

    protocol = ("flaky",)

    @classmethod
    def _strip_protocol(cls, path: str) -> str:
        return "/" + str(path).removeprefix("flaky:").strip("/")

    def unstrip_protocol(self, name: str) -> str:
        """Return the address of a path."""
        return f"flaky://{self._strip_protocol(name)}"

    def exists(self, path: str, **_: Any) -> bool:
        """Return whether there is such a file."""
        _fail()
        return os.path.exists(self._strip_protocol(path))

    def ls(self, path: str, detail: bool = False, **more: Any) -> Any:
        """List a folder."""
        _fail()
        return super().ls(path, detail=detail, **more)

    def cat_file(self, path: str, start: Any = None, end: Any = None, **_: Any) -> bytes:
        """Return a file, or a range of it."""
        _fail()
        return Path(self._strip_protocol(path)).read_bytes()[start:end]

    def rm_file(self, path: str) -> None:
        """Remove a file."""
        _fail()
        os.unlink(self._strip_protocol(path))

    def put_file(self, lpath: str, rpath: str, **_: Any) -> None:
        """Write a copy of another file."""
        self.pipe_file(rpath, Path(lpath).read_bytes())

    def pipe_file(self, path: str, value: bytes, mode: str = "overwrite", **_: Any) -> None:
        """Write a file, whole or not at all."""
        _fail()
        place = Path(self._strip_protocol(path))
        place.parent.mkdir(parents=True, exist_ok=True)
        made = place.parent / f".{uuid.uuid4().hex}"
        made.write_bytes(value)
        try:
            if mode == "create":
                os.link(made, place)
            else:
                os.replace(made, place)
        finally:
            made.unlink(missing_ok=True)
        # Some answers get lost after the work is done.
        _fail()


def _fail() -> None:
    if _CHANCE.random() < SHARE:
        raise OSError(5, "503 Slow Down")
