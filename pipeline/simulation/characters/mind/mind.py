"""Mind: one character that notices, feels, wants and does.

It thinks a few times a second and goes on with what it decided in between; only pain is felt
in every step.

Source: Horswill 2008, "High-level Control" and "Example application".
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pipeline.simulation.characters.behaviours.potential_field import DetourState
from pipeline.simulation.characters.behaviours.registry import Behaviour, MotorCommand
from pipeline.simulation.characters.contact_tasks import Hug
from pipeline.simulation.characters.mind.perception import (
    SHOCK,
    Attention,
    Glances,
    Memory,
    Surroundings,
    felt,
)
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import HAND, PLACED
from pipeline.simulation.dynamics.compiled import Record
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import Traits

HYSTERESIS = 0.08
"""What the present behaviour's activation is ahead of others."""

STROLL, RUN = 0.36, 0.95
"""Usual speeds of the slowest and the fastest by nature, as a part of √(g l)."""

BEARS = 2.0
"""Pain that is borne from whom one has in its arms, for it was expected."""

RETURNING = 0.25
"""How much less one is afraid that is on its way back."""

FORGETS = 0.12
"""How fast fear of somebody who has hurt one goes [1/s]."""

ALARM = 0.35
"""Fear that a blow that just hurts leaves."""

ANGERS, COOLS = 0.25, 0.1
"""Anger from a blow that just hurts, and how fast it goes [1/s]."""


class Mind:
    """One who has a mind.

    Attributes:
        controller: its body's controls.
        surroundings: all characters.
        traits: how it is minded.
        rng: its chances.
        slapstick: whether it runs into whom it hugs.
        memory: where it believes the others to be.
        attention: what it makes of them.
        glances: where it looks.
        way: its way around things.
        anxiety: from 0 to 1.
        anger: from 0 to 1.
        distance: how far its caregiver is [m], 0 for none.
        behaviours: name -> behaviour, in the order of the registry.
        biases: name -> what a script adds to its activation.
        doing: name of what is done, "" for nothing.
        cried: when it last cried [s].
    """

    def __init__(
        self, controller: PersonController, surroundings: Surroundings, traits: Traits, bond: int
    ) -> None:
        self.controller, self.surroundings, self.traits = controller, surroundings, traits
        self.me = int(controller.record.owner)
        self.rng = np.random.default_rng(0)
        self.slapstick = False
        self.memory = Memory(surroundings)
        self.attention = Attention(surroundings.kinds, self.me, bond, traits.curiosity)
        self.bond = bond
        self.way = DetourState()
        self.slim = float(surroundings.radius[self.me])
        self.solid = np.array([kind != "ball" for kind in surroundings.kinds])
        self.acting = np.zeros(len(surroundings.kinds), dtype=bool)
        self.anxiety = self.anger = self.anxious_before = 0.0
        self.struck: tuple[float, int] = (-math.inf, -1)
        self.cried = -math.inf
        self.behaviours: Mapping[str, Behaviour] = {}
        self.arms: Mapping[int, Record] = {}
        self.biases: dict[str, float] = {}
        self.doing = ""
        self.motor = MotorCommand()
        self.now = 0.0
        away = surroundings.places[max(bond, 0)] - surroundings.places[self.me]
        self.distance = math.hypot(away[0], away[2]) if bond >= 0 else 0.0
        self.at = np.zeros(2)
        self.root = math.sqrt(GRAVITY * float(controller.record.hip_height))
        self.glances: Glances

    def begin(self, rng: np.random.Generator, behaviours: Mapping[str, Behaviour]) -> None:
        """Give it its chances, and what it may do."""
        self.rng, self.behaviours = rng, behaviours
        self.glances = Glances(len(self.surroundings.kinds), rng)

    # --- what behaviours ask ---------------------------------------------------------

    @property
    def pace(self) -> float:
        """How fast it usually goes [m/s]."""
        return (STROLL + (RUN - STROLL) * self.traits.speed) * self.root

    @property
    def stroll(self) -> float:
        """How fast it goes at leisure [m/s]."""
        return STROLL * self.root

    def number(self, name: str) -> int:
        """Return the number of a character."""
        return self.surroundings.view.number(name)

    def place(self, owner: int) -> Array:
        """Return (2,) x and z where it believes a character to be [m]."""
        result: Array = self.memory.places[owner, [0, 2]]
        return result

    def velocity(self, owner: int) -> Array:
        """Return (2,) how it believes a character to move [m/s]."""
        result: Array = self.memory.velocities[owner, [0, 2]]
        return result

    def away(self, owner: int) -> float:
        """Return how far off it believes a character to be [m]."""
        return float(self.memory.away[owner])

    def gap(self, owner: int) -> float:
        """Return how far from its own surface that of a character is [m]."""
        return self.away(owner) - float(self.surroundings.radius[owner]) - self.slim

    def heading_to(self, place: Array) -> float:
        """Return the heading of a place."""
        return math.atan2(-(place[1] - self.at[1]), place[0] - self.at[0])

    @property
    def hugging(self) -> bool:
        """Whether it has somebody in its arms."""
        errand = self.motor.task
        return isinstance(errand, Hug) and errand.touched > 0.0

    def opens_arms(self, owner: int) -> bool:
        """Tell whether another one holds both arms out for somebody, as far as can be seen."""
        arms = self.arms.get(owner)
        return arms is not None and min(int(arms.arm_mode[0]), int(arms.arm_mode[1])) >= PLACED

    def hands_apart(self, owner: int) -> float:
        """Return how far apart the hands of another one are [m], as somebody in them feels."""
        arms = self.arms.get(owner)
        if arms is None:
            return 0.0
        p, first = self.surroundings.view.arrays.p, int(arms.node) + HAND
        away = p[first] - p[first + 1]
        return math.sqrt(float((away * away).sum()))

    # --- what it goes through --------------------------------------------------------

    def hurt(self, pain: float, by: int, now: float) -> bool:
        """Feel a blow that hurts so much, struck by a character, or by -1 for none.

        Returns:
            Whether it comes as a shock.
        """
        if (self._embraces(by) and pain < BEARS) or self._holds(by):
            return False
        self.struck = (now, by)
        self.anxiety = min(self.anxiety + SHOCK * min(pain, 2.0), 1.0)
        if by >= 0 and self.surroundings.people[by]:
            fears = self.attention.fears
            fears[by] = min(fears[by] + ALARM * min(pain, 2.0), 1.0)
            self.anger = min(self.anger + ANGERS * self.traits.aggression * 2.0, 1.0)
        return True

    def _embraces(self, by: int) -> bool:
        """Tell whether it holds somebody, or opens its arms for them, and means no harm."""
        gentle = self.doing.startswith(("attachment", "comfort")) and self.motor.touching
        return gentle and self.motor.target == by and not self.slapstick

    def _holds(self, owner: int) -> bool:
        """Tell whether it has a character in its hand, which then does not come as a shock."""
        nodes = self.surroundings.view.arrays.nodes
        held = [self.controller.held(k) for k in range(2)]
        return any(node >= 0 and int(nodes[node].owner) == owner for node in held)

    def notice(self, now: float, dt: float) -> None:
        """See, remember, feel, and attend, `dt` [s] after the last time."""
        me = self.controller.record
        self.now = now
        self.at = self.surroundings.places[self.me, [0, 2]]
        self.memory.look(self.surroundings, self.me, float(me.gaze[0]))
        self.attention.fears *= math.exp(-FORGETS * dt)
        self.anger *= math.exp(-COOLS * dt)
        if self.bond >= 0:
            away = self.away(self.bond)
            to = self.surroundings.places[self.bond, [0, 2]] - self.at
            self.distance = math.hypot(to[0], to[1])
            trait = self.traits.anxiety * (RETURNING if self.doing == "attachment" else 1.0)
            self.anxiety = felt(self.anxiety, trait, away, self.hugging, dt)
        else:
            self.anxiety *= math.exp(-0.1 * dt)
        chance = 2.0 * self.rng.random(len(self.surroundings.kinds)) - 1.0
        self.attention.appraise(self.memory, self.anxiety, chance, now)

    def choose(self) -> None:
        """Go on with the behaviour of the highest activation."""
        best, most = "", 0.0
        for name, behaviour in self.behaviours.items():
            level = behaviour.activation(self) + self.biases.get(name, 0.0)
            if name == self.doing and level > 0.0:
                level += HYSTERESIS
            if level > most:
                best, most = name, level
        if best != self.doing:
            self.leave()
            self.doing = best
        self.motor = self.behaviours[best].motor(self) if best else MotorCommand()

    def leave(self) -> None:
        """Leave off what is done."""
        if self.doing:
            self.behaviours[self.doing].end(self)
        self.doing, self.motor, self.way = "", MotorCommand(), DetourState()

    def look(self, dt: float) -> None:
        """Choose where to look."""
        self.glances.look(
            self.now, dt, self.attention.priority, self.attention.focus, self.motor.target
        )
