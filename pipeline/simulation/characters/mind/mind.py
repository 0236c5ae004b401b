"""Mind: one character that notices, feels, wants and acts.

A mind thinks a few times a second and goes on with its decision in between; only pain is felt in
every step.

Source: Horswill 2008, "High-level Control" and "Example application".
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pipeline.simulation.characters.contact_tasks import Hug
from pipeline.simulation.characters.mind.detour_state import DetourState
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.mind.perception import (
    ANXIETY,
    Attention,
    Glances,
    Memory,
    Surroundings,
    next_anxiety,
)
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import HAND, PLACED
from pipeline.simulation.dynamics.compiled import Record
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import Traits

HYSTERESIS = 0.08
"""Activation added to the present behaviour."""

STROLL_FROUDE, RUN_FROUDE = 0.36, 0.95
"""Usual speeds of the slowest and the fastest characters, in √(g l)."""


@dataclass(frozen=True)
class EmotionRates:
    """How feelings change, beside anxiety away from a caregiver.

    Attributes:
        hug_pain: pain that is expected from a hugged partner, and no blow.
        returning: factor of natural anxiety on the way back to the caregiver.
        calming: rate of decay of anxiety without a caregiver [1/s].
        fear_decay: of fear of a character [1/s].
        fear: by a blow that just hurts.
        anger: by a blow that just hurts.
        anger_decay: [1/s].
    """

    hug_pain: float = 2.0
    returning: float = 0.25
    calming: float = 0.1
    fear_decay: float = 0.12
    fear: float = 0.35
    anger: float = 0.25
    anger_decay: float = 0.1


EMOTION = EmotionRates()


@dataclass(frozen=True)
class FaceRates:
    """How feelings show in a face.

    Attributes:
        worry: anxiety from which it looks like fear, too.
        anxious_fear: fear of full anxiety, by the anxiety beyond worry.
        anxious_sadness: sadness of full anxiety.
        hug_joy: joy in somebody's arms.
        interest: curiosity by the salience of the focus.
    """

    worry: float = 0.5
    anxious_fear: float = 0.8
    anxious_sadness: float = 0.9
    hug_joy: float = 0.9
    interest: float = 1.3


FACE = FaceRates()

JOYS: Mapping[str, float] = {"play": 0.8, "comfort": 0.5, "carry": 0.35, "push": 0.7}
"""Joy in a face by the present behaviour."""


class Behaviour(Protocol):
    """An activity that a mind may choose."""

    def activation(self, mind: Mind) -> float:
        """Return the usefulness of the behaviour now, from 0 to about 1."""

    def motor(self, mind: Mind) -> MotorCommand:
        """Return the motor command while the behaviour is chosen."""

    def end(self, mind: Mind) -> None:
        """Reset when another behaviour is chosen."""


class Mind:
    """One mind.

    Args:
        controller: of the body.
        surroundings: all characters.
        traits: of the character.
        caregiver: number of the caregiver, -1 for none.
        slapstick: whether the character runs into those it hugs.
        rng: of the character's choices.
        acting: (C,) which characters act.
        records: `PERSON` records of acting people by their number.

    Attributes:
        number_of_self: number of the character.
        body_radius: of the circle on the ground around it [m].
        is_obstacle: (C,) which characters are walked around.
        memory: of the other characters.
        attention: to the other characters.
        glances: of the eyes.
        detour: of the present walk.
        anxiety: from 0 to 1.
        anger: from 0 to 1.
        struck: time of the last blow [s], and the striker's number or -1.
        caregiver_distance: [m], 0 without a caregiver.
        behaviours: by name, in the order of the registry.
        biases: by a script, added to activations by name.
        doing: name of the present behaviour, "" for none.
        command: of the present behaviour.
        cried: time of the last cry [s].
        gasped: time of the last gasp [s].
        next_laugh: time from which it laughs at play [s].
        froude_speed: √(g l) of its legs [m/s].
    """

    def __init__(
        self,
        controller: PersonController,
        surroundings: Surroundings,
        traits: Traits,
        caregiver: int,
        slapstick: bool,
        rng: np.random.Generator,
        acting: Array,
        records: Mapping[int, Record],
    ) -> None:
        self.controller, self.surroundings, self.traits = controller, surroundings, traits
        self.slapstick, self.rng, self.acting = slapstick, rng, acting
        self.number_of_self = int(controller.record.owner)
        self.body_radius = float(surroundings.radius[self.number_of_self])
        self.is_obstacle = np.array([kind != "ball" for kind in surroundings.kinds])
        self._caregiver, self._records = caregiver, records
        self.memory = Memory(surroundings)
        self.attention = Attention(
            surroundings.kinds, self.number_of_self, caregiver, traits.curiosity
        )
        self.glances = Glances(len(surroundings.kinds), rng)
        self.detour = DetourState()
        self.anxiety = self.anger = 0.0
        self.struck: tuple[float, int] = (-math.inf, -1)
        self.cried = self.gasped = -math.inf
        self.next_laugh = 0.0
        self.behaviours: Mapping[str, Behaviour] = {}
        self.biases: dict[str, float] = {}
        self.doing, self.command = "", MotorCommand()
        self.now = 0.0
        self.at = np.zeros(2)
        self.caregiver_distance = 0.0
        if caregiver >= 0:
            offset = surroundings.places[caregiver] - surroundings.places[self.number_of_self]
            self.caregiver_distance = math.hypot(offset[0], offset[2])
        self.froude_speed = math.sqrt(GRAVITY * float(controller.record.hip_height))

    # --- for behaviours -----------------------------------------------------------------

    @property
    def pace(self) -> float:
        """Usual speed [m/s]."""
        share = STROLL_FROUDE + (RUN_FROUDE - STROLL_FROUDE) * self.traits.speed
        return share * self.froude_speed

    @property
    def stroll(self) -> float:
        """Leisurely speed [m/s]."""
        return STROLL_FROUDE * self.froude_speed

    def number(self, name: str) -> int:
        """Return the number of a character."""
        return self.surroundings.view.number(name)

    def place(self, owner: int) -> Array:
        """Return (2,) x and z of a character as remembered [m]."""
        return self.memory.places[owner, [0, 2]]

    def velocity(self, owner: int) -> Array:
        """Return (2,) the velocity of a character as remembered [m/s]."""
        return self.memory.velocities[owner, [0, 2]]

    def distance_to(self, owner: int) -> float:
        """Return the distance of a character as remembered [m]."""
        return float(self.memory.distances[owner])

    def gap(self, owner: int) -> float:
        """Return the gap to the surface of a character as remembered [m]."""
        return self.distance_to(owner) - float(self.surroundings.radius[owner]) - self.body_radius

    def heading_to(self, place: Array) -> float:
        """Return the heading of a place."""
        return math.atan2(-(place[1] - self.at[1]), place[0] - self.at[0])

    def is_on_terrain(self, place: Array, margin: float) -> bool:
        """Tell whether a place (2,) is farther from the edge of the terrain than a margin [m]."""
        low, high = self.surroundings.low + margin, self.surroundings.high - margin
        return bool((place > low).all() and (place < high).all())

    @property
    def is_hugging(self) -> bool:
        """Whether it has somebody in its arms."""
        task = self.command.task
        return isinstance(task, Hug) and task.touched > 0.0

    def opens_arms(self, owner: int) -> bool:
        """Tell whether a character holds both arms out for somebody, as far as can be seen."""
        record = self._records.get(owner)
        return record is not None and bool((record.arm_mode >= PLACED).all())

    def hands_gap(self, owner: int) -> float:
        """Return the distance between the hands of a character, as felt in its arms [m]."""
        record = self._records.get(owner)
        if record is None:
            return 0.0
        p, first = self.surroundings.view.arrays.p, int(record.node) + HAND
        offset = p[first] - p[first + 1]
        return math.sqrt(float((offset * offset).sum()))

    def emotions(self) -> list[float]:
        """Return the emotions that its face shows, in the order of `EMOTIONS`, from 0 to 1."""
        attention, anxiety = self.attention, self.anxiety
        # Far-off threats frighten less.
        fear = max(float((attention.fears * attention.nearness).max(initial=0.0)), 0.0)
        fear = min(fear + FACE.anxious_fear * max(anxiety - FACE.worry, 0.0), 1.0)
        worried = FACE.anxious_sadness * anxiety
        calm = 1.0 - max(fear, worried, self.anger)
        social = FACE.hug_joy if self.is_hugging else JOYS.get(self.doing, 0.0)
        joy = social * (1.0 - anxiety) * (1.0 - max(fear, self.anger))
        focus = attention.focus
        interest = float(attention.salience[focus]) if focus >= 0 else 0.0
        curiosity = min(FACE.interest * interest, 1.0) * calm * (1.0 - joy)
        return [joy, min(worried, 1.0) * (1.0 - fear), self.anger, fear, 0.0, curiosity]

    # --- experience ---------------------------------------------------------------------

    def feel_blow(self, pain: float, striker: int, now: float) -> bool:
        """Feel the pain of a blow, struck by a character, or by -1 for none.

        Returns:
            Whether it comes as a shock.
        """
        if (self._embraces(striker) and pain < EMOTION.hug_pain) or self._holds(striker):
            return False
        self.struck = (now, striker)
        self.anxiety = min(self.anxiety + ANXIETY.shock * min(pain, 2.0), 1.0)
        if striker >= 0 and self.surroundings.people[striker]:
            fears = self.attention.fears
            fears[striker] = min(fears[striker] + EMOTION.fear * min(pain, 2.0), 1.0)
            self.anger = min(self.anger + EMOTION.anger * self.traits.aggression * 2.0, 1.0)
        return True

    def _embraces(self, owner: int) -> bool:
        """Tell whether it gently holds a character, or opens its arms for it."""
        is_gentle = self.doing.startswith(("attachment", "comfort")) and self.command.touching
        return is_gentle and self.command.target == owner and not self.slapstick

    def _holds(self, owner: int) -> bool:
        """Tell whether it has a character in its hand, which then is no shock."""
        nodes = self.surroundings.view.arrays.nodes
        held = [self.controller.held_node(k) for k in range(2)]
        return any(node >= 0 and int(nodes[node].owner) == owner for node in held)

    def notice(self, now: float, dt: float) -> None:
        """Perceive, remember, feel and attend, `dt` [s] after the last time."""
        self.now = now
        self.at = self.surroundings.places[self.number_of_self, [0, 2]]
        gaze = float(self.controller.record.gaze[0])
        self.memory.look(self.surroundings, self.number_of_self, gaze)
        self.attention.fears *= math.exp(-EMOTION.fear_decay * dt)
        self.anger *= math.exp(-EMOTION.anger_decay * dt)
        if self._caregiver >= 0:
            offset = self.surroundings.places[self._caregiver, [0, 2]] - self.at
            self.caregiver_distance = math.hypot(offset[0], offset[1])
            factor = EMOTION.returning if self.doing == "attachment" else 1.0
            trait, distance = self.traits.anxiety * factor, self.distance_to(self._caregiver)
            self.anxiety = next_anxiety(self.anxiety, trait, distance, self.is_hugging, dt)
        else:
            self.anxiety *= math.exp(-EMOTION.calming * dt)
        noise = 2.0 * self.rng.random(len(self.surroundings.kinds)) - 1.0
        self.attention.appraise(self.memory, self.anxiety, noise, now)

    def choose(self) -> None:
        """Follow the behaviour of the highest activation."""
        best, highest = "", 0.0
        for name, behaviour in self.behaviours.items():
            level = behaviour.activation(self) + self.biases.get(name, 0.0)
            if name == self.doing and level > 0.0:
                level += HYSTERESIS
            if level > highest:
                best, highest = name, level
        if best != self.doing:
            self.end_behaviour()
            self.doing = best
        self.command = self.behaviours[best].motor(self) if best else MotorCommand()

    def end_behaviour(self) -> None:
        """End the present behaviour."""
        if self.doing:
            self.behaviours[self.doing].end(self)
        self.doing, self.command, self.detour = "", MotorCommand(), DetourState()

    def look(self, dt: float) -> None:
        """Choose where to look for the next `dt` [s]."""
        attention = self.attention
        self.glances.look(self.now, dt, attention.priority, attention.focus, self.command.target)
