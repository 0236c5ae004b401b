"""Social behaviours: run to a caregiver and hug, hug back, and fight.

Source: Horswill 2008, "Hugging", "Grappling" and "Example application"; Bowlby 1969. A child that
    runs into its caregiver's arms at full speed hurts it there, which turns a sentimental scene
    into slapstick: here it slows down before, unless the scene asks for that.
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
from pipeline.simulation.characters.hug_tasks import (
    HUG,
    OPEN_TIME,
    Hug,
    LoosenHug,
    ReturnHug,
)
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.shove_task import Grapple
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import Attachment, Comfort, Fight

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

# Hugs.
RESOLVED_ACTIVATION = 0.85  # of a decided return
SOOTHED_ANXIETY = 0.1  # at which a hug ends
HUG_GAP = 0.75  # from which arms do the rest [m]
GENTLE_PACE = 0.5  # of the last steps, in strolls
SLAPSTICK_OVERSHOOT = 3.0  # behind the partner, aimed at by one that does not slow down [m]
STEP_BACK = 0.45  # after a hug [m]
EMBRACE_GAP = 0.2  # from which the partner is embraced [m]
HANDS_PARTED = 0.12  # distance of joined hands that have opened again [m]
MIN_HUG_TIME = 0.5  # for the arms to close before a hug ends [s]

# Fights.
PROVOCATION_RANGE = 3.0  # of a rival [m]
ROUND_TIME, ROUND_PAUSE = 4.0, 2.5  # of shoving, at most, and of keeping a distance after [s]
RECOVERY = 1.2  # of keeping a distance after being shoved [s]
DRAWING_TIMES = 0.25, 0.8  # for which hands are drawn back before they strike [s]
SHOVE_GAP = 4.0  # from which steps to a shove slow down, in arm lengths
STAND_OFF = 1.1  # distance between rounds [m]
SLACK = 0.15  # of that distance, within which nobody steps back
CIRCLING_TURN = math.radians(55.0)  # around the rival, to the place that is walked to
CIRCLING_DISTANCE = 1.35  # from it to that place, in distances between rounds


@implements(Attachment)
class ReturnToCaregiver(ConfiguredBehaviour[Attachment]):
    """Run to a caregiver and hug until soothed."""

    def __init__(self, config: Attachment, mind: Mind) -> None:
        super().__init__(config, mind)
        self.target = mind.number(config.attachment)
        self.size = mind.surroundings.view.size(self.target)
        self.hug: Hug | None = None
        self.loosening: LoosenHug | None = None

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        is_done = self.loosening is not None and self.loosening.time > OPEN_TIME
        level = mind.anxiety
        if mind.doing == "attachment" and not is_done:
            level = max(level, RESOLVED_ACTIVATION)
        return level + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        if self.hug is None and mind.gap(self.target) < HUG_GAP:
            self.hug = Hug(self.target, self.size, is_gentle=not mind.slapstick)
        if self.hug is not None and self.hug.touched > MIN_HUG_TIME:
            if mind.anxiety < SOOTHED_ANXIETY:
                self.loosening = self.loosening or LoosenHug(self.hug, STEP_BACK)
        gentle = GENTLE_PACE * mind.stroll
        if self.loosening is not None:
            return MotorCommand(task=self.loosening, pace=gentle, target=self.target)
        if self.hug is not None:
            pace = mind.pace if mind.slapstick else gentle
            return MotorCommand(task=self.hug, pace=pace, target=self.target, touching=True)
        place = mind.place(self.target)
        if mind.slapstick:
            offset = place - mind.at
            distance = max(math.hypot(offset[0], offset[1]), 1e-6)
            place = place + offset * (SLAPSTICK_OVERSHOOT / distance)
        stop_distance = 0.0 if mind.slapstick else 0.5 * HUG_GAP
        return steer(mind, place, stop_distance, target=self.target, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.hug = self.loosening = None


@implements(Comfort)
class ComfortChild(ConfiguredBehaviour[Comfort]):
    """Turn to a child that comes to be hugged, and close the arms around it."""

    def __init__(self, config: Comfort, mind: Mind) -> None:
        super().__init__(config, mind)
        self.target = mind.number(config.comfort)
        self.size = mind.surroundings.view.size(self.target)
        self.embrace: ReturnHug | None = None
        self.joined = math.inf

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if self.embrace is not None or self._arrives(mind):
            return RESOLVED_ACTIVATION + self.config.urge
        is_near = mind.distance_to(self.target) < 3.0 and self._approaches(mind)
        return 0.5 + self.config.urge if is_near else 0.0

    def _arrives(self, mind: Mind) -> bool:
        """Tell whether the child is about to put its arms around this person, or has.

        One that draws its hands back and pushes opens its arms, too.
        """
        is_near = mind.gap(self.target) < 1.2 * HUG_GAP
        return is_near and mind.opens_arms(self.target) and not mind.sees_push

    def _is_let_go(self, mind: Mind) -> bool:
        """Tell whether the child opens its arms again, as can be felt, or is gone."""
        if self.embrace is not None and not self.embrace.closes:
            return not mind.opens_arms(self.target)
        gap = mind.hands_gap(self.target)
        self.joined = min(self.joined, gap)
        return gap > self.joined + HANDS_PARTED or not mind.opens_arms(self.target)

    def _approaches(self, mind: Mind) -> bool:
        offset, v = mind.at - mind.place(self.target), mind.velocity(self.target)
        distance, speed = math.hypot(offset[0], offset[1]), math.hypot(v[0], v[1])
        return bool(offset @ v > 0.7 * distance * max(speed, 0.4))

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        embrace = self.embrace
        if embrace is not None and not embrace.opens and self._is_let_go(mind):
            embrace.opens, embrace.time = True, 0.0
        if embrace is not None and embrace.opens:
            if embrace.time > HUG.closing_time + OPEN_TIME:
                self.end(mind)
        if self.embrace is None and self._arrives(mind):
            self.embrace = ReturnHug(self.target, self.size)
        if self.embrace is not None and mind.gap(self.target) < EMBRACE_GAP:
            self.embrace.closes = True
        if self.embrace is not None:
            return MotorCommand(task=self.embrace, target=self.target, touching=True)
        if mind.gap(self.target) < HUG_GAP:
            # Stop short of the child's feet.
            return MotorCommand(target=self.target, touching=True)
        heading = mind.heading_to(mind.place(self.target))
        return MotorCommand(facing=heading, target=self.target)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.embrace, self.joined = None, math.inf


@implements(Fight)
class FightRival(ConfiguredBehaviour[Fight]):
    """Go for a rival and shove, step back, walk around it, and go for it again while angry."""

    def __init__(self, config: Fight, mind: Mind) -> None:
        super().__init__(config, mind)
        self.target = mind.number(config.fight)
        self.grapple: Grapple | None = None
        self.began, self.pause_end = 0.0, 0.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        nearness = max(1.0 - mind.distance_to(self.target) / PROVOCATION_RANGE, 0.0)
        heat = mind.traits.aggression * (0.35 + 0.65 * nearness) + mind.anger
        return heat - 0.5 * float(mind.attention.fears[self.target]) + self.config.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        place = mind.place(self.target)
        if self.grapple is not None and self._ends_round(mind, self.grapple):
            pause = ROUND_PAUSE if self.grapple.is_over else RECOVERY
            self.grapple = None
            self.pause_end = mind.now + pause * (0.7 + 0.6 * float(mind.rng.random()))
        if mind.now < self.pause_end:
            distance = STAND_OFF + mind.body_radius + float(mind.surroundings.radius[self.target])
            if mind.distance_to(self.target) < (1.0 - SLACK) * distance:
                return self._step_back(mind, place, distance)
            return self._circle(mind, place, distance)
        if self.grapple is None and mind.gap(self.target) < SHOVE_GAP * mind.controller.arm:
            # Two that strike at the same time would only meet one another's arms.
            low, high = DRAWING_TIMES
            drawing_time = low + (high - low) * float(mind.rng.random())
            self.grapple, self.began = Grapple(self.target, drawing_time), mind.now
        if self.grapple is None:
            return steer(mind, place, target=self.target, touching=True)
        pace = 0.5 * (mind.stroll + mind.pace)
        return MotorCommand(task=self.grapple, pace=pace, target=self.target, touching=True)

    def _ends_round(self, mind: Mind, grapple: Grapple) -> bool:
        """Tell whether it has shoved, has been shoved before it could, or does not get to it."""
        time, striker = mind.struck
        is_struck = striker == self.target and time > self.began and grapple.struck == 0.0
        return grapple.is_over or is_struck or mind.now - self.began > ROUND_TIME

    def _circle(self, mind: Mind, place: Array, distance: float) -> MotorCommand:
        """Return the motor command that walks around the rival at a distance [m].

        Both rivals walk the same way round, so that they stay opposite one another.
        """
        offset = mind.at - place
        turn = math.atan2(offset[1], offset[0]) + CIRCLING_TURN
        ahead = place + CIRCLING_DISTANCE * distance * np.array([math.cos(turn), math.sin(turn)])
        return steer(mind, mind.clip_to_terrain(ahead), target=self.target, pace=mind.stroll)

    def _step_back(self, mind: Mind, place: Array, distance: float) -> MotorCommand:
        """Return the motor command that gains a distance, with the eyes on the rival [m]."""
        facing, offset = mind.heading_to(place), mind.at - place
        left = distance - mind.distance_to(self.target)
        away = mind.clip_to_terrain(mind.at + offset * (left / max(math.hypot(*offset), 1e-6)))
        goal = float(away[0]), float(away[1])
        pace = GENTLE_PACE * mind.stroll
        return MotorCommand(goal=goal, pace=pace, target=self.target, facing=facing)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.grapple = None
