"""Initial stance: places the feet of a herd where they would be had it come walking."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.locomotion.foot_placement.step_batch import StepRequest
from pipeline.simulation.locomotion.foot_state import hold_up, place_foot
from pipeline.simulation.locomotion.gaits.pace_schedule import StepTiming
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.route_progress import set_initial_speed, stand_still
from pipeline.simulation.locomotion.stepping.step_requests import predict_footholds, with_forecast
from pipeline.simulation.locomotion.stepping.step_sequencer import StepSequencer
from pipeline.simulation.locomotion.stepping.step_stops import end_route_before
from pipeline.simulation.locomotion.stepping.taking_steps import lift_foot

ELSEWHERE = (
    "place it elsewhere with `at`, or raise `unsteppable_slope_deg` of the terrain, whose "
    "`show_forbidden: true` shows where no foot may stand"
)
"""What to do about a start without a foothold."""


def place_feet(sequencer: StepSequencer, numbers: Sequence[int]) -> None:
    """Place every foot where it would be if its creature had come walking.

    Args:
        sequencer: of the steps.
        numbers: of the creatures in the cast of the scene.

    Raises:
        SceneError: if a foot has no foothold; names one leg of each such creature.
    """
    herd, feet, progress = sequencer.herd, sequencer.feet, sequencer.progress
    walks = herd.walks[herd.owner]
    _look_ahead_from_start(sequencer, np.flatnonzero(walks).tolist())
    into = np.mod(-herd.up, 1.0)  # cycles since the last foot-up
    in_air = walks & (into < herd.swings)
    # Foot-down phases of the present stance, or of the one before the present swing.
    down = np.where(
        walks, -into + herd.swings - np.where(in_air, 1.0, 0.0), -0.5 * (1.0 - herd.swings)
    )
    requests = [
        with_forecast(sequencer, _initial_request(herd, leg, float(at), float(walks[leg])))
        for leg, at in enumerate(down)
    ]
    sequencer.planner.predict([request for request in requests if request.forecast is None])
    lost: dict[int, int] = {}  # first leg without a foothold, by creature
    for leg, request in enumerate(requests):
        hold = sequencer.planner.predicted(leg) or sequencer.planner.search.find_initial(request)
        if hold is None:
            lost.setdefault(int(herd.owner[leg]), leg)
            continue
        feet.start[leg] = feet.end[leg] = hold.tip
        feet.lowering[:, leg] = hold.lowering
        feet.footholds.append(hold)
    if lost:
        raise SceneError([_no_start(herd, leg, numbers[c]) for c, leg in lost.items()])
    predict_footholds(
        sequencer, [(leg, -float(into[leg])) for leg in np.flatnonzero(in_air).tolist()]
    )
    for leg in range(len(herd.owner)):
        if progress.paces.is_held_up(leg, 0.0):
            hold_up(feet, leg, 0.0)
            feet.held_up[0, leg] = 1.0
        elif in_air[leg]:
            lift_foot(sequencer, 0, leg, -float(into[leg]))
    for c in np.flatnonzero((progress.blocked_at == 0.0) | progress.halted).tolist():
        _stand_from_start(sequencer, c)


def _look_ahead_from_start(sequencer: StepSequencer, legs: Sequence[int]) -> None:
    """End routes before barriers, and slow creatures down that start near one or turn at once."""
    progress = sequencer.progress
    sequencer.lookahead.predict_initial(legs)
    for leg in legs:
        end_route_before(sequencer, 0, leg, sequencer.lookahead.initial_barrier(leg))
    braking = np.maximum(progress.braking_distance, 1e-9)
    rest = [route.distance_to_rest(0.0) for route in progress.trajectory.routes]
    fraction = np.sqrt(np.maximum(np.fmin(progress.blocked_at, rest), 0.0) / braking)
    for c, curve in progress.limits.curves.items():
        fraction[c] = min(fraction[c], curve.at(0.0)[1])
    set_initial_speed(progress, np.minimum(fraction, 1.0))


def _initial_request(herd: Herd, leg: int, down: float, speed_fraction: float = 1.0) -> StepRequest:
    """Return the request of a foot that has been down since the phase `down`."""
    swing = float(herd.swings[leg])
    return StepRequest(leg, 0.0, 0.0, StepTiming(down - swing, swing, 1.0 - swing), speed_fraction)


def _stand_from_start(sequencer: StepSequencer, c: int) -> None:
    """Let a creature that cannot set out stand on all its feet."""
    herd = sequencer.herd
    stand_still(sequencer.progress, c)
    for leg in np.flatnonzero(herd.owner == c).tolist():
        request = _initial_request(herd, leg, -0.5 * (1.0 - float(herd.swings[leg])), 0.0)
        hold = sequencer.planner.search.find_initial(request)
        if hold is not None:
            place_foot(sequencer.feet, leg, hold)


def _no_start(herd: Herd, leg: int, number: int) -> Problem:
    x, z = herd.starts[int(herd.owner[leg])]
    return Problem(
        f"cast[{number}].at",
        f"leg {herd.leg_names[leg]} of '{herd.names[int(herd.owner[leg])]}' finds no foothold "
        f"around its start at [{x:g}, {z:g}]: all is forbidden or out of reach; {ELSEWHERE}",
    )
