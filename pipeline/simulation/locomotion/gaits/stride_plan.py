"""Stride plan: stride, duty factor and height of a body at a speed, as far as its legs reach.

A stride of the laws of animals (`scaling_laws`) that is longer than the legs reach first lowers the
body, then shortens the stance, and at last is shortened itself; the cadence grows instead, up to
the greatest that muscles can drive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.locomotion.gaits import scaling_laws
from pipeline.simulation.locomotion.gaits.gait import WALKING_DUTY, Gait, share_of_run
from pipeline.simulation.locomotion.gaits.pace import MIN_CYCLE
from pipeline.simulation.locomotion.gaits.scaling_laws import Build, Style
from pipeline.simulation.locomotion.gaits.stride_limits import LegLayout
from pipeline.spec.walk import Manner


@dataclass(frozen=True, slots=True)
class BodyHeights:
    """Bounds of default body heights.

    Attributes:
        lowest: over level ground, in depths of the belly.
        run, walk, stand: greatest height running, walking and standing, as fractions of the
            tallest that the legs reach: straight legs have no room for a stride.
        running_crouch, walking_crouch: least height to which a long stride lowers a body that runs
            and that walks, as fractions of its own.
        upright_running_crouch, upright_crouch: the same on two legs.
    """

    lowest: float = 1.25
    run: float = 0.92
    walk: float = 0.94
    stand: float = 0.99
    running_crouch: float = 0.86
    walking_crouch: float = 0.97
    upright_running_crouch: float = 0.91
    upright_crouch: float = 0.975


BODY_HEIGHTS = BodyHeights()

# Default stride, as a fraction of the longest that the legs can do: the outer legs on a curve, and
# all while the body speeds up, need the rest of their reach. Sprawling legs need more of it.
STRIDE_OF_LONGEST, SPRAWLING_STRIDE_OF_LONGEST = 0.9, 0.75

# The same of two legs, as a fraction of the longest with legs that are extended so far, as a
# fraction of their length.
PLANNED_STRIDE, UPRIGHT_REACH = 0.97, 0.96

# Bounce of a gait without flights and with two beats, in leg lengths, and the part of it by which a
# body is lowest where stances begin and end.
BOUNCE, UPRIGHT_BOUNCE, BOUNCE_AT_ENDS = 0.018, 0.024, 0.85

# Least duty factor of a long stride, as a fraction of the law's. Where the law has no flights there
# are none; the bounds of walks go over into those of runs between two duty factors.
SHORTENED_STANCE, MIN_GROUNDED_DUTY = 0.75, WALKING_DUTY

# Gaits that keep their own duty factor, which belongs to the turns that feet take, or to the one
# leg that always leads.
OWN_DUTY = frozenset({"", "wave", "ripple", "hop", "skip"})

# Gaits that are a walk or a run at any speed; the others are one or the other by speed.
STYLES: dict[str, Style] = {
    "walk": "walking",
    **dict.fromkeys(
        (
            "amble",
            "pace",
            "canter",
            "transverse gallop",
            "rotary gallop",
            "bound",
            "run",
            "hop",
            "skip",
        ),
        "running",
    ),
}

# Speeds between which the greatest is looked for [m/s], and halvings.
SPEEDS, BISECTIONS = (1e-4, 1e3), 50

# Relative difference between speeds that is rounding.
SPEED_TOLERANCE = 1e-9


class Plan(NamedTuple):
    """What legs do at a speed: stride [m], duty factor, height of the body [m]."""

    stride: float
    duty: float
    height: float


@dataclass(frozen=True, eq=False)
class StridePlanner:
    """What the legs of one creature do at any speed.

    Attributes:
        where: path of `walk` in the scene.
        walk: the config.
        build: size of the creature, of all its legs.
        legs: that it walks on.
        belly: depth of its body below the hips [m].
    """

    where: str
    walk: Manner
    build: Build
    legs: LegLayout
    belly: float

    @cached_property
    def greatest_frequency(self) -> float:
        """Greatest stride frequency, of its muscles or of the world's steps [Hz]."""
        return min(scaling_laws.greatest_frequency(self.build), 1.0 / MIN_CYCLE)

    def style(self, name: str, speed: float) -> Style:
        """Return whether it walks or runs in a gait at a speed [m/s]."""
        if scaling_laws.is_graviportal(self.build):
            return "walking"
        if name in STYLES:
            return STYLES[name]
        if name == "trot" and len(self.legs.lengths) == 4 and self.build.family == "quadruped":
            return "running"
        return scaling_laws.style_at(self.build, speed)

    @cached_property
    def rest_height(self) -> float:
        """Height of the body as drawn, its belly off the ground [m]."""
        lowest = BODY_HEIGHTS.lowest * self.belly
        return max(float((self.legs.ends - self.legs.feet[:, 1]).mean()), lowest)

    def heights(self, duty: float) -> tuple[float, float]:
        """Return the least and the greatest height of the body with a duty factor [m].

        Raises:
            SceneError: the legs do not reach the ground from the author's.
        """
        tallest, given = self.legs.tallest(), self.walk.body_height
        runs = share_of_run(duty)
        heights = BODY_HEIGHTS
        fraction = heights.walk + runs * (heights.run - heights.walk)
        high = min(self.rest_height, fraction * tallest) if given is None else given
        if high >= tallest:
            message = f"the legs do not reach the ground from {high:g}; "
            message += f"at this scale less than {tallest:.3g} works"
            raise SceneError([Problem(f"{self.where}.body_height", message)])
        if given is not None:
            return given, given
        upright = self.build.family == "biped"
        walking = heights.upright_crouch if upright else heights.walking_crouch
        running = heights.upright_running_crouch if upright else heights.running_crouch
        crouch = walking + runs * (running - walking)
        belly = min(BODY_HEIGHTS.lowest * self.belly, high)
        return max(crouch * high, belly), high

    def _least_duty(self, duty: float) -> float:
        """Return the least duty factor of a long stride whose law has `duty`."""
        if duty >= MIN_GROUNDED_DUTY:
            return max(SHORTENED_STANCE * duty, MIN_GROUNDED_DUTY)
        shortened = 1.0 - share_of_run(duty) * (1.0 - SHORTENED_STANCE)
        return min(max(shortened * duty, scaling_laws.MIN_DUTY), duty)

    def _duties(self, name: str, gait: Gait, speed: float, style: Style) -> tuple[float, float]:
        """Return the duty factor of the law, or of the author or gait, and the least instead."""
        if name in OWN_DUTY or self.walk.duty is not None:
            duty = float(gait.duty.max())
            return duty, duty
        duty = scaling_laws.duty_at(self.build, speed, style)
        return duty, self._least_duty(duty)

    def plan(self, name: str, gait: Gait, speed: float) -> Plan:
        """Return what the legs do at a speed [m/s], perhaps too often."""
        style = self.style(name, speed)
        stride = scaling_laws.stride_at(self.build, speed, style)
        duty, least = self._duties(name, gait, speed, style)
        low, high = self.heights(duty)
        needed, dip = stride * duty, self._dip(gait, duty)
        if self._reach(high - dip) >= needed:
            return Plan(stride, duty, high)
        reach = self._reach(low - dip)
        if reach >= needed:
            below, above = low, high
            for _ in range(BISECTIONS):
                middle = 0.5 * (below + above)
                fits = self._reach(middle - dip) >= needed
                below, above = (middle, above) if fits else (below, middle)
            return Plan(stride, duty, below)
        duty = max(reach / stride, least)
        return Plan(min(stride, reach / duty), duty, low)

    def _reach(self, height: float) -> float:
        """Return the usual way that feet stand through, under a body at a height [m]."""
        if self.build.family == "sprawler":
            return SPRAWLING_STRIDE_OF_LONGEST * self.legs.reach(height)
        usual = STRIDE_OF_LONGEST * self.legs.reach(height)
        if self.build.family == "biped":
            # Nearly straight legs: more would lower the body at each step.
            usual = min(usual, PLANNED_STRIDE * self.legs.reach(height, UPRIGHT_REACH))
        return usual

    def _dip(self, gait: Gait, duty: float) -> float:
        """Return how much lower than on average a body is where its stances begin and end [m].

        In a walk on two legs it vaults over the one that stands.
        """
        if self.build.family != "biped" or gait.beats != 2 or duty < MIN_GROUNDED_DUTY:
            return 0.0
        bounce = grounded_bounce(gait, self.legs)
        return BOUNCE_AT_ENDS * (bounce if self.walk.body_bob is None else self.walk.body_bob)

    def is_possible(self, name: str, gait: Gait, speed: float) -> bool:
        """Return whether the cadence of a speed [m/s] is within reach of its muscles."""
        frequency = self.greatest_frequency * (1.0 + SPEED_TOLERANCE)
        return self.plan(name, gait, speed).stride * frequency >= speed

    def top_speed(self, name: str, gait: Gait) -> float:
        """Return the greatest speed in a gait [m/s]."""
        slow, fast = SPEEDS
        for _ in range(BISECTIONS):
            middle = math.sqrt(slow * fast)
            if self.is_possible(name, gait, middle):
                slow = middle
            else:
                fast = middle
        return slow


def grounded_bounce(gait: Gait, legs: LegLayout) -> float:
    """Return the bounce of a gait without flights [m].

    The more beats, the smaller: the body is shaken no harder.
    """
    bounce = UPRIGHT_BOUNCE if len(legs.lengths) <= 2 else BOUNCE
    return bounce * float(legs.lengths.mean()) * min((2.0 / gait.beats) ** 2, 1.0)


def build_of(figure: Figure, legs: LegLayout) -> Build:
    """Return the size of a figure with legs at rest."""
    mass = FigureMass(figure).mass_of(range(len(figure.skeleton.links)))
    if figure.style == "insect":
        return Build("sprawler", float(legs.lengths.mean()), mass)
    height = float((legs.hips[:, 1] - legs.feet[:, 1]).mean())
    return Build("biped" if len(legs.lengths) <= 2 else "quadruped", height, mass)
