"""Leg records: joints, masses and stances of a herd, for its take."""

from __future__ import annotations

from typing import Any

import numpy as np

from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.inverse_dynamics import FrameMasses
from pipeline.simulation.locomotion.gaits.pace_schedule import PaceSchedule
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.mechanism import Leg, Mechanism
from pipeline.simulation.spatial import Array


def mechanisms_of(herd: Herd) -> list[Mechanism]:
    """Return the mechanism of each figure of a herd that has legs."""
    members: dict[int, list[str]] = {}
    figures = {id(figure): figure for figure in herd.figures if figure.skeleton.legs}
    for name, figure in zip(herd.names, herd.figures, strict=True):
        members.setdefault(id(figure), []).append(name)
    found = []
    for key, figure in figures.items():
        skeleton = figure.skeleton
        masses = FrameMasses.of(skeleton, FigureMass(figure).links)
        found.append(
            Mechanism(
                tuple(members[key]),
                tuple(skeleton.joint_names),
                _frozen(skeleton.parents),
                _frozen(skeleton.axes),
                _frozen(skeleton.places),
                _frozen(skeleton.prismatic),
                _frozen(masses.mass),
                _frozen(masses.centre),
                _frozen(masses.inertia),
            )
        )
    return found


def legs_of(herd: Herd, paces: PaceSchedule, phase: Array) -> list[Leg]:
    """Return the legs of a herd, with the stances planned from phase 0 up to `phase` (C,)."""
    limbs = [limb for figure in herd.figures for limb in figure.skeleton.legs]
    found = []
    for k, (limb, c) in enumerate(zip(limbs, herd.owner.tolist(), strict=True)):
        start, end = herd.figures[c].skeleton.links[limb.links[-1]].ends
        stances = paces.stances(k, 0.0, float(phase[c])) if herd.walks[c] else np.zeros((0, 2))
        found.append(
            Leg(
                herd.names[c],
                limb.name,
                limb.side,
                limb.links[-1],
                limb.joints[-1],
                _frozen(end - start),
                float(herd.legs.lengths[k]),
                float(herd.sole[k]),
                _frozen(stances),
            )
        )
    return found


def _frozen(values: Any) -> Any:
    """Return an array as nested tuples."""
    plain = np.asarray(values).tolist()

    def tuples(value: Any) -> Any:
        return tuple(map(tuples, value)) if isinstance(value, list) else value

    return tuples(plain)
