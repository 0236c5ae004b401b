"""How long a scene lasts, and how frames, samples and steps fit together."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, TypeGuard

from pipeline.spec.faults import Fault
from pipeline.spec.rate import rate_of

MOST_FRAMES = 1_000_000
"""More than eleven hours at 24 frames a second; beyond it is a slip of the keyboard."""

DEFAULT_SAMPLES = 4
DEFAULT_STEPS = 4


def frames_of(duration: float, rate: Fraction) -> int:
    """Return the number of frames that last at least `duration` [s], 1 or more.

    The duration is taken as the decimal number that was written, not as the binary number
    nearest to it, which may lie just above and cost a frame.
    """
    return max(1, math.ceil(Fraction(repr(duration)) * rate))


def faults_of_timing(scene: Mapping[str, Any]) -> list[Fault]:
    """Find contradictions between duration, frames, fps, samples and steps.

    Args:
        scene: the words of a scene; those that are wrong by themselves are left aside.
    """
    faults = []
    duration, frames = scene.get("duration"), scene.get("frames")
    if duration is None and frames is None:
        faults.append(Fault((), "give duration (in seconds) or frames"))
    if duration is not None and frames is not None:
        faults.append(Fault(("frames",), "give either duration or frames, not both", at_key=True))
    rate = _rate(scene.get("fps", 24))
    if rate and _is_duration(duration):
        count = frames_of(duration, rate)
        if count > MOST_FRAMES:
            message = f"makes {count} frames, more than the {MOST_FRAMES} that are allowed"
            faults.append(Fault(("duration",), message))
    samples, steps = scene.get("samples", DEFAULT_SAMPLES), scene.get("steps", DEFAULT_STEPS)
    if _is_count(samples) and _is_count(steps) and steps % samples:
        message = f"must be a multiple of samples, which is {samples}; is {steps}"
        place = "steps" if "steps" in scene else "samples"
        if place == "samples":
            message = f"must divide steps, which is {steps}; is {samples}"
        faults.append(Fault((place,), message))
    return faults


def _rate(words: object) -> Fraction | None:
    if isinstance(words, bool) or not isinstance(words, int | str):
        return None
    try:
        return rate_of(words)
    except ValueError:
        return None


def _is_duration(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 < value < math.inf


def _is_count(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool) and value > 0
