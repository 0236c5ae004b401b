"""Key tables: keys of a model with their defaults and meanings, as the documentation shows them."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from pipeline.spec.script import FORMS, flow_text, order_keys
from pipeline.spec.terrain.base import (
    TERRAIN_KINDS,
    TERRAIN_PRESETS,
    GridTerrain,
    TerrainConfig,
)

HEAD = "| key | default | meaning |\n|---|---|---|"


def key_table(model: type[BaseModel], without: Collection[str] = ()) -> str:
    """Return the keys of a model as a table in Markdown.

    Args:
        model: any block of the scene.
        without: keys that are left out.
    """
    rows = [
        f"| `{key}` | {default_text(field)} | {_meaning(field)} |"
        for key, field in model.model_fields.items()
        if key not in without
    ]
    return "\n".join([HEAD, *rows])


def order_key_table() -> str:
    """Return the keys that orders may have besides the one that selects them, in Markdown."""
    rows = [
        f"| `{order}` | `{key}` | {default_text(field)} | {_meaning(field)} |"
        for order in FORMS
        for key, field in order_keys(order).items()
    ]
    return "\n".join(["| order | key | default | meaning |\n|---|---|---|---|", *rows])


def default_text(field: FieldInfo) -> str:
    """Return the default of a key, empty where the description says what is chosen."""
    if field.is_required():
        return "needed"
    default = field.default
    return "" if default is None else f"`{flow_text(default)}`"


def _meaning(field: FieldInfo) -> str:
    text = field.description or ""
    choices = [value for value in get_args(field.annotation) if isinstance(value, str)]
    if any(choice not in text for choice in choices):
        text = f"{text} One of {', '.join(f'`{choice}`' for choice in choices)}."
    return text.replace("|", "\\|")


def terrain_tables() -> str:
    """Return the keys of all terrains in Markdown: those of every kind, then those of each."""
    lines = ["### Keys of every terrain", "", key_table(TerrainConfig), ""]
    for kind, model in TERRAIN_KINDS.items():
        lines += [f"### `{kind}`", "", *_introduction(kind, model), ""]
        same = {key for key in TerrainConfig.model_fields if key in model.model_fields}
        lines += [key_table(model, {"kind", *same}), ""]
    return "\n".join(lines).rstrip()


def _introduction(kind: str, model: type[TerrainConfig]) -> Iterator[str]:
    """Yield what a kind is, and the presets that stand for it."""
    yield (model.__doc__ or "").strip().split("\n")[0]
    presets = {name: keys for name, keys in TERRAIN_PRESETS.items() if keys["kind"] == kind}
    texts = []
    for name, keys in presets.items():
        changes = ", ".join(f"{k}: {flow_text(v)}" for k, v in keys.items() if k != "kind")
        texts.append(f"`{name}` ({changes})" if changes else f"`{name}`")
    if texts:
        yield f"Presets: {', '.join(texts)}."
    elif not issubclass(model, GridTerrain):
        yield "It has no preset, because it needs a file."
