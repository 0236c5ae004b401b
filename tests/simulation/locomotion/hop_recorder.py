"""Simulations of hoppers with a record of every step."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.locomotion.pronking.hop_events import HopEvent
from pipeline.simulation.locomotion.pronking.hop_simulation import HopSimulation
from pipeline.simulation.locomotion.pronking.hop_state import level_height
from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from tests.simulation.conftest import tips_of


@dataclass
class HopperState:
    """One hopper at one step."""

    time: float
    phase: str
    jumps: int
    p: np.ndarray
    v: np.ndarray
    height: float
    tilt: float
    down: np.ndarray
    forces: np.ndarray


@dataclass
class HopRecording:
    """A simulation and the state of its hoppers at every step."""

    simulation: Simulation
    states: list[list[HopperState]] = field(default_factory=list)
    events: list[list[HopEvent]] = field(default_factory=list)
    _lifts: dict[int, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)

    @property
    def troupe(self) -> HopperTroupe:
        """The troupe of hoppers."""
        return next(t for t in self.simulation.troupes if isinstance(t, HopperTroupe))

    def record_step(self) -> None:
        """Record the state of this step."""
        for c, one in enumerate(self.troupe.simulations):
            self.states[c].append(_hopper_state(one))
            self.events[c].extend(one.events)
        state = self.troupe.simulations[0].state
        if state.jump_count:
            self._lifts[state.jump_count] = state.lift_off

    @property
    def lifts(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Centre of mass and its velocity at the lift-offs of the first hopper."""
        return list(self._lifts.values())

    @property
    def lift_times(self) -> list[float]:
        """Times of the lift-offs [s]."""
        times = [h.time for h in self.events[0] if h.kind == "lift"]
        return times[:: len(self.troupe.hoppers[0].hips)]

    @property
    def take(self) -> Take:
        """The take."""
        return self.simulation.take()

    def tips(self) -> np.ndarray:
        """(K, L, 3) tips of the legs, by the poses of the last links alone [m]."""
        return tips_of(self.simulation, self.troupe.herd)


def _hopper_state(one: HopSimulation) -> HopperState:
    state, hopper = one.state, one.hopper
    return HopperState(
        state.time,
        state.phase,
        state.jump_count,
        state.p.copy(),
        state.v.copy(),
        level_height(hopper, state.p) - state.floor_height,
        state.body(hopper).tilt,
        state.down.copy(),
        one.leg_forces(),
    )


def hop_through(scene: Scene, until: int | None = None) -> HopRecording:
    """Simulate a scene and record every step, until all hoppers made more than `until` jumps."""
    simulation = Simulation(scene)
    hops = HopRecording(simulation)
    count = len(hops.troupe.simulations)
    hops.states, hops.events = [[] for _ in range(count)], [[] for _ in range(count)]
    hops.record_step()
    while not simulation.finished:
        simulation.step()
        hops.record_step()
        if until is not None and all(s.state.jump_count > until for s in hops.troupe.simulations):
            break
    return hops
