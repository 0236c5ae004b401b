"""Sum: terrains of one grid whose heights are added."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from pipeline.spec.model_base import Fault, raise_faults
from pipeline.spec.terrain.base import (
    CELLS,
    SHARED_KEYS,
    TERRAIN_KINDS,
    Cells,
    GridTerrain,
    ShortForms,
    TerrainConfig,
    terrain_kind,
    written_out,
)

GRID = ("size", "cells")

TERM_KINDS = tuple(kind for kind in TERRAIN_KINDS.values() if "size" in kind.model_fields)
"""Terrains that fit any grid."""


def _term(value: Any) -> Any:
    """Write a term out; the material of a preset and the like belong to the sum."""
    return written_out(value, without=SHARED_KEYS)


if TYPE_CHECKING:
    Term = TerrainConfig
else:
    Term = Annotated[
        Union[TERM_KINDS],  # noqa: UP007 - made of the registry
        Field(discriminator="kind"),
        BeforeValidator(_term),
        ShortForms(),
    ]


@terrain_kind()
class SumTerrain(GridTerrain):
    """Terrains whose heights are added, such as stairs and the roughness of their stone.

    Keys that concern the whole, such as the size, the cells and the material, stand beside
    `of`.
    """

    kind: Literal["sum"] = Field("sum", description="Terrains that are added.")
    cells: Cells = Field((480, 480), description=CELLS)
    of: Annotated[tuple[Term, ...], Field(min_length=1, max_length=16)] = Field(
        description="The terrains that are added."
    )

    @model_validator(mode="before")
    @classmethod
    def _one_grid(cls, value: Any) -> Any:
        """Give the terms the grid of the whole, against which they check their features."""
        if not isinstance(value, Mapping) or not isinstance(value.get("of"), list | tuple):
            return value
        fields = cls.model_fields
        grid = {key: value.get(key, fields[key].default) for key in GRID}
        if not all(_is_pair(side) for side in grid.values()):
            return value
        return {**value, "of": tuple(_with_grid(term, grid) for term in value["of"])}

    @field_validator("of", mode="after")
    @classmethod
    def _one_ground(cls, of: tuple[Term, ...], info: ValidationInfo) -> tuple[Term, ...]:
        """Give the terms the keys of the whole."""
        raise_faults(_faults_of_shared_keys(of, info.data))
        if not all(key in info.data for key in SHARED_KEYS):
            return of
        shared = {key: info.data[key] for key in SHARED_KEYS}
        return tuple(term.model_copy(update=shared) for term in of)


def _with_grid(term: Any, grid: Mapping[str, Any]) -> Any:
    try:
        term = _term(term)
    except PydanticCustomError:
        return term  # It is refused again, at its own place, when the terms are read.
    return {**grid, **term} if isinstance(term, Mapping) else term


def _faults_of_shared_keys(of: tuple[Term, ...], whole: Mapping[str, Any]) -> Iterator[Fault]:
    for i, term in enumerate(of):
        for key in SHARED_KEYS:
            if key not in term.model_fields_set or key not in whole:
                continue
            if getattr(term, key) != whole[key]:
                yield Fault((i, key), "belongs to the whole sum; write it beside 'of'")


def _is_pair(value: Any) -> bool:
    return (
        isinstance(value, list | tuple)
        and len(value) == 2
        and all(type(n) in (int, float) and n > 0 for n in value)
    )
