"""Plain scalars of YAML 1.2's core schema: what is a number, a truth or nothing, and what is text.

YAML 1.1, which most readers follow, takes `on` for true, `1_000` for a thousand and `1:30` for
ninety. Here these are text.
"""

from __future__ import annotations

import math
import re

Scalar = str | int | float | bool | None

_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_WORDS: dict[str, bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_LARGEST = 2**63
_LONGEST = 400


def scalar_of(text: str) -> Scalar:
    """Return the value of a plain scalar.

    Raises:
        ValueError: it is a number that is not finite, or too large to be used.
    """
    if text in _WORDS:
        return _WORDS[text]
    if _NOT_FINITE.fullmatch(text):
        raise ValueError(f"must be a finite number, is {text}")
    if _INTEGER.fullmatch(text):
        if len(text) > _LONGEST or abs(number := _integer(text)) >= _LARGEST:
            raise ValueError("the number is too large")
        return number
    if _FLOAT.fullmatch(text):
        value = float(text)
        if not math.isfinite(value):
            raise ValueError("the number is too large")
        return value
    return text


def _integer(text: str) -> int:
    if text.startswith("0o"):
        return int(text[2:], 8)
    return int(text[2:], 16) if text.startswith("0x") else int(text)
