"""Unions of the JSON Schema as chains of conditions, so that a typo is reported in its branch.

In `oneOf` a value with one mistake matches no alternative, and validators cannot tell which one
its author meant. A chain `if, then, else` decides by the key that only one alternative has, or
by a key such as `kind` whose value differs, as the loader does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

UNIONS = ("oneOf", "anyOf")
Schema = dict[str, Any]


def with_conditions(schema: Any, definitions: Mapping[str, Schema]) -> Any:
    """Return a draft-07 schema whose unions of mappings are chains of conditions.

    Args:
        schema: any part of the schema.
        definitions: all definitions of the whole schema.
    """
    if isinstance(schema, list):
        return [with_conditions(item, definitions) for item in schema]
    if not isinstance(schema, dict):
        return schema
    result = {key: with_conditions(value, definitions) for key, value in schema.items()}
    for union in UNIONS:
        alternatives = result.get(union)
        if not isinstance(alternatives, list):
            continue
        mappings = [item for item in alternatives if _block(item, definitions) is not None]
        if len(mappings) > 1:
            del result[union]
            others = [_typed(item) for item in alternatives if item not in mappings]
            result |= _with_others(_chain(mappings, definitions), others)
        else:
            result[union] = [_typed(item) for item in alternatives]
    return result


def _with_others(mapping: Schema, others: Sequence[Schema]) -> Schema:
    """Return the union of a mapping and other alternatives.

    A word is checked against the words and a mapping against the mapping alone. What is neither,
    such as a value that is still to be written, is open to both, and editors offer both.
    """
    if not others:
        return mapping
    union = {"anyOf": [*others, mapping]}
    if any(other.get("type") != "string" for other in others):
        return union
    word = others[0] if len(others) == 1 else {"anyOf": list(others)}
    return {
        "if": {"type": "object"},
        "then": mapping,
        "else": {"if": {"type": "string"}, "then": word, "else": union},
    }


def _typed(schema: Any) -> Any:
    """Add the type to an enumeration of texts: validators prefer the branch whose type fits."""
    if isinstance(schema, dict) and "type" not in schema:
        values = schema.get("enum", ())
        if values and all(isinstance(value, str) for value in values):
            return {"type": "string", **schema}
    return schema


def _block(schema: Any, definitions: Mapping[str, Schema]) -> Schema | None:
    """Return the definition of a mapping with keys that a reference leads to, else None."""
    if not isinstance(schema, dict) or "$ref" not in schema:
        return None
    block = definitions[schema["$ref"].rpartition("/")[2]]
    return block if block.get("type") == "object" and "properties" in block else None


def _chain(references: Sequence[Schema], definitions: Mapping[str, Schema]) -> Schema:
    """Return the chain of conditions that decides between references to mappings."""
    blocks = [_block(reference, definitions) or {} for reference in references]
    tag = _tag(blocks)
    undecided = result = _tags_alone(tag, blocks) if tag else _keys_alone(blocks)
    for reference, block in reversed(list(zip(references, blocks, strict=True))):
        condition = _tag_condition(tag, block) if tag else {"required": block["required"][:1]}
        # What is not there yet has no key either: editors then offer the keys that decide.
        result = {"if": {"type": "object", **condition}, "then": reference, "else": result}
    if tag and len(keys := _tag_keys(tag, blocks)) > 1:
        has_none = {"not": {"anyOf": [{"required": [key]} for key in keys]}}
        result = {"if": has_none, "then": undecided, "else": result}
    return {"type": "object", **result}


def _tag(blocks: Sequence[Schema]) -> str | None:
    """Return the key whose values tell the blocks apart, None if there is none."""
    for key in blocks[0]["properties"]:
        values = [_values(key, block) for block in blocks]
        if all(values) and len({*chain.from_iterable(values)}) == sum(map(len, values)):
            return str(key)
    return None


def _values(key: str, block: Schema) -> list[Any]:
    """Return the values that a block allows for a key, empty where they are not listed."""
    word = block["properties"].get(key, {})
    return [word["const"]] if "const" in word else list(word.get("enum", ()))


def _tag_keys(tag: str, blocks: Sequence[Schema]) -> list[str]:
    """Return the tag, and the keys that stand in for it by `oneOf`, such as `preset`."""
    required = (choice for block in blocks for choice in block.get("oneOf", ()))
    return list(dict.fromkeys([tag, *(key for choice in required for key in choice["required"])]))


def _tag_condition(tag: str, block: Schema) -> Schema:
    """Return the condition that a mapping has the tag of a block, or leaves out its default."""
    properties = {key: {"enum": _values(key, block)} for key in _tag_keys(tag, [block])}
    return {
        "properties": properties,
        **({"required": [tag]} if tag in block.get("required", ()) else {}),
    }


def _tags_alone(tag: str, blocks: Sequence[Schema]) -> Schema:
    """Return the schema of a mapping whose tag is missing or unknown."""
    keys = _tag_keys(tag, blocks)
    values = {key: chain.from_iterable(_values(key, block) for block in blocks) for key in keys}
    properties = {key: {"enum": list(dict.fromkeys(values[key]))} for key in keys}
    one = {"oneOf": [{"required": [key]} for key in keys]} if keys[1:] else {"required": keys}
    return _undecided(blocks, properties, one)


def _keys_alone(blocks: Sequence[Schema]) -> Schema:
    """Return the schema of a mapping without any of the deciding keys."""
    keys = [block["required"][0] for block in blocks]
    words = {key: block["properties"][key] for key, block in zip(keys, blocks, strict=True)}
    properties = {key: {"description": word.get("description", "")} for key, word in words.items()}
    return _undecided(blocks, properties, {"anyOf": [{"required": [key]} for key in keys]})


def _undecided(blocks: Sequence[Schema], deciding: Schema, required: Schema) -> Schema:
    """Return what is wrong with a mapping that no condition decides on.

    It has an unknown key, which may be the one that decides, or it lacks that.

    Args:
        blocks: all alternatives.
        deciding: properties of the keys that decide.
        required: requires one of these.
    """
    known: Schema = {key: {} for block in blocks for key in block["properties"]}
    return {
        "properties": deciding,
        "if": {"propertyNames": {"enum": list(known)}},
        "then": required,
        "else": {"type": "object", "properties": known, "additionalProperties": False},
    }
