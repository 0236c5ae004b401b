"""Gait timing: stride rate and duty factor by speed, the gait clock, and smooth motions.

Speeds are compared by their Froude number as fractions of √(g l) for a leg of length l: people
of any size walk alike at equal fractions, and run above about 0.7.

Source: Grieve and Gear 1966 (the stride rate grows with speed to the power 0.57); Alexander 1989
(dynamic similarity; the transition from walking to running); Heglund and Taylor 1988 (runners
lengthen their strides and hardly quicken them).
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.person_record import HIP, STANDING_DUTY, SWING
from pipeline.simulation.dynamics.compiled import Record, compiled, inlined
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.vectors import hypotenuse


@compiled
def spring_step(
    x: float, rate: float, target: float, omega: float, dt: float
) -> tuple[float, float]:
    """Return position and rate of a critically damped spring after `dt`.

    Each sub-step is exact, so the motion never overshoots, and the target may change on the way
    without a jerk.

    Args:
        x: position.
        rate: of x.
        target: where the spring rests.
        omega: settled after about 5/ω [rad/s].
        dt: [s].
    """
    return decayed_step(x, rate, target, omega, dt, math.exp(-omega * dt))


@inlined
def decayed_step(
    x: float, rate: float, target: float, omega: float, dt: float, decay: float
) -> tuple[float, float]:
    """Return what `spring_step` does, of which exp(-ω dt) is known: several springs share it."""
    offset = x - target
    slope = rate + omega * offset
    return target + (offset + slope * dt) * decay, (rate - omega * slope * dt) * decay


STRIDE_RATE = 0.4512  # in √(g / l): 115 steps a minute at 1.4 m/s for an adult leg of 0.91 m
STRIDE_RATE_POWER = 0.57
SLOWEST_FROUDE = 0.15  # below this speed steps get shorter, not rarer
RUN_FROUDE, RUN_BLEND = 0.68, 0.16  # where running starts, and the span of its blend
WALK_BLEND = 0.3  # speed up to which steps in place blend into a walk, in √(g l)
RUN_STRIDE_RATE = 0.395  # of runners, in √(g / l)
EASY_STEP = 0.2  # up or down, in leg lengths, that takes no longer than others
EASY_SWING = 0.19  # height of a swing that takes no longer, in leg lengths: that of runners
RISE_SLOWING, LIFT_SLOWING = 3.2, 2.5  # by a high step; by a high swing
SLOWING_RATE = 14.0  # at which the gait slows for a high step, and quickens after it [1/s]
HIGH_STEP_SLOWING = 2.8  # of the gait by what a step is higher, in leg lengths
USUAL_LAG = 1.15  # of a foot behind its hip at lift-off, in half of what is gone in its stance
LEAST_LAG = 0.5  # that quickens no gait, in leg lengths
HURRY, MOST_HURRY = 6.0, 0.9  # of the gait by what a foot will be farther behind, in leg lengths
STAGGERING = 0.1  # slackness of the muscles of one that is thrown off balance
HURRY_RATE = 25.0  # at which the gait quickens for it, and slows after it [1/s]
LENGTHENING_RATE = 3.0  # at which the stance fraction follows a speed that falls [1/s]
SHORTENING_RATE = 20.0  # the same of one that rises; at once would set a swinging foot back [1/s]


@compiled
def froude(speed: float, leg: float) -> float:
    """Return a speed as a fraction of √(g l)."""
    return speed / math.sqrt(GRAVITY * leg)


@compiled
def smoothstep(x: float) -> float:
    """Return the smoothstep of x clamped to 0 to 1."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@compiled
def run_blend(speed: float, leg: float) -> float:
    """Return the blend from walking to running, 0 to 1."""
    if speed * speed < RUN_FROUDE * RUN_FROUDE * GRAVITY * leg:
        return 0.0
    return smoothstep((froude(speed, leg) - RUN_FROUDE) / RUN_BLEND)


@compiled
def walk_share(speed: float, leg: float) -> float:
    """Return how much of a walk, rather than of steps in place, a speed is, 0 to 1."""
    return smoothstep(froude(speed, leg) / WALK_BLEND)


@compiled
def stride_rate(speed: float, leg: float) -> float:
    """Return the gait cycles per second, two steps each."""
    froude_number = max(froude(speed, leg), SLOWEST_FROUDE)
    running = run_blend(speed, leg)
    rate = (1.0 - running) * STRIDE_RATE * math.pow(froude_number, STRIDE_RATE_POWER) + running * (
        RUN_STRIDE_RATE + 0.03 * (froude_number - RUN_FROUDE)
    )
    return rate * math.sqrt(GRAVITY / leg)


@compiled
def duty_factor(speed: float, leg: float) -> float:
    """Return the stance fraction of a cycle; below one half there is flight."""
    froude_number = froude(speed, leg)
    running = run_blend(speed, leg)
    walk = STANDING_DUTY - 0.21 * min(froude_number, 0.75)
    return (1.0 - running) * walk + running * max(0.46 - 0.09 * froude_number, 0.28)


@compiled
def leg_length(person: Record) -> float:
    """Return the leg length, which is the height of the hips [m]."""
    return person.hip_height


@compiled
def ground_speed(person: Record) -> float:
    """Return the speed over the ground [m/s]."""
    return hypotenuse(person.velocity[0], person.velocity[1])


@compiled
def wrap_angle(angle: float) -> float:
    """Return an angle in (-π, π]."""
    return angle - 2.0 * math.pi * math.ceil((angle - math.pi) / (2.0 * math.pi))


@compiled
def gait_pace(person: Record) -> tuple[float, float]:
    """Return cycles per second and the stance fraction of a cycle."""
    leg = leg_length(person)
    speed = ground_speed(person)
    # In turns and after pushes, steps are as brisk as in a slow walk.
    if speed != person.stride_speed or person.stride_rate == 0.0:
        person.stride_speed, person.stride_rate = speed, stride_rate(speed, leg)
    rate = max(person.stride_rate, 0.29 * math.sqrt(GRAVITY / leg))
    return rate * (1.0 + person.hurry) / (1.0 + person.slowing), person.duty


@compiled
def leg_phase(person: Record, k: int) -> float:
    """Return the phase of a leg in its own cycle: 0 when its foot may leave the ground."""
    return (person.phase + 0.5 * k) % 1.0


@compiled
def heel_offset(person: Record, walking: float) -> float:
    """Return how far the ankle is behind the middle of its stance, by a share of walking [m].

    Weight goes from heel to toes.
    """
    run = run_blend(ground_speed(person), leg_length(person))
    return (0.35 + 0.25 * run) * person.foot * walking


@compiled
def _high_step(person: Record) -> float:
    """Return by how much a foot steps higher than with ease, in leg lengths."""
    rise = lift = 0.0
    for k in range(2):
        if person.foot_state[k] == SWING:
            rise = max(rise, person.step_rise[k])
            lift = max(lift, person.swing_height[k])
    leg = leg_length(person)
    slowing = RISE_SLOWING * (rise / leg - EASY_STEP)
    return max(slowing, LIFT_SLOWING * (lift / leg - EASY_SWING), 0.0)


@inlined
def staggers(person: Record) -> bool:
    """Tell whether a person is thrown off balance, by a push or a blow."""
    result: bool = person.stun > STAGGERING
    return result


@compiled
def foot_lag(person: Record) -> float:
    """Return how much farther from its hip a stance foot will lift off than in a steady walk.

    A person that is pushed off moves at once, and its feet are left behind. In leg lengths.
    """
    if not person.stepping:
        return 0.0
    leg, speed = leg_length(person), ground_speed(person)
    rate, stance = gait_pace(person)
    most = 0.0
    for k in range(2):
        if person.foot_state[k] != SWING:
            x = person.targets[HIP + k, 0] - person.stance_place[k, 0]
            z = person.targets[HIP + k, 2] - person.stance_place[k, 2]
            now = (x * person.velocity[0] + z * person.velocity[1]) / max(speed, 1e-9)
            most = max(most, now + speed * (1.0 - leg_phase(person, k)) / rate)
    usual = USUAL_LAG * 0.5 * stance * speed * (1.0 + person.hurry) / rate
    usual += heel_offset(person, person.walk_blend)
    return max(most - max(usual, LEAST_LAG * leg), 0.0) / leg


@compiled
def follow_duty_factor(person: Record, dt: float) -> None:
    """Let the stance fraction of a cycle follow the speed, and its rate high and belated steps.

    A runner who slows to a walk would otherwise hurry a foot in mid-swing to the end of its way.
    """
    slowing = HIGH_STEP_SLOWING * _high_step(person)
    person.slowing += (slowing - person.slowing) * (1.0 - math.exp(-SLOWING_RATE * dt))
    hurry = min(HURRY * foot_lag(person), MOST_HURRY)
    person.hurry += (hurry - person.hurry) * (1.0 - math.exp(-HURRY_RATE * dt))
    change = duty_factor(ground_speed(person), leg_length(person)) - person.duty
    follow = LENGTHENING_RATE if change > 0.0 else SHORTENING_RATE
    person.duty += change * (1.0 - math.exp(-follow * dt))
