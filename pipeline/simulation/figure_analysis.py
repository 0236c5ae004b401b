"""Figure analysis: the public face of the figures for reports on a drawing, which has no take."""

from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.figures.denavit_hartenberg import (
    DenavitRow,
    denavit_table,
    to_denavit,
)
from pipeline.simulation.figures.drawing import draw
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.figure_checks import check_figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.kinematics import JointTree
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
    "FigureMass",
    "JointTree",
    "Limb",
    "MassProperties",
    "analyse",
    "build_figure",
    "check_figure",
    "denavit_table",
    "draw",
    "to_denavit",
]
