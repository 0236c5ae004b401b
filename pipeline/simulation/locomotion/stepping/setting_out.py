"""Setting out: creatures that begin to walk, or go on while they brake, leave no foot behind.

Their feet were placed for a body at rest or coming to rest. So bodies go no faster than their
standing feet bear until these lift, and those whose feet have closed up set out just before one
lifts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.foot_placement.step_batch import neutral_positions
from pipeline.simulation.locomotion.routes.route_progress import START_RAMP_CYCLES
from pipeline.simulation.locomotion.routes.speed_forecast import StandingReach
from pipeline.simulation.locomotion.stepping.step_sequencer import StepSequencer
from pipeline.simulation.spatial import Array

# World steps before the first lift-off at which a creature sets out again.
RESTART_LEAD = 2.0

# Part of a stride over which the way of neutral places is taken to be straight.
STRAIGHT_PART = 0.01


def phase_before_lift(sequencer: StepSequencer, c: int, phase: float) -> float:
    """Return the first phase from `phase` on just after which a foot of a creature lifts.

    A creature that sets out then leaves no foot behind.
    """
    up = sequencer.feet.up[sequencer.herd.owner == c]
    if not len(up):
        return phase
    lead = RESTART_LEAD * sequencer.world.clock.dt / float(sequencer.progress.cycle[c])
    return phase + float(np.mod(up - lead - phase, 1.0).min())


def greatest_strides(sequencer: StepSequencer) -> Array | None:
    """Return the greatest parts (C,) of a stride in a cycle at which no foot is left behind.

    They bound creatures that set out, and are infinite for others; None if there are none.
    """
    progress, result = sequencer.progress, None
    over = progress.phase >= progress.resume_phase + START_RAMP_CYCLES
    for c in np.flatnonzero(~over).tolist():
        if result is None:
            result = np.full(len(over), np.inf)
        reach = _standing_reach(sequencer, c)
        phase, distance = float(progress.phase[c]), float(progress.distance[c])
        result[c] = reach.stride_part(phase, distance, float(progress.stride[c]))
    progress.resume_phase = np.where(over, -np.inf, progress.resume_phase)
    return result


def standing_reach(sequencer: StepSequencer, c: int) -> StandingReach | None:
    """Return how far a creature that sets out goes before its feet lift; None if it does not.

    Feet that lift in this step hold nothing back.
    """
    progress, feet = sequencer.progress, sequencer.feet
    if progress.phase[c] >= progress.resume_phase[c] + START_RAMP_CYCLES:
        return None
    lifts_now = ~feet.swinging & (feet.next_lift <= progress.phase[c])
    return _standing_reach(sequencer, c, lifts_now)


def _standing_reach(
    sequencer: StepSequencer, c: int, without: NDArray[np.bool_] | None = None
) -> StandingReach:
    """Return how far a creature goes before its feet lift, but for some legs (L,)."""
    herd, progress, feet = sequencer.herd, sequencer.progress, sequencer.feet
    end = float(progress.resume_phase[c]) + START_RAMP_CYCLES
    trajectory, legs = progress.trajectory, np.flatnonzero(herd.owner == c)
    legs = legs[feet.held_up[1, legs] == 0.0]
    legs = legs if without is None else legs[~without[legs]]
    if not len(legs):
        return StandingReach(np.zeros(0), np.zeros(0), end)
    stride, phase = float(progress.stride[c]), float(progress.phase[c])
    pace, step = progress.paces.last(c), STRAIGHT_PART * stride
    distance = float(progress.distance[c]) + np.repeat([0.0, step], len(legs))
    owner, phases = np.full(len(distance), c), np.full(len(distance), phase)
    R, p = trajectory.pose(owner, distance, phases)
    now, then = np.split(neutral_positions(trajectory, np.tile(legs, 2), phases, R, p), 2)
    way, behind = (then - now) / step, now - feet.end[legs][:, [0, 2]]
    # |behind + way s| = reach, s in metres.
    reach = 0.5 * float(pace.gait.duty.max()) * pace.longest
    a, b = np.maximum((way**2).sum(axis=1), 1e-12), (behind * way).sum(axis=1)
    inside = b * b - a * ((behind**2).sum(axis=1) - reach * reach)
    room = np.maximum((np.sqrt(np.maximum(inside, 0.0)) - b) / a, 0.0)
    lifts = _next_lift(sequencer, c, phase)[legs - herd.first_leg[c]]
    return StandingReach(lifts, float(progress.distance[c]) + room, end)


def _next_lift(sequencer: StepSequencer, c: int, phase: float) -> Array:
    """Return the phases (n,) at which the feet of a creature leave their places, or their next."""
    feet, own = sequencer.feet, sequencer.herd.owner == c
    down = np.where(feet.swinging[own], feet.lift_phase[own] + feet.swing_length[own], phase)
    if c not in feet.changing:
        return down + np.mod(feet.up[own] - down, 1.0)
    paces = sequencer.progress.paces
    return np.array([paces.gait(c, at).next_up(at)[i] for i, at in enumerate(down.tolist())])
