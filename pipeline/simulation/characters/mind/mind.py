"""Mind: one character that notices, feels, wants and acts.

A mind thinks a few times a second and goes on with its decision in between; only pain is felt in
every step.

Source: Horswill 2008, "High-level Control" and "Example application".
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.hug_tasks import Hug
from pipeline.simulation.characters.mind.detour_state import DetourState
from pipeline.simulation.characters.mind.felt_emotions import FACE, JOYS
from pipeline.simulation.characters.mind.mind_arrays import NOISE_ROWS, MindArrays
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.mind.perception import (
    ANXIETY,
    EMOTION,
    Attention,
    Glances,
    Memory,
    Surroundings,
)
from pipeline.simulation.characters.mind.sight import Sight
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import HAND, PLACED
from pipeline.simulation.characters.terrain_edge import EDGE_MARGIN
from pipeline.simulation.dynamics.compiled import Record
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.record_view import record_view
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import Traits

HYSTERESIS = 0.08
"""Activation added to the present behaviour."""

STROLL_FROUDE, RUN_FROUDE = 0.36, 0.95
"""Usual speeds of the slowest and the fastest characters, in √(g l)."""


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
        arrays: of all minds.
        number: of this one among them.
        traits: of the character.
        slapstick: whether the character runs into those it hugs.
        rng: of the character's choices.
        acting: (C,) which characters act.
        records: `PERSON` records of acting people by their number.

    Attributes:
        arrays: of all minds.
        index: of this one among them.
        number_of_self: number of the character.
        body_radius: of the circle on the ground around it [m].
        is_obstacle: (C,) which characters are walked around.
        walking_bounds: (2, 2) least and greatest x and z of places on the way [m].
        memory: of the other characters.
        attention: to the other characters.
        glances: of the eyes.
        detour: of the present walk.
        walks: (1,) `WALK` of the present walk.
        walk: a view of it.
        struck: time of the last blow [s], and the striker's number or -1.
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
        arrays: MindArrays,
        number: int,
        traits: Traits,
        slapstick: bool,
        rng: np.random.Generator,
        acting: Array,
        records: Mapping[int, Record],
    ) -> None:
        self.controller, self.surroundings, self.traits = controller, surroundings, traits
        self.slapstick, self.rng = slapstick, rng
        self.number_of_self = int(controller.record.owner)
        self.body_radius = float(surroundings.radius[self.number_of_self])
        # Walkers step aside for people before they come near.
        is_ball = np.array([kind == "ball" for kind in surroundings.kinds])
        self.is_obstacle = ~(is_ball | (surroundings.people & acting))
        self.is_obstacle[self.number_of_self] = False
        edges = np.stack([surroundings.low, surroundings.high])
        self._edges = edges.tolist()
        self.walking_bounds = edges + 0.5 * EDGE_MARGIN * np.array([[1.0], [-1.0]])
        self._records = records
        self._noise = arrays.noise[number]
        self._state, self.at = record_view(arrays.minds, number), arrays.at[number]
        self._state.noise_row = NOISE_ROWS - 1
        self.memory, self.attention = Memory(arrays, number), Attention(arrays, number)
        self.glances = Glances(len(surroundings.kinds), rng)
        self.detour = DetourState()
        self.arrays, self.index = arrays, number
        self.walks = arrays.walks[number : number + 1]
        self.walk = record_view(self.walks, 0)
        self.walk.body_radius = self.body_radius
        (self.walk.low_x, self.walk.low_z), (self.walk.high_x, self.walk.high_z) = (
            self.walking_bounds.tolist()
        )
        self._sight: Sight | None = None
        self.struck: tuple[float, int] = (-math.inf, -1)
        self.cried = self.gasped = -math.inf
        self.next_laugh = 0.0
        self.behaviours: Mapping[str, Behaviour] = {}
        self.biases: dict[str, float] = {}
        self.doing, self.command = "", MotorCommand()
        # Time since the thought before [s].
        self._pause = self.now = 0.0
        self.froude_speed = math.sqrt(GRAVITY * float(controller.record.hip_height))

    @property
    def anxiety(self) -> float:
        """Anxiety, from 0 to 1."""
        return float(self._state.anxiety)

    @anxiety.setter
    def anxiety(self, anxiety: float) -> None:
        self._state.anxiety = anxiety

    @property
    def anger(self) -> float:
        """Anger, from 0 to 1."""
        return float(self._state.anger)

    @property
    def caregiver_distance(self) -> float:
        """Distance of the caregiver, 0 without one [m]."""
        return float(self._state.caregiver_distance)

    # --- for behaviours -----------------------------------------------------------------

    @cached_property
    def pace(self) -> float:
        """Usual speed [m/s]."""
        share = STROLL_FROUDE + (RUN_FROUDE - STROLL_FROUDE) * self.traits.speed
        return share * self.froude_speed

    @cached_property
    def stroll(self) -> float:
        """Leisurely speed [m/s]."""
        return STROLL_FROUDE * self.froude_speed

    def number(self, name: str) -> int:
        """Return the number of a character."""
        return self.surroundings.view.number(name)

    def place(self, owner: int) -> Array:
        """Return (2,) x and z of a character as remembered [m]."""
        return self.memory.places[owner, ::2]

    def velocity(self, owner: int) -> Array:
        """Return (2,) the velocity of a character as remembered [m/s]."""
        return self.memory.velocities[owner, ::2]

    def distance_to(self, owner: int) -> float:
        """Return the distance of a character as remembered [m]."""
        return float(self.memory.distances[owner])

    def gap(self, owner: int) -> float:
        """Return the gap to the surface of a character as remembered [m]."""
        return self.distance_to(owner) - float(self.surroundings.radius[owner]) - self.body_radius

    def heading_to(self, place: Sequence[float] | Array) -> float:
        """Return the heading of a place."""
        return math.atan2(-(place[1] - self.at[1]), place[0] - self.at[0])

    def is_on_terrain(self, place: Sequence[float] | Array, margin: float) -> bool:
        """Tell whether a place (2,) is farther from the edge of the terrain than a margin [m]."""
        (low_x, low_z), (high_x, high_z) = self._edges
        x, z = place
        is_inside = low_x + margin < x < high_x - margin
        return bool(is_inside and low_z + margin < z < high_z - margin)

    def clip_to_terrain(self, place: Sequence[float] | Array) -> Array:
        """Return the nearest place (2,) that can be walked to."""
        return np.array(self.nearest_on_terrain(*place))

    def nearest_on_terrain(self, x: float, z: float) -> tuple[float, float]:
        """Return x and z of the nearest place that can be walked to [m]."""
        (low_x, low_z), (high_x, high_z) = self._edges
        low_x, low_z, high_x, high_z = (
            *(low_x + EDGE_MARGIN, low_z + EDGE_MARGIN),
            *(high_x - EDGE_MARGIN, high_z - EDGE_MARGIN),
        )
        if low_x <= x <= high_x and low_z <= z <= high_z:
            return x, z
        return min(max(x, low_x), high_x), min(max(z, low_z), high_z)

    def record_of(self, owner: int) -> Record | None:
        """Return the record of an acting person, None of another character."""
        return self._records.get(owner)

    @property
    def is_hugging(self) -> bool:
        """Whether it has somebody in its arms."""
        task = self.command.task
        return isinstance(task, Hug) and task.touched > 0.0

    @property
    def sees_push(self) -> bool:
        """Whether it sees that somebody is about to push it."""
        return math.isfinite(float(self.controller.record.seen_push_left))

    def opens_arms(self, owner: int) -> bool:
        """Tell whether a character holds both arms out for somebody, as far as can be seen."""
        record = self._records.get(owner)
        if record is None:
            return False
        left, right = record.arm_mode.tolist()
        return bool(left >= PLACED and right >= PLACED)

    def hands_gap(self, owner: int) -> float:
        """Return the distance between the hands of a character, as felt in its arms [m]."""
        record = self._records.get(owner)
        if record is None:
            return 0.0
        p, first = self.surroundings.view.arrays.p, int(record.node) + HAND
        offset = p[first] - p[first + 1]
        return math.sqrt(float((offset * offset).sum()))

    @property
    def obstacles(self) -> NDArray[np.bool_]:
        """(C,) which characters are walked around; what is in its hands is not in its way."""
        if not self.controller.is_gripping:
            return self.is_obstacle
        nodes = self.surroundings.view.arrays.nodes
        held = [node for k in range(2) if (node := self.controller.held_node(k)) >= 0]
        obstacles = self.is_obstacle.copy()
        obstacles[nodes["owner"][held]] = False
        return obstacles

    @property
    def sight(self) -> Sight:
        """What it knows of things in its way."""
        obstacles, known = self.obstacles, self._sight
        circles = self.surroundings.view.obstacle_circles
        circles.update()
        if known is not None and known.is_obstacle is obstacles:
            if known.circle_middles is circles.middles:
                return known
        places, distances = self.memory.places, self.memory.distances
        known = Sight(
            *(places, distances, self.surroundings.radius, obstacles),
            *(circles.middles, circles.radii, circles.keys, circles.things),
        )
        self._sight = known
        return known

    def is_ridden(self, thing: int) -> bool:
        """Tell whether somebody else stands on a merry-go-round."""
        return any(
            int(record.deck) == thing and float(record.deck_share) > 0.5
            for owner, record in self._records.items()
            if owner != self.number_of_self
        )

    @property
    def delight(self) -> float:
        """Joy in what it does, from 0 to 1."""
        return FACE.hug_joy if self.is_hugging else JOYS.get(self.doing, 0.0)

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
            anger = self.anger + EMOTION.anger * self.traits.aggression * 2.0
            self._state.anger = min(anger, 1.0)
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

    def prepare(self) -> None:
        """Pass on what `notice` needs to know of it."""
        state = self._state
        state.returns, state.hugs = self.doing == "attachment", self.is_hugging
        state.noise_row = (state.noise_row + 1) % NOISE_ROWS
        if state.noise_row == 0:
            self.rng.random(out=self._noise)

    def take_over(self, now: float) -> None:
        """Accept the time at which it has noticed [s]."""
        self._pause, self.now = now - self.now, now

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
        self.walk.known = 0

    def look(self) -> None:
        """Choose where to look until the next thought."""
        attention, target = self.attention, self.command.target
        self.glances.look(self.now, self._pause, attention.priority, attention.focus, target)
