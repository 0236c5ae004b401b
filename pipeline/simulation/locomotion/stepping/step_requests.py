"""Step requests: where feet are, how fast bodies go, and how low they are, when feet lift."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.foot_placement.step_batch import StepRequest
from pipeline.simulation.locomotion.routes.route_progress import (
    ProgressSample,
)
from pipeline.simulation.locomotion.routes.speed_control import predicted
from pipeline.simulation.locomotion.routes.speed_forecast import speed_forecast
from pipeline.simulation.locomotion.stepping.setting_out import standing_reach
from pipeline.simulation.locomotion.stepping.step_sequencer import StepSequencer

# Strides in which a foot has done its step and stood.
STEP_STRIDES = 2.5

# Change of the speed fraction that counts as none.
EVEN_SPEED = 0.1


def predict_footholds(
    sequencer: StepSequencer, lifting: Sequence[tuple[int, float]], with_upcoming: bool = False
) -> None:
    """Predict the footholds of legs that go up at their phases, and of those that soon will."""
    now = sequencer.progress.sample
    requests = [
        request_at(sequencer, leg, phase, now)
        for leg, phase in lifting
        if swings_at(sequencer, leg, phase)
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
            if swings_at(sequencer, leg, float(up_at[leg])):
                requests.append(request_at(sequencer, leg, float(up_at[leg]), sample))
        before = phase
    return requests


def swings_at(sequencer: StepSequencer, leg: int, phase: float) -> bool:
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


def request_at(
    sequencer: StepSequencer, leg: int, phase: float, sample: ProgressSample
) -> StepRequest:
    """Return the request of a foot that lifts at `phase`, in the step that ends at `sample`."""
    paces, c = sequencer.progress.paces, int(sequencer.herd.owner[leg])
    fraction = float(sample.speed_fraction[c])
    back = paces.distance(c, float(sample.phase[c]), phase)
    distance = float(sample.distance[c] + back * math.sqrt(fraction))
    present = sequencer.feet.end[leg].copy()
    return StepRequest(leg, distance, phase, paces.step(leg, phase), fraction, present)


def request_of(sequencer: StepSequencer, leg: int, phase: float) -> StepRequest:
    """Return the request of a foot that lifts in this step, with changes of speed and lowering."""
    progress, feet, owner = sequencer.progress, sequencer.feet, int(sequencer.herd.owner[leg])
    request = request_at(sequencer, leg, phase, progress.sample)
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
        forecast = speed_forecast(progress, c, standing_reach(sequencer, c))
        known = sequencer.forecasts[c] = now, forecast
    forecast = known[1]
    distance = float(forecast.distance(np.array(request.phase)))
    return replace(request, distance=distance, forecast=forecast)
