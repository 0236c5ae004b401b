"""Attention: what somebody makes of each other character, and which of them it has in mind.

Each gets a salience (how interesting), a valence (how good, below 0 how bad) and a monitoring
priority (how much it wants watching). The most salient one is the focus of attention.

Source: Horswill 2008, "Example application".
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.characters.mind.anxiety import exposed
from pipeline.simulation.characters.mind.memory import Memory
from pipeline.simulation.spatial import Array

INTEREST = {
    "ball": 0.8,
    "ragdoll": 0.45,
    "merry-go-round": 0.35,
    "child": 0.35,
    "adult": 0.3,
    "box": 0.08,
    "bench": 0.05,
}
"""How interesting things and people are by nature."""

LIKED = {"ball": 0.8, "ragdoll": 0.6, "merry-go-round": 0.5, "child": 0.2, "adult": 0.1}
"""How good they are by nature; what is not here is neither good nor bad."""

NEARNESS = 8.0
"""At this distance something is half as interesting as at hand [m]."""

MOVING = 0.12
"""What a metre a second adds to salience."""

KEEPS = 0.08
"""What the present focus is ahead of others, so that it does not flicker."""

CHANCE = 0.05
"""How much salience changes by chance from thought to thought."""


class Attention:
    """What somebody attends to.

    Attributes:
        interest: (C,) by nature.
        liked: (C,) by nature.
        bond: the number of the caregiver, -1 for none.
        fears: (C,) how much each frightens, from 0 to 1, such as after a blow.
        salience: (C,).
        valence: (C,) from -1 to 1.
        priority: (C,) of watching, from 0 to about 1.
        focus: number of the most salient one, -1 if there is none.
    """

    def __init__(self, kinds: tuple[str, ...], me: int, bond: int, curiosity: float) -> None:
        self.me, self.bond = me, bond
        drawn = 0.6 + 0.8 * curiosity
        self.interest = drawn * np.array([INTEREST.get(kind, 0.1) for kind in kinds])
        self.liked = np.array([LIKED.get(kind, 0.0) for kind in kinds])
        self.fears = np.zeros(len(kinds))
        self.salience, self.valence = np.zeros(len(kinds)), self.liked.copy()
        self.priority = np.zeros(len(kinds))
        self.focus = -1

    def appraise(self, memory: Memory, anxiety: float, chance: Array, now: float) -> None:
        """Appraise all, and choose the focus.

        Args:
            memory: where they are.
            anxiety: from 0 to 1.
            chance: (C,) random numbers from -1 to 1.
            now: the time [s].
        """
        fresh = memory.fresh(now)
        v = memory.velocities
        speed = np.sqrt(v[:, 0] ** 2 + v[:, 2] ** 2)
        near = NEARNESS / (NEARNESS + memory.away)
        lively = np.minimum(MOVING * speed, 0.3)
        self.valence = np.clip(self.liked - 1.5 * self.fears, -1.0, 1.0)
        self.salience = fresh * near * (self.interest + lively + self.fears) * (1 + CHANCE * chance)
        self.priority = np.maximum(self.fears * near, 0.06 * near * (self.interest > 0.2))
        if self.bond >= 0:
            self.valence[self.bond] = min(0.3 + anxiety, 1.0)
            self.salience[self.bond] += anxiety
            far = exposed(float(memory.away[self.bond]))
            self.priority[self.bond] = 0.05 + 0.6 * far + 0.35 * anxiety * far
        self.salience[self.me] = self.priority[self.me] = 0.0
        if self.focus >= 0:
            self.salience[self.focus] += KEEPS
        best = int(self.salience.argmax())
        self.focus = best if self.salience[best] > 0.1 else -1
