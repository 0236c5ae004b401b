"""Pydantic's complaints, in the words of an author."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pydantic_core import ErrorDetails

from pipeline.spec.nearest import hint
from pipeline.spec.tree import REFUSED

_WANTED = {
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
            short = value if len(value) <= 60 else value[:57] + "..."
            return f"the text {short!r}"
        case int() | float():
            return str(value)
        case Mapping():
            return "a mapping"
        case list() | tuple():
            return f"a list of {len(value)}" if value else "an empty list"
    return repr(REFUSED)


def wanted(error: ErrorDetails) -> str | None:
    """Return what would be right, such as `a number`, if the error is about the kind of value."""
    if error["type"] == "literal_error":
        return _choices(error)
    return _WANTED.get(error["type"])


def message(error: ErrorDetails, value: object) -> str:
    """Return what is wrong and what would be right.

    Args:
        error: one error of pydantic; unknown keys are not among them.
        value: the value in the file that it is about.
    """
    kind = error["type"]
    context: Mapping[str, Any] = error.get("ctx", {})
    right = wanted(error)
    if kind == "literal_error" and isinstance(value, str):
        choices = _texts(context)
        if choices:
            return f"must be {right}, is {described(value)}{_meant(value, choices)}"
    if right is not None:
        return f"should be {right}, is {described(value)}"
    if kind in _LIMITS:
        words, key = _LIMITS[kind]
        return f"must be {words} {context[key]:.15g}, is {described(value)}"
    if kind in _LENGTHS:
        words, key = _LENGTHS[kind]
        return _of_length(words, context[key], value)
    return _SPECIAL.get(kind, _as_it_is)(error, value)


def _of_length(words: str, length: int, value: object) -> str:
    things = "characters" if isinstance(value, str) else "values"
    held = len(value) if isinstance(value, str | list | tuple | Mapping) else 0
    return f"must hold {words} {length} {things if length != 1 else things[:-1]}, holds {held}"


def _choices(error: ErrorDetails) -> str:
    # Pydantic writes 'a', 'b' or 'c'.
    return str(error.get("ctx", {}).get("expected", ""))


def _texts(context: Mapping[str, Any]) -> list[str]:
    parts = str(context.get("expected", "")).replace(" or ", ", ").split(", ")
    return [part.strip("'") for part in parts if part.startswith("'")]


def _meant(value: str, choices: list[str]) -> str:
    said = hint(value, choices)
    return f"; {said}" if said.startswith("did") else ""


def _pattern(error: ErrorDetails, value: object) -> str:
    return f"must be made of letters, digits, _ and, inside, - and blanks; is {described(value)}"


def _unknown_tag(error: ErrorDetails, value: object) -> str:
    context = error.get("ctx", {})
    key, tag = str(context.get("discriminator", "kind")).strip("'"), str(context.get("tag", ""))
    choices = _texts({"expected": context.get("expected_tags", "")})
    return f"no {key} is called '{tag}', {hint(tag, choices)}"


def _no_tag(error: ErrorDetails, value: object) -> str:
    key = str(error.get("ctx", {}).get("discriminator", "kind")).strip("'")
    if not isinstance(value, Mapping):
        return f"should be a name or a mapping, is {described(value)}"
    return f"needs the key '{key}'"


def _of_validator(error: ErrorDetails, value: object) -> str:
    return error["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")


def _as_it_is(error: ErrorDetails, value: object) -> str:
    said = error["msg"].removeprefix("Input ")
    return f"{said}, is {described(value)}"


_SPECIAL: dict[str, Callable[[ErrorDetails, object], str]] = {
    "string_pattern_mismatch": _pattern,
    "union_tag_invalid": _unknown_tag,
    "union_tag_not_found": _no_tag,
    "value_error": _of_validator,
    "assertion_error": _of_validator,
}
