"""Outputs: the folder of one scene, and what stands in it.

Everything is written beside its place and renamed into it, so whatever has its name
is whole, and a run that is stopped at any moment can go on.
"""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import StoreError

PARTIAL = ".partial"
"""Ends the names of what is not yet whole."""


@dataclass(frozen=True, slots=True)
class Outputs:
    """Where the files of one scene are.

    Attributes:
        folder: such as out/first_steps.
        name: of the scene; files are called after it.
    """

    folder: Path
    name: str

    @property
    def frames(self) -> Path:
        """Folder of the frames."""
        return self.folder / "frames"

    def frame(self, number: int, suffix: str = "png") -> Path:
        """Return the file of one frame."""
        return self.frames / f"{number:04d}.{suffix}"

    def film(self, part: str = "", suffix: str = ".mp4") -> Path:
        """Return the file of the film, or of a part of it such as "1-48"."""
        return self.folder / (f"{self.name}_{part}{suffix}" if part else f"{self.name}{suffix}")

    @property
    def midi(self) -> Path:
        """The score."""
        return self.folder / f"{self.name}.mid"

    @property
    def wav(self) -> Path:
        """The sound."""
        return self.folder / f"{self.name}.wav"

    @property
    def events(self) -> Path:
        """The sound events, one JSON object a line."""
        return self.folder / "events.jsonl"

    @property
    def event_table(self) -> Path:
        """The same events as a table."""
        return self.folder / "events.csv"

    @property
    def edit_list(self) -> Path:
        """Cuts, sounds and instructions for editing programs."""
        return self.folder / f"{self.name}.edl"

    @property
    def labels(self) -> Path:
        """Sounds, cuts and instructions as labels of Audacity."""
        return self.folder / f"{self.name}_labels.txt"

    @property
    def take(self) -> Path:
        """The take."""
        return self.folder / "take.zarr"

    @property
    def manifest(self) -> Path:
        """What was made, by what, from what."""
        return self.folder / "manifest.json"


@contextlib.contextmanager
def opened(outputs: Outputs) -> Iterator[None]:
    """Make the folder of `outputs` and keep other runs out of it.

    What an earlier run left unfinished is cleared away.

    Raises:
        StoreError: if the folder cannot be written to, or another run is at work in it.
    """
    try:
        outputs.frames.mkdir(parents=True, exist_ok=True)
        lock = (outputs.folder / ".lock").open("a")
    except OSError as error:
        reason = error.strerror or str(error)
        raise StoreError(
            f"{outputs.folder}: cannot be written to ({reason}); choose another place with --out"
        ) from error
    with lock:
        if not _locked(lock.fileno()):
            raise StoreError(f"{outputs.folder}: another run is at work here; wait for its end")
        _clear(outputs)
        yield


def _locked(descriptor: int) -> bool:
    """Take the lock of an open file if nobody else has it; it goes with the process."""
    try:
        import fcntl  # There is none on Windows, which then goes unlocked.
    except ImportError:
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _clear(outputs: Outputs) -> None:
    """Remove what is not yet whole: its name is a dot, that of an output, and more.

    Frames, films and sounds are written by floors that know nothing of production; all
    that is agreed upon is the beginning of the name.
    """
    # Sounds cut a long name short, because no name may be longer than 255 bytes.
    own = [f".{outputs.name}{end}"[:65] for end in "._"]
    for path in outputs.folder.iterdir():
        if path.name.startswith((*own, ".events.", ".manifest.", ".take.")):
            _remove(path)
    for path in outputs.frames.glob(".[0-9]*"):
        _remove(path)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def replace_folder(new: Path, place: Path) -> None:
    """Move the folder `new` to `place`, over what is there.

    Two renames are not one; if the run is stopped between them there is no folder, and
    the next run makes it again.
    """
    old = place.with_name(f".{place.name}.old{PARTIAL}")
    with contextlib.suppress(FileNotFoundError):
        os.replace(place, old)
    os.replace(new, place)
    _remove(old)
