"""What PyYAML complains of, said as a problem at its place."""

from __future__ import annotations

from collections.abc import Sequence

import yaml
from yaml.reader import ReaderError

from pipeline.errors import Problem
from pipeline.spec.tree import Place


def syntax_problem(error: Exception, file: str, lines: Sequence[str], text: str) -> Problem:
    """Return the problem that an error of PyYAML stands for.

    Args:
        error: what PyYAML raised.
        file: name of the file as the author gave it.
        lines: the text, line by line.
        text: the whole file.
    """
    if isinstance(error, ReaderError):
        return _odd_character(text, error.position, file, lines)
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    if not isinstance(error, yaml.MarkedYAMLError) or mark is None:
        return Place(file).problem((), f"is not YAML: {error}")
    place = _place(file, lines, mark.line, mark.column)
    return place.problem((), _said(error))


def _said(error: yaml.MarkedYAMLError) -> str:
    problem = error.problem or error.context or "it cannot be read"
    if "'\\t'" in problem:
        return "is not YAML: a tab cannot indent, use blanks"
    message = f"is not YAML: {problem}"
    if error.problem and error.context and error.context_mark:
        message += f" ({error.context} that began on line {error.context_mark.line + 1})"
    return message


def _odd_character(text: str, position: int, file: str, lines: Sequence[str]) -> Problem:
    before = text[:position]
    line = before.count("\n")
    column = position - (before.rfind("\n") + 1)
    code = ord(text[position]) if position < len(text) else 0
    # The line is not shown: what cannot be read might not be shown either.
    return Place(file, line + 1, column + 1).problem(
        (), f"is not YAML: the character U+{code:04X} is not allowed"
    )


def _place(file: str, lines: Sequence[str], line: int, column: int) -> Place:
    return Place(file, line + 1, column + 1, lines[line] if line < len(lines) else "")
