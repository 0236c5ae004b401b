"""Movement behaviours: approach, flee, keep off, freeze, withdraw, wander and sit down.

Source: Horswill 2008, "High-level Control" (freeze; withdrawal; sit down, stand up); Reynolds
1999 (flee).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.potential_field import (
    has_room,
    is_way_free,
    steer,
)
from pipeline.simulation.characters.behaviours.registry import (
    ConfiguredBehaviour,
    implements,
)
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.pain_reflex import (
    WITHDRAWAL_FROUDE,
    WITHDRAWAL_TIME,
    step_back_goal,
    step_back_way,
    withdrawal_facing,
)
from pipeline.simulation.characters.terrain_edge import refuge
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import Approach, Flee, Freeze, Shyness, SitDown, Urge, Wander

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

# Flight.
FEAR_RANGE = 7.0  # [m]
FREEZE_RANGE = 0.6 * FEAR_RANGE
FLIGHT_DISTANCE, SHY_DISTANCE = 4.0, 1.2  # to the place of refuge [m]
SHY_URGENCY = 1.5  # added activation of a very anxious one that is quite close

WITHDRAWAL_ACTIVATION = 2.0
"""Nothing else comes before withdrawal."""

# Wandering.
STANDING_TIME = (0.8, 3.0)  # between strolls [s]
WANDER_STOP_DISTANCE = 0.4  # [m]
WANDER_CHOICES = 6  # of places, until one has room
WANDER_PATIENCE = 12.0  # after which another place is chosen [s]


@implements(Approach)
class ApproachTarget(ConfiguredBehaviour[Approach]):
    """Go to a character, around what stands in the way."""

    def __init__(self, config: Approach, mind: Mind) -> None:
        super().__init__(config, mind)
        self.target = mind.number(config.approach)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        return 0.45 + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        config, place = self.config, mind.place(self.target)
        distance = mind.surroundings.radius[self.target] + mind.body_radius + config.distance
        if config.from_deg is not None:
            angle = math.radians(config.from_deg)
            place = place + distance * np.array([math.cos(angle), -math.sin(angle)])
            distance = 0.0
        touching = config.distance < 0.3
        return steer(mind, place, distance, target=self.target, touching=touching)


def _refuge(mind: Mind, push: Array, distance: float) -> Array:
    """Return the place (2,) in a direction, turned away from the edge of the terrain."""
    surroundings = mind.surroundings
    return refuge(mind.at, surroundings.low, surroundings.high, push, distance)


@implements(Flee)
class FleeThreat(ConfiguredBehaviour[Flee]):
    """Run from a character."""

    def __init__(self, config: Flee, mind: Mind) -> None:
        super().__init__(config, mind)
        self.threat = mind.number(config.flee)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        nearness = 1.0 - mind.distance_to(self.threat) / FEAR_RANGE
        fear = max(nearness, 0.0) * (0.7 + 0.6 * mind.traits.anxiety)
        mind.attention.fears[self.threat] = max(mind.attention.fears[self.threat], 0.8 * fear)
        return min(1.3 * fear, 1.0) + self.config.urge if fear > 0.0 else 0.0

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        threat = mind.place(self.threat) + 0.4 * mind.velocity(self.threat)
        nearness = max(1.0 - mind.distance_to(self.threat) / FEAR_RANGE, 0.0)
        pace = mind.stroll + (mind.pace - mind.stroll) * min(2.0 * nearness, 1.0)
        return steer(mind, _refuge(mind, mind.at - threat, FLIGHT_DISTANCE), pace=pace)


@implements(Shyness)
class KeepOff(ConfiguredBehaviour[Shyness]):
    """Keep away from all people."""

    def __init__(self, config: Shyness, mind: Mind) -> None:
        super().__init__(config, mind)
        self.others = mind.surroundings.people.copy()
        self.others[mind.number_of_self] = False

    def _intrusions(self, mind: Mind) -> Array:
        """Return (C,) by how much each character is too near, from 0 to 1."""
        reach = mind.memory.distances / max(self.config.keep_off, 1e-6)
        return np.where(self.others, np.clip(1.0 - reach, 0.0, 1.0), 0.0)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        intrusions = self._intrusions(mind)
        mind.attention.fears[:] = np.maximum(mind.attention.fears, 0.5 * intrusions)
        largest = float(intrusions.max())
        # Once begun it goes on until there is some room.
        least = 0.02 if mind.doing == "keep_off" else 0.25
        if largest <= least:
            return 0.0
        return 0.35 + SHY_URGENCY * mind.traits.anxiety * largest + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        intrusions = self._intrusions(mind)
        offset = mind.at - mind.memory.places[:, [0, 2]]
        distances = np.maximum(mind.memory.distances, 0.1)[:, None]
        push = (intrusions[:, None] * offset / distances).sum(axis=0)
        nearest = int(intrusions.argmax())
        if math.hypot(push[0], push[1]) < 0.05:
            return MotorCommand(facing=mind.heading_to(mind.place(nearest)), target=nearest)
        return steer(mind, _refuge(mind, push, SHY_DISTANCE), pace=mind.stroll)


@implements(Freeze)
class FreezeInFear(ConfiguredBehaviour[Freeze]):
    """Keep quite still in the face of a character."""

    def __init__(self, config: Freeze, mind: Mind) -> None:
        super().__init__(config, mind)
        self.threat = mind.number(config.freeze)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if not mind.memory.in_view[self.threat]:
            return 0.0
        nearness = max(1.0 - mind.distance_to(self.threat) / FREEZE_RANGE, 0.0)
        if mind.doing != "freeze" and nearness < 0.2:
            return 0.0
        return nearness * (0.6 + 0.8 * mind.traits.anxiety) + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        return MotorCommand(frozen=True, target=self.threat)


@implements(Urge)
class Withdraw(ConfiguredBehaviour[Urge]):
    """Step back from pain; decided at the start, and not changed after."""

    def __init__(self, config: Urge, mind: Mind) -> None:
        super().__init__(config, mind)
        self.struck = -math.inf
        self.command = MotorCommand()

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        return WITHDRAWAL_ACTIVATION if mind.now - mind.struck[0] < WITHDRAWAL_TIME else 0.0

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        time, striker = mind.struck
        if time != self.struck:
            self.struck, self.command = time, self._step_back(mind, striker)
        return self.command

    def _step_back(self, mind: Mind, striker: int) -> MotorCommand:
        heading = float(mind.controller.record.heading)
        offset = mind.place(striker) - mind.at if striker >= 0 else np.array([0.0, 0.0])
        if math.hypot(offset[0], offset[1]) < 1e-6:
            offset = np.array([math.cos(heading), -math.sin(heading)])
        away = math.atan2(-offset[1], -offset[0])
        bounds = mind.surroundings.low, mind.surroundings.high
        goal = step_back_goal(mind.at, away, bounds, lambda place: is_way_free(mind, place))
        way = step_back_way(mind.at, goal, away)
        return MotorCommand(
            goal=(float(goal[0]), float(goal[1])),
            pace=WITHDRAWAL_FROUDE * mind.froude_speed,
            facing=withdrawal_facing(heading, math.atan2(-offset[1], offset[0]), way),
            target=striker,
            startled=True,
        )


@implements(Wander)
class WanderAround(ConfiguredBehaviour[Wander]):
    """Stroll from place to place."""

    def __init__(self, config: Wander, mind: Mind) -> None:
        super().__init__(config, mind)
        self.home = mind.surroundings.places[mind.number_of_self, [0, 2]].copy()
        self.goal = self.home.copy()
        self.standing_end, self.walk_end = 0.0, 0.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        return 0.2 + 0.2 * mind.traits.curiosity + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        offset = self.goal - mind.at
        is_there = math.hypot(offset[0], offset[1]) < WANDER_STOP_DISTANCE + 0.1
        if is_there or mind.now > self.walk_end:
            if self.standing_end == 0.0:
                low, high = STANDING_TIME
                self.standing_end = mind.now + low + (high - low) * float(mind.rng.random())
            if mind.now < self.standing_end:
                return MotorCommand()
            self._choose_goal(mind)
        pace = mind.stroll + 0.5 * (mind.pace - mind.stroll)
        return steer(mind, self.goal, WANDER_STOP_DISTANCE, pace=pace)

    def _choose_goal(self, mind: Mind) -> None:
        surroundings = mind.surroundings
        for _ in range(WANDER_CHOICES):
            angle = 2.0 * math.pi * float(mind.rng.random())
            reach = self.config.wander * math.sqrt(float(mind.rng.random()))
            self.goal = self.home + reach * np.array([math.cos(angle), math.sin(angle)])
            self.goal = np.clip(self.goal, surroundings.low + 1.0, surroundings.high - 1.0)
            if has_room(mind, self.goal):
                break
        self.standing_end, self.walk_end = 0.0, mind.now + WANDER_PATIENCE

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.standing_end, self.walk_end = 0.0, 0.0


@implements(SitDown)
class SitForAWhile(ConfiguredBehaviour[SitDown]):
    """Sit down; the next behaviour that is chosen stands up."""

    def __init__(self, config: SitDown, mind: Mind) -> None:
        super().__init__(config, mind)
        self.idle_since = mind.now

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if mind.doing not in ("", "rest"):
            self.idle_since = mind.now
        is_idle = mind.now - self.idle_since >= self.config.rest
        return 0.12 + self.config.urge if is_idle else 0.0

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        return MotorCommand(sits=True)
