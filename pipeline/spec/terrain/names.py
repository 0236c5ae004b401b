"""Names of terrains: a name or an adjusted preset -> the mapping that it stands for."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from pydantic.annotated_handlers import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from pipeline.spec.faults import fault
from pipeline.spec.nearest import hint
from pipeline.spec.terrain.presets import TERRAIN_PRESETS


def written_out(words: Any, without: Collection[str] = ()) -> Any:
    """Replace a name, or a preset with changes, by the mapping that it stands for.

    Args:
        words: what stands for a terrain.
        without: words that are not taken from presets.

    Raises:
        PydanticCustomError: no terrain has this name.
    """
    if isinstance(words, str):
        if words not in TERRAIN_PRESETS:
            raise fault(f"no terrain is called '{words}', {hint(words, TERRAIN_PRESETS)}")
        return _preset(words, without)
    if not isinstance(words, Mapping) or "preset" not in words:
        return words
    preset = words["preset"]
    if not isinstance(preset, str) or preset not in TERRAIN_PRESETS:
        close = hint(str(preset), TERRAIN_PRESETS)
        raise fault(f"no terrain is called '{preset}', {close}", "preset")
    if "kind" in words:
        raise fault("give either preset or kind, not both", "kind", at_key=True)
    changes = {key: value for key, value in words.items() if key != "preset"}
    return {**_preset(preset, without), **changes}


def _preset(name: str, without: Collection[str]) -> dict[str, Any]:
    return {key: value for key, value in TERRAIN_PRESETS[name].items() if key not in without}


class ShortForms:
    """Lets the JSON Schema accept a terrain by name, and by preset with changes."""

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the names beside what the models say."""
        return {"anyOf": [{"enum": list(TERRAIN_PRESETS)}, handler(core)]}
