"""Dancers that tests run step by step, and a record of their motion."""

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
    "pronk: 1\nduration: {duration}\n{more}\ncast:\n- {{name: adonis, dancer: {build}, {config}}}\n"
)

TOUCH_TOLERANCE = 0.04
"""Largest distance of a hand from its touch point [m]."""

ANGLE_TOLERANCE = np.radians(10.0)
"""Largest error of an arm's direction and of a wrist's angle [rad]."""

MAX_PENETRATION = 0.01
"""Largest penetration of two solids [m]."""


def build_dancer(
    config: str, rate: float = 96.0, duration: float = 30, more: str = "", build: str = "torso"
) -> DancerMotion:
    """Returns a rehearsed dancer at its start."""
    scene = read_scene(HEADER.format(duration=duration, config=config, more=more, build=build))
    _, member = scene.dancers[0]
    dance = scene.dances[member.dance]
    moves = plan_moves(member, dance, duration, "cast[0]")
    choreography = dance_choreography(
        dancer_proportions(member), dance, member.dance, member.compensate_gravity
    )
    return rehearsed_motion(member, choreography, moves, beat_duration(member, dance), 1.0 / rate)


@dataclass
class DanceRecording:
    """Motion of a dancer.

    Attributes:
        dancer: the dancer.
        times: (K,) times of the rows [s].
        hands: (K, 2, 3) centres of the palms, right and left [m].
        places: (K, S, 3) touch points of the subtasks, NaN for other subtasks [m].
        forward: (K, 2, 3) directions from shoulders to wrists.
        deepest: deepest penetration of each pair of solids [m].
        strikes: contacts of the hands.
        torques: (K, 20) joint torques [N m].
        q: (K, 20) joint angles [rad].
    """

    dancer: DancerMotion
    times: list[float] = field(default_factory=list)
    hands: list[Array] = field(default_factory=list)
    places: list[Array] = field(default_factory=list)
    forward: list[Array] = field(default_factory=list)
    deepest: dict[tuple[str, str], float] = field(default_factory=dict)
    strikes: list[HandStrike] = field(default_factory=list)
    torques: list[Array] = field(default_factory=list)
    q: list[Array] = field(default_factory=list)

    def record(self) -> None:
        """Appends the present state."""
        dancer, moving = self.dancer, self.dancer.moving
        self.times.append(dancer.now)
        self.hands.append(moving.places[[arm.palm for arm in dancer.arms]].copy())
        R, p = moving.poses()
        rest = np.array([link.place for link in dancer.torso.linkage.links])
        rows = []
        for goal in dancer.goals:
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

    def run(self, until: float) -> DanceRecording:
        """Runs the dancer until a time [s]."""
        while self.dancer.now < until:
            self.strikes += self.dancer.advance()
            self.record()
        return self

    def moves(self, bar: int = 0) -> list[tuple[Move, int]]:
        """Returns the moves of a bar, each with the number of its hand."""
        rows = [(m, k) for k, moves in enumerate(self.dancer.moves) for m in moves]
        return sorted((r for r in rows if r[0].bar == bar), key=lambda row: row[0].land)

    def around(self, move: Move, before: float, after: float) -> slice:
        """Returns the rows around the arrival of a move."""
        first = int(np.searchsorted(self.times, move.land - before))
        return slice(first, int(np.searchsorted(self.times, move.land + after)) + 1)


def record_motion(
    config: str, until: float, rate: float = 96.0, more: str = "", build: str = "torso"
) -> DanceRecording:
    """Returns the motion of a dancer until a time [s]."""
    return DanceRecording(build_dancer(config, rate, until + 1.0, more, build)).run(until)


def missed_goals(motion: DanceRecording, skipped: tuple[int, ...] = ()) -> list[str]:
    """Returns the missed subtasks with their errors."""
    found = []
    for move, hand in motion.moves():
        if move.subtask in skipped:
            continue
        goal = motion.dancer.goals[move.subtask]
        rows = motion.around(move, 0.1, 0.12)
        if goal.surface is not None:
            places = np.array(motion.places)[rows, move.subtask]
            away = np.linalg.norm(np.array(motion.hands)[rows, hand] - places, axis=1).min()
            if away > TOUCH_TOLERANCE:
                found.append(f"{move.subtask + 1}: {100 * away:.1f} cm")
        elif goal.sites:
            forward = np.array(motion.forward)[rows, hand, 0].max()
            if np.arccos(min(forward, 1.0)) > ANGLE_TOLERANCE:
                found.append(f"{move.subtask + 1}: {np.degrees(np.arccos(forward)):.0f} degrees")
        else:
            wrist = motion.dancer.torso.wrist("rl"[hand])
            turned = np.array(motion.q)[rows, wrist.start]
            wanted = goal.held[4]
            if np.abs(turned - wanted).min() > ANGLE_TOLERANCE:
                found.append(f"{move.subtask + 1}: {np.degrees(turned - wanted).min():.0f} degrees")
    return found
