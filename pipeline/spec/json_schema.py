"""The scene language as JSON Schema, from which editors complete and check.

Editors read draft-07; pydantic writes 2020-12.
"""

from __future__ import annotations

from typing import Any

from pipeline.spec.library_search import FigureFile
from pipeline.spec.scene import Scene
from pipeline.spec.scene_sequence import SequenceFile
from pipeline.spec.schema_names import with_closed_names, with_names
from pipeline.spec.schema_unions import with_conditions

DRAFT = "http://json-schema.org/draft-07/schema#"


def schema() -> dict[str, Any]:
    """Return the JSON Schema of a scene file."""
    marked = _draft_07(Scene.model_json_schema())
    result = with_closed_names(_finished(marked, "A scene of pronk"), marked)
    result["oneOf"] = [{"required": ["duration"]}, {"required": ["frames"]}]
    return result


def figure_schema() -> dict[str, Any]:
    """Return the JSON Schema of a figure file."""
    return _finished(_draft_07(FigureFile.model_json_schema()), "A figure of pronk")


def sequence_schema() -> dict[str, Any]:
    """Return the JSON Schema of a file that joins scenes."""
    schema = _finished(_draft_07(SequenceFile.model_json_schema()), "A sequence of pronk")
    clips = schema["properties"]["sequence"]["items"]
    schema["properties"]["sequence"]["items"] = {"anyOf": [{"type": "string"}, clips]}
    return schema


def _finished(marked: dict[str, Any], title: str) -> dict[str, Any]:
    finished = with_names(with_conditions(marked, marked["definitions"]))
    return {**finished, "$schema": DRAFT, "title": title}


def _draft_07(schema: Any) -> Any:
    """Convert a schema from draft 2020-12 to draft-07."""
    if isinstance(schema, list | tuple):
        return [_draft_07(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    result = {key: _draft_07(value) for key, value in schema.items() if key != "discriminator"}
    if isinstance(schema.get("discriminator"), str):
        result["discriminator"] = schema["discriminator"]
    if isinstance(result.get("$defs"), dict):
        result["definitions"] = result.pop("$defs")
    if isinstance(result.get("prefixItems"), list):
        result["items"] = result.pop("prefixItems")
    if "patternProperties" in result:
        # Pydantic gives the pattern of names, and does not exclude others.
        result.setdefault("additionalProperties", False)
    reference = result.get("$ref")
    if isinstance(reference, str):
        result["$ref"] = reference.replace("#/$defs/", "#/definitions/")
        if len(result) > 1:
            # Draft-07 ignores what stands beside a reference.
            result["allOf"] = [{"$ref": result.pop("$ref")}]
    return result
