"""Terrain: the ground of a scene, by the name of its kind or written out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field
from pydantic.annotated_handlers import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from pipeline.spec.faults import fault
from pipeline.spec.nearest import hint
from pipeline.spec.values import Length, LengthOrZero, Name, Number, Whole, Words

CellCount = Annotated[Whole, Field(ge=2, le=4000)]


class Ground(Words):
    """What every kind of terrain has."""

    size: tuple[Length, Length] = Field(
        (30.0, 30.0), description="Extent along x and z, centred on the origin [m]."
    )
    cells: tuple[CellCount, CellCount] = Field(
        (240, 240), description="Number of cells of the grid along x and z."
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

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Let a preset of this kind stand for the kind, as `{preset: hills, height: 2}`."""
        block = handler.resolve_ref_schema(handler(core))
        kind = block["properties"]["kind"]["const"]
        names = [name for name, words in TERRAIN_PRESETS.items() if words["kind"] == kind]
        preset = {"enum": names, "description": "The preset that this terrain starts from."}
        block["properties"] = {"preset": preset, **block["properties"]}
        block["oneOf"] = [{"required": ["kind"]}, {"required": ["preset"]}]
        return block


class FlatTerrain(Ground):
    """Level ground at height 0."""

    kind: Literal["flat"] = Field("flat", description="Level ground.")


class FractalTerrain(Ground):
    """Rocky ground whose detail repeats at ever smaller sizes."""

    kind: Literal["fractal"] = Field("fractal", description="Fractal ground.")
    height: LengthOrZero = Field(1.2, description="From the lowest to the highest point [m].")
    roughness: Number = Field(
        0.55, ge=0, le=1, description="How much of the height each halving of the size keeps."
    )
    scale: Length | None = Field(
        None, description="Size of the largest features [m]; chosen by the size if left out."
    )


class HillsTerrain(Ground):
    """Smooth hills."""

    kind: Literal["hills"] = Field("hills", description="Smooth hills.")
    height: LengthOrZero = Field(1.0, description="From the lowest to the highest point [m].")
    spacing: Length = Field(6.0, description="From one hill to the next, on average [m].")


TERRAIN_PRESETS: Mapping[str, Mapping[str, Any]] = {
    "flat": {"kind": "flat"},
    "fractal": {"kind": "fractal"},
    "hills": {"kind": "hills"},
}


def _written_out(words: Any) -> Any:
    """Replace a name, or a preset with changes, by the mapping that it stands for."""
    if isinstance(words, str):
        if words not in TERRAIN_PRESETS:
            raise fault(f"no terrain is called '{words}', {hint(words, TERRAIN_PRESETS)}")
        return TERRAIN_PRESETS[words]
    if not isinstance(words, Mapping) or "preset" not in words:
        return words
    preset = words["preset"]
    if not isinstance(preset, str) or preset not in TERRAIN_PRESETS:
        close = hint(str(preset), TERRAIN_PRESETS)
        raise fault(f"no terrain is called '{preset}', {close}", "preset")
    if "kind" in words:
        raise fault("give either preset or kind, not both", "kind", at_key=True)
    changes = {key: value for key, value in words.items() if key != "preset"}
    return {**TERRAIN_PRESETS[preset], **changes}


class _ShortForms:
    """Lets the JSON Schema accept a terrain by name, and by preset with changes."""

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"enum": list(TERRAIN_PRESETS)}, handler(core)]}


Terrain = Annotated[
    FlatTerrain | FractalTerrain | HillsTerrain,
    Field(discriminator="kind"),
    BeforeValidator(_written_out),
    _ShortForms(),
]
