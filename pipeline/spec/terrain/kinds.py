"""Kinds of terrain: natural ground, built ground, ground from files, and sums of them.

Built terrains begin at the key `start`, along x from the terrain's middle, with level ground
before it, so that a walker at the middle that looks along x meets them. A height field has no
walls: a wall takes one cell of the grid along x or z. A scene names files from its own folder.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, Union

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from pipeline.spec.model_base import (
    Coordinate,
    Fault,
    Integer,
    Length,
    LengthOrZero,
    Number,
    Positive,
    raise_faults,
)
from pipeline.spec.terrain.base import (
    CELLS,
    SHARED_KEYS,
    SIZE,
    TERRAIN_KINDS,
    Cells,
    GridTerrain,
    ShortForms,
    Size,
    TerrainConfig,
    terrain_kind,
    too_coarse,
    written_out,
)

IRREGULAR = 0.4
"""Share of its radius that a stepping stone may lack on one side."""


@terrain_kind(flat={})
class FlatTerrain(GridTerrain):
    """Level ground at height 0."""

    kind: Literal["flat"] = Field("flat", description="Level ground.")


@terrain_kind(fractal={}, rocks={"height": 1.6, "roughness": 0.6, "material": "rock"})
class FractalTerrain(GridTerrain):
    """Rocky ground whose detail repeats at ever smaller sizes."""

    kind: Literal["fractal"] = Field("fractal", description="Fractal ground.")
    height: LengthOrZero = Field(1.2, description="From the lowest to the highest point [m].")
    roughness: Number = Field(
        0.55, ge=0, le=1, description="How much of the height each halving of the size keeps."
    )
    scale: Length | None = Field(
        None, description="Size of the largest features [m]; chosen by the size if left out."
    )


@terrain_kind(
    hills={},
    meadow={"height": 0.5, "spacing": 7.0, "material": "grass"},
    dunes={"height": 2.2, "spacing": 9.0, "crest": 0.8, "material": "sand"},
)
class HillsTerrain(GridTerrain):
    """Smooth hills, or dunes with crests across the wind."""

    kind: Literal["hills"] = Field("hills", description="Smooth hills.")
    height: LengthOrZero = Field(1.0, description="From the lowest to the highest point [m].")
    spacing: Length = Field(6.0, description="From one hill to the next, on average [m].")
    crest: Number = Field(
        0.0,
        ge=0,
        le=1,
        description="How sharp the crests are: 0 round hills, 1 dunes that a wind along x has "
        "piled up, steep on the far side.",
    )


@terrain_kind(boulders={})
class BouldersTerrain(GridTerrain):
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
        raise_faults(self._faults())
        return self

    def _faults(self) -> Iterator[Fault]:
        small, large = self.diameters
        if large < small:
            told = f"{large:g} is less than the diameter of the smallest, {small:g}"
            yield Fault(("diameters", 1), told)
            return
        yield from too_coarse(self, "diameters", small, least=3)


Course = Literal["up", "down", "up and down"]
COURSE = "Whether it leads up, down, or up and down again."


@terrain_kind(stairs={"material": "grey plaster"})
class StairsTerrain(GridTerrain):
    """Stairs along x."""

    kind: Literal["stairs"] = Field("stairs", description="Stairs.")
    cells: Cells = Field((600, 60), description=CELLS)
    course: Course = Field("up and down", description=COURSE)
    start: Coordinate = Field(1.0, description="Where the first riser is, along x [m].")
    steps: Annotated[Integer, Field(ge=1, le=2000)] = Field(
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
        raise_faults(too_coarse(self, "step_depth", self.step_depth, axes="x"))
        return self


@terrain_kind(ramp={})
class RampTerrain(GridTerrain):
    """A ramp along x, to level ground above or below."""

    kind: Literal["ramp"] = Field("ramp", description="A ramp.")
    cells: Cells = Field((600, 60), description=CELLS)
    course: Course = Field("up and down", description=COURSE)
    start: Coordinate = Field(1.0, description="Where it begins, along x [m].")
    slope_deg: Positive = Field(15.0, le=85, description="Its slope [degrees].")
    height: LengthOrZero = Field(1.0, description="How high, or how deep, it leads [m].")
    level: LengthOrZero = Field(
        2.0, description="How long its level top is before it leads down again [m]."
    )


@terrain_kind(ditches={})
class DitchesTerrain(GridTerrain):
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
        raise_faults(self._faults())
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


@terrain_kind(stones={"material": "rock"})
class StonesTerrain(GridTerrain):
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
    irregularity: Number = Field(
        0.0,
        ge=0,
        le=1,
        description="How unlike the stones' outlines are, and how unlike round: at 1 a stone may "
        "be six tenths as wide across as the widest.",
    )
    rows: Annotated[int, Field(ge=1, le=1001)] | None = Field(
        None,
        description="Of stones beside one another, an odd number, the middle one in the terrain's "
        "middle; rows all across if left out.",
    )

    @model_validator(mode="after")
    def _can_be_shown(self) -> Self:
        raise_faults(self._faults())
        return self

    def _faults(self) -> Iterator[Fault]:
        if self.rows is not None and self.rows % 2 == 0:
            yield Fault(("rows",), f"{self.rows} rows have no middle one; take {self.rows + 1}")
        least = self.diameter * (1.0 - IRREGULAR * self.irregularity)
        yield from too_coarse(self, "diameter", least, least=3)
        yield from too_coarse(self, "gap", self.gap * (1.0 - 0.5 * self.jitter))


@terrain_kind()
class ImageTerrain(TerrainConfig):
    """Heights from a grayscale picture: its columns along x, its rows along z."""

    kind: Literal["image"] = Field("image", description="Heights from a picture.")
    file: str = Field(
        min_length=1,
        max_length=1000,
        description="A grayscale PNG of 8 or 16 bits, named from the scene's folder.",
    )
    size: Size = Field((30.0, 30.0), description=SIZE)
    cells: Cells | None = Field(
        None,
        description="Number of cells of the grid along x and z; one from pixel to pixel if left "
        "out.",
    )
    low: Coordinate = Field(0.0, description="Height of black [m].")
    high: Coordinate = Field(1.5, description="Height of white [m].")


@terrain_kind()
class MeshTerrain(TerrainConfig):
    """Heights from a mesh whose vertices form a regular grid; its faces are not read."""

    kind: Literal["mesh"] = Field("mesh", description="Heights from a mesh.")
    file: str = Field(
        min_length=1,
        max_length=1000,
        description="An OBJ or PLY mesh, named from the scene's folder.",
    )
    up: Literal["y", "z"] = Field("y", description="The axis of the file that points up.")
    scale: Length = Field(1.0, description="Metres a unit of the file.")


GRID = ("size", "cells")

TERM_KINDS = tuple(kind for kind in TERRAIN_KINDS.values() if "size" in kind.model_fields)
"""Terrains that fit any grid."""


def _term(value: Any) -> Any:
    """Write a term out; the material of a preset and the like belong to the sum."""
    return written_out(value, without=SHARED_KEYS)


if TYPE_CHECKING:
    Term = TerrainConfig
else:
    Term = Annotated[
        Union[TERM_KINDS],  # noqa: UP007 - made of the registry
        Field(discriminator="kind"),
        BeforeValidator(_term),
        ShortForms(),
    ]


@terrain_kind()
class SumTerrain(GridTerrain):
    """Terrains whose heights are added, such as stairs and the roughness of their stone.

    Keys that concern the whole, such as the size, the cells and the material, stand beside
    `of`.
    """

    kind: Literal["sum"] = Field("sum", description="Terrains that are added.")
    cells: Cells = Field((480, 480), description=CELLS)
    of: Annotated[tuple[Term, ...], Field(min_length=1, max_length=16)] = Field(
        description="The terrains that are added."
    )

    @model_validator(mode="before")
    @classmethod
    def _one_grid(cls, value: Any) -> Any:
        """Give the terms the grid of the whole, against which they check their features."""
        if not isinstance(value, Mapping) or not isinstance(value.get("of"), list | tuple):
            return value
        fields = cls.model_fields
        grid = {key: value.get(key, fields[key].default) for key in GRID}
        if not all(_is_pair(side) for side in grid.values()):
            return value
        return {**value, "of": tuple(_with_grid(term, grid) for term in value["of"])}

    @field_validator("of", mode="after")
    @classmethod
    def _one_ground(cls, of: tuple[Term, ...], info: ValidationInfo) -> tuple[Term, ...]:
        """Give the terms the keys of the whole."""
        raise_faults(_faults_of_shared_keys(of, info.data))
        if not all(key in info.data for key in SHARED_KEYS):
            return of
        shared = {key: info.data[key] for key in SHARED_KEYS}
        return tuple(term.model_copy(update=shared) for term in of)


def _with_grid(term: Any, grid: Mapping[str, Any]) -> Any:
    try:
        term = _term(term)
    except PydanticCustomError:
        return term  # It is refused again, at its own place, when the terms are read.
    return {**grid, **term} if isinstance(term, Mapping) else term


def _faults_of_shared_keys(of: tuple[Term, ...], whole: Mapping[str, Any]) -> Iterator[Fault]:
    for i, term in enumerate(of):
        for key in SHARED_KEYS:
            if key not in term.model_fields_set or key not in whole:
                continue
            if getattr(term, key) != whole[key]:
                yield Fault((i, key), "belongs to the whole sum; write it beside 'of'")


def _is_pair(value: Any) -> bool:
    return (
        isinstance(value, list | tuple)
        and len(value) == 2
        and all(type(n) in (int, float) and n > 0 for n in value)
    )
