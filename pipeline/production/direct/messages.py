"""Messages: their limits, and JSON-RPC text made and read where no method is called.

Source: JSON-RPC 2013.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

MAX_MESSAGE_BYTES = 2**20
"""Longest message that is read [bytes]."""

MAX_DEPTH = 48
"""Deepest nesting of lists and mappings in a message."""


class OversizedMessage:
    """Stands for a message that is too long."""


def decoded(message: bytes) -> object:
    """Return the content of a message.

    Raises:
        ValueError: it is not valid JSON.
    """
    try:
        content: object = json.loads(message.decode("utf-8"), parse_constant=_refuse_constant)
        is_too_deep = _is_too_deep(content)
    except RecursionError:
        is_too_deep = True
    if is_too_deep:
        raise ValueError(f"lists and mappings go deeper than {MAX_DEPTH} levels")
    return content


def notification(method: str, params: Mapping[str, object]) -> str:
    """Return the text of a notification."""
    return json.dumps({"jsonrpc": "2.0", "method": method, "params": params})


def refusal(error: Mapping[str, object], number: object = None) -> str:
    """Return the answer to a request with an error; `number` is its id, None if it is unknown."""
    return json.dumps({"jsonrpc": "2.0", "id": number, "error": error})


def _refuse_constant(name: str) -> Any:
    raise ValueError(f"{name} is no number of JSON")


def _is_too_deep(content: object) -> bool:
    level: list[object] = [content]
    for _ in range(MAX_DEPTH):
        level = [
            inner
            for outer in level
            if isinstance(outer, dict | list)
            for inner in (outer.values() if isinstance(outer, dict) else outer)
        ]
        if not level:
            return False
    return True
