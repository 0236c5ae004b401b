"""Outputs: the folder of one scene and its files.

Every file is written under a temporary name and renamed, so a file that has its name is whole and
a run that was stopped at any moment can go on.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from pipeline.atomic_file import make_folder, remove
from pipeline.errors import StoreError
from pipeline.foreign_files.confinement import link_out_of


class OutputsBusy(StoreError):
    """Another run is at work in the folder of the outputs."""


@dataclass(frozen=True, slots=True)
class Outputs:
    """Paths of the files of one scene.

    Attributes:
        folder: such as out/first_steps.
        name: of the scene and of its files.
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
    def score_folder(self) -> Path:
        """The score for other programs, where it was exported."""
        return self.folder / "score"

    @property
    def wav(self) -> Path:
        """The sound."""
        return self.folder / f"{self.name}.wav"

    def surround(self, layout: str) -> Path:
        """Return the sound in a layout of more channels, such as "5.1"."""
        return self.folder / f"{self.name}_{layout}.wav"

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
    def token(self) -> Path:
        """The token of a port at which a program may direct the scene, while the port waits."""
        return self.folder / f"{self.name}.token"

    @property
    def refused_take(self) -> Path:
        """A take whose notes `--strict` refused; `take` stays that of the film."""
        return self.folder / "take_refused.zarr"

    @property
    def early_take(self) -> Path:
        """The start of a take, with which single frames were looked at."""
        return self.folder / "take_early.zarr"

    @property
    def lock(self) -> Path:
        """File that is locked while a run is at work."""
        return self.folder / ".lock"

    @property
    def manifest(self) -> Path:
        """Sources, versions and times of all outputs."""
        return self.folder / "manifest.json"


def refuse_links(outputs: Outputs, scene_folder: Path) -> None:
    """Refuse outputs that links lead elsewhere: the author of a scene may have put them there.

    A link on the way to the outputs is right unless it lies in the folder of the scene.

    Raises:
        StoreError: there is such a link.
    """
    home = Path(os.path.realpath(scene_folder))
    above = Path(os.path.abspath(outputs.folder)).parents
    on_the_way = (
        folder
        for folder in above
        if folder.is_symlink() and Path(os.path.realpath(folder.parent)).is_relative_to(home)
    )
    link = next(on_the_way, None) or link_out_of(outputs.folder)
    if link is not None:
        raise StoreError(
            f"{link}: is a link that leads elsewhere, which --untrusted refuses; remove it, or "
            "choose another place with --out"
        )


@contextlib.contextmanager
def opened(outputs: Outputs) -> Iterator[None]:
    """Make the folder of `outputs`, lock it, and remove unfinished files of earlier runs.

    At the end the lock is removed, and folders that stayed empty.

    Raises:
        StoreError: the folder cannot be written to, or another run is at work in it.
    """
    # False for names that are too long, unlike the method of paths.
    missing = [folder for folder in outputs.folder.parents if not os.path.exists(folder)]
    with contextlib.ExitStack() as stack:
        try:
            make_folder(outputs.frames)
            stack.enter_context(locked(outputs, (outputs.frames, outputs.folder, *missing)))
            # A run that ended meanwhile has removed the folder if it was empty.
            make_folder(outputs.frames)
            _clear(outputs)
        except OSError as error:
            reason = error.strerror or str(error)
            raise StoreError(
                f"{outputs.folder}: cannot be written to ({reason}); choose another place with "
                "--out"
            ) from error
        yield


@contextlib.contextmanager
def locked(outputs: Outputs, folders: Sequence[Path] = ()) -> Iterator[None]:
    """Lock the folder of `outputs` against other runs.

    Args:
        outputs: of the scene.
        folders: removed at the end if they are empty.

    Raises:
        OutputsBusy: another run is at work in it.
        OSError: it cannot be written to.
    """
    lock = _lock(outputs.lock)
    if lock is None:
        raise OutputsBusy(f"{outputs.folder}: another run is at work here; wait for its end")
    with lock:
        try:
            yield
        finally:
            # Where an open file cannot be removed, it stays.
            with contextlib.suppress(OSError):
                outputs.lock.unlink()
            for folder in folders:
                with contextlib.suppress(OSError):
                    folder.rmdir()


def _lock(path: Path) -> IO[str] | None:
    """Open a file and lock it; return None if another process has locked it."""
    while True:
        lock = path.open("a")
        if not _take_lock(lock.fileno()):
            lock.close()
            return None
        # A run that ended meanwhile has removed the file that is locked now.
        if path.exists() and os.path.samestat(path.stat(), os.fstat(lock.fileno())):
            return lock
        lock.close()
        make_folder(path.parent)


def _take_lock(descriptor: int) -> bool:
    """Take the lock of an open file, unless another process has it."""
    try:
        import fcntl  # Windows has none and goes unlocked.
    except ImportError:
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _clear(outputs: Outputs) -> None:
    """Remove unfinished files: their names are a dot and the name of an output, and more.

    `render` and `audio` choose the rest of the name.
    """
    # Atomic writing cuts long names short, because a name has at most 255 bytes.
    own = [f".{outputs.name}{end}"[:65] for end in "._"]
    for path in outputs.folder.iterdir():
        if path.name.startswith((*own, ".events.", ".manifest.", ".take.", ".take_")):
            remove(path)
    for path in outputs.frames.glob(".[0-9]*"):
        remove(path)
