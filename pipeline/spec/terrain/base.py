"""Base of all terrains: their common keys, presets, and the registry of kinds.

A new kind is a model in this package with `@terrain_kind`, which lists its presets, and a
generator in `pipeline/simulation/terrain` with `@generates`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field
from pydantic.annotated_handlers import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from pipeline.spec.model_base import (
    ConfigModel,
    Coordinate,
    Fault,
    Integer,
    Length,
    LengthOrZero,
    MaterialName,
    Number,
    Positive,
    fault_error,
)
from pipeline.spec.suggestions import hint
from pipeline.spec.terrain.scatter import Scatter, ScatterValue
from render.config import Water

MAX_CELLS = 4000
"""Cells along one side of a grid."""

CellCount = Annotated[Integer, Field(ge=2, le=MAX_CELLS)]
Cells = tuple[CellCount, CellCount]
Size = tuple[Length, Length]
Polygons = Literal["triangles", "quads"]
Surroundings = Literal[
    "auto", "hills", "mountains", "forest", "sea", "plain", "dunes", "mesas", "none"
]
Edging = Literal[
    "auto",
    "hedge",
    "wall",
    "fence",
    "railing",
    "planters",
    "houses",
    "house",
    "school",
    "overgrown",
    "room",
    "none",
]

SIZE = "Extent along x and z, centred on the place `at` [m]."
CELLS = "Number of cells of the grid along x and z."

TERRAIN_KINDS: dict[str, type[TerrainConfig]] = {}
"""Models of terrains by their kind."""

TERRAIN_PRESETS: dict[str, Mapping[str, Any]] = {}
"""Names that stand for a kind and some of its keys."""


class TerrainConfig(ConfigModel):
    """What every kind of terrain has."""

    at: tuple[Coordinate, Coordinate] = Field(
        (0.0, 0.0), description="Middle of the terrain, [x, z] [m]."
    )
    heading_deg: Number = Field(
        0.0,
        ge=-36_000,
        le=36_000,
        description="Turn of the terrain about +Y at its middle [degrees].",
    )
    polygons: Polygons = Field(
        "triangles",
        description="Faces of the grid: `triangles`, two a cell along one diagonal, or `quads`, "
        "four triangles about a middle at the mean height of the corners.",
    )
    material: MaterialName = Field("dry soil", description="Material of the ground, by name.")
    unsteppable_slope_deg: Positive = Field(
        40.0, lt=90, description="Slopes steeper than this are no footholds [degrees]."
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
        True,
        strict=True,
        description="Whether feet leave prints in soft ground: soil, sand, grass, mud or snow.",
    )
    surroundings: Surroundings = Field(
        "auto",
        description="The land from the terrain's edge to the horizon: `hills`, `mountains`, "
        "`forest`, `sea`, `plain`, `dunes`, `mesas` or `none`. `auto`: dunes around sand, "
        "mountains around snow, rock, gravel and ice, a plain around mud, none around a floor in "
        "a studio, hills around all else.",
    )
    edging: Edging = Field(
        "auto",
        description="How a floor on open land ends: with a `hedge`, a dry-stone `wall`, a "
        "`fence` of split rails, a `railing`, `planters`, a row of `houses`, a single `house` or "
        "`school`, the walls of a `room`, or `overgrown` with nothing behind. Slabs end at a "
        "kerb, boards have a rim, and level floors are no larger than the cast needs. "
        "Houses, walls and fences stand on natural ground, too. `auto` is what suits floor and "
        "surroundings; `none` leaves the whole terrain a bare floor.",
    )
    water: Water | None = Field(
        None,
        description="Water over the terrain and the land around it: a name or values. What "
        "moves goes through it as through air.",
    )
    scatter: ScatterValue = Field(
        Scatter(preset="auto"),
        description="Plants and stones: the name of a preset, a list of species, or `{preset, "
        "density, size, species}`. `auto` is what suits the ground; `none` leaves it bare.",
    )

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Accept a preset of this kind instead of the kind, as in `{preset: hills, height: 2}`."""
        block = handler.resolve_ref_schema(handler(core))
        kind = block["properties"]["kind"]["const"]
        names = [name for name, preset in TERRAIN_PRESETS.items() if preset["kind"] == kind]
        if not names:
            block["required"] = ["kind", *block.get("required", [])]
            return block
        preset = {"enum": names, "description": "The preset that this terrain starts from."}
        block["properties"] = {"preset": preset, **block["properties"]}
        block["oneOf"] = [{"required": ["kind"]}, {"required": ["preset"]}]
        return block


class GridTerrain(TerrainConfig):
    """A terrain whose grid the author chooses."""

    size: Size = Field((30.0, 30.0), description=SIZE)
    cells: Cells = Field((240, 240), description=CELLS)


SHARED_KEYS = (*TerrainConfig.model_fields, "size", "cells")
"""Keys that a sum of terrains gives once for all of its terms."""

Kind = TypeVar("Kind", bound=TerrainConfig)


def terrain_kind(**presets: Mapping[str, Any]) -> Callable[[type[Kind]], type[Kind]]:
    """Register a kind of terrain.

    Args:
        presets: by name, the keys in which each differs from the kind's defaults.
    """

    def register(model: type[Kind]) -> type[Kind]:
        kind = model.model_fields["kind"].default
        TERRAIN_KINDS[kind] = model
        TERRAIN_PRESETS.update({name: {"kind": kind, **keys} for name, keys in presets.items()})
        return model

    return register


def too_coarse(
    terrain: GridTerrain, key: str, length: float, least: int = 2, axes: str = "xz"
) -> Iterator[Fault]:
    """Find that a feature is shorter than the cells that it needs.

    Args:
        terrain: any grid.
        key: the key that gives the length.
        length: smallest length of the feature [m].
        least: number of cells that it needs.
        axes: axes along which the grid must be fine enough.
    """
    cells = {axis: terrain.size[k] / terrain.cells[k] for k, axis in enumerate("xz")}
    # A whole number of cells is one only up to rounding.
    coarse = [axis for axis in axes if length < least * cells[axis] * (1.0 - 1e-9)]
    if not coarse:
        return
    needed = {axis: math.ceil(terrain.size["xz".index(axis)] * least / length) for axis in coarse}
    if max(needed.values()) > MAX_CELLS:
        finer = "or size smaller"
    elif len(coarse) > 1:
        finer = f"or cells at least [{needed['x']}, {needed['z']}]"
    else:
        finer = f"or cells[{'xz'.index(coarse[0])}] at least {needed[coarse[0]]}"
    sides = " and ".join(f"{least} cells of {cells[axis]:g} m along {axis}" for axis in coarse)
    yield Fault(
        (key,),
        f"{key} makes features of {length:g} m, less than {sides}; make that larger, {finer}",
    )


def written_out(value: Any, without: Collection[str] = ()) -> Any:
    """Return a terrain as a mapping with its kind, given a name or a preset with changes.

    Args:
        value: a terrain, or the name of one.
        without: keys that are not taken from presets.

    Raises:
        PydanticCustomError: no terrain has this name.
    """
    if isinstance(value, str):
        _require_preset(value)
        return _preset(value, without)
    if not isinstance(value, Mapping) or "preset" not in value:
        return value
    preset = value["preset"]
    _require_preset(preset, "preset")
    if "kind" in value:
        raise fault_error("give either preset or kind, not both", "kind", at_key=True)
    changes = {key: change for key, change in value.items() if key != "preset"}
    return {**_preset(preset, without), **changes}


def _require_preset(name: object, *path: str) -> None:
    if isinstance(name, str) and name in TERRAIN_PRESETS:
        return
    if isinstance(name, str) and name in TERRAIN_KINDS:
        message = f"a terrain of the kind '{name}' needs more keys; write {{kind: {name}, ...}}"
    else:
        close = hint(str(name), {*TERRAIN_PRESETS, *TERRAIN_KINDS}, "terrains")
        message = f"no terrain is called '{name}', {close}"
    raise fault_error(message, *path)


def _preset(name: str, without: Collection[str]) -> dict[str, Any]:
    return {key: value for key, value in TERRAIN_PRESETS[name].items() if key not in without}


class ShortForms:
    """Lets the JSON Schema accept a terrain by name, and by preset with changes."""

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the names of presets beside the models."""
        return {"anyOf": [{"enum": list(TERRAIN_PRESETS)}, handler(core)]}
