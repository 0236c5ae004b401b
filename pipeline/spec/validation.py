"""Validation: checks the values of a file against a model, key by key.

Every error of pydantic is led back to its location in the file and said in an author's words.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

import audio.names
from pipeline.errors import Problem
from pipeline.spec.model_base import FAULTS, Fault, PathSegment
from pipeline.spec.suggestions import close_names, hint, known_keys, listed_as
from pipeline.spec.yaml_tree import (
    REFUSED,
    FoundNode,
    ListNode,
    MappingNode,
    SourceLocation,
    SourceNode,
    find_node,
    has_refused,
    plain_values,
    with_key,
)
from render.config.base import UnknownName

Model = TypeVar("Model", bound=BaseModel)

MAX_ERRORS = 300
"""Errors reported of one file; a file with more is no scene at all."""

MAX_TEXT_LENGTH = 60
"""Longer text values are cut off in messages [characters]."""

MISSING = "is missing"
"""Message about a key that a mapping lacks."""

_KEY = "[key]"
"""Ends pydantic's path to a wrong key."""


@dataclass(frozen=True, slots=True)
class _Finding:
    """An error at a node of the tree.

    Attributes:
        node: where.
        message: what is wrong and what would be right.
        expected: what the value should be, if it is of the wrong kind.
        at_key: the key is wrong, not its value.
        is_missing: the node lacks a key.
    """

    node: FoundNode
    message: str
    expected: str | None = None
    at_key: bool = False
    is_missing: bool = False

    @property
    def place(self) -> SourceLocation:
        return self.node.key if self.at_key else self.node.tree.place


def check(model: type[Model], tree: SourceNode) -> tuple[Model | None, list[Problem]]:
    """Make a model of a tree.

    Args:
        model: what it should become.
        tree: what the file holds.

    Returns:
        The model, None if something is wrong, and the problems in no certain order.
    """
    try:
        return model.model_validate(plain_values(tree), strict=True), []
    except ValidationError as error:
        details = _last_missing(error.errors(include_url=False)[:MAX_ERRORS])
    findings = [finding for detail in details for finding in _findings(model, tree, detail)]
    return None, _problems(_joined_expectations(findings))


def with_meant_keys(model: type[BaseModel], tree: SourceNode) -> SourceNode:
    """Return a tree whose unknown keys are called as they were meant, where that is certain.

    A model checks what belongs together only when all its keys are right; so the rest of a file
    with a typo can be checked as well.

    Args:
        model: what the tree should become.
        tree: what the file holds.
    """
    try:
        model.model_validate(plain_values(tree), strict=True)
    except ValidationError as error:
        details = error.errors(include_url=False)[:MAX_ERRORS]
    else:
        return tree
    for detail in details:
        if detail["type"] == "extra_forbidden":
            *_, key = path = find_node(tree, detail["loc"]).path
            meant = close_names(str(key), known_keys(model, detail["loc"][:-1]))
            if len(meant) == 1:
                tree = with_key(tree, path, meant[0])
    return tree


def problems_of_faults(tree: SourceNode, faults: Iterable[Fault]) -> list[Problem]:
    """Return the problems of faults whose paths begin at the root."""
    return _problems(_of_fault(tree, (), fault) for fault in faults)


def _problems(findings: Iterable[_Finding]) -> list[Problem]:
    """Return the first problem of each place, leaving out what follows from a refused value."""
    first: dict[tuple[str, int, int, tuple[PathSegment, ...]], Problem] = {}
    for finding in findings:
        node, place = finding.node, finding.place
        stays = finding.at_key or finding.is_missing or not node.path
        if stays or not has_refused(node.tree):
            problem = place.problem(node.path, finding.message)
            first.setdefault((place.file, place.line, place.column, node.path), problem)
    return list(first.values())


def in_order(problems: Iterable[Problem], files: Sequence[str]) -> list[Problem]:
    """Return each problem once, sorted by the order of files and by line and column."""
    order = {file: i for i, file in enumerate(files)}
    unique = list(dict.fromkeys(problems))
    return sorted(unique, key=lambda p: (order.get(p.file, len(order)), p.line, p.column))


def _findings(model: type[BaseModel], tree: SourceNode, error: ErrorDetails) -> list[_Finding]:
    path, kind = error["loc"], error["type"]
    if kind == FAULTS:
        return [_of_fault(tree, path, fault) for fault in error["ctx"]["faults"]]
    if path and path[-1] == _KEY:
        return [_Finding(find_node(tree, path[:-1]), _message(error, path[-2]), at_key=True)]
    node = find_node(tree, path)
    if kind == "extra_forbidden":
        known = known_keys(model, path[:-1])
        return [_Finding(node, f"unknown key, {hint(str(path[-1]), known)}", at_key=True)]
    if kind == "missing":
        return [_missing(node, path)]
    if kind == "union_tag_invalid":
        node = find_node(tree, (*path, str(error["ctx"]["discriminator"]).strip("'")))
    if kind == "too_short" and len(plain_values(node.tree)) >= error["ctx"]["min_length"]:
        # Pydantic counts only the values that are right; the others are reported.
        return []
    return [_Finding(node, _message(error, plain_values(node.tree)), _expected(error))]


def _last_missing(details: Sequence[ErrorDetails]) -> Iterator[ErrorDetails]:
    """Keep only the last of the values that a list lacks: its index says how many are needed."""
    last = {detail["loc"][:-1]: detail for detail in details if _lacks_value(detail)}
    return (
        detail
        for detail in details
        if not _lacks_value(detail) or last[detail["loc"][:-1]] is detail
    )


def _lacks_value(error: ErrorDetails) -> bool:
    return error["type"] == "missing" and isinstance(error["loc"][-1], int)


def _missing(node: FoundNode, path: Sequence[PathSegment]) -> _Finding:
    last = path[-1]
    if isinstance(last, int):
        length = len(node.tree.items) if isinstance(node.tree, ListNode) else 0
        return _Finding(node, f"must hold {last + 1} values, holds {length}")
    if isinstance(node.tree, MappingNode):
        lacking = FoundNode((*node.path, last), node.tree, node.key)
        return _Finding(lacking, MISSING, is_missing=True)
    return _Finding(node, f"should be a mapping that has '{last}'")


def _of_fault(tree: SourceNode, path: Sequence[PathSegment], fault: Fault) -> _Finding:
    node = find_node(tree, (*path, *fault.path))
    return _Finding(node, fault.message, at_key=fault.at_key)


def _joined_expectations(findings: Sequence[_Finding]) -> list[_Finding]:
    """Join what the branches of a union expect of one value into one message."""
    # A branch that went deeper into the value knows better what is wrong.
    deeper = {f.node.path[:n] for f in findings for n in range(len(f.node.path))}
    expected: dict[tuple[PathSegment, ...], dict[str, None]] = {}
    for finding in findings:
        if finding.expected:
            expected.setdefault(finding.node.path, {})[finding.expected] = None
    joined = []
    for finding in findings:
        node, choices = finding.node, expected.get(finding.node.path, {})
        if not (finding.expected and node.skipped):
            joined.append(finding)
        elif node.path not in deeper:
            text = f"should be {' or '.join(choices)}, is {described(plain_values(node.tree))}"
            joined.append(_Finding(node, text if len(choices) > 1 else finding.message))
    return joined


_EXPECTED = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text",
    "bool_type": "true or false",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping of keys to values",
    "model_type": "a mapping of keys to values",
    "model_attributes_type": "a mapping of keys to values",
    "none_required": "empty",
    "finite_number": "a finite number",
}

_LIMITS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
    "multiple_of": ("a multiple of", "multiple_of"),
}

_LENGTHS = {
    "too_short": ("at least", "min_length"),
    "too_long": ("at most", "max_length"),
    "string_too_short": ("at least", "min_length"),
    "string_too_long": ("at most", "max_length"),
}


def described(value: object) -> str:
    """Return a value as a message names it: `the text 'fast'`, `a list`, `-2`."""
    match value:
        case None:
            return "empty"
        case bool():
            return "true" if value else "false"
        case str():
            is_short = len(value) <= MAX_TEXT_LENGTH
            return f"the text {value if is_short else value[: MAX_TEXT_LENGTH - 3] + '...'!r}"
        case int() | float():
            return str(value)
        case Mapping():
            return "a mapping"
        case list() | tuple():
            return f"a list of {len(value)}" if value else "an empty list"
    return repr(REFUSED)


def _expected(error: ErrorDetails) -> str | None:
    """Return what would be right, such as `a number`, if the error is about the kind of value."""
    if error["type"] == "literal_error":
        # Pydantic writes 'a', 'b' or 'c'.
        return str(error.get("ctx", {}).get("expected", ""))
    return _EXPECTED.get(error["type"])


def _message(error: ErrorDetails, value: object) -> str:
    """Return what is wrong and what would be right.

    Args:
        error: one error of pydantic; unknown keys are not among them.
        value: the value in the file.
    """
    kind = error["type"]
    context: Mapping[str, Any] = error.get("ctx", {})
    expected = _expected(error)
    if kind == "literal_error" and isinstance(value, str):
        choices = _quoted(str(context.get("expected", "")))
        if choices:
            return f"must be {expected}, is {described(value)}{_meant(value, choices)}"
    if expected is not None:
        return f"should be {expected}, is {described(value)}"
    if kind in _LIMITS:
        relation, key = _LIMITS[kind]
        return f"must be {relation} {context[key]:.15g}, is {described(value)}"
    if kind in _LENGTHS:
        relation, key = _LENGTHS[kind]
        things = "character" if isinstance(value, str) else "value"
        held = len(value) if isinstance(value, str | list | tuple | Mapping) else 0
        plural = "" if context[key] == 1 else "s"
        return f"must hold {relation} {context[key]} {things}{plural}, holds {held}"
    return _special_message(error, value)


def _special_message(error: ErrorDetails, value: object) -> str:
    context: Mapping[str, Any] = error.get("ctx", {})
    key = str(context.get("discriminator", "kind")).strip("'")
    match error["type"]:
        case "string_pattern_mismatch":
            return (
                "must be made of letters, digits, _ and, inside, - and blanks; "
                f"is {described(value)}"
            )
        case "union_tag_invalid":
            tag = str(context.get("tag", ""))
            return f"no {key} is called '{tag}', {hint(tag, _quoted(context['expected_tags']))}"
        case "union_tag_not_found" if isinstance(value, Mapping):
            return f"needs the key '{key}'"
        case "union_tag_not_found":
            return f"should be a name or a mapping, is {described(value)}"
        case "value_error" if isinstance(context["error"], audio.names.UnknownName | UnknownName):
            unknown: audio.names.UnknownName | UnknownName = context["error"]
            close = hint(unknown.name, unknown.known, listed_as(unknown.kind))
            verb = "are" if unknown.kind.endswith("s") else "is"
            return f"no {unknown.kind} {verb} called '{unknown.name}', {close}"
        case "value_error" | "assertion_error":
            return error["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")
    return f"{error['msg'].removeprefix('Input ')}, is {described(value)}"


def _quoted(text: str) -> list[str]:
    """Return the quoted words of pydantic's list `'a', 'b' or 'c'`."""
    parts = text.replace(" or ", ", ").split(", ")
    return [part.strip("'") for part in parts if part.startswith("'")]


def _meant(value: str, choices: list[str]) -> str:
    suggestion = hint(value, choices)
    return f"; {suggestion}" if suggestion.startswith("did") else ""
