"""Reads a file of the language into a tree: its bytes, its encoding, its outermost mapping."""

from __future__ import annotations

from pathlib import Path

from pipeline.errors import Problem
from pipeline.spec.reader import read_yaml
from pipeline.spec.tree import Place, Table

MOST_BYTES = 8 * 2**20
_BOM = b"\xef\xbb\xbf"


def read_file(path: Path) -> tuple[Table | None, list[Problem]]:
    """Read a file.

    Returns:
        Its mapping, None if there is none to go on with, and what is wrong so far.
    """
    file = str(path)
    try:
        if path.is_dir():
            return None, [Problem("", "is a folder, not a file", file)]
        with path.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        return None, [Problem("", f"cannot be read: {reason}", file)]
    return read_bytes(content, file)


def read_bytes(content: bytes, file: str) -> tuple[Table | None, list[Problem]]:
    """Read the content of a file.

    Args:
        content: UTF-8, with or without a byte order mark.
        file: its name as the author gave it.

    Returns:
        Its mapping, None if there is none to go on with, and what is wrong so far.
    """
    if len(content) > MOST_BYTES:
        return None, [Problem("", f"is larger than {MOST_BYTES // 2**20} MiB", file)]
    content = content.removeprefix(_BOM)
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        before = content[: error.start]
        line = before.count(b"\n")
        column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8"))
        message = f"is not UTF-8: the byte 0x{content[error.start]:02x}"
        return None, [Problem("", message, file, line + 1, column + 1)]
    tree, problems = read_yaml(text, file)
    if problems and tree is None:
        return None, problems
    empty = "is empty; the least that a file holds is 'pronk: 1'"
    if tree is None:
        return None, [Place(file).problem((), empty)]
    if isinstance(tree, Table):
        return tree, problems
    if problems:
        return None, problems
    return None, [tree.place.problem((), "should be a mapping of keys to values at the top")]
