"""The scene language: models, loading, errors with line and column."""

from pipeline.spec.cast import Member
from pipeline.spec.figure import Figure, Node, Operation
from pipeline.spec.mirror import Mirror, copied_names, mirrored, mirrored_name, mirrored_point
from pipeline.spec.scene import VERSION, Scene
from pipeline.spec.terrain import FlatTerrain, FractalTerrain, HillsTerrain, Terrain
from pipeline.spec.walk import GaitWords, Walk

__all__ = [
    "VERSION",
    "Figure",
    "FlatTerrain",
    "FractalTerrain",
    "GaitWords",
    "HillsTerrain",
    "Member",
    "Mirror",
    "Node",
    "Operation",
    "Scene",
    "Terrain",
    "Walk",
    "copied_names",
    "mirrored",
    "mirrored_name",
    "mirrored_point",
]
