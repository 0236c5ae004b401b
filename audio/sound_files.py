"""Sound files: writing MIDI and WAV files atomically."""

from __future__ import annotations

from pathlib import Path

from audio.errors import SoundFileError
from pipeline.atomic_file import write_if_changed


def write_sound_file(path: Path, data: bytes) -> bool:
    """Write a file atomically unless it already holds these bytes; return whether it was written.

    Raises:
        SoundFileError: it could not be written; an earlier file is untouched.
    """
    try:
        return write_if_changed(path, data)
    except OSError as error:
        raise SoundFileError(f"{path} could not be written: {error.strerror or error}") from error
