"""Atomic file replacement: a file holds either its old or its new bytes, never a part."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from audio.errors import SoundFileError


def write_if_changed(path: Path, data: bytes) -> bool:
    """Write a file atomically unless it already holds these bytes.

    Returns:
        Whether the file was written; an equal file keeps its time stamp.

    Raises:
        SoundFileError: it could not be written; an earlier file is untouched.
    """
    try:
        if path.is_file() and path.stat().st_size == len(data) and path.read_bytes() == data:
            return False
        _replace(path, data)
    except OSError as error:
        raise SoundFileError(f"{path} could not be written: {error}") from error
    return True


def _replace(path: Path, data: bytes) -> None:
    # In the same folder, because a rename is atomic only within one file system.
    handle, name = tempfile.mkstemp(
        prefix=f".{path.name[:64]}.", suffix=".partial", dir=path.parent
    )
    partial = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        # mkstemp gives mode 600; the file gets the mode of any new file instead.
        partial.chmod(path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~_umask())
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
