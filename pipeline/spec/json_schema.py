"""The scene language as JSON Schema, from which editors complete and check.

Editors read draft-07; pydantic writes 2020-12.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from pipeline.spec.library_search import FigureFile
from pipeline.spec.scene import Scene

DRAFT = "http://json-schema.org/draft-07/schema#"


def schema() -> dict[str, Any]:
    """Return the JSON Schema of a scene file."""
    result = _schema_of(Scene, "A scene of pronk")
    result["oneOf"] = [{"required": ["duration"]}, {"required": ["frames"]}]
    return result


def figure_schema() -> dict[str, Any]:
    """Return the JSON Schema of a figure file."""
    return _schema_of(FigureFile, "A figure of pronk")


def _schema_of(model: type[BaseModel], title: str) -> dict[str, Any]:
    return {**_draft_07(model.model_json_schema()), "$schema": DRAFT, "title": title}


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
