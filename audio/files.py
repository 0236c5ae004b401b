"""Files that are either whole or as they were."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from audio.errors import SoundFileError


def put(path: Path, data: bytes) -> bool:
    """Make a file hold these bytes; an equal file is left alone, its time stamp too.

    Returns:
        Whether the file was written.

    Raises:
        SoundFileError: it could not be written; an earlier file stands untouched.
    """
    try:
        if path.is_file() and path.stat().st_size == len(data) and path.read_bytes() == data:
            return False
        _replace(path, data)
    except OSError as error:
        raise SoundFileError(f"{path} could not be written: {error}") from error
    return True


def _replace(path: Path, data: bytes) -> None:
    # Beside the target, because a rename is atomic only within one file system.
    handle, name = tempfile.mkstemp(
        prefix=f".{path.name[:64]}.", suffix=".partial", dir=path.parent
    )
    beside = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        # mkstemp gives mode 600; a film's sound is as readable as any new file.
        beside.chmod(path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~_umask())
        beside.replace(path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
