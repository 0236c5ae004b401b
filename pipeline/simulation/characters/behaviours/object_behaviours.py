"""Object behaviours: play with a ball, carry something, push a merry-go-round, ride on one.

Source: Horswill 2008, "Example application", figure 1 and "Limb control" (grab).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.potential_field import steer
from pipeline.simulation.characters.behaviours.registry import (
    ConfiguredBehaviour,
    implements,
)
from pipeline.simulation.characters.contact_tasks import Grab
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.mind.perception import freshness
from pipeline.simulation.characters.push_task import PushRound
from pipeline.simulation.characters.ride_task import RideCarousel
from pipeline.simulation.characters.terrain_edge import EDGE_MARGIN
from pipeline.spec.behaviour import Carry, Play, Push, Ride

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

# Activations without curiosity, and the share that curiosity adds.
PLAY_ACTIVATION, PLAY_CURIOSITY = 0.25, 0.5
CARRY_ACTIVATION, CARRY_CURIOSITY = 0.4, 0.4
PUSH_ACTIVATION, PUSH_CURIOSITY = 0.2, 0.35
RIDER_WAITS = 0.25  # more of it when somebody is on the merry-go-round
RIDE_ACTIVATION, RIDE_CURIOSITY = 0.3, 0.35

# Play.
LOST_BALL_FRESHNESS = 0.7  # of a ball out of view, which is looked for where it was
BALL_PREDICTION = 0.35  # [s]
KICK_APPROACH_DISTANCE = 0.9  # in which the player slows down [m]
KICK_SPEED = 0.8  # in strolls
KICK_RANGE = 8.0  # from the edge within which a ball is kicked back: beyond it nobody runs [m]
BEHIND_BALL = 0.55  # distance behind the ball to start a kick from [m]
KICK_ALIGNMENT = math.cos(math.radians(40.0))  # behind the ball

# Carry.
TAKING_GAP = 0.5  # [m]
GRAB_PATIENCE, GRAB_PAUSE = 5.0, 15.0  # of an attempt, and after a vain one [s]
LEFT_HAND = 0

# Push.
PUSH_TIME, PUSH_PAUSE = 7.0, 14.0  # [s]
PUSH_GAP = 0.12  # to the rim [m]
RIM_LEAD_ANGLE = 0.55  # ahead along the rim [rad]
ROUND_TIME = 18.0  # of pushing a merry-go-round [s]
MANY_TURNS = 100.0  # that nobody completes in this time

# Ride.
RIDE_TIME, RIDE_PAUSE = 60.0, 15.0  # [s]
BOARDING_DISTANCE = 0.6  # from the rim from which a rider steps on [m]


@implements(Play)
class PlayBall(ConfiguredBehaviour[Play]):
    """Run after a ball and kick it; kick it back when it is too far from where it started."""

    def __init__(self, config: Play, mind: Mind) -> None:
        super().__init__(config, mind)
        self.ball = mind.number(config.play)
        self.home = mind.place(self.ball).tolist()

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        ball, memory = self.ball, mind.memory
        x, _, z = memory.places[ball].tolist()
        if not mind.is_on_terrain((x, z), EDGE_MARGIN):
            return 0.0
        liked = max(mind.attention.valence.item(ball), 0.0)
        seen = memory.seen.item(ball)
        known = max(freshness(seen, mind.now), LOST_BALL_FRESHNESS)
        draw = PLAY_ACTIVATION + PLAY_CURIOSITY * mind.traits.curiosity
        focus = 0.1 if mind.attention.focus == ball else 0.0
        return (draw + focus) * min(liked / 0.8, 1.0) * known + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        ball, memory = self.ball, mind.memory
        x, _, z = memory.places[ball].tolist()
        v_x, _, v_z = memory.velocities[ball].tolist()
        at_x, at_z = mind.at.tolist()
        x, z = x + BALL_PREDICTION * v_x, z + BALL_PREDICTION * v_z
        off_x, off_z = x - at_x, z - at_z
        distance = max(math.hypot(off_x, off_z), 1e-6)
        aim_x, aim_z = self._aim(mind, x, z, (off_x / distance, off_z / distance))
        along = aim_x * off_x + aim_z * off_z
        if along > KICK_ALIGNMENT * distance:
            is_near = distance < KICK_APPROACH_DISTANCE
            pace = KICK_SPEED * mind.stroll if is_near else mind.pace
            lead = 0.8 if is_near else 0.0
            place = x + lead * aim_x, z + lead * aim_z
            return steer(mind, place, pace=pace, target=ball, touching=True)
        x, z = x - BEHIND_BALL * aim_x, z - BEHIND_BALL * aim_z
        if distance < 1.2 and along < 0.0:
            # Around the ball, not over it.
            side = -1.0 if aim_x * off_z - aim_z * off_x > 0.0 else 1.0
            x, z = x - BEHIND_BALL * aim_z * side, z + BEHIND_BALL * aim_x * side
        return steer(mind, (x, z), pace=mind.pace, target=ball, touching=True)

    def _aim(
        self, mind: Mind, x: float, z: float, ahead: tuple[float, float]
    ) -> tuple[float, float]:
        """Return the direction of a kick of a ball at x and z [m]: ahead, or back home."""
        back_x, back_z = self.home[0] - x, self.home[1] - z
        far = math.hypot(back_x, back_z)
        is_inside = mind.is_on_terrain((x, z), KICK_RANGE)
        if (far > self.config.within or not is_inside) and far > 1e-6:
            return back_x / far, back_z / far
        return ahead


@implements(Carry)
class CarryThing(ConfiguredBehaviour[Carry]):
    """Fetch something, and have it in hand while doing other things."""

    def __init__(self, config: Carry, mind: Mind) -> None:
        super().__init__(config, mind)
        self.thing = mind.number(config.carry)
        self.grab: Grab | None = None
        self.began = self.pause_end = -1.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if mind.controller.held_node(LEFT_HAND) >= 0 or mind.now < self.pause_end:
            return 0.0
        return CARRY_ACTIVATION + CARRY_CURIOSITY * mind.traits.curiosity + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        if self.grab is None and mind.gap(self.thing) < TAKING_GAP:
            self.grab, self.began = Grab((LEFT_HAND,), self.thing), mind.now
        if self.grab is None:
            place = mind.place(self.thing)
            return steer(mind, place, 0.3, target=self.thing, touching=True)
        if mind.now - self.began > GRAB_PATIENCE:
            self.pause_end = mind.now + GRAB_PAUSE
        return MotorCommand(task=self.grab, pace=mind.stroll, target=self.thing, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.grab = None


@implements(Push)
class PushRim(ConfiguredBehaviour[Push]):
    """Go to a merry-go-round and push it round; run along another thing, hands ahead."""

    def __init__(self, config: Push, mind: Mind) -> None:
        super().__init__(config, mind)
        self.thing = mind.number(config.push)
        self.is_carousel = mind.surroundings.kinds[self.thing] == "merry-go-round"
        self.task: PushRound | None = None
        self.began, self.pause_end = math.inf, -1.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if mind.now < self.pause_end:
            return 0.0
        waits = RIDER_WAITS if mind.is_ridden(self.thing) else 0.0
        draw = PUSH_ACTIVATION + PUSH_CURIOSITY * mind.traits.curiosity
        return draw + waits + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        return self._push_round(mind) if self.is_carousel else self._run_along(mind)

    def _push_round(self, mind: Mind) -> MotorCommand:
        """Return the motor command of a push at a post."""
        if self.task is None and mind.gap(self.thing) > BOARDING_DISTANCE:
            distance = float(mind.surroundings.radius[self.thing]) + mind.body_radius
            distance += 0.5 * BOARDING_DISTANCE
            return steer(mind, mind.place(self.thing), distance, target=self.thing, touching=True)
        if self.task is None:
            self.task = PushRound(self.thing, MANY_TURNS)
        if self.task.failure or self.task.time > ROUND_TIME:
            self.pause_end = mind.now + PUSH_PAUSE
        return MotorCommand(task=self.task, pace=mind.stroll, target=self.thing, touching=True)

    def _run_along(self, mind: Mind) -> MotorCommand:
        """Return the motor command of a run along the rim of a thing."""
        place, radius = mind.place(self.thing), float(mind.surroundings.radius[self.thing])
        if mind.gap(self.thing) > 6.0 * PUSH_GAP:
            distance = radius + mind.body_radius + 2.0 * PUSH_GAP
            return steer(mind, place, distance, target=self.thing, touching=True)
        self.began = min(self.began, mind.now)
        if mind.now - self.began > PUSH_TIME:
            self.began, self.pause_end = math.inf, mind.now + PUSH_PAUSE
        offset = mind.at - place
        angle = math.atan2(offset[1], offset[0]) + RIM_LEAD_ANGLE
        goal = place + (radius + PUSH_GAP) * np.array([math.cos(angle), math.sin(angle)])
        return MotorCommand(
            goal=(float(goal[0]), float(goal[1])),
            pace=mind.stroll,
            target=self.thing,
            touching=True,
            reaching=True,
        )

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.began, self.task = math.inf, None


@implements(Ride)
class RideAround(ConfiguredBehaviour[Ride]):
    """Go to a merry-go-round, step onto it and stay there for a while."""

    def __init__(self, config: Ride, mind: Mind) -> None:
        super().__init__(config, mind)
        self.thing = mind.number(config.ride)
        self.task: RideCarousel | None = None
        self.aboard, self.pause_end = math.inf, -1.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if mind.now < self.pause_end:
            return 0.0
        return RIDE_ACTIVATION + RIDE_CURIOSITY * mind.traits.curiosity + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        if self.task is None and mind.gap(self.thing) > BOARDING_DISTANCE:
            distance = float(mind.surroundings.radius[self.thing]) + mind.body_radius
            distance += 0.5 * BOARDING_DISTANCE
            return steer(mind, mind.place(self.thing), distance, target=self.thing, touching=True)
        if self.task is None:
            name = mind.surroundings.view.names[self.thing]
            self.task = RideCarousel(name, self.thing)
        if self.task.is_there:
            self.aboard = min(self.aboard, mind.now)
        is_over = self.task.failure or self.task.is_lost or mind.now > self.aboard + RIDE_TIME
        if is_over:
            self.pause_end = mind.now + RIDE_PAUSE
        return MotorCommand(task=self.task, pace=mind.stroll, target=self.thing, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.task, self.aboard = None, math.inf
