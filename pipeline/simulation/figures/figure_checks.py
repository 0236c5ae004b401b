"""Figure checks: what an author of a figure may not have meant, once it stands.

The figure stands in its rest pose on level ground, which is where its lowest foot is.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.network import LEG, Remark
from pipeline.simulation.spatial import Array

REACH = 0.97
"""Greatest extension of a leg, in its length."""

FLOAT_FRACTION = 0.02
"""Height of a stretched leg's foot above the ground that is worth a remark, in its length."""

LENGTH_RATIO = 1.4
"""Ratio of the longest leg to the shortest that is worth a remark. That of a spider is 1.3."""

BALANCE_FRACTION = 0.15
"""Distance of the centre of mass outside the feet that is worth a remark, in a leg's length:
about what a long foot makes up for."""

DIRECTIONS = 72
"""Directions in which the centre of mass is compared with the feet."""


def check_figure(figure: Figure) -> tuple[Remark, ...]:
    """Return remarks on a figure: on its drawing, then on how it stands."""
    return (*figure.anatomy.warnings, *_stance_remarks(figure))


def _stance_remarks(figure: Figure) -> Iterator[Remark]:
    """Yield remarks on how a figure stands."""
    skeleton = figure.skeleton
    if not skeleton.legs:
        return
    legs = LimbBatch.of([(skeleton, limb) for limb in skeleton.legs]).slid_out()
    tips = legs.pose(legs.preferred).tips
    yield from _floating_feet(figure, legs, tips)
    yield from _unequal_legs(figure, legs.lengths)
    yield from _low_body(figure, legs)
    yield from _toppling(figure, legs.lengths, tips)


def _feet(figure: Figure) -> list[str]:
    """Return the names of the drawing's nodes at the tips of the legs."""
    return [figure.drawing.names[a.nodes[-1]] for a in figure.anatomy.of_kind(LEG)]


def _floating_feet(figure: Figure, legs: LimbBatch, tips: Array) -> Iterator[Remark]:
    soles = np.array([limb.tip_radius for limb in figure.skeleton.legs])
    bottoms = tips[:, 1] - soles
    ground = float(bottoms.min())
    short = legs.places[:, 0, 1] - legs.lengths - soles - ground
    names = _feet(figure)
    lowest = names[int(bottoms.argmin())]
    floating = np.flatnonzero(short > FLOAT_FRACTION * legs.lengths)
    if not len(floating):
        return
    worst = int(floating[short[floating].argmax()])
    feet = ", ".join(f"'{names[i]}'" for i in floating)
    text = (
        f"{feet} {'float' if len(floating) > 1 else 'floats'} {bottoms[worst] - ground:.2g} m "
        f"above the ground where '{lowest}' stands, and stretched {short[worst]:.2g} m: make "
        "the leg longer, or the others shorter; walking, the body sinks until all feet reach"
    )
    yield Remark(names[int(floating[0])], text, True)


def _unequal_legs(figure: Figure, lengths: Array) -> Iterator[Remark]:
    short, long = int(lengths.argmin()), int(lengths.argmax())
    if lengths[long] > LENGTH_RATIO * lengths[short]:
        names = _feet(figure)
        text = (
            f"legs are of very unequal length: {lengths[short]:.2g} m to '{names[short]}', "
            f"{lengths[long]:.2g} m to '{names[long]}'; if one of them is no leg, say so: "
            f"parts: {{{names[short]}: arm}}"
        )
        yield Remark(names[short], text, True)


def _low_body(figure: Figure, legs: LimbBatch) -> Iterator[Remark]:
    room = REACH * legs.lengths - legs.places[:, 0, 1]
    short = int(room.argmin())
    if room[short] < figure.belly:
        name = _feet(figure)[short]
        text = (
            f"the body lies on the ground: it is {figure.belly:.2g} m thick below its middle, and "
            f"the leg to '{name}' reaches {room[short]:.2g} m down; make the leg longer or the "
            "body's nodes thinner"
        )
        yield Remark(name, text, True)


def _toppling(figure: Figure, lengths: Array, tips: Array) -> Iterator[Remark]:
    centre = FigureMass(figure).at_rest.centre
    angles = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    beyond = centre[[0, 2]] @ directions - (tips[:, [0, 2]] @ directions).max(axis=0)
    worst = int(beyond.argmax())
    if beyond[worst] <= BALANCE_FRACTION * float(lengths.mean()):
        return
    x, z = directions[:, worst]
    side = ("ahead of" if x > 0 else "behind") if abs(x) >= abs(z) else "beside"
    text = (
        f"it would fall over: its centre of mass is {beyond[worst]:.2g} m {side} its feet; move "
        "its legs there, or make what is on the other side heavier"
    )
    yield Remark(_feet(figure)[0], text, True)
