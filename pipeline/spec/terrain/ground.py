"""Ground: the words that every kind of terrain has."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field
from pydantic.annotated_handlers import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from pipeline.spec.faults import Fault
from pipeline.spec.terrain.presets import TERRAIN_PRESETS
from pipeline.spec.values import Coordinate, Length, LengthOrZero, Name, Number, Whole, Words

MOST_CELLS = 4000
"""Along one side of a grid."""

CellCount = Annotated[Whole, Field(ge=2, le=MOST_CELLS)]
Cells = tuple[CellCount, CellCount]
Size = tuple[Length, Length]
Polygons = Literal["triangles", "quads"]

SIZE = "Extent along x and z, centred on the place `at` [m]."
CELLS = "Number of cells of the grid along x and z."


class Ground(Words):
    """What every kind of terrain has."""

    at: tuple[Coordinate, Coordinate] = Field(
        (0.0, 0.0), description="Where the middle of the terrain lies, as x and z [m]."
    )
    heading_deg: Number = Field(
        0.0,
        ge=-36_000,
        le=36_000,
        description="How far the terrain is turned about +Y at its middle [degrees].",
    )
    polygons: Polygons = Field(
        "triangles",
        description="What the grid is made of: `triangles`, two a cell along one diagonal, or "
        "`quads`, which favour neither: four triangles about a middle as high as their corners on "
        "average.",
    )
    material: Name = Field("dry soil", description="Material of the ground, by name.")
    unsteppable_slope_deg: Number = Field(
        40.0, gt=0, lt=90, description="Slopes steeper than this are no footholds [degrees]."
    )
    foot_radius: LengthOrZero = Field(
        0.08,
        description="The ground within this distance downhill of an unsteppable slope is a "
        "forbidden zone [m].",
    )
    show_forbidden: bool = Field(
        False, strict=True, description="Whether forbidden zones are hatched in the picture."
    )
    footprints: bool = Field(
        False,
        strict=True,
        description="Whether feet leave prints in soft ground: soil, sand, grass, mud or snow.",
    )

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Let a preset of this kind stand for the kind, as `{preset: hills, height: 2}`."""
        block = handler.resolve_ref_schema(handler(core))
        kind = block["properties"]["kind"]["const"]
        names = [name for name, words in TERRAIN_PRESETS.items() if words["kind"] == kind]
        if not names:
            block["required"] = ["kind", *block.get("required", [])]
            return block
        preset = {"enum": names, "description": "The preset that this terrain starts from."}
        block["properties"] = {"preset": preset, **block["properties"]}
        block["oneOf"] = [{"required": ["kind"]}, {"required": ["preset"]}]
        return block


class Grid(Ground):
    """A terrain whose grid the author chooses."""

    size: Size = Field((30.0, 30.0), description=SIZE)
    cells: Cells = Field((240, 240), description=CELLS)


WORDS_OF_THE_WHOLE = (*Ground.model_fields, "size", "cells")
"""What a sum of terrains says once for all of its terms."""


def too_coarse(
    words: Grid, word: str, length: float, least: int = 2, axes: str = "xz"
) -> Iterator[Fault]:
    """Find that a length is less than the least number of cells which show it.

    Args:
        words: a terrain.
        word: the one whose length it is.
        length: of the feature, where it is smallest [m].
        least: number of cells.
        axes: along which the grid must be fine enough.
    """
    for axis in axes:
        k = "xz".index(axis)
        cell = words.size[k] / words.cells[k]
        # What is a whole number of cells is so only up to rounding.
        if length >= least * cell * (1.0 - 1e-9):
            continue
        needed = math.ceil(words.size[k] * least / length)
        finer = f"or cells[{k}] at least {needed}" if needed <= MOST_CELLS else "or size smaller"
        yield Fault(
            (word,),
            f"{word} makes features of {length:g} m, less than {least} cells of {cell:g} m "
            f"along {axis}; make that larger, {finer}",
        )
        return
