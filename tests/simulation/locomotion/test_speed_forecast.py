"""Forecasts of creatures that speed up, slow down in curves, turn in place and come to rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from pipeline.simulation.locomotion.routes.speed_forecast import HORIZON, speed_forecast
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.simulate import Simulation

if TYPE_CHECKING:
    from pipeline.spec import Scene

    SceneOf = Callable[..., Scene]

WAYS = {
    "comes to rest": "path: [[1.6, 0]]",
    "curve": "path: [[0.8, 0], [0.9, 0.7]]",
    "turns in place": "path: [[0.8, 0], [0, 0.1]]",
}


@pytest.mark.parametrize("way", list(WAYS))
def test_creatures_go_as_forecast(scene_of: SceneOf, way: str) -> None:
    member = f"{{figure: spider, at: [0, 0], heading_deg: 0, walk: {{{WAYS[way]}}}}}"
    simulation = Simulation(scene_of(member, duration=6))
    troupe = simulation.troupes[0]
    assert isinstance(troupe, WalkerTroupe)
    progress, changed = troupe.progress, 0
    while not simulation.finished and not progress.arrived[0]:
        forecast = speed_forecast(progress, 0)
        ahead = []
        for _ in range(12):
            if simulation.finished:
                break
            simulation.step()
            ahead.append([float(values[0]) for values in progress.sample])
        distance, phase, fraction = np.array(ahead).T
        within = phase < forecast.phases[0] + HORIZON
        np.testing.assert_allclose(forecast.distance(phase)[within], distance[within], atol=1e-6)
        changed += np.ptp(fraction) > 0.05
    assert changed > 1


def test_forecasts_go_back_to_the_beginning_of_a_step(scene_of: SceneOf) -> None:
    member = "{figure: spider, at: [0, 0], walk: {path: [[5, 0]]}}"
    simulation = Simulation(scene_of(member, duration=2))
    troupe = simulation.troupes[0]
    assert isinstance(troupe, WalkerTroupe)
    for _ in range(20):
        simulation.step()
    before = [float(values[0]) for values in troupe.progress.sample]
    simulation.step()
    found = speed_forecast(troupe.progress, 0).distance(np.array(before[1]))
    assert found == pytest.approx(before[0], abs=1e-9)
