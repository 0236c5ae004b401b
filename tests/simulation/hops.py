"""Hops: a simulation of one pronker or more, with what was seen of it at every step."""

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

from .conftest import tips_of


@dataclass
class Seen:
    """One pronker at one step."""

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
class Hops:
    """A simulation and what was seen of its pronkers."""

    simulation: Simulation
    seen: list[list[Seen]] = field(default_factory=list)
    happened: list[list[HopEvent]] = field(default_factory=list)
    _lifts: dict[int, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)

    @property
    def troupe(self) -> HopperTroupe:
        """Its creatures that hop."""
        return next(t for t in self.simulation.troupes if isinstance(t, HopperTroupe))

    def look(self) -> None:
        """Keep the state of this step."""
        for c, one in enumerate(self.troupe.simulations):
            self.seen[c].append(_seen(one))
            self.happened[c].extend(one.events)
        state = self.troupe.simulations[0].state
        if state.jump_count:
            self._lifts[state.jump_count] = state.lift_off

    @property
    def lifts(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Centre of mass and its velocity at the lift-offs of the first pronker."""
        return list(self._lifts.values())

    @property
    def lift_times(self) -> list[float]:
        """When these were [s]."""
        times = [h.time for h in self.happened[0] if h.kind == "lift"]
        return times[:: len(self.troupe.hoppers[0].hips)]

    @property
    def take(self) -> Take:
        """What happened."""
        return self.simulation.take()

    def tips(self) -> np.ndarray:
        """(K, L, 3) tips of the legs, by the poses of the last links alone [m]."""
        return tips_of(self.simulation, self.troupe.herd)


def _seen(one: HopSimulation) -> Seen:
    state, of = one.state, one.hopper
    return Seen(
        state.time,
        state.phase,
        state.jump_count,
        state.p.copy(),
        state.v.copy(),
        level_height(of, state.p) - state.floor_height,
        state.body(of).tilt,
        state.down.copy(),
        one.leg_forces(),
    )


def hop_through(scene: Scene, until: int | None = None) -> Hops:
    """Simulate `scene` and look at every step; with `until`, as far as so many jumps of all."""
    simulation = Simulation(scene)
    hops = Hops(simulation)
    count = len(hops.troupe.simulations)
    hops.seen, hops.happened = [[] for _ in range(count)], [[] for _ in range(count)]
    hops.look()
    while not simulation.finished:
        simulation.step()
        hops.look()
        if until is not None and all(s.state.jumps > until for s in hops.troupe.simulations):
            break
    return hops
