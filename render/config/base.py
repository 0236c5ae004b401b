"""Base classes and value types of all configuration models."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    model_validator,
)
from pydantic_core import CoreSchema


class RenderConfig(BaseModel):
    """A block of the scene file: frozen; it rejects unknown keys, infinities and NaN."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class PresetModel(RenderConfig):
    """A block that the name of a preset may replace, or that adjusts one by its key `preset`.

    The values of the preset are written out when the block is read, so that a block means the
    same wherever it goes. The block's own values override those of the preset.
    """

    presets: ClassVar[Mapping[str, Mapping[str, Any]]]
    preset: str | None = Field(None, description="The preset that this block starts from.")

    @model_validator(mode="before")
    @classmethod
    def _expand_preset(cls, value: object) -> object:
        values = {"preset": value} if isinstance(value, str) else value
        if not isinstance(values, Mapping) or values.get("preset") is None:
            return values
        known_name(str(values["preset"]), cls.presets, cls.__name__.lower())
        return merge(cls.presets[str(values["preset"])], values)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Let the JSON schema accept the name of a preset in place of the block."""
        block = handler.resolve_ref_schema(handler(schema))
        names = {"type": "string", "enum": sorted(cls.presets)}
        block.get("properties", {}).get("preset", {}).pop("anyOf", None)
        block.get("properties", {}).setdefault("preset", {}).update(names)
        return {"anyOf": [names, block], "title": cls.__name__}


class UnknownName(ValueError):
    """A name that nothing has; the message holds the nearest name, or all of them.

    Attributes:
        kind: what the name should be of, such as "material".
        name: the unknown name.
        known: all known names.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        near = difflib.get_close_matches(name, self.known, n=1, cutoff=0.5)
        hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(self.known)}"
        super().__init__(f"no {kind} is called {name!r}, {hint}")


def merge(base: Mapping[str, Any], override: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with the values of `override` over it, block by block."""
    merged = dict(base)
    for key, value in override.items():
        below = merged.get(key)
        both = isinstance(below, Mapping) and isinstance(value, Mapping)
        merged[key] = merge(below, value) if both else value  # type: ignore[arg-type]
    return merged


def known_name(name: str, names: Iterable[str], kind: str) -> str:
    """Return `name` if it is one of `names`.

    Raises:
        UnknownName: it is not.
    """
    known = sorted(names)
    if name in known:
        return name
    raise UnknownName(kind, name, known)


def _from_hex(value: object) -> object:
    if not isinstance(value, str):
        return value
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
        raise ValueError(f"{value!r} is no colour; write '#rrggbb' or [red, green, blue] in 0..1")
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
"""Red, green, blue of sRGB, each 0 to 1, or `#rrggbb`."""

Point = tuple[float, float, float]

# Beyond 10 km a float32 vertex is less accurate than a millimetre.
Coordinate = Annotated[float, Field(ge=-10_000, le=10_000)]
Place = tuple[Coordinate, Coordinate, Coordinate]
Rate = Annotated[float, Field(ge=-36_000, le=36_000)]
Rates = tuple[Rate, Rate, Rate]

Time = Annotated[float, Field(ge=0, le=1e6)]
Angle = Annotated[float, Field(ge=-36_000, le=36_000)]
Turn = tuple[Angle, Angle, Angle]

Ease = Literal["spline", "linear", "in", "out", "in-out", "hold"]
"""Interpolation from the keyframe before, of bodies and of the camera."""

EASE_DESCRIPTION = (
    "Interpolation from the keyframe before: spline passes through without a stop, in starts "
    "from rest, out comes to rest, in-out does both, linear does neither"
)
HELD_EASE_DESCRIPTION = f"{EASE_DESCRIPTION}, hold waits and then jumps."

TURN_DESCRIPTION = "about z, then x, then y, so that y turns it about the vertical [degrees]"
"""Meaning of the three numbers of every `turn_deg` and `rotation_deg`."""
