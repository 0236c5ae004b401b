"""The scene language as JSON Schema, from which editors complete and check.

Editors read draft-07; pydantic writes 2020-12.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from pipeline.spec.figure_files import FigureFile
from pipeline.spec.scene import Scene

DRAFT = "http://json-schema.org/draft-07/schema#"


def schema() -> dict[str, Any]:
    """Return the JSON Schema of a scene file."""
    words = _draft_07_of(Scene, "A scene of pronk")
    words["oneOf"] = [{"required": ["duration"]}, {"required": ["frames"]}]
    return words


def figure_schema() -> dict[str, Any]:
    """Return the JSON Schema of a figure file."""
    return _draft_07_of(FigureFile, "A figure of pronk")


def _draft_07_of(model: type[BaseModel], title: str) -> dict[str, Any]:
    words = _draft_07(model.model_json_schema())
    return {**words, "$schema": DRAFT, "title": title}


def _draft_07(words: Any) -> Any:
    """Say in draft-07 what is said in 2020-12."""
    if isinstance(words, list | tuple):
        return [_draft_07(item) for item in words]
    if not isinstance(words, dict):
        return words
    said = {key: _draft_07(value) for key, value in words.items() if key != "discriminator"}
    if isinstance(words.get("discriminator"), str):
        said["discriminator"] = words["discriminator"]
    if isinstance(said.get("$defs"), dict):
        said["definitions"] = said.pop("$defs")
    if isinstance(said.get("prefixItems"), list):
        said["items"] = said.pop("prefixItems")
    if "patternProperties" in said:
        # Pydantic says what names look like, and not that there are no others.
        said.setdefault("additionalProperties", False)
    reference = said.get("$ref")
    if isinstance(reference, str):
        said["$ref"] = reference.replace("#/$defs/", "#/definitions/")
        if len(said) > 1:
            # Draft-07 reads nothing beside a reference.
            said["allOf"] = [{"$ref": said.pop("$ref")}]
    return said
