"""Distance, height and speed of a jump: two of them determine the third.

A mass that leaves the ground at speed v, rises by h and returns to its height after a distance d
has

    v_y² = 2 g h,   d = v_x · 2 √(2 h / g),   so   v² = g d² / (8 h) + 2 g h.

In h this is 2 g h² - v² h + g d² / 8 = 0, which has a solution only if v² ≥ g d.

Source: Sims 1987, 9.1; (11.13) to (11.15) with |g| for g, and Δt_{f/2} for Δt in (11.15).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.spec.creature import Pronk

SPEED_TOLERANCE = 1e-3
"""Relative difference between a given speed and the formula's that counts as rounding."""

DEFAULT_DISTANCE, DEFAULT_HEIGHT = 1.15, 0.4
"""Default distance and height of a jump, in heights of the creature on stretched legs."""

DEFAULT_ELEVATION = math.radians(52.0)
"""Take-off angle where only the speed is given [rad]."""

FORMULA = "speed² = g distance² / (8 height) + 2 g height"


@dataclass(frozen=True, slots=True)
class Jump:
    """A jump over level ground.

    Attributes:
        distance: from lift-off until the body is back at that height [m].
        height: of the apex above the lift-off [m].
    """

    distance: float
    height: float

    @property
    def up(self) -> float:
        """Upward speed at lift-off [m/s]."""
        return math.sqrt(2.0 * GRAVITY * self.height)

    @property
    def forward(self) -> float:
        """Horizontal speed [m/s]."""
        return 0.5 * self.distance / math.sqrt(2.0 * self.height / GRAVITY)

    @property
    def speed(self) -> float:
        """Speed at lift-off [m/s]."""
        return math.hypot(self.up, self.forward)


def resolve_jump(where: str, config: Pronk, leg_height: float) -> Jump:
    """Return the jump of a `pronk` block; defaults and the formula supply what it leaves open.

    Args:
        where: path of the block in the scene.
        config: the block.
        leg_height: height of the creature on stretched legs [m].

    Raises:
        SceneError: the values contradict each other.
    """
    d, h, v = config.distance, config.height, config.speed
    if v is None:
        distance = DEFAULT_DISTANCE * leg_height if d is None else d
        return Jump(distance, DEFAULT_HEIGHT * leg_height if h is None else h)
    if d is not None and h is not None:
        right = Jump(d, h).speed
        if abs(right - v) > SPEED_TOLERANCE * right:
            raise SceneError([_contradiction_problem(where, d, h, v)])
        return Jump(d, h)
    if h is not None:
        return Jump(_resolve_distance(where, h, v), h)
    if d is None:
        d, h = (
            v * v * math.sin(2.0 * DEFAULT_ELEVATION) / GRAVITY,
            (v * math.sin(DEFAULT_ELEVATION)) ** 2 / (2 * GRAVITY),
        )
        return Jump(d, h)
    return Jump(d, _resolve_height(where, d, v))


def jump_heights(distance: float, speed: float) -> tuple[float, float]:
    """Return the lower and the higher jump with a distance and a speed [m].

    Raises:
        ValueError: the speed is too low for the distance.
    """
    square = speed * speed
    room = square * square - (GRAVITY * distance) ** 2
    if room < 0.0:
        raise ValueError("too slow for the distance")
    high = (square + math.sqrt(room)) / (4.0 * GRAVITY)
    # The product of both roots is d² / 16; their difference would lose digits.
    return distance * distance / (16.0 * high), high


def _resolve_height(where: str, d: float, v: float) -> float:
    try:
        low, high = jump_heights(d, v)
    except ValueError:
        message = (
            f"{FORMULA} has a height only if speed² ≥ g distance, but {v:g}² = {v * v:.4g} is less "
            f"than {GRAVITY:g} × {d:g} = {GRAVITY * d:.4g}; take speed: "
            f"{round_up(math.sqrt(GRAVITY * d))} or more, or distance: "
            f"{round_down(v * v / GRAVITY)} or less"
        )
        raise SceneError([Problem(f"{where}.speed", message)]) from None
    return low if low > 0.0 else high


def _resolve_distance(where: str, h: float, v: float) -> float:
    room = v * v - 2.0 * GRAVITY * h
    if room < -SPEED_TOLERANCE * v * v:
        message = (
            f"{FORMULA} has a distance only if speed² ≥ 2 g height, but {v:g}² = {v * v:.4g} is "
            f"less than 2 × {GRAVITY:g} × {h:g} = {2 * GRAVITY * h:.4g}; take speed: "
            f"{round_up(math.sqrt(2 * GRAVITY * h))} or more, or height: "
            f"{round_down(v * v / (2 * GRAVITY))} or less"
        )
        raise SceneError([Problem(f"{where}.speed", message)])
    return math.sqrt(8.0 * h * max(room, 0.0) / GRAVITY)


def _contradiction_problem(where: str, d: float, h: float, v: float) -> Problem:
    values, removable = [f"speed: {Jump(d, h).speed:.6g}"], ["speed"]
    room = v * v - 2.0 * GRAVITY * h
    if room >= 0.0:
        values.append(f"distance: {math.sqrt(8.0 * h * room / GRAVITY):.6g}")
        removable.append("distance")
    if v * v >= GRAVITY * d:
        values += [f"height: {height:.6g}" for height in jump_heights(d, v) if height > 0.0]
        removable.append("height")
    message = (
        f"{FORMULA}, but with distance {d:g} and height {h:g} that is {Jump(d, h).speed:.6g}², not "
        f"{v:g}²; leave out {' or '.join(removable)}, or take {', or '.join(values)}"
    )
    return Problem(f"{where}.speed", message)


def round_up(value: float) -> str:
    """Return `value` rounded up to four digits."""
    step = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f"{math.ceil(value / step - 1e-9) * step:.4g}"


def round_down(value: float) -> str:
    """Return `value` rounded down to four digits."""
    step = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f"{math.floor(value / step + 1e-9) * step:.4g}"
