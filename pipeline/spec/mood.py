"""Mood: changes to the motion of a creature (Sims 1987, 3.2.4)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, BeforeValidator, Field

from pipeline.spec.model_base import MoodName, Number, fault_error
from render.config.base import PresetModel

Factor = Annotated[Number, Field(ge=0.05, le=20)]
Tilt = Annotated[Number, Field(ge=-80, le=80)]

MOODS: Mapping[str, Mapping[str, float]] = {
    "happy": {
        "stride": 1.05, "cycle": 0.88, "body_bob": 2.2, "step_height": 1.4,
        "head_deg": 10, "tail_deg": 20, "sway": 1.6, "looseness": 1.3,
    },
    "sad": {
        "stride": 0.72, "cycle": 1.3, "body_bob": 0.5, "step_height": 0.6, "duty": 0.04,
        "head_deg": -30, "tail_deg": -20, "pitch_deg": -3, "sway": 0.6, "wander": 0.4,
    },
    "tired": {
        "stride": 0.7, "cycle": 1.45, "body_bob": 0.8, "step_height": 0.3, "duty": 0.06,
        "body_height": 0.95, "head_deg": -22, "tail_deg": -15, "sway": 1.7, "wander": 0.6,
        "looseness": 1.6,
    },
    "impatient": {
        "stride": 0.85, "cycle": 0.62, "body_bob": 1.2, "head_deg": 4, "tail_deg": 10,
        "wander": 2.5,
    },
    "proud": {
        "stride": 1.1, "cycle": 1.12, "body_bob": 1.3, "step_height": 1.7, "body_height": 1.03,
        "head_deg": 26, "tail_deg": 22, "pitch_deg": 4, "sway": 0.7, "looseness": 0.6,
    },
    "sneaking": {
        "stride": 0.8, "cycle": 1.8, "body_bob": 0.2, "step_height": 1.5, "body_height": 0.8,
        "duty": 0.1, "head_deg": -12, "tail_deg": -10, "sway": 0.4, "wander": 1.6,
        "looseness": 0.5,
    },
    "frightened": {
        "stride": 0.85, "cycle": 0.6, "body_bob": 0.7, "body_height": 0.88, "head_deg": -8,
        "tail_deg": -35, "pitch_deg": -2, "wander": 2.2, "looseness": 0.5,
    },
    "angry": {
        "stride": 1.12, "cycle": 0.82, "body_bob": 1.4, "step_height": 1.3, "body_height": 0.96,
        "head_deg": -16, "tail_deg": 12, "pitch_deg": -3, "sway": 1.2, "looseness": 0.6,
    },
}  # fmt: skip
"""The library of moods."""


class Mood(PresetModel):
    """A mood: factors on the gait of a creature, and its posture.

    Keys that are left out change nothing. At half its weight a mood changes half as much:
    factors by their roots, angles and fractions by halves; several moods add up.
    """

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = MOODS

    stride: Factor = Field(1.0, description="Factor on the length of a cycle over the ground.")
    cycle: Factor = Field(1.0, description="Factor on the duration of a cycle.")
    duty: Annotated[Number, Field(ge=-0.5, le=0.5)] = Field(
        0.0,
        description="Fraction of the cycle that feet stay down longer, in gaits without flights.",
    )
    body_bob: Factor = Field(1.0, description="Factor on the amplitude of the body bob.")
    body_height: Factor = Field(1.0, description="Factor on the height of the body.")
    step_height: Factor = Field(1.0, description="Factor on the lift of feet.")
    pitch_deg: Annotated[Number, Field(ge=-30, le=30)] = Field(
        0.0, description="Pitch of the body, nose up [degrees]."
    )
    head_deg: Tilt = Field(0.0, description="Raise of the head [degrees].")
    tail_deg: Tilt = Field(0.0, description="Raise of the tail [degrees].")
    sway: Factor = Field(1.0, description="Factor on the sway of head and tail with the gait.")
    wander: Factor = Field(
        1.0,
        description="Factor on the wandering of head and feelers, and on how far head and tail "
        "turn aside at rest.",
    )
    looseness: Factor = Field(1.0, description="Factor on the follow-through of loose parts.")


MAX_WEIGHT = 2.0
"""Sum of weights beyond which legs would hardly follow."""

Weight = Annotated[Number, Field(ge=0, le=2)]


def _mix_of(value: object) -> object:
    """Let the name of a mood stand for all of it."""
    return {value: 1.0} if isinstance(value, str) else value


def _few(mix: dict[str, float]) -> dict[str, float]:
    if sum(mix.values()) > MAX_WEIGHT:
        raise fault_error(f"the weights of moods should not sum up to more than {MAX_WEIGHT:g}")
    return mix


MoodMix = Annotated[
    dict[MoodName, Weight],
    Field(max_length=32),
    AfterValidator(_few),
    BeforeValidator(_mix_of, json_schema_input_type=MoodName | dict[MoodName, Weight]),
]
"""One mood by name, or weights of several by their names."""
