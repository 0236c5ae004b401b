"""File check: the files of a scene's outputs, each against its record and its key."""

from __future__ import annotations

import re
from pathlib import Path

from pipeline.errors import StoreError
from pipeline.production.run.file_records import FileRecord, content_digest
from pipeline.production.run.outputs import Outputs
from pipeline.production.verification.fault import MISSING, NOT_AS_WRITTEN
from pipeline.simulation.take_store import read_take
from render.film_codecs import CONTAINERS
from render.film_file import film_key
from render.image_files import has_digest, read_key

FRAME = re.compile(r"\d{4,}\.(png|exr)")
"""Names of frames."""

OTHER_KEY = "was made of something else than its record says"


def fault_of(outputs: Outputs, path: Path, record: FileRecord | None) -> str | None:
    """Return what is wrong with a file, "" for nothing, None for what cannot be judged.

    A frame or a take without a record, or with that of an earlier one, is of a run that was
    stopped before it wrote the manifest; it is judged by its own digest.

    Args:
        outputs: that it belongs to.
        path: of the file.
        record: of it, None without one.
    """
    if not path.exists():
        return MISSING
    try:
        is_as_recorded = record is not None and content_digest(path) == record.digest
        if path == outputs.take:
            return _take_fault(path, record, is_as_recorded)
        if is_frame(path):
            if record is None and not has_digest(path):
                return None
            return _frame_fault(path, record, is_as_recorded)
        if record is None:
            return None
        if not is_as_recorded:
            return NOT_AS_WRITTEN
        is_film = path.suffix in CONTAINERS
        return OTHER_KEY if is_film and film_key(path) != record.key else ""
    except OSError as error:
        return f"cannot be read ({error.strerror or error})"


def is_frame(path: Path) -> bool:
    """Return whether a file is a frame by its name."""
    return path.parent.name == "frames" and FRAME.fullmatch(path.name) is not None


def _frame_fault(path: Path, record: FileRecord | None, is_as_recorded: bool) -> str:
    key = read_key(path)
    if key is None:
        return NOT_AS_WRITTEN
    if record is None or is_as_recorded:
        return "" if record is None or key == record.key else OTHER_KEY
    return "" if key != record.key else NOT_AS_WRITTEN


def _take_fault(path: Path, record: FileRecord | None, is_as_recorded: bool) -> str:
    try:
        key = read_take(path).header.key
    except StoreError as error:
        return str(error).removeprefix(f"{path}: ")
    except Exception as error:
        # A damaged file can raise anything.
        return f"is no take that can be read ({error})"
    if record is None or is_as_recorded:
        return "" if record is None or key == record.key else OTHER_KEY
    return "" if key != record.key else NOT_AS_WRITTEN
