"""Ground as nature makes it: level, fractal, hills, boulders."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, Self

from pydantic import Field, model_validator

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.terrain.ground import CELLS, Cells, Grid, too_coarse
from pipeline.spec.values import Length, LengthOrZero, Number


class FlatTerrain(Grid):
    """Level ground at height 0."""

    kind: Literal["flat"] = Field("flat", description="Level ground.")


class FractalTerrain(Grid):
    """Rocky ground whose detail repeats at ever smaller sizes."""

    kind: Literal["fractal"] = Field("fractal", description="Fractal ground.")
    height: LengthOrZero = Field(1.2, description="From the lowest to the highest point [m].")
    roughness: Number = Field(
        0.55, ge=0, le=1, description="How much of the height each halving of the size keeps."
    )
    scale: Length | None = Field(
        None, description="Size of the largest features [m]; chosen by the size if left out."
    )


class HillsTerrain(Grid):
    """Smooth hills."""

    kind: Literal["hills"] = Field("hills", description="Smooth hills.")
    height: LengthOrZero = Field(1.0, description="From the lowest to the highest point [m].")
    spacing: Length = Field(6.0, description="From one hill to the next, on average [m].")


class BouldersTerrain(Grid):
    """Rounded boulders, many small and few large, half buried in gentle ground."""

    kind: Literal["boulders"] = Field("boulders", description="A field of boulders.")
    cells: Cells = Field((480, 480), description=CELLS)
    diameters: tuple[Length, Length] = Field(
        (0.3, 1.2), description="Of the smallest and of the largest boulders [m]."
    )
    cover: Number = Field(
        0.2, ge=0, le=0.9, description="Share of the ground that boulders stand on."
    )
    buried: Number = Field(
        0.5, ge=0, le=0.95, description="Share of a boulder's height that is in the ground."
    )
    clearing: LengthOrZero = Field(
        1.0, description="No boulder comes this near to the terrain's middle [m]."
    )
    height: LengthOrZero = Field(
        0.4, description="Of the ground between them, from its lowest to its highest point [m]."
    )
    spacing: Length = Field(
        8.0, description="From one swell of the ground to the next, on average [m]."
    )

    @model_validator(mode="after")
    def _can_be_shown(self) -> Self:
        refuse(self._faults())
        return self

    def _faults(self) -> Iterator[Fault]:
        small, large = self.diameters
        if large < small:
            told = f"{large:g} is less than the diameter of the smallest, {small:g}"
            yield Fault(("diameters", 1), told)
            return
        yield from too_coarse(self, "diameters", small, least=3)
