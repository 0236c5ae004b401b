"""Scatter: what grows and lies on the ground, by preset or species by species.

A new species is a name here and a shape with the same name in
`pipeline/production/scenery/species.py`; a test pairs them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, field_validator
from pydantic.annotated_handlers import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from pipeline.spec.model_base import ConfigModel, Number, Positive, fault_error
from pipeline.spec.suggestions import hint

SPECIES = (
    *("short grass", "meadow grass", "tall grass", "dry grass", "tussock", "beach grass"),
    *("sedge", "reeds", "water weed", "wheat", "maize"),
    *("daisy", "buttercup", "poppy", "cornflower", "dandelion", "clover"),
    *("fern", "heather", "moss cushion", "succulent", "mushroom", "leaves", "twigs"),
    *("bush", "scrub", "willow scrub", "oak", "birch", "acacia", "spruce"),
    *("pebbles", "stone", "boulder", "coral"),
)
"""Names of all species."""

SCATTER_PRESETS: Mapping[str, Mapping[str, float]] = {
    "none": {},
    "lawn": {"short grass": 1.3, "daisy": 0.5, "clover": 0.7, "dandelion": 0.4},
    "meadow": {
        "short grass": 0.6,
        "meadow grass": 1.0,
        "tall grass": 1.8,
        "dry grass": 0.12,
        "clover": 0.8,
        "dandelion": 0.6,
        "leaves": 0.4,
        "daisy": 1.0,
        "buttercup": 1.0,
        "poppy": 0.35,
        "cornflower": 0.35,
        "stone": 0.35,
        "bush": 0.5,
        "oak": 1.0,
        "birch": 0.6,
    },
    "pasture": {
        "short grass": 1.0,
        "meadow grass": 0.7,
        "tall grass": 0.12,
        "dry grass": 0.08,
        "clover": 1.0,
        "dandelion": 0.8,
        "leaves": 0.4,
        "twigs": 0.2,
        "daisy": 0.4,
        "stone": 0.8,
        "boulder": 0.4,
        "bush": 0.3,
        "oak": 1.0,
        "spruce": 0.4,
    },
    "steppe": {
        "dry grass": 1.0,
        "sedge": 0.9,
        "scrub": 0.8,
        "pebbles": 1.0,
        "stone": 1.0,
        "boulder": 0.5,
        "twigs": 0.3,
        "tall grass": 0.06,
        "bush": 0.15,
    },
    "savanna": {
        "dry grass": 1.6,
        "sedge": 0.8,
        "tall grass": 0.2,
        "scrub": 0.6,
        "pebbles": 0.6,
        "stone": 0.6,
        "boulder": 0.3,
        "acacia": 1.0,
        "twigs": 0.4,
    },
    "forest floor": {
        "moss cushion": 1.0,
        "fern": 1.0,
        "sedge": 0.3,
        "short grass": 0.25,
        "leaves": 1.0,
        "twigs": 1.0,
        "mushroom": 1.0,
        "stone": 0.5,
        "bush": 0.6,
        "birch": 2.0,
        "spruce": 3.0,
        "oak": 1.5,
    },
    "moss": {
        "moss cushion": 1.6,
        "short grass": 0.45,
        "sedge": 0.3,
        "clover": 0.5,
        "leaves": 3.0,
        "twigs": 0.6,
        "fern": 0.35,
        "daisy": 0.2,
        "mushroom": 0.5,
        "pebbles": 0.15,
        "stone": 0.6,
        "boulder": 0.5,
        "birch": 0.6,
        "spruce": 1.0,
    },
    "desert": {
        "dry grass": 0.25,
        "scrub": 0.5,
        "succulent": 0.5,
        "pebbles": 0.7,
        "stone": 0.5,
        "boulder": 0.4,
    },
    "dunes": {"beach grass": 0.16, "dry grass": 0.1, "scrub": 0.12, "pebbles": 0.3, "stone": 0.12},
    "tundra": {
        "tussock": 0.35,
        "sedge": 0.3,
        "willow scrub": 0.5,
        "pebbles": 0.3,
        "stone": 0.7,
        "boulder": 0.6,
        "spruce": 0.5,
    },
    "scree": {
        "pebbles": 2.4,
        "stone": 1.8,
        "boulder": 1.0,
        "sedge": 0.6,
        "tussock": 0.6,
        "dry grass": 0.4,
        "twigs": 0.15,
        "heather": 0.2,
        "spruce": 0.3,
    },
    "heath": {
        "heather": 1.0,
        "tussock": 0.6,
        "sedge": 0.5,
        "short grass": 0.25,
        "dry grass": 0.12,
        "twigs": 0.3,
        "pebbles": 0.4,
        "stone": 0.7,
        "boulder": 0.4,
        "birch": 0.4,
    },
    "beach": {"beach grass": 0.5, "pebbles": 1.2, "stone": 0.3, "twigs": 0.4},
    "wetland": {"reeds": 1.0, "sedge": 1.2, "tussock": 0.5, "twigs": 0.4, "willow scrub": 0.6},
    "wheat field": {"wheat": 1.0, "poppy": 0.5, "cornflower": 0.6},
    "maize field": {"maize": 1.0, "short grass": 0.15},
    "pavement": {"leaves": 0.16, "pebbles": 0.12},
    "room": {},
}
"""Presets: species with factors on their own densities."""

NAMES = ("auto", *SCATTER_PRESETS)


def _preset(name: Any) -> Any:
    if isinstance(name, str) and name not in NAMES:
        close = hint(name, NAMES, "scatter")
        message = f"no scatter is called '{name}', {close}"
        if name in SPECIES:
            message = f"'{name}' is one species; write it in a list: [{name}]"
        raise fault_error(message)
    return name


class ScatteredSpecies(ConfigModel):
    """One species among what is scattered."""

    species: str = Field(strict=True, description="Name of the species.")
    density: Positive | None = Field(
        None, le=400, description="Per square metre of its patches; its own if left out."
    )
    size: Positive = Field(1.0, ge=0.1, le=10, description="Factor on its size.")
    cover: Positive | None = Field(
        None,
        le=1,
        description="Share of the ground that its patches take, 1 for all of it; its own if left "
        "out.",
    )

    @field_validator("species")
    @classmethod
    def _is_known(cls, name: str) -> str:
        if name not in SPECIES:
            close = hint(name, SPECIES, "species")
            raise fault_error(f"no species is called '{name}', {close}")
        return name


def _species(value: Any) -> Any:
    return {"species": value} if isinstance(value, str) else value


Listed = Annotated[ScatteredSpecies, BeforeValidator(_species)]


class Scatter(ConfigModel):
    """Plants and stones over the ground: the name of a preset, a list of species, or both."""

    preset: Annotated[str, BeforeValidator(_preset)] = Field(
        "none", strict=True, description="What grows and lies there, by name."
    )
    density: Number = Field(
        1.0, ge=0, le=20, description="Factor on the densities of the preset's species."
    )
    size: Positive = Field(
        1.0,
        ge=0.25,
        le=12,
        description="Factor on the sizes of the preset's species, of which as many fewer stand: at "
        "6, a beetle as long as a dog walks among them as an insect.",
    )
    species: tuple[Listed, ...] = Field(
        (), max_length=len(SPECIES), description="Further species, by name or with values."
    )

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Accept the name of a preset, or a list of species."""
        block = handler.resolve_ref_schema(handler(core))
        block["properties"]["preset"] = {"enum": list(NAMES), "default": "none"}
        item = block["properties"]["species"]["items"]
        one = {"anyOf": [{"enum": list(SPECIES)}, item]}
        block["properties"]["species"]["items"] = one
        return block


class ScatterForms:
    """Lets the JSON Schema accept a scatter by name or as a list."""

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return names and lists beside the model."""
        names = [{"enum": list(SPECIES)}, {"type": "object"}]
        listed = {"type": "array", "items": {"anyOf": names}}
        return {"anyOf": [{"enum": list(NAMES)}, listed, handler(core)]}


def _scatter(value: Any) -> Any:
    if isinstance(value, str):
        return {"preset": _preset(value)}
    if isinstance(value, list | tuple):
        return {"species": value}
    return value


ScatterValue = Annotated[Scatter, BeforeValidator(_scatter), ScatterForms()]
"""A scatter as an author may write it."""
