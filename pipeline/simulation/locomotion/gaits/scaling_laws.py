"""Scaling laws: how animals of a size go at a speed; pure functions.

Speeds are compared by the Froude number v²/(g h) with h the height of the hips: animals of
different size move alike at equal Froude numbers (Alexander and Jayes 1983). Sprawling arthropods
have no such height; their numbers are formed with the length of their legs. Body mass bounds the
stride frequency.

Each constant has its source beside it. Where a source gives measurements only, the law goes through
them, and they are given too. Numbers marked (?) are quoted from memory and have not been checked
against their source; heights of hips and lengths of legs are assumed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from pipeline.simulation.dynamics.gravity import GRAVITY

Family = Literal["quadruped", "biped", "sprawler"]
Style = Literal["walking", "running"]


@dataclass(frozen=True, slots=True)
class Build:
    """The size of an animal.

    Attributes:
        family: of laws: `quadruped` for any number of upright legs but two, `sprawler` for
            arthropods.
        size: height of the hips; length of a leg of sprawlers [m].
        mass: of the body [kg].
    """

    family: Family
    size: float
    mass: float

    def froude(self, speed: float) -> float:
        """Return the Froude number of a speed [m/s]."""
        return speed * speed / (GRAVITY * self.size)

    def speed_at(self, froude: float) -> float:
        """Return the speed at a Froude number [m/s]."""
        return math.sqrt(froude * GRAVITY * self.size)


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """A law y = a Fr^b."""

    a: float
    b: float

    def at(self, froude: float) -> float:
        """Return y at a Froude number."""
        return float(self.a * froude**self.b)


# --- strides ------------------------------------------------------------------------

# Relative stride s / h of cursorial mammals: 2.4 Fr^0.34 walking and 1.9 Fr^0.40 running (Alexander
# and Jayes 1983 (?)). Running horses have less: trotting ones of 86 to 714 kg 1.43, 1.49 and 1.66
# at Fr 0.5, 0.75 and 1 (Bullimore and Burn 2006), galloping ones 3.43 and 5.48 at Fr 6.4 and 23
# (Witte et al. 2006, hips 1.3 m high); cheetahs have 5.36 at Fr 12 (Hudson et al. 2012, 0.7 m).
# The law for running lies between them.
WALKING_STRIDE, RUNNING_STRIDE = PowerLaw(2.4, 0.34), PowerLaw(1.84, 0.39)

# Of mammals that crouch, most of those below 5 kg: s / h = 1.13, 2.27 and 3.03 of mice with hips
# 0.03 m high at 0.09, 0.40 and 0.91 m/s (walk, trot and gallop of Bellardita and Kiehn 2015:
# strides of 3.4, 6.8 and 9.1 cm, 2.7, 5.9 and 9.8 a second; for the trot they give 0.51 m/s, more
# than the product).
CROUCHED_STRIDE, CROUCHED_MASS = PowerLaw(2.53, 0.22), 5.0

# Of running people: strides of 2.5 m at 3.5 m/s, hips 0.9 m high, and 4.2 m at 9 m/s (step
# frequencies of 2.8/s of Cavagna et al. 1997 (?), and of 4.3/s of Weyand et al. 2000 (?); Schepens
# et al. 1998 give 2.5/s below 3 m/s and 4/s at top speed).
BIPED_RUNNING_STRIDE = PowerLaw(2.55, 0.27)

# Of cockroaches, by the length of their legs (0.02 m): 13 Hz at 0.35 m/s of Blaberus (Full and Tu
# 1990), 27 Hz at 1.5 m/s of Periplaneta (Full and Tu 1991).
SPRAWLING_STRIDE = PowerLaw(1.5, 0.245)

# --- duty factors -------------------------------------------------------------------

# Walking quadrupeds: 0.65 of horses at Fr 0.2 (Hildebrand 1976 (?)), 0.7 of elephants at Fr 0.12
# (?) and 0.5 at Fr 1, where their hindquarters begin to fly (Hutchinson et al. 2006).
WALKING_DUTY = PowerLaw(0.53, -0.12)

# Walking people: 0.68 at 0.8 m/s, 0.62 at 1.4 m/s (Grieve and Gear 1966 (?)), hips 0.9 m high.
BIPED_WALKING_DUTY = PowerLaw(0.565, -0.07)

# Running: 0.47, 0.44 and 0.39 of trotting horses at Fr 0.5, 0.75 and 1 (Bullimore and Burn 2006);
# 0.275 and 0.205 of galloping ones at 9 and 17 m/s, hips 1.3 m high (Witte et al. 2006: stances of
# 131 and 143 ms, swings of 364 and 355 ms of fore and hind feet at 9 m/s; 77 and 94, 342 and 326 ms
# at 17 m/s).
RUNNING_DUTY = PowerLaw(0.40, -0.22)

# Sprawling: Periplaneta, legs of 0.02 m, begins to fly at 1 m/s, with 0.5 (Full and Tu 1991);
# that of running cockroaches falls to 0.5 and below (Ting et al. 1994); 0.68 at 0.1 m/s, a choice,
# keeps three feet down while tripods alternate.
SPRAWLING_DUTY = PowerLaw(0.56, -0.067)

# Bounds on the duty factor. At top speed animals from hares to horses keep 0.2 and a little less
# (Witte et al. 2006); cheetahs use less (?).
MIN_DUTY, MAX_DUTY = 0.15, 0.8

# --- speeds -------------------------------------------------------------------------

# Froude numbers of transitions, and how far beyond them a gait is kept: speeds of the changes up
# and down differ (Daley et al. 2016 of ostriches), by some 10 % (?).
WALK_TO_TROT = 0.35  # horses of 90 to 720 kg (Griffin et al. 2004 (?))
WALK_TO_RUN = 0.5  # people (Alexander 1989 (?)); ostriches change below (Daley et al. 2016)
TROT_TO_CANTER = 2.5  # cursorial mammals change between 2 and 3 (Alexander and Jayes 1983 (?))
CANTER_TO_GALLOP = 4.0
HYSTERESIS = 1.1

# Froude numbers at which animals go when they are free to: walking people and horses, the trot and
# the gallop that Heglund and Taylor (1988) call preferred, and running people.
COMFORTABLE = {
    "walk": 0.2,
    "amble": 0.8,
    "pace": 0.8,
    "trot": 0.8,
    "canter": 3.0,
    "transverse gallop": 5.0,
    "rotary gallop": 5.0,
    "bound": 5.0,
    "run": 1.2,
    "skip": 0.6,
    "hop": 0.5,
}

# Of sprawlers: 0.1 m/s with legs of 0.02 m, a cockroach that walks; a choice.
COMFORTABLE_SPRAWL = 0.05

# Of those that hurry: a gallop, a run, and half of the speed of the fastest cockroach.
HURRIED = {"quadruped": 5.0, "biped": 3.0, "sprawler": 0.6}

# Mass from which animals never trot or gallop: elephants keep the footfall of their walk at all
# speeds (Hutchinson et al. 2006); the heaviest that gallop, rhinoceroses, have some 2,000 kg.
GRAVIPORTAL_MASS = 2500.0

# Mass from which gallops are transverse, as horses', rather than rotary, as dogs' and cheetahs'
# (Hildebrand 1977; Biancardi and Minetti 2012).
TRANSVERSE_MASS = 100.0

# --- cadence ------------------------------------------------------------------------

# Greatest stride frequency by mass [Hz, kg]: the exponent of Heglund and Taylor 1988 (-0.15 at
# equivalent speeds; its third digit (?)), and for quadrupeds the 4.0 Hz of cheetahs of 45 kg
# (Hudson
# et al. 2012), for bipeds the 2.45 Hz of sprinters of 80 kg (Weyand et al. 2000 (?)), for
# sprawlers
# the 27 Hz of Periplaneta of 0.83 g (Full and Tu 1991).
FREQUENCY_EXPONENT = -0.156
GREATEST_FREQUENCY = {"quadruped": 7.3, "biped": 5.0, "sprawler": 9.0}


def greatest_frequency(build: Build) -> float:
    """Return the greatest stride frequency that muscles can drive [Hz]."""
    return float(GREATEST_FREQUENCY[build.family] * build.mass**FREQUENCY_EXPONENT)


def style_at(build: Build, speed: float) -> Style:
    """Return whether an animal walks or runs at a speed [m/s], in a gait that can be either."""
    bound = WALK_TO_RUN if build.family == "biped" else WALK_TO_TROT
    return "walking" if is_graviportal(build) or build.froude(speed) < bound else "running"


def is_graviportal(build: Build) -> bool:
    """Return whether an animal is too heavy to trot and gallop."""
    return build.family == "quadruped" and build.mass >= GRAVIPORTAL_MASS


def stride_at(build: Build, speed: float, style: Style) -> float:
    """Return the length of a stride at a speed [m/s] over the ground [m]."""
    if build.family == "sprawler":
        law = SPRAWLING_STRIDE
    elif build.family == "quadruped" and build.mass < CROUCHED_MASS:
        law = CROUCHED_STRIDE
    elif style == "walking":
        law = WALKING_STRIDE
    else:
        law = BIPED_RUNNING_STRIDE if build.family == "biped" else RUNNING_STRIDE
    return build.size * law.at(build.froude(speed))


def duty_at(build: Build, speed: float, style: Style) -> float:
    """Return the duty factor at a speed [m/s]."""
    if build.family == "sprawler":
        law = SPRAWLING_DUTY
    else:
        walking = BIPED_WALKING_DUTY if build.family == "biped" else WALKING_DUTY
        law = walking if style == "walking" else RUNNING_DUTY
    return min(max(law.at(build.froude(speed)), MIN_DUTY), MAX_DUTY)


def comfortable_speed(build: Build, gait: str) -> float:
    """Return the speed at which an animal goes in a gait if it is free to [m/s]."""
    if build.family == "sprawler":
        return build.speed_at(COMFORTABLE_SPRAWL)
    if gait == "trot" and build.family == "biped":
        gait = "walk"
    return build.speed_at(COMFORTABLE.get(gait, COMFORTABLE["walk"]))


def hurried_speed(build: Build, gait: str) -> float:
    """Return the speed of an animal that hurries, `gait` its fastest [m/s]."""
    if build.family != "sprawler" and (gait == "walk" or is_graviportal(build)):
        return build.speed_at(WALK_TO_RUN)
    return build.speed_at(HURRIED[build.family])


def ladder(build: Build, legs: int) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Return the gaits of paired legs from slow to fast, and the Froude numbers between them."""
    if build.family == "sprawler":
        return ("tripod" if legs == 6 else "trot",), ()
    if legs == 2:
        return ("walk", "run"), (WALK_TO_RUN,)
    if legs != 4:
        return ("trot",), ()
    if is_graviportal(build):
        return ("walk", "amble"), (WALK_TO_RUN,)
    gallop = "transverse gallop" if build.mass >= TRANSVERSE_MASS else "rotary gallop"
    return ("walk", "trot", "canter", gallop), (WALK_TO_TROT, TROT_TO_CANTER, CANTER_TO_GALLOP)


def gait_at(build: Build, legs: int, speed: float, present: str | None = None) -> str:
    """Return the gait of an animal on paired legs at a speed.

    Args:
        build: of the animal.
        legs: number of them.
        speed: [m/s].
        present: gait that it has, which it keeps a little beyond the transitions.
    """
    gaits, bounds = ladder(build, legs)
    number = gaits.index(present) if present in gaits else None
    froude, wanted = build.froude(speed), 0
    for i, bound in enumerate(bounds):
        if number is not None:
            bound *= HYSTERESIS**2 if number <= i else HYSTERESIS**-2
        if froude >= bound:
            wanted = i + 1
    return gaits[wanted]
