"""Many: bodies of one kind that begin as a wall, a stack, a row, a pyramid or a heap."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from pipeline.spec.body import BodyWords
from pipeline.spec.faults import Fault, refuse
from pipeline.spec.values import Length, LengthOrZero, Name, Point, Whole, Words

MOST = 5_000
"""Bodies of one member of a cast."""

Count = Annotated[Whole, Field(ge=1, le=MOST)]

ShapeName = Literal[
    "box",
    "brick",
    "cube",
    "die",
    "tetrahedron",
    "octahedron",
    "dodecahedron",
    "icosahedron",
    "prism",
    "pyramid",
    "sphere",
]


def _in_full(words: Any) -> Any:
    """Return the words of a body that its shape's name stands for; it meets all others."""
    if isinstance(words, str):
        words = {"shape": words}
    return {"collide": "all", **words} if isinstance(words, Mapping) else words


OfWhat = Annotated[
    BodyWords, BeforeValidator(_in_full, json_schema_input_type=ShapeName | BodyWords)
]


class Arrangement(Words, ABC):
    """What all arrangements have."""

    of: OfWhat = Field(
        description="Shape and matter of each: a shape by its name, or all words of a body."
    )
    materials: tuple[Name, ...] = Field(
        (),
        max_length=100,
        description="Each has one of these, by chance; if none are given, that of all.",
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.of.collide != "all":
            message = "bodies of `many` meet one another; take this away"
            refuse([Fault(("of", "collide"), message)])
        if self.total > MOST:
            refuse([Fault((), f"makes {self.total} bodies, where {MOST} are the most")])
        return self

    @property
    @abstractmethod
    def total(self) -> int:
        """How many bodies there are."""


class Wall(Arrangement):
    """A wall in running bond, about its middle."""

    layout: Literal["wall"] = Field(
        "wall",
        description="A wall along its x; every other row is moved by not quite half a body.",
    )
    rows: Count = Field(6, description="How high it is, in bodies.")
    columns: Count = Field(8, description="How long it is, in bodies.")
    gap: LengthOrZero = Field(0.002, description="Between neighbours of a row [m].")

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.rows * self.columns


class Pyramid(Arrangement):
    """A wall of which each row is shorter by one."""

    layout: Literal["pyramid"] = Field(
        description="A wall along its x, each row shorter by one body."
    )
    rows: Annotated[Whole, Field(ge=1, le=100)] = Field(
        6, description="How high it is, and how long at the ground, in bodies."
    )
    gap: LengthOrZero = Field(0.01, description="Between neighbours of a row [m].")

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.rows * (self.rows + 1) // 2


class Stack(Arrangement):
    """One on top of another."""

    layout: Literal["stack"] = Field(description="One on top of another.")
    count: Count = Field(10, description="How many there are.")

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.count


class Row(Arrangement):
    """One after another, each on the ground and looking along the row."""

    layout: Literal["row"] = Field(description="One after another, as dominoes.")
    count: Count = Field(20, description="How many there are.")
    spacing: Length = Field(0.15, description="From middle to middle along the row [m].")
    along: Annotated[tuple[Point, ...], Field(max_length=1000)] = Field(
        (),
        description="Places [x, z] that the row passes smoothly after `at`, relative to it and "
        "its heading; straight along its x, and beyond the last one, if left out.",
    )

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.count


class Heap(Arrangement):
    """Turned anyhow above one another, so that they fall on a heap."""

    layout: Literal["heap"] = Field(description="Loose in the air, to fall on a heap.")
    count: Count = Field(40, description="How many there are.")
    radius: Length = Field(0.6, description="Of the column of air that they fall in [m].")
    above: LengthOrZero = Field(0.3, description="From the ground to the lowest of them [m].")

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.count


def _laid_out(words: Any) -> Any:
    """Return words with their layout: what says none is a wall."""
    return {"layout": "wall", **words} if isinstance(words, Mapping) else words


ManyWords = Annotated[
    Wall | Pyramid | Stack | Row | Heap,
    Field(discriminator="layout"),
    BeforeValidator(_laid_out),
]
