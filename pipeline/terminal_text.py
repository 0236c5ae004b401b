r"""Terminal text: text of scenes and file names as it may be printed.

A scene may come from anybody, and a terminal obeys control characters: they move the cursor,
change colours, rename the window or turn the order of letters around. Everything that is printed
passes through here, and such characters are shown as escapes, `\x1b` for the escape character.
"""

from __future__ import annotations

import json
import re
from typing import Any

_CONTROLS = re.compile(
    "["
    "\x00-\x08\x0b-\x1f\x7f-\x9f"  # control characters but tab and line feed
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # the order of letters
    "\u2028\u2029"  # further line breaks
    "\ud800-\udfff"  # what no encoding knows: bytes of file names
    "]"
)


def escaped(text: str) -> str:
    """Return a text of one or more lines with its control characters shown as escapes."""
    return _CONTROLS.sub(_escape, text)


def escaped_line(text: str) -> str:
    """Return a text as one line: line feeds are shown as escapes too."""
    return escaped(text).replace("\n", "\\n")


def json_line(members: Any) -> str:
    """Return values as one line of JSON in which control characters are escapes.

    It reads back as the same values.
    """
    return _CONTROLS.sub(_json_escape, json.dumps(members, ensure_ascii=False))


def _escape(found: re.Match[str]) -> str:
    code = ord(found[0])
    if found[0] == "\r":
        return "\\r"
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


def _json_escape(found: re.Match[str]) -> str:
    return f"\\u{ord(found[0]):04x}"
