"""Step sequencer: lifts and places the feet of a herd, in time with its gaits.

A foot that reaches its foot-up phase plans a step, one that reaches its foot-down phase touches the
ground. Where a foot finds no foothold, its creature comes to rest.

Source: Sims 1987, 10.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.foot_placement.barrier_lookahead import (
    Barrier,
    BarrierLookahead,
)
from pipeline.simulation.locomotion.foot_placement.foothold_planner import FootholdPlanner
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.foot_placement.step_batch import StepRequest
from pipeline.simulation.locomotion.foot_state import FootState, hold_up, start_swing
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.stride_limits import MAX_REACH
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.locomotion.routes.route_progress import (
    ProgressSample,
    RouteProgress,
    halt,
    is_blocked,
    redirect,
    stop_within,
    stopping_range,
)
from pipeline.simulation.locomotion.routes.speed_control import predicted
from pipeline.simulation.locomotion.routes.speed_forecast import SpeedForecast, speed_forecast
from pipeline.simulation.locomotion.swing.foot_contacts import FootContacts
from pipeline.simulation.locomotion.swing.swing_planner import SwingPlanner
from pipeline.simulation.locomotion.swing.swing_trajectory import QUICKNESS, quickness
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.take import TakeNote
from pipeline.simulation.troupe import World

# Strides in which a foot has done its step and stood.
STEP_STRIDES = 2.5

# Change of the speed fraction that counts as none.
EVEN_SPEED = 0.1

# Distance of a foot from its neutral place that is closed up, as a fraction of its leg.
CLOSING_DISTANCE = 0.08

# Resting places tried between the shortest and the longest stopping distance.
STOP_CANDIDATES = 13


@dataclass(frozen=True, eq=False)
class StepSequencer:
    """The feet of a herd and the planners of their steps.

    Attributes:
        world, herd: their constants.
        progress: of the creatures on their routes.
        feet: where they are.
        planner: chooses footholds.
        lookahead: finds barriers.
        swings: plans swings, None if all are plain arches.
        contacts: of the feet with the ground.
        notes: about the last step.
        forecasts: last ones, by creature, with their steps and routes.
    """

    world: World
    herd: Herd
    progress: RouteProgress
    feet: FootState
    planner: FootholdPlanner
    lookahead: BarrierLookahead
    swings: SwingPlanner | None
    contacts: FootContacts
    notes: list[TakeNote] = field(default_factory=list)
    forecasts: dict[int, tuple[tuple[int, Route], SpeedForecast]] = field(default_factory=dict)

    @staticmethod
    def of(
        world: World, progress: RouteProgress, swings: SwingPlanner | None, contacts: FootContacts
    ) -> StepSequencer:
        """Prepare the steps of a herd; its feet are not placed yet."""
        herd = progress.herd
        planner = FootholdPlanner(herd, world.ground, progress.trajectory)
        lookahead = BarrierLookahead(planner.search, progress)
        feet = FootState.of(herd, None if swings is None else swings.no_bends)
        return StepSequencer(world, herd, progress, feet, planner, lookahead, swings, contacts)


# --- one step -----------------------------------------------------------------------


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
        request = partial(_request, sequencer, leg, phase)
        is_stuck = (
            _swings_at(sequencer, leg, phase)
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
        request = _request(sequencer, leg, phase)
    else:
        request = _request_at(sequencer, leg, phase, progress.sample)
    hold = sequencer.planner.next_foothold(leg, lambda: request)
    if hold is None and progress.steps and not progress.arrived[owner]:
        request, hold = _last_step(sequencer, step, request)
    if hold is None:
        # A blocked creature rests as soon as it can, and has been noted already.
        noted = is_blocked(progress, owner)
        if not noted or not progress.arrived[owner]:
            _halt(sequencer, owner)
        if not noted:
            _note_missing(sequencer, step, request)
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


def _last_step(
    sequencer: StepSequencer, step: int, request: StepRequest
) -> tuple[StepRequest, Foothold | None]:
    """Let a creature brake whose foot has no foothold, and return how the foot steps until then.

    A slow creature comes to rest above its feet at once, and the foot stays where it is: None.
    """
    progress, leg = sequencer.progress, request.leg
    c = int(sequencer.herd.owner[leg])
    own = sequencer.herd.owner == c
    if _least_beyond(sequencer, c, _halting_rooms(progress, c), own)[1] <= 0.0:
        return request, None
    route, fraction = progress.trajectory.routes[c], float(progress.speed_fraction[c])
    braking = float(progress.braking_distance[c]) * fraction * fraction
    rooms = braking + float(progress.stride[c]) * np.linspace(0.0, 1.0, STOP_CANDIDATES)
    # A barrier farther ahead is not reached.
    if not is_blocked(progress, c) or route.length - float(progress.distance[c]) > rooms[-1]:
        # Feet in the air come down where they were to.
        room, _ = _least_beyond(sequencer, c, rooms, own & sequencer.feet.swinging)
        end = min(float(progress.distance[c]) + room, route.length)
        progress.blocked_at[c] = end
        redirect(progress, c, route.upto(end))
        _note_missing(sequencer, step, request)
        sequencer.planner.forget(c)
    request = _request(sequencer, leg, request.phase)
    hold = sequencer.planner.search.find(request, any_swing=True)
    if hold is None:
        return _step_of_hard_stop(sequencer, request)
    return request, hold


def _step_of_hard_stop(
    sequencer: StepSequencer, request: StepRequest
) -> tuple[StepRequest, Foothold | None]:
    """Let a creature brake so hard that a foot finds a foothold, and return how it steps then.

    It keeps its route if there is no such place.
    """
    progress, leg = sequencer.progress, request.leg
    c = int(sequencer.herd.owner[leg])
    route, distance = progress.trajectory.routes[c], float(progress.distance[c])
    hardest, usual = stopping_range(progress, c)[0], route.length - distance
    for room in np.linspace(usual, hardest, STOP_CANDIDATES).tolist()[1:]:
        stop_within(progress, c, room)
        harder = _request(sequencer, leg, request.phase)
        hold = sequencer.planner.search.find(harder, any_swing=True)
        if hold is not None:
            sequencer.planner.forget(c)
            return harder, hold
    redirect(progress, c, route)
    progress.blocked_at[c] = route.length
    return request, None


def _note_missing(sequencer: StepSequencer, step: int, request: StepRequest) -> None:
    """Note that a foot has no foothold."""
    herd, feet, leg = sequencer.herd, sequencer.feet, request.leg
    name = f"{herd.names[int(herd.owner[leg])]}.{herd.leg_names[leg]}"
    x, _, z = feet.start[leg] if request.present is None else request.present
    text = f"no foothold within reach, at [{x:.2f}, {z:.2f}]"
    sequencer.notes.append(TakeNote("stopped", step, name, text))


# --- requests for footholds -----------------------------------------------------------


def predict_footholds(
    sequencer: StepSequencer, lifting: Sequence[tuple[int, float]], with_upcoming: bool = False
) -> None:
    """Predict the footholds of legs that go up at their phases, and of those that soon will."""
    now = sequencer.progress.sample
    requests = [
        _request_at(sequencer, leg, phase, now)
        for leg, phase in lifting
        if _swings_at(sequencer, leg, phase)
    ]
    upcoming = cache(lambda: _upcoming(sequencer) if with_upcoming else [])
    sequencer.planner.predict(
        [r for r in requests if _is_steady(sequencer, r)],
        lambda: [r for r in upcoming() if _is_steady(sequencer, r)],
    )
    sequencer.lookahead.predict(requests, upcoming=upcoming)


def _upcoming(sequencer: StepSequencer) -> list[StepRequest]:
    """Return the requests of the next few steps if all creatures go on as they do."""
    herd, feet, requests = sequencer.herd, sequencer.feet, list[StepRequest]()
    before = sequencer.progress.phase[herd.owner]
    for sample in predicted(sequencer.progress):
        phase = sample.phase[herd.owner]
        up_at = before + np.mod(feet.up - before, 1.0)
        for leg in np.flatnonzero(up_at < phase).tolist():
            if _swings_at(sequencer, leg, float(up_at[leg])):
                requests.append(_request_at(sequencer, leg, float(up_at[leg]), sample))
        before = phase
    return requests


def _swings_at(sequencer: StepSequencer, leg: int, phase: float) -> bool:
    """Return whether a leg that goes up at `phase` swings from one foothold to the next."""
    is_down = sequencer.feet.held_up[1, leg] == 0.0
    return bool(is_down and not sequencer.progress.paces.is_held_up(leg, phase))


def _is_steady(sequencer: StepSequencer, request: StepRequest) -> bool:
    """Return whether a body is not lowered and keeps its speed while a foot steps."""
    herd, c = sequencer.herd, int(sequencer.herd.owner[request.leg])
    first = int(herd.first_leg[c])
    own = slice(first, first + len(herd.paces[c].held))
    lowered = sequencer.feet.lowering[:, own].any()
    return not lowered and _keeps_speed(sequencer, request)


def _keeps_speed(sequencer: StepSequencer, request: StepRequest) -> bool:
    """Return whether a body keeps its speed, but for slopes, while a foot steps."""
    progress, c = sequencer.progress, int(sequencer.herd.owner[request.leg])
    if float(progress.limits.target[c]) - request.speed_fraction > EVEN_SPEED:
        return False
    needed = progress.braking_room(c) + STEP_STRIDES * float(progress.stride[c])
    if progress.trajectory.routes[c].distance_to_rest(request.distance) <= needed:
        return False
    curve = progress.limits.curves.get(c)
    here = request.distance - float(progress.stride[c])
    return curve is None or not curve.bind(here, request.distance + needed)


def _request_at(
    sequencer: StepSequencer, leg: int, phase: float, sample: ProgressSample
) -> StepRequest:
    """Return the request of a foot that lifts at `phase`, in the step that ends at `sample`."""
    paces, c = sequencer.progress.paces, int(sequencer.herd.owner[leg])
    fraction = float(sample.speed_fraction[c])
    back = paces.distance(c, float(sample.phase[c]), phase)
    distance = float(sample.distance[c] + back * math.sqrt(fraction))
    present = sequencer.feet.end[leg].copy()
    return StepRequest(leg, distance, phase, paces.step(leg, phase), fraction, present)


def _request(sequencer: StepSequencer, leg: int, phase: float) -> StepRequest:
    """Return the request of a foot that lifts in this step, with changes of speed and lowering."""
    progress, feet, owner = sequencer.progress, sequencer.feet, int(sequencer.herd.owner[leg])
    request = _request_at(sequencer, leg, phase, progress.sample)
    request = with_forecast(sequencer, request)
    others: NDArray[np.bool_] = sequencer.herd.owner == owner
    others[leg] = False
    lowering = float(feet.lowering[1, leg]), float(feet.lowering[:, others].max(initial=0.0))
    # Legs far apart from this one may stand on other ground.
    distance, now = np.array([request.distance]), np.array([phase])
    R, p = progress.trajectory.pose(np.array([owner]), distance, now)
    down = np.flatnonzero(others & (feet.held_up[1] == 0.0))
    room = sequencer.planner.search.lowering_room(down, feet.end[down], R[0], p[0])
    return replace(request, lowering=lowering, room=room)


def with_forecast(sequencer: StepSequencer, request: StepRequest) -> StepRequest:
    """Return a request of this step, with a forecast if the speed of its body changes."""
    if _keeps_speed(sequencer, request):
        return request
    progress, c = sequencer.progress, int(sequencer.herd.owner[request.leg])
    now = progress.steps, progress.trajectory.routes[c]
    known = sequencer.forecasts.get(c)
    if known is None or known[0] != now:
        known = sequencer.forecasts[c] = now, speed_forecast(progress, c)
    forecast = known[1]
    distance = float(forecast.distance(np.array(request.phase)))
    return replace(request, distance=distance, forecast=forecast)


# --- rest ---------------------------------------------------------------------------


def is_astray(sequencer: StepSequencer, leg: int) -> bool:
    """Return whether a foot of a body at rest is off its neutral place."""
    progress, owner = sequencer.progress, sequencer.herd.owner[leg]
    distance, phase = float(progress.distance[owner]), float(progress.phase[owner])
    neutral = sequencer.planner.search.neutral_place(leg, distance, phase)
    gap = np.linalg.norm(sequencer.feet.end[leg, [0, 2]] - neutral)
    return bool(gap > CLOSING_DISTANCE * sequencer.herd.legs.lengths[leg])


def end_route_before(
    sequencer: StepSequencer, step: int, leg: int, barrier: Barrier | None
) -> None:
    """End the route of a leg's creature before a barrier."""
    progress, c = sequencer.progress, int(sequencer.herd.owner[leg])
    route = progress.trajectory.routes[c]
    if barrier is None or barrier.distance >= route.length:
        return
    noted = is_blocked(progress, c)
    progress.blocked_at[c] = barrier.distance
    redirect(progress, c, route.upto(barrier.distance))
    if not noted:
        name = f"{sequencer.herd.names[c]}.{sequencer.herd.leg_names[leg]}"
        ((x, z),), _ = route.at(np.array([barrier.distance]))
        text = f"{barrier.cause}, at [{x:.2f}, {z:.2f}]"
        sequencer.notes.append(TakeNote("stopped", step, name, text))


def _halt(sequencer: StepSequencer, c: int) -> None:
    """Bring a creature without foothold to rest where its feet still reach the ground.

    Where they cannot, at the distance at which they are the least out of reach.
    """
    progress = sequencer.progress
    own, rooms = sequencer.herd.owner == c, _halting_rooms(progress, c)
    halt(progress, c, _least_beyond(sequencer, c, rooms, own)[0])


def _halting_rooms(progress: RouteProgress, c: int) -> Array:
    """Return distances in which a creature comes to rest that lifts no foot any more [m]."""
    nearest, farthest = stopping_range(progress, c)
    return np.linspace(farthest, nearest, STOP_CANDIDATES if farthest > nearest else 1)


def _least_beyond(
    sequencer: StepSequencer, c: int, rooms: Array, legs: NDArray[np.bool_]
) -> tuple[float, float]:
    """Return the first distance at which feet are the least beyond their reach.

    Also returns by how much they are, in leg lengths.

    Args:
        sequencer: of the herd.
        c: number of the creature.
        rooms: (n,) distances from here to where it rests [m].
        legs: (L,) those whose feet are to reach the ground where they are, or will come down.
    """
    herd, progress = sequencer.herd, sequencer.progress
    creature = np.full(len(rooms), c)
    phase = np.full(len(rooms), float(progress.phase[c]))
    R, p = progress.trajectory.pose(creature, float(progress.distance[c]) + rooms, phase)
    # Bodies are as low as their feet need them.
    p[:, 1] -= sequencer.feet.lowering[1, herd.owner == c].max(initial=0.0)
    hips = p[:, None] + turn(R[:, None], herd.hips[legs])
    far = np.linalg.norm(sequencer.feet.end[legs] - hips, axis=-1) / herd.legs.lengths[legs]
    beyond = np.maximum(far - MAX_REACH, 0.0).max(axis=1, initial=0.0)
    best = int(np.argmin(beyond))
    return float(rooms[best]), float(beyond[best])
