"""Stops: creatures that find no foothold come to rest.

Source: Sims 1987, 10.2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.foot_placement.barrier_lookahead import Barrier
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.foot_placement.step_batch import StepRequest
from pipeline.simulation.locomotion.gaits.stride_limits import MAX_REACH
from pipeline.simulation.locomotion.routes.route_progress import (
    RouteProgress,
    halt,
    is_blocked,
    redirect,
    stop_within,
    stopping_range,
)
from pipeline.simulation.locomotion.stepping.step_requests import request_of
from pipeline.simulation.locomotion.stepping.step_sequencer import StepSequencer
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.take import TakeNote

# Resting places tried between the shortest and the longest stopping distance.
STOP_CANDIDATES = 13


def last_step(
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
        note_missing(sequencer, step, request)
        sequencer.planner.forget(c)
    request = request_of(sequencer, leg, request.phase)
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
        harder = request_of(sequencer, leg, request.phase)
        hold = sequencer.planner.search.find(harder, any_swing=True)
        if hold is not None:
            sequencer.planner.forget(c)
            return harder, hold
    redirect(progress, c, route)
    progress.blocked_at[c] = route.length
    return request, None


def note_missing(sequencer: StepSequencer, step: int, request: StepRequest) -> None:
    """Note that a foot has no foothold."""
    herd, feet, leg = sequencer.herd, sequencer.feet, request.leg
    name = f"{herd.names[int(herd.owner[leg])]}.{herd.leg_names[leg]}"
    x, _, z = feet.start[leg] if request.present is None else request.present
    text = f"no foothold within reach, at [{x:.2f}, {z:.2f}]"
    sequencer.notes.append(TakeNote("stopped", step, name, text))


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


def halt_creature(sequencer: StepSequencer, c: int) -> None:
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
