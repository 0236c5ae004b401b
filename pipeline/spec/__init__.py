"""The scene language: models, loading, errors with line and column."""

from pipeline.spec.cast import Body, Character, Creature, Group, Many, Member, Prop
from pipeline.spec.digest import scene_digest, simulation_key
from pipeline.spec.figure import Figure, Node
from pipeline.spec.json_schema import figure_schema, schema
from pipeline.spec.loading import load_figure, load_figures, load_scene, read_scene
from pipeline.spec.operations import Operation
from pipeline.spec.scene import VERSION, Scene
from pipeline.spec.shipped import find_scene, library, shipped_scenes
from pipeline.spec.terrain import (
    BouldersTerrain,
    DitchesTerrain,
    FlatTerrain,
    FractalTerrain,
    HillsTerrain,
    ImageTerrain,
    MeshTerrain,
    RampTerrain,
    StairsTerrain,
    StonesTerrain,
    SumTerrain,
    Terrain,
)
from pipeline.spec.walk import GaitWords, Walk
from pipeline.spec.writing import dump

__all__ = [
    "VERSION",
    "Body",
    "BouldersTerrain",
    "Character",
    "Creature",
    "DitchesTerrain",
    "Figure",
    "FlatTerrain",
    "FractalTerrain",
    "GaitWords",
    "Group",
    "HillsTerrain",
    "ImageTerrain",
    "Many",
    "Member",
    "MeshTerrain",
    "Node",
    "Operation",
    "Prop",
    "RampTerrain",
    "Scene",
    "StairsTerrain",
    "StonesTerrain",
    "SumTerrain",
    "Terrain",
    "Walk",
    "dump",
    "figure_schema",
    "find_scene",
    "library",
    "load_figure",
    "load_figures",
    "load_scene",
    "read_scene",
    "scene_digest",
    "schema",
    "shipped_scenes",
    "simulation_key",
]
