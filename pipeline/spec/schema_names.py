"""Names in the JSON Schema: those of the library, which editors offer, and the author's own.

Closed sets are enumerations. Materials and moods are closed as long as the scene has no block of
its own for them. Figures and dances may be files beside the scene, which no schema can see: any
name and path is accepted, and those of the library are offered.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cache
from typing import Any

from audio.general_midi import DRUMS, INSTRUMENTS
from pipeline.spec.behaviour import NAMES
from pipeline.spec.model_base import NAMES_MARK
from pipeline.spec.mood import MOODS
from pipeline.spec.scene_library import DANCES, FIGURES, library, names_in
from pipeline.spec.sound_thresholds import Detect
from render.config import MATERIALS

Schema = dict[str, Any]

BLOCKS_OF_OWN = ("materials", "moods")
"""Kinds of names for which a scene may have a block of its own."""

PATH_SCHEMA = {"type": "string", "pattern": r"\.ya?ml$|[/\\]"}
"""Path of a file, see `scene_library.is_path`."""


@cache
def _names(kind: str) -> list[str]:
    """Return the names of a kind, in the order in which they are listed."""
    folders = {FIGURES: FIGURES, DANCES: DANCES}
    if kind in folders:
        return names_in(library() / folders[kind])
    known: Mapping[str, Collection[str]] = {
        "materials": MATERIALS,
        "moods": MOODS,
        "behaviours": NAMES,
        "instruments": INSTRUMENTS,
        "drums": DRUMS,
        "causes": Detect.model_fields,
    }
    return list(known[kind])


def with_names(schema: Any) -> Any:
    """Return a schema with the names that stand for its marks."""
    if isinstance(schema, list):
        return [with_names(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    result = {key: with_names(value) for key, value in schema.items() if key != NAMES_MARK}
    kind = schema.get(NAMES_MARK)
    if kind is None:
        return result
    names = _names(kind)
    if kind == "behaviours":
        return result | {"enum": names}
    if kind in BLOCKS_OF_OWN or kind in (FIGURES, DANCES):
        own = {key: result.pop(key) for key in ("type", "pattern", "maxLength") if key in result}
        paths = [] if kind in BLOCKS_OF_OWN else [PATH_SCHEMA]
        return result | {"anyOf": [{"type": "string", "enum": names}, own, *paths]}
    # These are read in any case, with blanks, `-` or `_` between words.
    accepted = "|".join([*map(_spellings, names), *(["\\*"] if kind == "causes" else [])])
    return result | {
        "examples": names,
        "if": {"not": {"pattern": accepted}},
        "then": {"type": "string", "enum": names},
    }


def _spellings(name: str) -> str:
    """Return the pattern of all spellings of a name that `audio.names` takes for the same."""
    words = ("".join(f"[{c.lower()}{c.upper()}]" if c.isalpha() else c for c in word)
             for word in name.replace("-", " ").split())  # fmt: skip
    return rf"^[ _-]*{'[ _-]+'.join(words)}[ _-]*$"


def with_closed_names(schema: Schema, marked: Schema) -> Schema:
    """Return a schema that closes the sets of names for which a scene has no block of its own.

    Args:
        schema: a whole schema.
        marked: the same with its marks, and without conditions.
    """
    definitions, conditions = {**schema["definitions"]}, []
    for kind in BLOCKS_OF_OWN:
        definitions[f"{kind} of the library"] = {"type": "string", "enum": _names(kind)}
        closed = _closed(marked, kind, marked["definitions"], ())
        conditions.append({"if": {"not": {"required": [kind]}}, "then": closed})
    return {**schema, "definitions": definitions, "allOf": conditions}


def _closed(
    schema: Any, kind: str, definitions: Mapping[str, Schema], inside: tuple[str, ...]
) -> Schema:
    """Return the schema that closes a kind of names and says nothing else, empty without them.

    Args:
        schema: any part of the schema.
        kind: of the names.
        definitions: of the whole schema.
        inside: definitions around this part; one within itself is not followed.
    """
    if not isinstance(schema, dict):
        return {}
    if schema.get(NAMES_MARK) == kind:
        return {"if": {"type": "string"}, "then": {"$ref": f"#/definitions/{kind} of the library"}}
    result: Schema = {}
    if "$ref" in schema and (name := schema["$ref"].rpartition("/")[2]) not in inside:
        result = _closed(definitions[name], kind, definitions, (*inside, name))
    for part in (item for key in ("anyOf", "oneOf", "allOf") for item in schema.get(key, ())):
        result = _merged(result, _closed(part, kind, definitions, inside))
    properties = {
        key: closed
        for key, part in schema.get("properties", {}).items()
        if (closed := _closed(part, kind, definitions, inside))
    }
    if properties:
        result = _merged(result, {"properties": properties})
    # Keys of mappings by name follow one pattern.
    named = [*schema.get("patternProperties", {}).values(), schema.get("additionalProperties")]
    for key, parts in (("additionalProperties", named), ("items", [schema.get("items")]),
                       ("propertyNames", [schema.get("propertyNames")])):  # fmt: skip
        for part in parts:
            if closed := _closed(part, kind, definitions, inside):
                result = _merged(result, {key: closed})
    return result


def _merged(schema: Schema, other: Schema) -> Schema:
    """Return both schemas as one, block by block."""
    merged = dict(schema)
    for key, value in other.items():
        both = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = _merged(merged[key], value) if both else value
    return merged
