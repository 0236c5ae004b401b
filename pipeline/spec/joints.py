"""Joints: what an author says of a joint that the style would make otherwise."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.values import Coordinate, Number, Words

Angle = Annotated[Number, Field(ge=-180, le=180)]


class JointWords(Words):
    """One joint: its limits and where it rests; or a joint that slides instead of turning."""

    rest_deg: Angle | None = Field(None, description="Value at rest [degrees].")
    limits_deg: tuple[Angle, Angle] | None = Field(
        None, description="Least and greatest value [degrees]."
    )
    slide: tuple[Coordinate, Coordinate] | None = Field(
        None, description="Makes it slide along its link, between these values [m]."
    )
    rest: Coordinate | None = Field(None, description="Value at rest of a joint that slides [m].")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        faults = []
        for name in ("limits_deg", "slide"):
            limits = getattr(self, name)
            if limits is not None and limits[0] >= limits[1]:
                faults.append(Fault((name,), "the first must be less than the second"))
        if self.slide is not None and (self.rest_deg is not None or self.limits_deg is not None):
            faults.append(Fault(("slide",), "a joint that slides has rest, not angles"))
        if self.slide is None and self.rest is not None:
            faults.append(Fault(("rest",), "a joint that turns rests at rest_deg"))
        refuse(faults)
        return self
