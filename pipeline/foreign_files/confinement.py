"""Confinement: the folder that the files of an untrusted scene must lie in.

Links are followed before anything is decided, and what lies outside is refused before it is
looked at: a message must not tell whether it exists.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from pipeline.foreign_files.safe_file import FileKind, ForeignFileError, require_file

SCENE_FILE = FileKind("a scene", 8 * 2**20)
"""The same bound as that of the YAML reader, which tells a larger file likewise."""


@dataclass(frozen=True, slots=True)
class Confinement:
    """The folder of an untrusted scene.

    Attributes:
        folder: its path without links.
    """

    folder: Path

    @classmethod
    def beside(cls, scene_file: Path) -> Self:
        """Return the confinement to the folder of a scene's file.

        Raises:
            ForeignFileError: the file itself is a link that leads elsewhere, or no regular file.
        """
        confinement = cls(Path(os.path.realpath(scene_file.parent)))
        require_file(confinement.located(scene_file), SCENE_FILE)
        return confinement

    def located(self, path: Path) -> Path:
        """Return the path of a file without links; the file need not exist.

        Raises:
            ForeignFileError: it leads out of the folder.
        """
        try:
            found = Path(os.path.realpath(path))
        except (OSError, ValueError):
            raise ForeignFileError("cannot be the name of a file") from None
        if not found.is_relative_to(self.folder):
            raise ForeignFileError(
                "leads out of the folder of the scene, which --untrusted refuses; "
                "put the file beside the scene"
            )
        return found

    def holds(self, path: Path) -> bool:
        """Return whether a file lies in the folder."""
        try:
            self.located(path)
        except ForeignFileError:
            return False
        return True

    def require(self, path: Path, kind: FileKind) -> None:
        """Refuse a file larger than one of an untrusted scene may be.

        Raises:
            ForeignFileError: it is, or it is no regular file.
        """
        require_file(path, kind.for_untrusted())


def link_out_of(folder: Path) -> Path | None:
    """Return a link in a folder of outputs that leads out of it, None without any.

    Args:
        folder: of outputs; the way to it is the caller's choice.
    """
    if folder.is_symlink():
        return folder
    whole = Path(os.path.realpath(folder))
    return next(
        (link for link in _links(folder) if not Path(os.path.realpath(link)).is_relative_to(whole)),
        None,
    )


def _links(folder: Path) -> Iterator[Path]:
    for parent, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(parent, name)
            if path.is_symlink():
                yield path
