"""Pace choice: gait, stride, cycle, duty factor and posture of a creature at a speed.

What the author leaves open follows the laws of animals (`scaling_laws`), as far as the legs reach.
A stride that is longer than that first lowers the body, then shortens the stance, and at last is
shortened itself; the cadence grows instead, up to the greatest that muscles can drive.
"""

from __future__ import annotations

import math
from collections.abc import Container
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.locomotion.gaits import scaling_laws
from pipeline.simulation.locomotion.gaits.gait import FlightBounce, Gait
from pipeline.simulation.locomotion.gaits.named_gaits import (
    choose_gait,
    join_choices,
    walking_legs,
)
from pipeline.simulation.locomotion.gaits.pace import MIN_CYCLE, Pace, cycle_and_stride
from pipeline.simulation.locomotion.gaits.scaling_laws import Build, Style
from pipeline.simulation.locomotion.gaits.stride_limits import (
    LegLayout,
    rounded_down,
    rounded_up,
)
from pipeline.spec.walk import AUTO, Manner, Walk


@dataclass(frozen=True, slots=True)
class BodyHeights:
    """Bounds of default body heights.

    Attributes:
        lowest: over level ground, in depths of the belly.
        run, walk, stand: greatest height running, walking and standing, as fractions of the
            tallest that the legs reach: straight legs have no room for a stride.
        running_crouch, walking_crouch: least height to which a long stride lowers a body, as
            fractions of its own.
    """

    lowest: float = 1.25
    run: float = 0.92
    walk: float = 0.94
    stand: float = 0.99
    running_crouch: float = 0.86
    walking_crouch: float = 0.97


BODY_HEIGHTS = BodyHeights()

# Default stride, as a fraction of the longest that the legs can do: the outer legs on a curve, and
# all while the body speeds up, need the rest of their reach. Sprawling legs need more of it.
STRIDE_OF_LONGEST, SPRAWLING_STRIDE_OF_LONGEST = 0.9, 0.75

# Least duty factor of a long stride, as a fraction of the law's. Where the law has no flights there
# are none; the bounds of walks go over into those of runs between two duty factors.
SHORTENED_STANCE, MIN_GROUNDED_DUTY, RUNNING_DUTY = 0.75, 0.52, 0.45

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

# Duration of a cycle of one that stands, in periods of a pendulum of its size, over 2π.
PERIOD = 3.0

# Default step height, in leg lengths.
STEP_HEIGHT = 0.13

# Bounce of a gait without flights and with two beats, and greatest with flights, in leg lengths.
BOUNCE, MAX_FLIGHT_BOUNCE = 0.018, 0.1

# How far feet that carry a body alone stand under its middle, as a fraction of the way.
CENTERING = 0.9

# Speeds between which the greatest is looked for [m/s], halvings, and heights that are tried.
SPEEDS, BISECTIONS, HEIGHTS = (1e-4, 1e3), 50, 33

# Relative difference between speeds that is rounding.
SPEED_TOLERANCE = 1e-9


class Plan(NamedTuple):
    """What legs do at a speed: stride [m], duty factor, height of the body [m]."""

    stride: float
    duty: float
    height: float


def choose_pace(
    where: str, walk: Manner | None, figure: Figure, legs: LegLayout, present: str | None = None
) -> Pace:
    """Return the pace of a config; what it leaves open follows the laws of animals.

    Args:
        where: path of `walk` in the scene.
        walk: the config; None for a creature that stands.
        figure: at its scale.
        legs: at rest.
        present: name of the gait that it has, which an automatic one keeps near a transition.

    Raises:
        SceneError: if the legs cannot follow speed, stride or body height on level ground.
    """
    if not len(legs.lengths):
        return _legless_pace(where, walk, figure)
    choice = PaceChoice(where, walk or Walk(), figure, legs)
    return choice.standing() if walk is None else choice.walking(present)


@dataclass(frozen=True, eq=False)
class PaceChoice:
    """The choice of a pace.

    Attributes:
        where: path of `walk` in the scene.
        walk: the config.
        figure: at its scale.
        all_legs: at rest.
        is_trial: whether it tries advice, and needs none itself.
    """

    where: str
    walk: Manner
    figure: Figure
    all_legs: LegLayout
    is_trial: bool = False

    @cached_property
    def own(self) -> list[int]:
        """Numbers of the legs that it walks on."""
        return walking_legs(self.where, self.walk, self.figure)

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """(n,) legs that are held up."""
        return np.isin(np.arange(len(self.all_legs.lengths)), self.own, invert=True)

    @cached_property
    def lateral_offset(self) -> float:
        """Distance of each foot to the right of its rest position [m]."""
        if not self.held.any():
            return 0.0
        return -CENTERING * float(self.all_legs.feet[self.own, 2].mean())

    @cached_property
    def legs(self) -> LegLayout:
        """The legs that it walks on."""
        return self.all_legs.only(self.own, self.lateral_offset)

    @cached_property
    def build(self) -> Build:
        """Its size, of all its legs."""
        return build_of(self.figure, self.all_legs)

    @cached_property
    def greatest_frequency(self) -> float:
        """Greatest stride frequency, of its muscles or of the world's steps [Hz]."""
        return min(scaling_laws.greatest_frequency(self.build), 1.0 / MIN_CYCLE)

    # --- paces ------------------------------------------------------------------------

    def standing(self) -> Pace:
        """Return the pace of a creature that does not walk."""
        name, gait = self._gait(0.0, None)
        tallest = BODY_HEIGHTS.stand * self.legs.tallest()
        cycle = PERIOD * math.sqrt(self.build.size / GRAVITY)
        return self._pace(name, gait, (cycle, 0.0), min(self._rest_height, tallest))

    def walking(self, present: str | None = None) -> Pace:
        """Return the pace of a creature that walks.

        Raises:
            SceneError: its legs cannot.
        """
        walk, speed = self.walk, self.walk.speed
        if walk.stride is not None and walk.cycle is not None:
            speed = walk.stride / walk.cycle
        name, gait = self._gait(speed, present)
        if speed is None:
            comfortable = scaling_laws.comfortable_speed(self.build, name)
            speed = min(comfortable, self._top_speed_in(name, gait))
        plan = self._plan(name, gait, speed)
        if walk.stride is None and walk.cycle is None:
            return self._by_law(name, gait, speed, plan)
        tempo = cycle_and_stride(walk, plan.stride / speed, plan.stride)
        return self._by_tempo(name, gait, tempo)

    def _by_law(self, name: str, gait: Gait, speed: float, plan: Plan) -> Pace:
        if not self._is_possible(name, gait, speed):
            raise SceneError([self._too_fast(name, speed, plan)])
        if float(np.ptp(gait.duty)) or plan.duty != float(gait.duty.max()):
            gait = gait if name in OWN_DUTY else gait.with_duty(plan.duty)
        cycle = min(plan.stride / speed, self._longest_cycle(gait))
        return self._pace(name, gait, (cycle, speed * cycle), plan.height)

    def _longest_cycle(self, gait: Gait) -> float:
        """Return the longest cycle in whose flights the body does not rise too far [s]."""
        flight = FlightBounce.of(gait)
        if flight is None:
            return math.inf
        rise = MAX_FLIGHT_BOUNCE * float(self.legs.lengths.mean())
        longest = math.sqrt(rise / (flight.amplitude * GRAVITY))
        return max(longest, 1.0 / self.greatest_frequency)

    def _by_tempo(self, name: str, gait: Gait, tempo: tuple[float, float]) -> Pace:
        """Return a pace whose stride or cycle is the author's: the gait keeps its duty factor."""
        cycle, stride = tempo
        low, high = self._heights(float(gait.duty.max()))
        for height in np.linspace(high, low, HEIGHTS).tolist():
            if self.legs.longest_stride(gait, height) >= stride:
                break
        else:
            raise SceneError([self._too_long(gait, low, tempo)])
        if cycle * self.greatest_frequency < 1.0 - SPEED_TOLERANCE:
            raise SceneError([self._too_quick(cycle)])
        return self._pace(name, gait, tempo, height)

    def _pace(self, name: str, gait: Gait, tempo: tuple[float, float], height: float) -> Pace:
        walk, leg = self.walk, float(self.legs.lengths.mean())
        cycle, stride = tempo
        flight = FlightBounce.of(gait) if stride else None
        bounce = _bounce(gait, flight, leg, cycle)
        return Pace(
            gait=gait.among(~self.held),
            cycle=cycle,
            stride=stride,
            body_height=height,
            bounciness=bounce if walk.body_bob is None else walk.body_bob,
            step_height=STEP_HEIGHT * leg if walk.step_height is None else walk.step_height,
            longest=self.legs.longest_stride(gait, height),
            flight=flight,
            held=self.held,
            lateral_offset=self.lateral_offset,
            top_speed=self.top_speed if stride else 0.0,
            hurried_speed=self._hurried_speed if stride else 0.0,
            gait_name=name,
        )

    # --- gait -------------------------------------------------------------------------

    def _gait(self, speed: float | None, present: str | None) -> tuple[str, Gait]:
        """Return name and gait of the config at a speed, None for a comfortable one [m/s]."""

        def automatic(gaits: Container[str]) -> str:
            count, build = len(self.own), self.build
            slowest = scaling_laws.ladder(build, count)[0][0]
            at = scaling_laws.comfortable_speed(build, slowest) if speed is None else speed
            name = scaling_laws.gait_at(build, count, at, present)
            if name not in gaits:
                name = "hop" if count == 1 else "trot"
            return name

        forward = self.legs.hips[:, 0].tolist()
        return choose_gait(self.where, self.walk, self.figure, self.own, forward, automatic)

    def _style(self, name: str, speed: float) -> Style:
        if scaling_laws.is_graviportal(self.build):
            return "walking"
        if name in STYLES:
            return STYLES[name]
        if name == "trot" and len(self.own) == 4 and self.build.family == "quadruped":
            return "running"
        return scaling_laws.style_at(self.build, speed)

    # --- posture ----------------------------------------------------------------------

    @cached_property
    def _rest_height(self) -> float:
        lowest = BODY_HEIGHTS.lowest * self.figure.belly
        return max(-float(self.legs.feet[:, 1].mean()), lowest)

    def _heights(self, duty: float) -> tuple[float, float]:
        """Return the least and the greatest height of the body with a duty factor [m].

        Raises:
            SceneError: the legs do not reach the ground from the author's.
        """
        tallest, given = self.legs.tallest(), self.walk.body_height
        runs = _share_of_run(duty)
        heights = BODY_HEIGHTS
        fraction = heights.walk + runs * (heights.run - heights.walk)
        high = min(self._rest_height, fraction * tallest) if given is None else given
        if high >= tallest:
            message = f"the legs do not reach the ground from {high:g}; "
            message += f"at this scale less than {tallest:.3g} works"
            raise SceneError([Problem(f"{self.where}.body_height", message)])
        if given is not None:
            return given, given
        crouch = heights.walking_crouch
        crouch += runs * (heights.running_crouch - heights.walking_crouch)
        belly = min(BODY_HEIGHTS.lowest * self.figure.belly, high)
        return max(crouch * high, belly), high

    def _least_duty(self, duty: float) -> float:
        """Return the least duty factor of a long stride whose law has `duty`."""
        if duty >= MIN_GROUNDED_DUTY:
            return max(SHORTENED_STANCE * duty, MIN_GROUNDED_DUTY)
        shortened = 1.0 - _share_of_run(duty) * (1.0 - SHORTENED_STANCE)
        return min(max(shortened * duty, scaling_laws.MIN_DUTY), duty)

    def _duties(self, name: str, gait: Gait, speed: float, style: Style) -> tuple[float, float]:
        """Return the duty factor of the law, or of the author or gait, and the least instead."""
        if name in OWN_DUTY or self.walk.duty is not None:
            duty = float(gait.duty.max())
            return duty, duty
        duty = scaling_laws.duty_at(self.build, speed, style)
        return duty, self._least_duty(duty)

    def _plan(self, name: str, gait: Gait, speed: float) -> Plan:
        """Return what the legs do at a speed [m/s], perhaps too often."""
        style = self._style(name, speed)
        stride = scaling_laws.stride_at(self.build, speed, style)
        duty, least = self._duties(name, gait, speed, style)
        low, high = self._heights(duty)
        sprawls = self.build.family == "sprawler"
        usual = SPRAWLING_STRIDE_OF_LONGEST if sprawls else STRIDE_OF_LONGEST
        needed = stride * duty / usual
        if self.legs.reach(high) >= needed:
            return Plan(stride, duty, high)
        reach = self.legs.reach(low)
        if reach >= needed:
            below, above = low, high
            for _ in range(BISECTIONS):
                middle = 0.5 * (below + above)
                fits = self.legs.reach(middle) >= needed
                below, above = (middle, above) if fits else (below, middle)
            return Plan(stride, duty, below)
        reach *= usual
        duty = max(reach / stride, least)
        return Plan(min(stride, reach / duty), duty, low)

    # --- limits -----------------------------------------------------------------------

    def _is_possible(self, name: str, gait: Gait, speed: float) -> bool:
        frequency = self.greatest_frequency * (1.0 + SPEED_TOLERANCE)
        return self._plan(name, gait, speed).stride * frequency >= speed

    def _top_speed_in(self, name: str, gait: Gait) -> float:
        """Return the greatest speed in a gait [m/s]."""
        slow, fast = SPEEDS
        for _ in range(BISECTIONS):
            middle = math.sqrt(slow * fast)
            if self._is_possible(name, gait, middle):
                slow = middle
            else:
                fast = middle
        return slow

    @cached_property
    def top_speed(self) -> float:
        """The greatest speed, in the fastest gait if it is automatic [m/s]."""
        name, gait = self._gait(SPEEDS[1], None)
        if self.walk.gait != AUTO:
            return self._top_speed_in(name, gait)
        top, count = self._top_speed_in(name, gait), len(self.own)
        gaits, _ = scaling_laws.ladder(self.build, count)
        if name in gaits and scaling_laws.gait_at(self.build, count, top) != name:
            # So slow a creature does not gallop.
            top = min(self._top_speed_in(slower, gait) for slower in gaits)
        return top

    @cached_property
    def _hurried_speed(self) -> float:
        fastest = self._gait(SPEEDS[1], None)[0]
        return min(scaling_laws.hurried_speed(self.build, fastest), self.top_speed)

    # --- refusals ---------------------------------------------------------------------

    def _advice(self, *changes: dict[str, str]) -> str:
        """Return those of some changes of the config that work, as text: "a: 1, b: 2 or c: 3"."""
        if self.is_trial:
            return ""
        choices = []
        for change in changes:
            keys = self.walk.model_dump(exclude_unset=True)
            keys |= {key: float(text) for key, text in change.items()}
            try:
                walk = type(self.walk).model_validate(keys)
                replace(self, walk=walk, is_trial=True).walking()
            except (SceneError, ValidationError):
                continue
            choices.append(" with ".join(f"{key}: {text}" for key, text in change.items()))
        return f"take {join_choices(choices)}" if choices else "take another gait or scale"

    def _too_fast(self, name: str, speed: float, plan: Plan) -> Problem:
        most = self.greatest_frequency
        if plan.stride == 0.0:
            message = (
                f"the legs of '{self.figure.name}' cannot step: at a body height of "
                f"{plan.height:.3g} they only just reach the ground; make them longer, or let "
                "their joints bend (limits_deg) or slide farther; or take `walk` away"
            )
            return Problem(self.where, message)
        in_gait = "" if self.walk.gait == AUTO else f" in the gait '{name or 'written out'}'"
        message = (
            f"a speed of {speed:.3g} is more than the legs can do{in_gait}: strides of "
            f"{rounded_down(plan.stride)} at most {rounded_down(most)} times a second; "
        )
        return Problem(
            f"{self.where}.speed", message + self._advice({"speed": rounded_down(self.top_speed)})
        )

    def _too_long(self, gait: Gait, height: float, tempo: tuple[float, float]) -> Problem:
        cycle, stride = tempo
        walk, duty = self.walk, float(gait.duty.max())
        most = self.legs.longest_stride(gait, height)
        text = rounded_down(most)
        timings: list[dict[str, str]] = [{"stride": text}]
        if walk.speed is not None and walk.cycle is not None:
            speed, shorter = rounded_down(most / walk.cycle), rounded_down(most / walk.speed)
            timings = [{"speed": speed}, {"cycle": shorter}]
            if walk.stride is not None:
                timings = [{"stride": text, "speed": f"{float(text) / cycle:.9g}"}]
        shorter_stance = duty * most / stride
        duties = [{"duty": rounded_down(shorter_stance)}]
        if shorter_stance < scaling_laws.MIN_DUTY:
            duties = []
        heights = np.linspace(height, 0.5 * height, HEIGHTS)[1:].tolist()
        lower = (h for h in heights if self.legs.longest_stride(gait, h) >= stride)
        postures = [{"body_height": rounded_down(h)} for h in list(lower)[:1]]
        message = (
            f"a stride (speed × cycle) of {stride:.3g} is more than the legs can do: at a body "
            f"height of {height:.3g} they reach over {rounded_down(most * duty)} of ground, and "
            f"stride = reach / duty, at most {text}; "
        )
        return Problem(self.where, message + self._advice(*timings, *duties, *postures))

    def _too_quick(self, cycle: float) -> Problem:
        walk, most = self.walk, self.greatest_frequency
        changes = [{"cycle": rounded_up(1.0 / most)}]
        if walk.speed is not None and walk.stride is not None:
            changes.append({"speed": rounded_down(walk.stride * most)})
            changes.append({"stride": rounded_up(walk.speed / most)})
        message = (
            f"a gait cycle of {cycle:.3g} s is too short: muscles of {self.build.mass:.3g} kg move "
            f"legs at most {rounded_down(most)} times a second; "
        )
        return Problem(self.where, message + self._advice(*changes))


def _share_of_run(duty: float) -> float:
    """Return how far a duty factor is that of a run, 0 to 1."""
    part = (MIN_GROUNDED_DUTY - duty) / (MIN_GROUNDED_DUTY - RUNNING_DUTY)
    return min(max(part, 0.0), 1.0)


def build_of(figure: Figure, legs: LegLayout) -> Build:
    """Return the size of a figure with legs at rest."""
    mass = FigureMass(figure).mass_of(range(len(figure.skeleton.links)))
    if figure.style == "insect":
        return Build("sprawler", float(legs.lengths.mean()), mass)
    height = float((legs.hips[:, 1] - legs.feet[:, 1]).mean())
    return Build("biped" if len(legs.lengths) <= 2 else "quadruped", height, mass)


def _bounce(gait: Gait, flight: FlightBounce | None, leg: float, cycle: float) -> float:
    """Return the bounce that suits a cycle [s] of legs of a length [m]."""
    if flight is None:
        # The more beats, the smaller: the body is shaken no harder.
        return BOUNCE * leg * min((2.0 / gait.beats) ** 2, 1.0)
    # In flight the body falls freely, unless that would throw it out of its legs' reach.
    return min(flight.amplitude * GRAVITY * cycle * cycle, MAX_FLIGHT_BOUNCE * leg)


def _legless_pace(where: str, walk: Manner | None, figure: Figure) -> Pace:
    if walk is not None:
        message = f"figure '{figure.name}' has no legs to walk on; remove `walk`"
        raise SceneError([Problem(where, message)])
    lying = figure.skeleton.links[0].radii[0]
    none = np.zeros(0)
    return Pace(Gait(none, none), 1.0, 0.0, lying, 0.0, 0.0, 0.0, None, none.astype(bool))
