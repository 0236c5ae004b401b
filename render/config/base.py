"""What all words share: they are frozen, closed and finite, and may start from a preset."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    model_validator,
)
from pydantic_core import CoreSchema


class Words(BaseModel):
    """A block of the scene file: it refuses unknown words, infinities and NaN."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class PresetWords(Words):
    """A block for which the name of a preset may stand, or which adjusts one by `preset`.

    The values of the preset are written out when the block is read, so that a block
    means the same wherever it goes. Its own words come before those of the preset.
    """

    presets: ClassVar[Mapping[str, Mapping[str, Any]]]
    preset: str | None = Field(None, description="The preset that this block starts from.")

    @model_validator(mode="before")
    @classmethod
    def _write_out(cls, value: object) -> object:
        words = {"preset": value} if isinstance(value, str) else value
        if not isinstance(words, Mapping) or words.get("preset") is None:
            return words
        known_name(str(words["preset"]), cls.presets, "preset")
        return merge(cls.presets[str(words["preset"])], words)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Let the name of a preset stand for the block in the JSON schema too."""
        block = handler.resolve_ref_schema(handler(schema))
        names = {"type": "string", "enum": sorted(cls.presets)}
        block.get("properties", {}).get("preset", {}).pop("anyOf", None)
        block.get("properties", {}).setdefault("preset", {}).update(names)
        return {"anyOf": [names, block], "title": cls.__name__}


def merge(under: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return `under` with the words of `over` laid on top, block by block."""
    merged = dict(under)
    for word, value in over.items():
        below = merged.get(word)
        both = isinstance(below, Mapping) and isinstance(value, Mapping)
        merged[word] = merge(below, value) if both else value  # type: ignore[arg-type]
    return merged


def known_name(name: str, names: Iterable[str], what: str) -> str:
    """Return `name` if it is one of `names`.

    Raises:
        ValueError: it is not; the message holds the nearest name, or all of them.
    """
    known = sorted(names)
    if name in known:
        return name
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
    raise ValueError(f"no {what} is called {name!r}; {hint}")


def _from_hex(value: object) -> object:
    if not isinstance(value, str):
        return value
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
        raise ValueError(f"{value!r} is no colour: write '#rrggbb' or [red, green, blue] in 0..1")
    return tuple(int(value[i : i + 2], 16) / 255 for i in (1, 3, 5))


Unit = Annotated[float, Field(ge=0, le=1)]
Color = Annotated[
    tuple[Unit, Unit, Unit],
    BeforeValidator(
        _from_hex,
        json_schema_input_type=Annotated[str, Field(pattern="^#[0-9a-fA-F]{6}$")]
        | tuple[Unit, Unit, Unit],
    ),
]
"""Red, green, blue of sRGB, each 0 to 1; `#rrggbb` may be written for it."""

Point = tuple[float, float, float]
