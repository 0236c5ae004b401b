"""Terrain: the ground of a scene, by the name of its kind or written out."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator, Field

from pipeline.spec.terrain.built import DitchesTerrain, RampTerrain, StairsTerrain, StonesTerrain
from pipeline.spec.terrain.files import ImageTerrain, MeshTerrain, beside, simulated
from pipeline.spec.terrain.ground import Grid, Ground, Polygons
from pipeline.spec.terrain.names import ShortForms, written_out
from pipeline.spec.terrain.presets import TERRAIN_PRESETS
from pipeline.spec.terrain.sum import SumTerrain
from pipeline.spec.terrain.wild import BouldersTerrain, FlatTerrain, FractalTerrain, HillsTerrain

Terrain = Annotated[
    FlatTerrain
    | FractalTerrain
    | HillsTerrain
    | BouldersTerrain
    | StairsTerrain
    | RampTerrain
    | DitchesTerrain
    | StonesTerrain
    | ImageTerrain
    | MeshTerrain
    | SumTerrain,
    Field(discriminator="kind"),
    BeforeValidator(written_out),
    ShortForms(),
]

__all__ = [
    "TERRAIN_PRESETS",
    "BouldersTerrain",
    "DitchesTerrain",
    "FlatTerrain",
    "FractalTerrain",
    "Grid",
    "Ground",
    "HillsTerrain",
    "ImageTerrain",
    "MeshTerrain",
    "Polygons",
    "RampTerrain",
    "StairsTerrain",
    "StonesTerrain",
    "SumTerrain",
    "Terrain",
    "beside",
    "simulated",
]
