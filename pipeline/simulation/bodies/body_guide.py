"""Body guides: what moves one body in place of physics, and when.

A guided body follows its path, is held by hands, or stays where it was put down; otherwise it is
free, and physics moves it.

Source: Sims 1987, 3.2.1 (parents and children).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from pipeline.simulation.bodies.prop_paths import PropPath
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.kinematic_bodies import Poses, rotation_vectors
from pipeline.simulation.spatial import UP, Array, cross, normalized, rotation

DIFFERENCE_TIME = 1e-6
"""Interval of the difference that gives the velocity of a path [s]."""


class GuideState(Enum):
    """What moves a body."""

    FREE = "physics"
    ON_PATH = "its path, relative to its parent or the world"
    PUT_DOWN = "its parent or the world, relative to which it stays"
    HELD = "the first of the hands that hold it, or the two people that do with both hands"


@dataclass(frozen=True, slots=True)
class AuthoredGrip:
    """An interval during which a hand of the scene holds a body.

    Attributes:
        node: number of the hand's node.
        rows: row in which it is taken, and row in which it is released.
        falls: whether it falls when it is released.
    """

    node: int
    rows: tuple[int, int]
    falls: bool


@dataclass(frozen=True, slots=True)
class Fall:
    """The start of a free fall from a path.

    Attributes:
        time: at which it starts [s].
        row: first row at or after it.
    """

    time: float
    row: int


@dataclass(frozen=True, eq=False)
class Flight:
    """A body shortly after the start of a free fall.

    Attributes:
        X: (4, 4) pose of its node.
        velocity: (6,) of its node, v [m/s] and w in the world [rad/s].
    """

    X: Array
    velocity: Array


@dataclass(eq=False)
class BodyGuide:
    """State of one body that is not always free.

    Attributes:
        body: number of the body.
        path: relative to its parent or the world; None for a body that begins free.
        parent: number of the parent's node, -1 for the world.
        grips: of the scene, in the order of time.
        fall: when it leaves its path; None for never.
        state: what moves it now.
        holds: nodes of each hand that holds it, or of both hands of a person; the first moves it.
        X_HB: (4, 4) pose in the first hand, between the first two, or between two people.
        X_PB: (4, 4) pose relative to the parent where it was put down.
        flight: its free fall in the row in which it leaves its path.
    """

    body: int
    path: PropPath | None
    parent: int = -1
    grips: tuple[AuthoredGrip, ...] = ()
    fall: Fall | None = None
    state: GuideState = GuideState.FREE
    holds: list[tuple[int, ...]] = field(default_factory=list)
    X_HB: Array | None = None
    X_PB: Array | None = None
    flight: Flight | None = None

    def __post_init__(self) -> None:
        if self.path is not None:
            self.state = GuideState.ON_PATH

    @property
    def carrier(self) -> int:
        """Number of the node that it goes with, -1 for the world or none."""
        if self.state is GuideState.FREE:
            return -1
        return self.holds[0][0] if self.state is GuideState.HELD else self.parent

    @property
    def carriers(self) -> set[int]:
        """Numbers of all nodes of the scene that it goes with at some time."""
        return {n for n in (self.parent, *(grip.node for grip in self.grips)) if n >= 0}

    def pose(self, row: int, time: float, nodes: Poses) -> Array:
        """Returns its pose (4, 4) in the world while it is guided.

        Args:
            row: number of the row; does not decrease.
            time: of the row [s].
            nodes: all nodes in that row.
        """
        if self.X_HB is not None:
            return pose_of_holds(nodes, self.holds) @ self.X_HB
        X_WP = np.eye(4) if self.parent < 0 else node_pose(nodes, self.parent)
        if self.X_PB is not None:
            return X_WP @ self.X_PB
        if self.parent < 0 and self.fall is not None and row >= self.fall.row:
            self.flight = self.flight or self._flight(time, self.fall.time)
            return self.flight.X
        assert self.path is not None
        p, R = self.path.at(np.array([time]))
        return X_WP @ pose_matrix(p[0], R[0])

    def _flight(self, time: float, start: float) -> Flight:
        """Returns the motion at `time` of a free fall from the path that began at `start` [s].

        The path is not asked for later times.
        """
        assert self.path is not None
        # A value that jumps at that time has no part in the velocity.
        first = max(start - 2.0 * DIFFERENCE_TIME, 0.0)
        second = first + DIFFERENCE_TIME
        p, R = self.path.at(np.array([first, second, max(start, second)]))
        v = (p[1] - p[0]) / DIFFERENCE_TIME
        w = rotation_vectors(R[1:2] @ R[:1].swapaxes(-1, -2))[0] / DIFFERENCE_TIME
        after, rate = max(time - start, 0.0), float(np.linalg.norm(w))
        drop = np.array([0.0, GRAVITY, 0.0]) * after
        turned = rotation(normalized(w), rate * after) @ R[2]
        X = pose_matrix(p[2] + after * (v - 0.5 * drop), turned)
        return Flight(X, np.concatenate([v - drop, w]))

    # --- changes, in a row that is finished -----------------------------------------------

    def take(self, hands: tuple[int, ...], X_WB: Array, nodes: Poses) -> None:
        """Lets a hand, or both of a person, hold it as it is now."""
        if hands not in self.holds:
            self.holds.append(hands)
        self._hold(X_WB, nodes)

    def release(self, hands: tuple[int, ...], X_WB: Array, nodes: Poses, falls: bool) -> None:
        """Takes it out of these hands; released by the last, it falls or stays there."""
        if hands not in self.holds:
            return
        self.holds.remove(hands)
        if self.holds:
            self._hold(X_WB, nodes)
        elif falls:
            self.set_free()
        else:
            self.state, self.X_HB = GuideState.PUT_DOWN, None
            X_WP = np.eye(4) if self.parent < 0 else node_pose(nodes, self.parent)
            self.X_PB = np.linalg.inv(X_WP) @ X_WB

    def set_free(self) -> None:
        """Leaves it to physics."""
        self.holds.clear()
        self.state, self.X_HB, self.X_PB, self.flight = GuideState.FREE, None, None, None

    def _hold(self, X_WB: Array, nodes: Poses) -> None:
        self.state = GuideState.HELD
        self.X_HB = np.linalg.inv(pose_of_holds(nodes, self.holds)) @ X_WB


def pose_matrix(p: Array, R: Array) -> Array:
    """Returns the pose (4, 4) of a position (3,) [m] and a rotation (3, 3)."""
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, p
    return X


def node_pose(nodes: Poses, node: int) -> Array:
    """Returns the pose (4, 4) of a node."""
    return pose_matrix(nodes.p[node], nodes.R[node])


def pose_of_hands(nodes: Poses, hands: Sequence[int]) -> Array:
    """Returns the pose (4, 4) of a hand, or the upright one in the middle between two hands."""
    if len(hands) == 1:
        return node_pose(nodes, hands[0])
    return _pose_between(*nodes.p[list(hands)])


def pose_of_holds(nodes: Poses, holds: Sequence[tuple[int, ...]]) -> Array:
    """Returns the pose (4, 4) of what moves a body: two people, or the first that holds it."""
    if len(holds) == 2 and all(len(hands) == 2 for hands in holds):
        return _pose_between(*(nodes.p[list(hands)].mean(axis=0) for hands in holds))
    return pose_of_hands(nodes, holds[0])


def _pose_between(left: Array, right: Array) -> Array:
    """Returns the upright pose (4, 4) in the middle between two places (3,) [m]."""
    across = normalized(right - left)
    up = normalized(UP - (UP @ across) * across)
    return pose_matrix(0.5 * (left + right), np.stack([across, up, cross(across, up)], axis=1))
