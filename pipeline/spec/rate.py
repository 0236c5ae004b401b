"""The frame rate as an author writes it."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any

from pydantic import PlainValidator, WithJsonSchema

from pipeline.spec.faults import fault
from pipeline.spec.messages import described

SLOWEST, FASTEST = 1, 240
NTSC = {
    Fraction(24000, 1001): ("23.976", "23.98"),
    Fraction(30000, 1001): ("29.97",),
    Fraction(60000, 1001): ("59.94",),
    Fraction(120000, 1001): ("119.88",),
}
_TEXT = r"^[1-9][0-9]{0,5}/[1-9][0-9]{0,3}$"


def rate_of(words: int | str) -> Fraction:
    """Return frames a second of `24` or `"30000/1001"`.

    Raises:
        ValueError: the text is not a fraction of two whole numbers.
    """
    if isinstance(words, int):
        return Fraction(words)
    over, under = words.split("/")
    if not (over.isascii() and over.isdigit() and under.isascii() and under.isdigit()):
        raise ValueError(words)
    if len(over) > 6 or len(under) > 4 or not int(under):
        raise ValueError(words)
    return Fraction(int(over), int(under))


def _checked(words: Any) -> int | str:
    allowed = f"should be a whole number {SLOWEST} to {FASTEST}, or text such as '30000/1001'"
    if isinstance(words, bool) or not isinstance(words, int | str):
        raise fault(f"{allowed}{_meant(words)}, is {described(words)}")
    try:
        rate = rate_of(words)
    except ValueError:
        raise fault(f"{allowed}{_meant(words)}, is {described(words)}") from None
    if not SLOWEST <= rate <= FASTEST:
        raise fault(f"must be from {SLOWEST} to {FASTEST} frames a second, is {words}")
    return words


def _meant(words: Any) -> str:
    for rate, shorthands in NTSC.items():
        if str(words) in shorthands:
            return f" ('{rate}' is probably meant)"
    return ""


Rate = Annotated[
    int | str,
    PlainValidator(_checked),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "integer", "minimum": SLOWEST, "maximum": FASTEST},
                {"type": "string", "pattern": _TEXT},
            ]
        }
    ),
]
