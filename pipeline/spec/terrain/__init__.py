"""Terrain: the ground of a scene, by the name of a preset or written out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Union

from pydantic import BeforeValidator, Field

from pipeline.spec.terrain import kinds  # noqa: F401 - registers all kinds
from pipeline.spec.terrain.base import TERRAIN_KINDS, ShortForms, TerrainConfig, written_out

if TYPE_CHECKING:
    Terrain = TerrainConfig
else:
    Terrain = Annotated[
        Union[tuple(TERRAIN_KINDS.values())],  # noqa: UP007 - made of the registry
        Field(discriminator="kind"),
        BeforeValidator(written_out),
        ShortForms(),
    ]
