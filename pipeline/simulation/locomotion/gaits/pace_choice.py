"""Pace choice: gait, stride, cycle, duty factor and posture of a creature at a speed.

What the author leaves open follows the laws of animals, as far as the legs reach (`stride_plan`).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Container
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits import scaling_laws
from pipeline.simulation.locomotion.gaits.gait import FlightBounce, Gait, share_of_run
from pipeline.simulation.locomotion.gaits.named_gaits import (
    choose_gait,
    join_choices,
    walking_legs,
)
from pipeline.simulation.locomotion.gaits.pace import Pace, cycle_and_stride
from pipeline.simulation.locomotion.gaits.scaling_laws import Build
from pipeline.simulation.locomotion.gaits.stride_limits import (
    LegLayout,
    rounded_down,
    rounded_up,
)
from pipeline.simulation.locomotion.gaits.stride_plan import (
    BODY_HEIGHTS,
    OWN_DUTY,
    SPEED_TOLERANCE,
    SPEEDS,
    Plan,
    StridePlanner,
    build_of,
    grounded_bounce,
)
from pipeline.spec.walk import AUTO, Manner, Walk

# Heights of the body that are tried, and the least that is advised: lower, feet find no place.
HEIGHTS, LEAST_CROUCH = 33, 0.75

# Duration of a cycle of one that stands, in periods of a pendulum of its size, over 2π.
PERIOD = 3.0

# Default step height, and that of a walk on two legs, in leg lengths: people hardly lift their toes
# (Winter 1992).
STEP_HEIGHT, UPRIGHT_STEP_HEIGHT = 0.13, 0.1

# Greatest bounce with flights, in leg lengths.
MAX_FLIGHT_BOUNCE = 0.1

# How far feet that carry a body alone stand under its middle, as a fraction of the way.
CENTERING = 0.9


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
    def planner(self) -> StridePlanner:
        """What its legs do at any speed."""
        return StridePlanner(self.where, self.walk, self.build, self.legs, self.figure.belly)

    # --- paces ------------------------------------------------------------------------

    def standing(self) -> Pace:
        """Return the pace of a creature that does not walk."""
        name, gait = self._gait(0.0, None)
        tallest = BODY_HEIGHTS.stand * self.legs.tallest()
        cycle = PERIOD * math.sqrt(self.build.size / GRAVITY)
        return self._pace(name, gait, (cycle, 0.0), min(self.planner.rest_height, tallest))

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
            speed = min(comfortable, self.planner.top_speed(name, gait))
        plan = self.planner.plan(name, gait, speed)
        if walk.stride is None and walk.cycle is None:
            return self._by_law(name, gait, speed, plan)
        tempo = cycle_and_stride(walk, plan.stride / speed, plan.stride)
        return self._by_tempo(name, gait, tempo)

    def _by_law(self, name: str, gait: Gait, speed: float, plan: Plan) -> Pace:
        if not self.planner.is_possible(name, gait, speed):
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
        return max(longest, 1.0 / self.planner.greatest_frequency)

    def _by_tempo(self, name: str, gait: Gait, tempo: tuple[float, float]) -> Pace:
        """Return a pace whose stride or cycle is the author's: the gait keeps its duty factor."""
        cycle, stride = tempo
        low, high = self.planner.heights(float(gait.duty.max()))
        for height in np.linspace(high, low, HEIGHTS).tolist():
            if self.legs.longest_stride(gait, height) >= stride:
                break
        else:
            raise SceneError([self._too_long(gait, low, tempo)])
        if cycle * self.planner.greatest_frequency < 1.0 - SPEED_TOLERANCE:
            raise SceneError([self._too_quick(cycle)])
        return self._pace(name, gait, tempo, height)

    def _pace(self, name: str, gait: Gait, tempo: tuple[float, float], height: float) -> Pace:
        walk = self.walk
        cycle, stride = tempo
        flight = FlightBounce.of(gait) if stride else None
        bounce = _bounce(gait, flight, self.legs, cycle)
        return Pace(
            gait=gait.among(~self.held),
            cycle=cycle,
            stride=stride,
            body_height=height,
            bounciness=bounce if walk.body_bob is None else walk.body_bob,
            step_height=self._step_height(gait) if walk.step_height is None else walk.step_height,
            longest=self.legs.longest_stride(gait, height),
            flight=flight,
            held=self.held,
            lateral_offset=self.lateral_offset,
            top_speed=self.top_speed if stride else 0.0,
            hurried_speed=self._hurried_speed if stride else 0.0,
            gait_name=name,
        )

    def _step_height(self, gait: Gait) -> float:
        """Return the height of the swings over level ground [m]."""
        fraction = STEP_HEIGHT
        if len(self.legs.lengths) == 2:
            runs = share_of_run(float(gait.duty.mean()))
            fraction = UPRIGHT_STEP_HEIGHT + runs * (STEP_HEIGHT - UPRIGHT_STEP_HEIGHT)
        return fraction * float(self.legs.lengths.mean())

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

    @cached_property
    def top_speed(self) -> float:
        """The greatest speed, in the fastest gait if it is automatic [m/s]."""
        name, gait = self._gait(SPEEDS[1], None)
        if self.walk.gait != AUTO:
            return self.planner.top_speed(name, gait)
        top, count = self.planner.top_speed(name, gait), len(self.own)
        gaits, _ = scaling_laws.ladder(self.build, count)
        if name in gaits and scaling_laws.gait_at(self.build, count, top) != name:
            # So slow a creature does not gallop.
            top = min(self.planner.top_speed(slower, gait) for slower in gaits)
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
            if not self._works(keys):
                continue
            choices.append(" with ".join(f"{key}: {text}" for key, text in change.items()))
        return f"take {join_choices(choices)}" if choices else self._omission()

    def _omission(self) -> str:
        """Return as text what to leave out of a config that no other value of one key mends."""
        given = [key for key in ("cycle", "stride", "speed") if getattr(self.walk, key) is not None]
        for count in range(1, len(given) + 1):
            for left_out in itertools.combinations(given, count):
                if self._works(self.walk.model_dump(exclude_unset=True, exclude=set(left_out))):
                    return f"leave out {' and '.join(f'`{key}`' for key in left_out)}"
        return "take another gait or scale"

    def _works(self, keys: dict[str, Any]) -> bool:
        """Return whether a creature can walk with these keys of its config."""
        try:
            walk = type(self.walk).model_validate(keys)
            replace(self, walk=walk, is_trial=True).walking()
        except (SceneError, ValidationError):
            return False
        return True

    def _too_fast(self, name: str, speed: float, plan: Plan) -> Problem:
        most = self.planner.greatest_frequency
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
        heights = np.linspace(height, LEAST_CROUCH * height, HEIGHTS)[1:].tolist()
        lower = (h for h in heights if self.legs.longest_stride(gait, h) >= stride)
        postures = [{"body_height": rounded_down(h)} for h in list(lower)[:1]]
        message = (
            f"a stride (speed × cycle) of {stride:.3g} is more than the legs can do: at a body "
            f"height of {height:.3g} they reach over {rounded_down(most * duty)} of ground, and "
            f"stride = reach / duty, at most {text}; "
        )
        return Problem(self.where, message + self._advice(*timings, *duties, *postures))

    def _too_quick(self, cycle: float) -> Problem:
        walk, most = self.walk, self.planner.greatest_frequency
        changes = [{"cycle": rounded_up(1.0 / most)}]
        if walk.speed is not None and walk.stride is not None:
            changes.append({"speed": rounded_down(walk.stride * most)})
            changes.append({"stride": rounded_up(walk.speed / most)})
        message = (
            f"a gait cycle of {cycle:.3g} s is too short: muscles of {self.build.mass:.3g} kg move "
            f"legs at most {rounded_down(most)} times a second; "
        )
        return Problem(self.where, message + self._advice(*changes))


def _bounce(gait: Gait, flight: FlightBounce | None, legs: LegLayout, cycle: float) -> float:
    """Return the bounce that suits a cycle of legs [s]."""
    if flight is None:
        return grounded_bounce(gait, legs)
    # In flight the body falls freely, unless that would throw it out of its legs' reach.
    return min(
        flight.amplitude * GRAVITY * cycle * cycle, MAX_FLIGHT_BOUNCE * float(legs.lengths.mean())
    )


def _legless_pace(where: str, walk: Manner | None, figure: Figure) -> Pace:
    if walk is not None:
        message = f"figure '{figure.name}' has no legs to walk on; remove `walk`"
        raise SceneError([Problem(where, message)])
    lying = figure.skeleton.links[0].radii[0]
    none = np.zeros(0)
    return Pace(Gait(none, none), 1.0, 0.0, lying, 0.0, 0.0, 0.0, None, none.astype(bool))
