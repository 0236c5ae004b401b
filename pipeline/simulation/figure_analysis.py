"""Figure analysis: the public face of the figures for reports on a drawing, which has no take."""

from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.figures.denavit import DenavitRow, denavit_table, to_denavit
from pipeline.simulation.figures.drawing import draw
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.inertia import Inertia
from pipeline.simulation.figures.kinematics import Tree
from pipeline.simulation.figures.network import ARM, FEELER, HEAD, LEG, TAIL, analyse
from pipeline.simulation.figures.skeleton import BODY, Limb

__all__ = [
    "ARM",
    "BODY",
    "FEELER",
    "HEAD",
    "LEG",
    "TAIL",
    "DenavitRow",
    "Figure",
    "Inertia",
    "Limb",
    "MassProperties",
    "Tree",
    "analyse",
    "build_figure",
    "denavit_table",
    "draw",
    "to_denavit",
]
