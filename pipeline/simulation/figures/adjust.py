"""Adjust: joints as their author wants them, where the style would make them otherwise."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.stance import Stance
from pipeline.spec.figure import JointWords


@dataclass(frozen=True, eq=False)
class Adjusted:
    """Limits and values of all joints, and which of them slide."""

    stances: list[Stance]
    prismatic: NDArray[np.bool_]


def adjusted_joints(
    words: Mapping[str, Mapping[str, JointWords]],
    names: Sequence[str],
    stances: Sequence[Stance],
    scale: float,
) -> Adjusted:
    """Apply an author's words on joints.

    Args:
        words: by limb and joint.
        names: of the joints, "limb.joint".
        stances: as the style makes them.
        scale: factor from the drawing to the world, for what slides.

    Raises:
        SceneError: if a joint is named that there is not, or rests outside its limits.
    """
    told = {f"{limb}.{joint}": w for limb, joints in words.items() for joint, w in joints.items()}
    problems = [
        Problem(f"joints.{name}", f"the figure has no such joint{_hint(name, names)}")
        for name in told
        if name not in names
    ]
    result = [
        _adjusted(told[name], stance, scale) if name in told else stance
        for name, stance in zip(names, stances, strict=True)
    ]
    problems += [
        Problem(f"joints.{name}", "rests outside its limits")
        for name, stance in zip(names, result, strict=True)
        if not stance.lower <= stance.preferred <= stance.upper
    ]
    if problems:
        raise SceneError(problems)
    slides = [name in told and told[name].slide is not None for name in names]
    return Adjusted(result, np.array(slides, dtype=bool))


def _adjusted(words: JointWords, stance: Stance, scale: float) -> Stance:
    if words.slide is not None:
        lower, upper = (scale * value for value in words.slide)
        rest = lower if words.rest is None else scale * words.rest
        return Stance(lower, upper, rest, upper)
    if words.limits_deg is not None:
        lower, upper = (math.radians(value) for value in words.limits_deg)
        rest = min(max(stance.preferred, lower), upper)
        stance = replace(stance, lower=lower, upper=upper, preferred=rest)
    if words.rest_deg is not None:
        stance = replace(stance, preferred=math.radians(words.rest_deg))
    return stance


def _hint(name: str, names: Sequence[str]) -> str:
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.0)
    return f", did you mean '{close[0]}'?" if close else ": it has no joints"
