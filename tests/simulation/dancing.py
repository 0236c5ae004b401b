"""Dancers that several tests look at: what they do, step by step."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.dancers.dance_goals import dance_choreography
from pipeline.simulation.dancers.dance_moves import Move, beat_duration, plan_moves
from pipeline.simulation.dancers.dancer_motion import DancerMotion
from pipeline.simulation.dancers.hand_contacts import HandStrike
from pipeline.simulation.dancers.practice import rehearsed_motion
from pipeline.simulation.dancers.torso import HANDS, LINKS, dancer_proportions
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene

HEADER = (
    "pronk: 1\nduration: {duration}\n{more}\ncast:\n- {{name: adonis, dancer: {build}, {words}}}\n"
)


def dancing_of(
    words: str, rate: float = 96.0, duration: float = 30, more: str = "", build: str = "torso"
) -> DancerMotion:
    """Return a dancer of its words, about to begin."""
    scene = read_scene(HEADER.format(duration=duration, words=words, more=more, build=build))
    _, member = scene.dancers[0]
    dance = scene.dances[member.dance]
    moves = plan_moves(member, dance, duration, "cast[0]")
    choreography = dance_choreography(
        dancer_proportions(member), dance, member.dance, member.compensate_gravity
    )
    return rehearsed_motion(member, choreography, moves, beat_duration(member, dance), 1.0 / rate)


@dataclass
class Seen:
    """What a dancer did.

    Attributes:
        dancing: the dancer.
        times: of the rows [s].
        hands: (K, 2, 3) middles of the palms, right and left [m].
        gaps: per touched subtask, how far the palm is from the named place at each row [m].
        forward: (K, 2, 3) directions from shoulders to wrists.
        deepest: depth and names of what went deepest into what.
        strikes: what hands touched.
        torques: (K, 20) [N m].
        energies: kinetic and potential, row by row [J].
    """

    dancing: DancerMotion
    times: list[float] = field(default_factory=list)
    hands: list[Array] = field(default_factory=list)
    places: list[Array] = field(default_factory=list)
    forward: list[Array] = field(default_factory=list)
    deepest: dict[tuple[str, str], float] = field(default_factory=dict)
    strikes: list[HandStrike] = field(default_factory=list)
    torques: list[Array] = field(default_factory=list)
    q: list[Array] = field(default_factory=list)

    def look(self) -> None:
        """Keep how the dancer is now."""
        one, moving = self.dancing, self.dancing.moving
        self.times.append(one.now)
        self.hands.append(moving.places[[arm.palm for arm in one.arms]].copy())
        R, p = moving.poses()
        rest = np.array([link.place for link in one.torso.linkage.links])
        rows = []
        for goal in one.goals:
            row = np.full(3, np.nan)
            if goal.surface is not None:
                k = LINKS.index(goal.surface.link) if goal.surface.link else 0
                row = p[k] + R[k] @ (goal.surface.place - rest[k])
            rows.append(row)
        self.places.append(np.array(rows))
        arms = [
            p[LINKS.index(f"hand_{side}")] - p[LINKS.index(f"upper_arm_{side}")] for side in HANDS
        ]
        self.forward.append(np.array([arm / np.linalg.norm(arm) for arm in arms]))
        for touch in moving.touches():
            pair = touch.one, touch.other
            self.deepest[pair] = max(self.deepest.get(pair, 0.0), touch.depth)
        self.torques.append(moving.torques())
        self.q.append(moving.q.copy())

    def run(self, until: float) -> Seen:
        """Let it dance."""
        while self.dancing.now < until:
            self.strikes += self.dancing.advance()
            self.look()
        return self

    def moves(self, bar: int = 0) -> list[tuple[Move, int]]:
        """Return the moves of a bar, each with the number of its hand."""
        rows = [(m, k) for k, moves in enumerate(self.dancing.moves) for m in moves]
        return sorted((r for r in rows if r[0].bar == bar), key=lambda row: row[0].land)

    def around(self, move: Move, before: float, after: float) -> slice:
        """Return the rows around the arrival of a move."""
        first = int(np.searchsorted(self.times, move.land - before))
        return slice(first, int(np.searchsorted(self.times, move.land + after)) + 1)


def danced(
    words: str, until: float, rate: float = 96.0, more: str = "", build: str = "torso"
) -> Seen:
    """Return what a dancer of its words did."""
    return Seen(dancing_of(words, rate, until + 1.0, more, build)).run(until)
