"""The base of all models of the scene language: value types, and errors between keys."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Strict, Tag
from pydantic.annotated_handlers import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError


class ConfigModel(BaseModel):
    """A block of the scene file: unknown keys and NaN are errors, instances do not change."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True
    )


_LETTER = "0-9A-Za-z_\u00c0-\u1fff\u2c00-\ud7ff"
NAME_PATTERN = f"^[{_LETTER}]([{_LETTER} \\-]*[{_LETTER}])?$"
"""Letters of any script, digits, `_`; inside also `-` and blanks. Dots and brackets are left to
paths. Spelled out, because pydantic, Python and editors disagree on what `\\w` is."""

MAX_NAME_LENGTH = 64
"""Of a name [characters]."""

WORLD_LIMIT = 10_000.0
"""Largest coordinate [m]: beyond 10 km a float32 vertex is not exact to a millimetre."""

LEAST = 1e-9
"""Smallest of the numbers that must be positive: quotients of much smaller ones overflow."""


def _not_tiny(value: float) -> float:
    if value < LEAST:
        raise fault_error(f"must be at least {LEAST:g}, is {value!r}")
    return value


Number = Annotated[float, Strict()]
Positive = Annotated[Number, Field(gt=0), AfterValidator(_not_tiny)]
Integer = Annotated[int, Strict()]
Name = Annotated[str, Strict(), Field(pattern=NAME_PATTERN, max_length=MAX_NAME_LENGTH)]


@dataclass(frozen=True, slots=True)
class ListedIn:
    """Marks a name in the JSON Schema as one of those that `pronk list` shows as a kind."""

    kind: str

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Add the mark, which `schema_names` replaces by the names."""
        return {**handler(core), NAMES_MARK: self.kind}


NAMES_MARK = "x-names"

MaterialName = Annotated[Name, ListedIn("materials")]
FigureName = Annotated[Name, ListedIn("figures")]
DanceName = Annotated[Name, ListedIn("dances")]
MoodName = Annotated[Name, ListedIn("moods")]
BehaviourName = Annotated[Name, ListedIn("behaviours")]

Coordinate = Annotated[Number, Field(ge=-WORLD_LIMIT, le=WORLD_LIMIT)]
Length = Annotated[Positive, Field(le=WORLD_LIMIT)]
LengthOrZero = Annotated[Number, Field(ge=0, le=WORLD_LIMIT)]
Phase = Annotated[Number, Field(ge=0, le=1)]
Point = tuple[Coordinate, Coordinate]
Position = tuple[Coordinate, Coordinate, Coordinate]


MEMBER_PATTERN = f"{NAME_PATTERN[:-1]}(\\.[{_LETTER}]([{_LETTER} \\-]*[{_LETTER}])?)?$"
MemberName = Annotated[str, Strict(), Field(pattern=MEMBER_PATTERN, max_length=129)]
"""A member of the cast or a place by name, or a part of a member, such as bug.head."""


def _name_or_place(value: Any) -> str:
    return "a name" if isinstance(value, str) else "a place"


Target = Annotated[
    Annotated[MemberName, Tag("a name")] | Annotated[Position, Tag("a place")],
    Discriminator(_name_or_place),
]
"""A performer by its name, or a place [x, y, z] [m]."""


Goal = Annotated[
    Annotated[MemberName, Tag("a name")] | Annotated[Point, Tag("a place")],
    Discriminator(_name_or_place),
]
"""A member of the cast or a place by its name, or a place on the ground [x, z] [m]."""


def keyed_union(forms: Mapping[str, type[BaseModel]], default: str, word: Any = None) -> Any:
    """Return the union of models that are told apart by the key that each alone has.

    Args:
        forms: the models by their keys; the first of these keys that a mapping has decides.
        default: name of the model that a mapping without any of the keys is checked against.
        word: type of what a plain string may be, if it may.
    """

    def tag(value: Any) -> str | None:
        if word is not None and isinstance(value, str):
            return "a word"
        if isinstance(value, Mapping):
            return next((form.__name__ for key, form in forms.items() if key in value), default)
        return type(value).__name__ if isinstance(value, ConfigModel) else None

    union: Any = Annotated[word, Tag("a word")] if word is not None else None
    for model in forms.values():
        tagged = Annotated[model, Tag(model.__name__)]  # type: ignore[valid-type] # at run time
        union = tagged if union is None else union | tagged
    return Annotated[union, Discriminator(tag)]


PathSegment = str | int
"""A key of a mapping or an index of a list."""

FAULTS = "faults"
"""Type of the pydantic error that carries faults."""

MAX_FAULTS = 100
"""Faults reported of one model: finding near names takes time."""


@dataclass(frozen=True, slots=True)
class Fault:
    """An error between the keys of a model.

    Attributes:
        path: keys and indices from the model down to the error.
        message: what is wrong and what to write instead.
        at_key: the key is wrong, not its value.
    """

    path: tuple[PathSegment, ...]
    message: str
    at_key: bool = False

    def below(self, *path: PathSegment) -> Fault:
        """Return the fault as seen from a model around this one."""
        return Fault((*path, *self.path), self.message, self.at_key)


def raise_faults(faults: Iterable[Fault]) -> None:
    """Raise all faults as one error of pydantic, if there are any.

    Raises:
        PydanticCustomError: there is at least one fault.
    """
    found = tuple(islice(faults, MAX_FAULTS))
    if found:
        text = "; ".join(fault.message for fault in found)
        raise PydanticCustomError(FAULTS, "{text}", {"text": text, "faults": found})


def fault_error(message: str, *path: PathSegment, at_key: bool = False) -> PydanticCustomError:
    """Return one fault as an error of pydantic, to be raised."""
    context = {"text": message, "faults": (Fault(path, message, at_key),)}
    return PydanticCustomError(FAULTS, "{text}", context)
