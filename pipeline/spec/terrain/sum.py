"""Sum: terrains of one grid whose heights are added."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.terrain.built import DitchesTerrain, RampTerrain, StairsTerrain, StonesTerrain
from pipeline.spec.terrain.files import ImageTerrain
from pipeline.spec.terrain.ground import CELLS, WORDS_OF_THE_WHOLE, Cells, Grid
from pipeline.spec.terrain.names import ShortForms, written_out
from pipeline.spec.terrain.wild import BouldersTerrain, FlatTerrain, FractalTerrain, HillsTerrain

GRID = ("size", "cells")


def _term(words: Any) -> Any:
    """Write a term out; the material of a preset and the like are the sum's to say."""
    return written_out(words, without=WORDS_OF_THE_WHOLE)


Term = Annotated[
    FlatTerrain
    | FractalTerrain
    | HillsTerrain
    | BouldersTerrain
    | StairsTerrain
    | RampTerrain
    | DitchesTerrain
    | StonesTerrain
    | ImageTerrain,
    Field(discriminator="kind"),
    BeforeValidator(_term),
    ShortForms(),
]


class SumTerrain(Grid):
    """Terrains whose heights are added, such as stairs and the roughness of their stone.

    What concerns the whole, such as the size, the cells and the material, is said once,
    beside `of`.
    """

    kind: Literal["sum"] = Field("sum", description="Terrains that are added.")
    cells: Cells = Field((480, 480), description=CELLS)
    of: Annotated[tuple[Term, ...], Field(min_length=1, max_length=16)] = Field(
        description="The terrains that are added."
    )

    @model_validator(mode="before")
    @classmethod
    def _one_grid(cls, words: Any) -> Any:
        """Give the terms the grid of the whole, by which they judge what they can show."""
        if not isinstance(words, Mapping) or not isinstance(words.get("of"), list | tuple):
            return words
        fields = cls.model_fields
        grid = {key: words.get(key, fields[key].default) for key in GRID}
        if not all(_is_pair(value) for value in grid.values()):
            return words
        return {**words, "of": tuple(_with(term, grid) for term in words["of"])}

    @field_validator("of", mode="after")
    @classmethod
    def _said_once(cls, of: tuple[Term, ...], info: ValidationInfo) -> tuple[Term, ...]:
        refuse(_said_twice(of, info.data))
        return tuple(
            term.model_copy(update={key: info.data[key] for key in WORDS_OF_THE_WHOLE})
            if all(key in info.data for key in WORDS_OF_THE_WHOLE)
            else term
            for term in of
        )


def _with(term: Any, grid: Mapping[str, Any]) -> Any:
    try:
        term = _term(term)
    except PydanticCustomError:
        return term  # It is refused where it stands, when the terms are read.
    return {**grid, **term} if isinstance(term, Mapping) else term


def _said_twice(of: tuple[Term, ...], whole: Mapping[str, Any]) -> Iterator[Fault]:
    for i, term in enumerate(of):
        for key in WORDS_OF_THE_WHOLE:
            if key not in term.model_fields_set or key not in whole:
                continue
            if getattr(term, key) != whole[key]:
                yield Fault((i, key), "is said once for the whole sum, beside 'of'")


def _is_pair(value: Any) -> bool:
    return (
        isinstance(value, list | tuple)
        and len(value) == 2
        and all(type(n) in (int, float) and n > 0 for n in value)
    )
