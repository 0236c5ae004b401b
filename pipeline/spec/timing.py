"""Timing: the frame rate, the length of a scene, and its frames, steps and rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Annotated, Any, TypeGuard

from pydantic import PlainValidator, WithJsonSchema

from pipeline.spec.model_base import Fault, fault_error
from pipeline.spec.validation import described

MAX_FRAMES = 1_000_000
"""More than eleven hours at 24 frames a second; a longer scene is a typing error."""

DEFAULT_ROWS_PER_FRAME = 4
DEFAULT_STEPS = 4

MIN_RATE, MAX_RATE = 1, 240
"""Frames a second."""

NTSC_RATES = {
    Fraction(24000, 1001): ("23.976", "23.98"),
    Fraction(30000, 1001): ("29.97",),
    Fraction(60000, 1001): ("59.94",),
    Fraction(120000, 1001): ("119.88",),
}
"""Rates of NTSC with their rounded forms, which are not exact enough."""


def frames_of(duration: float, rate: Fraction) -> int:
    """Return the number of frames that last at least `duration` [s], 1 or more.

    The duration is taken as the decimal number that was written, not as the binary number
    nearest to it, which may lie just above and cost a frame.
    """
    return max(1, math.ceil(Fraction(repr(duration)) * rate))


def faults_of_timing(scene: Mapping[str, Any]) -> list[Fault]:
    """Find contradictions between duration, frames, fps, rows_per_frame and steps.

    Args:
        scene: the values of a scene; those that are wrong by themselves are ignored.
    """
    faults = []
    duration, frames = scene.get("duration"), scene.get("frames")
    if duration is None and frames is None:
        faults.append(Fault((), "give duration (in seconds) or frames"))
    if duration is not None and frames is not None:
        faults.append(Fault(("frames",), "give either duration or frames, not both", at_key=True))
    rate = _valid_rate(scene.get("fps", 24))
    if rate and _is_duration(duration):
        count = frames_of(duration, rate)
        if count > MAX_FRAMES:
            message = f"makes {count} frames, more than the {MAX_FRAMES} that are allowed"
            faults.append(Fault(("duration",), message))
    rows = scene.get("rows_per_frame", DEFAULT_ROWS_PER_FRAME)
    steps = scene.get("steps", DEFAULT_STEPS)
    if _is_count(rows) and _is_count(steps) and steps % rows:
        if "steps" in scene:
            message = f"must be a multiple of rows_per_frame, which is {rows}; is {steps}"
            faults.append(Fault(("steps",), message))
        else:
            message = f"must divide steps, which is {steps}; is {rows}"
            faults.append(Fault(("rows_per_frame",), message))
    return faults


def _valid_rate(value: object) -> Fraction | None:
    if isinstance(value, bool) or not isinstance(value, int | str):
        return None
    try:
        return rate_of(value)
    except ValueError:
        return None


def _is_duration(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 < value < math.inf


def _is_count(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool) and value > 0


def rate_of(value: int | str) -> Fraction:
    """Return frames a second of `24` or `"30000/1001"`.

    Raises:
        ValueError: the text is not a fraction of two whole numbers.
    """
    if isinstance(value, int):
        return Fraction(value)
    over, under = value.split("/")
    if not (over.isascii() and over.isdigit() and under.isascii() and under.isdigit()):
        raise ValueError(value)
    if len(over) > 6 or len(under) > 4 or not int(under):
        raise ValueError(value)
    return Fraction(int(over), int(under))


def _checked_rate(value: Any) -> int | str:
    rate = _valid_rate(value)
    if rate is None:
        allowed = f"should be a whole number {MIN_RATE} to {MAX_RATE}, or text such as '30000/1001'"
        meant = (exact for exact, rounded in NTSC_RATES.items() if str(value) in rounded)
        suggestion = next((f" ('{exact}' is probably meant)" for exact in meant), "")
        raise fault_error(f"{allowed}{suggestion}, is {described(value)}")
    if not MIN_RATE <= rate <= MAX_RATE:
        raise fault_error(f"must be from {MIN_RATE} to {MAX_RATE} frames a second, is {value}")
    return value


Rate = Annotated[
    int | str,
    PlainValidator(_checked_rate),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "integer", "minimum": MIN_RATE, "maximum": MAX_RATE},
                {"type": "string", "pattern": r"^[1-9][0-9]{0,5}/[1-9][0-9]{0,3}$"},
            ]
        }
    ),
]
