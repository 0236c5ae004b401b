"""Taking steps: lifts and places the feet of a herd, in time with its gaits.

A foot that reaches its foot-up phase plans a step, one that reaches its foot-down phase touches the
ground. Where a foot finds no foothold, its creature comes to rest.

Source: Sims 1987, 10.2.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from pipeline.simulation.locomotion.foot_state import hold_up, start_swing
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.routes.route_progress import (
    is_blocked,
)
from pipeline.simulation.locomotion.stepping.step_requests import (
    predict_footholds,
    request_at,
    request_of,
    swings_at,
)
from pipeline.simulation.locomotion.stepping.step_sequencer import StepSequencer
from pipeline.simulation.locomotion.stepping.step_stops import (
    end_route_before,
    halt_creature,
    last_step,
    note_missing,
)
from pipeline.simulation.locomotion.swing.swing_trajectory import QUICKNESS, quickness
from pipeline.simulation.spatial import Array

# Distance of a foot from its neutral place that is closed up, as a fraction of its leg.
CLOSING_DISTANCE = 0.08


def take_steps(sequencer: StepSequencer, step: int, phase_before: Array) -> None:
    """Lift the feet that pass their foot-up phases, put down feet at their foot-down phases.

    Args:
        sequencer: of the herd.
        step: number of the world step.
        phase_before: (C,) of the gaits when it began.
    """
    herd, progress, feet = sequencer.herd, sequencer.progress, sequencer.feet
    phase, before = progress.phase[herd.owner], phase_before[herd.owner]
    _make_contacts(sequencer, step, before, phase)
    up_at = feet.next_lift = _next_foot_up(sequencer, phase_before, before)
    due = np.flatnonzero((~feet.swinging | (feet.held_up[1] > 0.0)) & (up_at < phase))
    if not len(due):
        return
    owner = herd.owner[due]
    may_lift = ~progress.halted[owner] & herd.walks[owner]
    if progress.can_rest:
        rests = zip(due.tolist(), progress.arrived[owner], strict=True)
        may_lift &= [not rest or is_astray(sequencer, leg) for leg, rest in rests]
    lifting = [(leg, float(up_at[leg])) for leg in due[may_lift].tolist()]
    predict_footholds(sequencer, lifting, with_upcoming=True)
    for leg, up in _stuck_first(sequencer, lifting):
        _foot_up(sequencer, step, leg, up)


def _make_contacts(sequencer: StepSequencer, step: int, before: Array, phase: Array) -> None:
    """Note scuffs and touchdowns of feet between two phases (L,)."""
    feet, contacts = sequencer.feet, sequencer.contacts
    span = phase - before
    rate = span / sequencer.world.clock.dt
    for leg in contacts.scuffs.due(before, phase).tolist():
        fraction = (contacts.scuffs.phase[leg] - before[leg]) / span[leg]
        contacts.scuff((step, float(fraction)), leg, float(rate[leg]))
    down_at = feet.lift_phase + feet.swing_length
    down = feet.swinging & ~(feet.held_up[1] > 0.0) & (down_at <= phase)
    for leg in np.flatnonzero(down).tolist():
        fraction = float((down_at[leg] - before[leg]) / span[leg])
        feet.swinging[leg] = False
        length = feet.swing_length[leg]
        time = sequencer.progress.cycle[sequencer.herd.owner[leg]] * float(length)
        # Quick feet end their swings at a higher rate.
        time /= 1.0 + QUICKNESS * float(quickness(length))
        swing = feet.start[leg], float(feet.swing_height[leg]), feet.bend_of(leg)
        timing = float(time), float(rate[leg])
        contacts.touch((step, fraction), leg, feet.footholds[leg], swing, timing)


def _next_foot_up(sequencer: StepSequencer, phase_before: Array, before: Array) -> Array:
    """Return the phases (L,) of the first foot-up since the step's start, at (C,) and (L,)."""
    feet, progress = sequencer.feet, sequencer.progress
    up_at: Array = before + np.mod(feet.up - before, 1.0)
    for c in sorted(feet.changing):
        own, phase = sequencer.herd.owner == c, float(phase_before[c])
        gait = progress.paces.gait(c, phase)
        up_at[own] = gait.next_up(phase)
        if isinstance(gait, Gait) and c not in progress.transition_ends:
            feet.changing.remove(c)
            feet.up[own] = gait.up
    return up_at


def _stuck_first(
    sequencer: StepSequencer, lifting: list[tuple[int, float]]
) -> list[tuple[int, float]]:
    """Sort legs without a foothold first: others that would lift with them then stay down."""
    owners = [int(sequencer.herd.owner[leg]) for leg, _ in lifting]
    if len(set(owners)) == len(owners):
        return lifting
    free = []
    for leg, phase in lifting:
        request = partial(request_of, sequencer, leg, phase)
        is_stuck = (
            swings_at(sequencer, leg, phase)
            and sequencer.planner.next_foothold(leg, request) is None
        )
        free.append(not is_stuck)
    return [lifting[i] for i in np.argsort(free, kind="stable")]


def _foot_up(sequencer: StepSequencer, step: int, leg: int, phase: float) -> None:
    """Lift a foot at `phase`, to come down again or to be held up."""
    feet, stays_up = sequencer.feet, sequencer.progress.paces.is_held_up(leg, phase)
    if feet.held_up[1, leg] == 0.0:
        if stays_up:
            hold_up(feet, leg, phase)
        else:
            lift_foot(sequencer, step, leg, phase)
    elif not stays_up:
        # It comes down from about its neutral place.
        distance = float(sequencer.progress.distance[sequencer.herd.owner[leg]])
        search = sequencer.planner.search
        xz = search.neutral_place(leg, distance, phase)
        feet.end[leg] = search.tip_positions(np.array([leg]), xz[None, None])[0, 0]
        lift_foot(sequencer, step, leg, phase)
        if feet.lift_phase[leg] == phase:
            feet.held_up[:, leg] = 1.0, 0.0


def lift_foot(sequencer: StepSequencer, step: int, leg: int, phase: float) -> None:
    """Plan the swing of a foot that lifts at `phase`; halt its creature if it has nowhere to go."""
    herd, progress, feet = sequencer.herd, sequencer.progress, sequencer.feet
    owner = int(herd.owner[leg])
    if progress.halted[owner]:
        return
    if sequencer.planner.predicted(leg) is None:
        request = request_of(sequencer, leg, phase)
    else:
        request = request_at(sequencer, leg, phase, progress.sample)
    hold = sequencer.planner.next_foothold(leg, lambda: request)
    if hold is None and progress.steps and not progress.arrived[owner]:
        request, hold = last_step(sequencer, step, request)
    if hold is None:
        # A blocked creature rests as soon as it can, and has been noted already.
        noted = is_blocked(progress, owner)
        if not noted or not progress.arrived[owner]:
            halt_creature(sequencer, owner)
        if not noted:
            note_missing(sequencer, step, request)
        return
    timing = request.timing
    start_swing(feet, leg, hold, phase)
    if hold.lowering > 0.0:
        # Feet that lift now as well were searched for a higher body.
        sequencer.planner.forget(owner)
    step_height = float(progress.paces.number("step_height", owner, np.array(phase)))
    if sequencer.swings is not None and feet.bend is not None:
        planned = sequencer.swings.plan(request, hold, step_height, feet.lowering[1])
        feet.swing_height[leg], feet.bend[leg] = planned
    feet.lift_phase[leg], feet.swing_length[leg] = phase, timing.swing
    feet.swinging[leg] = True
    heights = float(feet.swing_height[leg]), step_height
    sequencer.contacts.scuffs.plan(
        leg, timing, feet.start[leg], hold.tip, heights, feet.bend_of(leg)
    )
    barrier = sequencer.lookahead.next_barrier(leg, request.distance, phase)
    end_route_before(sequencer, step, leg, barrier)


def is_astray(sequencer: StepSequencer, leg: int) -> bool:
    """Return whether a foot of a body at rest is off its neutral place."""
    progress, owner = sequencer.progress, sequencer.herd.owner[leg]
    distance, phase = float(progress.distance[owner]), float(progress.phase[owner])
    neutral = sequencer.planner.search.neutral_place(leg, distance, phase)
    gap = np.linalg.norm(sequencer.feet.end[leg, [0, 2]] - neutral)
    return bool(gap > CLOSING_DISTANCE * sequencer.herd.legs.lengths[leg])
