"""Gaits: what animals of real sizes do at five speeds, beside what has been measured of them.

Figures of the library, and a cockroach from the folder `figures` beside this file, are scaled to
the height of the animal's hips (of sprawlers: to the length of its legs) and get its mass; gait,
stride, cycle and duty factor are chosen as in a scene. Prints the table of docs/walking.md. The
last column is the greatest deviation from what was measured.

    python benchmarks/gaits.py
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.locomotion.gaits.pace import Pace
from pipeline.simulation.locomotion.gaits.pace_choice import choose_pace
from pipeline.simulation.locomotion.gaits.stride_limits import LegLayout
from pipeline.simulation.locomotion.gaits.stride_plan import build_of
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene
from pipeline.spec.walk import Walk

SCENE = "pronk: 1\nduration: 0.1\ncast:\n- {{figure: {figure}, scale: {scale:.9g}}}\n"

# Folder whose folder `figures` has the figures that the library lacks.
BESIDE = Path(__file__).parent


@dataclass(frozen=True, slots=True)
class Measured:
    """What was measured at a speed [m/s]: stride [m], cycle [s], duty factor, and by whom."""

    stride: float | None = None
    cycle: float | None = None
    duty: float | None = None
    source: str = ""


@dataclass(frozen=True, slots=True)
class Animal:
    """An animal.

    Attributes:
        name: of it.
        figure: of the library that stands for it.
        size: height of the hips, or length of the legs of sprawlers [m].
        mass: [kg].
        speeds: with what was measured [m/s].
    """

    name: str
    figure: str
    size: float
    mass: float
    speeds: dict[float, Measured]


NONE = Measured()
WITTE, HUDSON = "Witte et al. 2006", "Hudson et al. 2012"
SPAGNA = "Spagna et al. 2011"
MICE, HUTCHINSON = "Bellardita and Kiehn 2015", "Hutchinson et al. 2006"
HORSE = {
    1.6: Measured(duty=0.65, source="Hildebrand 1976"),
    3.1: Measured(1.94, None, 0.44, "Bullimore and Burn 2006"),
    6.0: NONE,
    9.0: Measured(4.46, 0.495, 0.275, WITTE),
    17.0: Measured(7.12, 0.419, 0.205, WITTE),
}
CHEETAH = {
    1.0: NONE,
    3.0: NONE,
    9.0: Measured(3.75, 0.417, None, HUDSON),
    17.0: Measured(5.31, 0.3125, None, HUDSON),
    21.8: NONE,
}
ELEPHANT = {
    0.8: NONE,
    1.5: Measured(duty=0.7, source=HUTCHINSON),
    2.5: NONE,
    4.3: Measured(duty=0.5, source=HUTCHINSON),
    6.0: NONE,
}
MOUSE = {
    0.09: Measured(0.034, 0.37, None, MICE),
    0.25: NONE,
    0.40: Measured(0.068, 0.169, None, MICE),
    0.91: Measured(0.091, 0.102, None, MICE),
    1.5: NONE,
}
PERSON = {
    0.8: Measured(duty=0.68, source="Grieve and Gear 1966"),
    1.4: Measured(duty=0.62, source="Grieve and Gear 1966"),
    3.5: Measured(2.5, 0.71, None, "Cavagna et al. 1997"),
    6.0: NONE,
    9.0: Measured(4.19, 0.465, None, "Weyand et al. 2000"),
}
BLABERUS = {
    0.05: NONE,
    0.1: NONE,
    0.2: NONE,
    0.35: Measured(0.027, 0.077, None, "Full and Tu 1990"),
    0.5: NONE,
}
ANIMALS = (
    Animal("horse", "horse", 1.3, 500.0, HORSE),
    Animal(
        "greyhound",
        "antelope",
        0.6,
        30.0,
        {0.9: NONE, 2.0: NONE, 4.0: NONE, 9.0: NONE, 15.0: Measured(4.3, 0.286, None, HUDSON)},
    ),
    Animal("cheetah", "antelope", 0.7, 45.0, CHEETAH),
    Animal("elephant", "camel", 1.9, 3500.0, ELEPHANT),
    Animal("mouse", "antelope", 0.03, 0.025, MOUSE),
    Animal("ostrich", "ostrich", 1.2, 100.0, dict.fromkeys((1.2, 3.0, 5.0, 8.0, 12.0), NONE)),
    Animal("person", "person", 0.9, 75.0, PERSON),
    Animal("Blaberus", "cockroach", 0.02, 0.0026, BLABERUS),
    Animal("Periplaneta", "cockroach", 0.02, 0.00083, dict.fromkeys((0.1, 0.44, 0.7), NONE)),
    Animal("spider", "spider", 0.04, 0.003, dict.fromkeys((0.05, 0.1, 0.15, 0.2, 0.3), NONE)),
    # Hololena of 7 mm: flights begin at 54 body lengths a second. Legs and mass are assumed.
    Animal(
        "Hololena",
        "spider",
        0.01,
        3e-5,
        {0.05: NONE, 0.2: NONE, 0.38: Measured(duty=0.5, source=SPAGNA)},
    ),
)


def of_size(animal: Animal) -> tuple[Figure, LegLayout]:
    """Return the figure of an animal, at its size and with its mass, and its legs."""
    scale = 1.0
    for _ in range(3):
        scene = SCENE.format(figure=animal.figure, scale=scale)
        troupe = Simulation(read_scene(scene, beside=BESIDE)).troupes[0]
        assert isinstance(troupe, WalkerTroupe)
        figure, legs = troupe.herd.figures[0], troupe.herd.leg_layouts[0]
        scale *= animal.size / build_of(figure, legs).size
    mass = FigureMass(figure).mass_of(range(len(figure.skeleton.links)))
    return replace(figure, density=figure.density * animal.mass / mass), legs


def paces(animal: Animal) -> list[Pace]:
    """Return the paces of an animal at its speeds."""
    figure, legs = of_size(animal)
    return [choose_pace("walk", Walk(speed=speed), figure, legs) for speed in animal.speeds]


def deviation(pace: Pace, measured: Measured) -> float | None:
    """Return the greatest relative deviation from what was measured, None without any."""
    duty = float(pace.gait.duty.max())
    pairs = (pace.stride, measured.stride), (pace.cycle, measured.cycle), (duty, measured.duty)
    parts = [abs(ours / theirs - 1.0) for ours, theirs in pairs if theirs is not None]
    return max(parts) if parts else None


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def table(animals: Sequence[Animal] = ANIMALS) -> str:
    """Return the table as Markdown."""
    rows = [
        "| animal | m/s | gait | stride [m] | cycle [s] | duty | measured: the same | off |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for animal in animals:
        for (speed, measured), pace in zip(animal.speeds.items(), paces(animal), strict=True):
            values = (measured.stride, measured.cycle, measured.duty)
            theirs = ", ".join(_number(v) or "-" for v in values)
            off = deviation(pace, measured)
            told = f"{theirs} ({measured.source})" if measured.source else ""
            cells = (
                animal.name,
                f"{speed:g}",
                pace.gait_name,
                _number(pace.stride),
                _number(pace.cycle),
                _number(float(np.max(pace.gait.duty))),
                told,
                "" if off is None else f"{100.0 * off:.0f} %",
            )
            rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


if __name__ == "__main__":
    sys.stdout.write(f"{table()}\n")
