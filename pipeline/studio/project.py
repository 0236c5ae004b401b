"""Project: the folder whose files the page may read and write, and the library, which it may read.

A document is named by its path below the folder, or below the library after `library:`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Literal

from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.errors import StoreError, UsageError
from pipeline.spec import library
from pipeline.spec.scene_library import FIGURES, PATH_SUFFIXES, SUFFIX, name_fault
from pipeline.spec.yaml_reader import MAX_FILE_BYTES
from pipeline.terminal_text import escaped_line

LIBRARY = "library:"
"""Begins the names of shipped documents."""

Kind = Literal["figure", "scene", "other"]

LISTED_FOLDERS = ("", FIGURES)
"""Folders of documents, of a project and of the library."""

MAX_LISTED = 1000
"""Documents of a folder that are listed."""


@dataclass(frozen=True, slots=True)
class Document:
    """A file that is open.

    Attributes:
        name: below the project's folder or the library.
        kind: by its keys.
        text: as it is in the file.
        is_shipped: whether it belongs to the library; saving makes a copy in the project.
    """

    name: str
    kind: Kind
    text: str
    is_shipped: bool


@dataclass(frozen=True, slots=True)
class Project:
    """A folder of scenes and figures.

    Attributes:
        folder: absolute, without links.
    """

    folder: Path

    @staticmethod
    def at(folder: Path) -> Project:
        """Return the project of a folder."""
        return Project(folder.resolve())

    def name_of(self, path: Path) -> str:
        """Return the name of a file of the project or of the library.

        Raises:
            UsageError: it lies in neither.
        """
        whole = path.resolve()
        for root, head in ((self.folder, ""), (library().resolve(), LIBRARY)):
            if whole.is_relative_to(root):
                return head + whole.relative_to(root).as_posix()
        raise UsageError(f"'{path}' is not in this folder; start the studio in its folder")

    def path_of(self, name: str) -> Path:
        """Return the file of a name.

        Raises:
            UsageError: it would lie outside, through dots or links, or is no YAML file.
        """
        root = library().resolve() if name.startswith(LIBRARY) else self.folder
        inner = name.removeprefix(LIBRARY)
        shown = escaped_line(name)
        parts = PurePosixPath(inner).parts
        bad = not parts or "\\" in inner or "\0" in inner or ":" in inner
        if bad or any(part in ("..", "/") or part.startswith(".") for part in parts):
            raise UsageError(f"'{shown}' is no file of this project")
        if not inner.endswith(PATH_SUFFIXES):
            raise UsageError(f"'{shown}' is no YAML file")
        try:
            path = (root / inner).resolve()
        except (OSError, RuntimeError, ValueError):
            raise UsageError(f"'{shown}' is no file of this project") from None
        if not path.is_relative_to(root):
            raise UsageError(f"'{shown}' leads out of this project")
        return path

    def read(self, name: str) -> Document:
        """Return a document.

        Raises:
            UsageError: there is no such document.
            StoreError: it cannot be read.
        """
        path = self.path_of(name)
        if not path.is_file():
            raise UsageError(f"there is no file '{escaped_line(name)}'")
        try:
            with path.open("rb") as stream:
                content = stream.read(MAX_FILE_BYTES + 1)
            if len(content) > MAX_FILE_BYTES:
                raise UsageError(f"'{escaped_line(name)}' is larger than the studio reads")
            text = content.decode("utf-8")
        except OSError as error:
            raise StoreError(f"{path.name}: cannot be read ({error.strerror})") from error
        except UnicodeDecodeError:
            raise UsageError(f"'{escaped_line(name)}' is not UTF-8") from None
        return Document(name, kind_of(text), text, name.startswith(LIBRARY))

    def write(self, name: str, text: str, before: str | None = None) -> str:
        """Write a document, a shipped one as a copy in the project; return its name there.

        Args:
            name: of the document.
            text: its new text.
            before: text of the file when it was opened; None for a new file.

        Raises:
            UsageError: it would lie outside, or replace a file that holds something else.
            StoreError: it cannot be written.
        """
        own = name.removeprefix(LIBRARY)
        path = self.path_of(own)
        fault = name_fault(path.stem)
        if fault is not None:
            raise UsageError(f"the name {fault}")
        try:
            self._check_unchanged(own, path, text, None if name.startswith(LIBRARY) else before)
            make_folder(path.parent)
            write_if_changed(path, text.encode("utf-8"))
        except (OSError, UnicodeEncodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not Unicode"
            raise StoreError(f"{path.name}: cannot be written ({reason})") from error
        return own

    def _check_unchanged(self, own: str, path: Path, text: str, before: str | None) -> None:
        """Refuse to replace a file of another text than it had when it was opened."""
        if not path.exists():
            return
        texts = (text,) if before is None else (text, before)
        if path.read_bytes() in [one.encode("utf-8") for one in texts]:
            return
        if before is None:
            raise UsageError(f"there is a file '{own}' in the project already; open that one")
        raise UsageError(f"'{own}' was changed by another program; open it again")

    def listed(self) -> list[dict[str, str]]:
        """Return the documents of the project and of the library, by name and kind."""
        found = []
        for root, head in ((self.folder, ""), (library().resolve(), LIBRARY)):
            for below in LISTED_FOLDERS:
                paths = sorted((root / below).glob("*" + SUFFIX))[:MAX_LISTED]
                for path in paths:
                    name = head + path.relative_to(root).as_posix()
                    kind = self._kind(name)
                    if kind != "other":
                        found.append({"name": name, "kind": kind})
        return found

    def _kind(self, name: str) -> Kind:
        try:
            return self.read(name).kind
        except (UsageError, StoreError):
            return "other"


_TOP_KEY = re.compile(r"^(figure|cast)[ \t]*:", re.MULTILINE)


def kind_of(text: str) -> Kind:
    """Return what a text holds, by its first key that decides; it may be no right YAML yet."""
    found = _TOP_KEY.search(text)
    if found is None:
        return "other"
    return "figure" if found[1] == "figure" else "scene"
