"""Figure facts: what is told of a figure, for other programs, with all its digits.

Units are SI and angles degrees where a key ends in `_deg`. Places and axes are those of the
creation frame, in which the figure lies as it was drawn: X forward, Y up, Z right. A frame
is four rows of four numbers.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.figures.denavit_hartenberg import denavit_table, to_denavit
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.skeleton import BODY


def facts(figure: Figure, inertia: FigureMass) -> dict[str, Any]:
    """Return masses, centres of mass and inertias of a figure and its links.

    Those of the whole are in its rest pose, in the body's frame.
    """
    skeleton = figure.skeleton
    links = [
        {
            "name": link.name,
            "kind": link.kind,
            "joint": None if link.joint == BODY else skeleton.joint_names[link.joint],
            **_mass(mass),
        }
        for link, mass in zip(skeleton.links, inertia.links, strict=True)
    ]
    whole = _mass(inertia.at_rest)
    return {"name": figure.name, "density": figure.density, "rest": whole, "links": links}


def denavit_facts(figure: Figure) -> list[dict[str, Any]]:
    """Return the Denavit-Hartenberg parameters of all joints.

    Each has the frame in it that its link is told in: parallel to the creation frame at joint
    values zero, at the joint's place.
    """
    rows, tools = denavit_table(figure.skeleton), to_denavit(figure.skeleton).tools
    return [{**asdict(row), "tool": tool.tolist()} for row, tool in zip(rows, tools, strict=True)]


def _mass(mass: MassProperties) -> dict[str, Any]:
    return {
        "mass": mass.mass,
        "centre": mass.centre.tolist(),
        "inertia": mass.inertia.tolist(),
    }
