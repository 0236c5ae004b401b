"""Hold: an interval during which a hand has a prop or a body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Self

from pydantic import Field, model_validator

from pipeline.spec.keyframes import Time
from pipeline.spec.model_base import ConfigModel, Fault, fault_error

TAKEN_GRIP = 0.35
"""How far fingers close about a thing that was taken.

A hand reaches with its fingertips, so what it takes lies before them, and fingers that closed would
leave it.
"""


class Hold(ConfigModel):
    """Somebody has it in a hand: it goes with that link, as it was when it was taken."""

    by: str = Field(
        min_length=1,
        max_length=200,
        description="The hand that holds it, such as arm.hand: a performer and a node of its "
        "drawing or a link.",
    )
    at: Time = Field(description="Time at which it is taken [s].")
    until: Time | None = Field(
        None, description="Time at which it is released [s]; never if left out."
    )
    grip: float = Field(
        TAKEN_GRIP,
        ge=0.0,
        le=1.0,
        description="How far the fingers close: a little around what lies at the fingertips, 0.8 "
        "around what lies in the palm.",
    )

    @model_validator(mode="after")
    def _ends_later(self) -> Self:
        if self.until is not None and self.until <= self.at:
            raise fault_error(f"should be later than it is taken, at {self.at:g}", "until")
        return self


def faults_of_holds(holds: Sequence[Hold]) -> Iterator[Fault]:
    """Find holds that begin before the one before has ended."""
    for i in range(1, len(holds)):
        before = holds[i - 1]
        if before.until is None or holds[i].at < before.until:
            message = f"'{before.by}' still holds it then; let it go with `until` first"
            yield Fault(("held", i, "at"), message)
