"""Ground as builders make it: stairs, ramps, ditches, stepping stones.

Each begins at the word `start`, along x from the terrain's middle, with level ground before
it: somebody who stands at the middle and looks along x meets it.

A height field has no walls: what should be one takes one cell of the grid along x or z.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.terrain.ground import CELLS, Cells, Grid, too_coarse
from pipeline.spec.values import Coordinate, Length, LengthOrZero, Number, Whole

Course = Literal["up", "down", "up and down"]
COURSE = "Whether it leads up, down, or up and down again."


class StairsTerrain(Grid):
    """Stairs along x."""

    kind: Literal["stairs"] = Field("stairs", description="Stairs.")
    cells: Cells = Field((600, 60), description=CELLS)
    course: Course = Field("up and down", description=COURSE)
    start: Coordinate = Field(1.0, description="Where the first riser is, along x [m].")
    steps: Annotated[Whole, Field(ge=1, le=2000)] = Field(
        8, description="Number of risers of a flight."
    )
    step_height: LengthOrZero = Field(0.12, description="Height of a riser [m].")
    step_depth: Length = Field(
        0.4, description="From riser to riser [m]; the riser takes one cell of it."
    )
    landing: LengthOrZero = Field(
        1.5, description="From the last riser up to the first one down [m]."
    )

    @model_validator(mode="after")
    def _can_be_shown(self) -> Self:
        refuse(too_coarse(self, "step_depth", self.step_depth, axes="x"))
        return self


class RampTerrain(Grid):
    """A ramp along x, to level ground above or below."""

    kind: Literal["ramp"] = Field("ramp", description="A ramp.")
    cells: Cells = Field((600, 60), description=CELLS)
    course: Course = Field("up and down", description=COURSE)
    start: Coordinate = Field(1.0, description="Where it begins, along x [m].")
    slope_deg: Number = Field(15.0, gt=0, le=85, description="Its slope [degrees].")
    height: LengthOrZero = Field(1.0, description="How high, or how deep, it leads [m].")
    level: LengthOrZero = Field(
        2.0, description="How long its level top is before it leads down again [m]."
    )


class DitchesTerrain(Grid):
    """Ditches with steep walls across x, one after the other."""

    kind: Literal["ditches"] = Field("ditches", description="Ditches.")
    cells: Cells = Field((600, 60), description=CELLS)
    start: Coordinate = Field(1.0, description="Where the first stretch begins, along x [m].")
    width: Length = Field(0.3, description="Of the widest ditch [m]; each wall takes one cell.")
    depth: LengthOrZero = Field(0.5, description="Of the deepest ditch [m].")
    spacing: Length = Field(1.5, description="From one ditch to the next, on average [m].")
    variation: Number = Field(
        0.5,
        ge=0,
        le=1,
        description="How much their widths, depths and places differ: at 1 down to one half, and "
        "by half of the ground between them.",
    )

    @model_validator(mode="after")
    def _can_be_shown(self) -> Self:
        refuse(self._faults())
        return self

    def _faults(self) -> Iterator[Fault]:
        narrowest = self.width * (1.0 - 0.5 * self.variation)
        if self.spacing <= self.width:
            told = f"spacing, {self.spacing:g}, must be more than width, {self.width:g}"
            yield Fault(("spacing",), told)
            return
        yield from too_coarse(self, "width", narrowest, axes="x")
        ground = (self.spacing - self.width) * (1.0 - 0.5 * self.variation)
        yield from too_coarse(self, "spacing", ground, axes="x")


class StonesTerrain(Grid):
    """Stepping stones with flat tops, in rows, over a pit between two banks."""

    kind: Literal["stones"] = Field("stones", description="Stepping stones.")
    size: tuple[Length, Length] = Field(
        (20.0, 12.0), description="Extent along x and z, centred on the place `at` [m]."
    )
    cells: Cells = Field((500, 300), description=CELLS)
    start: Coordinate = Field(1.0, description="Where the pit begins, along x [m].")
    length: Length = Field(
        4.0, description="Of the pit along x, at least of one stone; made to fit whole stones [m]."
    )
    depth: LengthOrZero = Field(0.6, description="Of the pit below the banks [m].")
    diameter: Length = Field(0.5, description="Of the stones [m].")
    gap: Length = Field(0.2, description="Between stones side by side [m].")
    jitter: Number = Field(
        0.5,
        ge=0,
        le=1,
        description="How far stones stand off their rows: at 1 a gap may be half as wide, or one "
        "and a half times.",
    )
    height_variation: LengthOrZero = Field(
        0.06, description="Between the lowest and the highest tops there may be [m]."
    )

    @model_validator(mode="after")
    def _can_be_shown(self) -> Self:
        refuse(self._faults())
        return self

    def _faults(self) -> Iterator[Fault]:
        yield from too_coarse(self, "diameter", self.diameter, least=3)
        yield from too_coarse(self, "gap", self.gap * (1.0 - 0.5 * self.jitter))
