"""The scene language: models, loading, errors with line and column."""

from pipeline.spec.body import Body, Many
from pipeline.spec.cast import Member
from pipeline.spec.character import Character
from pipeline.spec.creature import Creature
from pipeline.spec.dance import Dance, Subtask
from pipeline.spec.dancer import Dancer
from pipeline.spec.digest import scene_digest, simulation_key
from pipeline.spec.figure import Figure, Node
from pipeline.spec.group import Group
from pipeline.spec.json_schema import figure_schema, schema, sequence_schema
from pipeline.spec.operations import Operation
from pipeline.spec.prop import Prop
from pipeline.spec.scene import VERSION, Scene
from pipeline.spec.scene_library import find_scene, library, shipped_scenes
from pipeline.spec.scene_loader import load_figure, load_figures, load_scene, read_scene
from pipeline.spec.scene_sequence import SceneSequence, is_sequence, load_sequence
from pipeline.spec.terrain import Terrain
from pipeline.spec.walk import GaitPhases, Walk
from pipeline.spec.yaml_writer import dump

__all__ = [
    "VERSION",
    "Body",
    "Character",
    "Creature",
    "Dance",
    "Dancer",
    "Figure",
    "GaitPhases",
    "Group",
    "Many",
    "Member",
    "Node",
    "Operation",
    "Prop",
    "Scene",
    "SceneSequence",
    "Subtask",
    "Terrain",
    "Walk",
    "dump",
    "figure_schema",
    "find_scene",
    "is_sequence",
    "library",
    "load_figure",
    "load_figures",
    "load_scene",
    "load_sequence",
    "read_scene",
    "scene_digest",
    "schema",
    "sequence_schema",
    "shipped_scenes",
    "simulation_key",
]
