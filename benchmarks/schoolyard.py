"""Schoolyard: what becomes of the shipped scene under other seeds.

A seed is good if the doll is carried for `CARRY_TIME`, the merry-go-round turns faster than `RATE`
for `TURN_TIME` with somebody on it, and the small child has gone through `CYCLES` of play, fear and
a hug. Falls are counted that no blow has caused.

    python benchmarks/schoolyard.py [SEED...]
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

from pipeline.simulation.characters.carousel_pose import carousel_pose
from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.person_record import HEAD
from pipeline.simulation.simulate import Simulation
from pipeline.spec import load_scene
from pipeline.spec.scene_library import library

SEEDS = range(1, 11)
CARRY_TIME, TURN_TIME, RATE, CYCLES = 10.0, 10.0, 0.5, 3
"""Least times [s], rate [rad/s] and cycles of a good seed."""

LOW_HEAD = 0.5  # of a person that has fallen, in heights above its floor
STRUCK_TIME = 2.0  # after pain in which a fall is that of the blow [s]
FEARFUL = 0.3  # anxiety that counts as fear


@dataclass
class Outcome:
    """What became of one seed.

    Attributes:
        carried: time for which the doll is held [s].
        turned: time for which the merry-go-round turns with somebody on it [s].
        cycles: of the small child.
        falls: people and times [s] of falls that no blow has caused.
        doing: times [s] and behaviours of each person.
    """

    carried: float = 0.0
    turned: float = 0.0
    cycles: int = 0
    falls: list[str] = field(default_factory=list)
    doing: dict[str, list[str]] = field(default_factory=dict)

    @property
    def is_good(self) -> bool:
        """Whether the seed is good."""
        is_busy = self.carried >= CARRY_TIME and self.turned >= TURN_TIME
        return is_busy and self.cycles >= CYCLES and not self.falls


class Watch:
    """Watches one simulation of the schoolyard."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation, self.outcome = simulation, Outcome()
        self.troupe = next(t for t in simulation.troupes if isinstance(t, Characters))
        self.view, self.dt = self.troupe.dispatcher.view, simulation.world.clock.dt
        self.doll, self.carousel = (self.view.number(name) for name in ("doll", "carousel"))
        self.stage, self.down = 0, set[str]()
        self.struck = dict[str, float]()

    def step(self) -> None:
        """Take a step and note what happens."""
        self.simulation.step()
        arrays, out = self.troupe.arrays, self.outcome
        held = arrays.grips[:, 1]
        held = held[held >= 0]
        out.carried += self.dt * bool((arrays.nodes["owner"][held] == self.doll).any())
        persons = self.troupe.persons
        rides = (persons["deck"] == self.carousel) & (persons["deck_share"] > 0.5)
        turns = abs(carousel_pose(self.view, self.carousel).rate) > RATE
        out.turned += self.dt * bool(rides.any() and turns)
        self._count_cycles()
        self._find_falls()

    def _count_cycles(self) -> None:
        """Count play, then fear, then a hug of the small child."""
        minds = self.troupe.minds
        assert minds is not None
        for mind in minds.minds:
            name, doing = mind.controller.name, mind.doing
            log = self.outcome.doing.setdefault(name, [])
            if not log or log[-1].partition(" ")[2] != doing:
                log.append(f"{self.simulation.step_number * self.dt:.0f} {doing}")
            if name == "small":
                fears = mind.anxiety > FEARFUL and doing == "attachment"
                if (doing == "play", fears, mind.is_hugging)[self.stage]:
                    self.stage += 1
                if self.stage == 3:
                    self.stage, self.outcome.cycles = 0, self.outcome.cycles + 1

    def _find_falls(self) -> None:
        """Find people that are down although they neither sit nor bow, and were not struck."""
        now = self.simulation.step_number * self.dt
        for signal in self.troupe.facts().signals:
            if signal.kind in ("pain", "cry"):
                self.struck[signal.who] = now
        for one in self.troupe.dispatcher.controllers:
            person = one.record
            height = self.view.p[person.node + HEAD][1] - person.floor
            stands = person.sit_blend == 0.0 and person.bow < 0.3
            is_down = stands and height < LOW_HEAD * person.height
            was_struck = now - self.struck.get(one.name, -STRUCK_TIME) < STRUCK_TIME
            if is_down and one.name not in self.down and not was_struck:
                self.outcome.falls.append(f"{one.name} at {now:.1f} s")
            self.down.discard(one.name)
            if is_down:
                self.down.add(one.name)


def play(seed: int) -> Outcome:
    """Play the schoolyard under a seed."""
    watch = Watch(Simulation(load_scene(library() / "schoolyard.yaml", [f"seed={seed}"])))
    while not watch.simulation.finished:
        watch.step()
    return watch.outcome


def main(seeds: Sequence[int] = SEEDS) -> None:
    """Print the table."""
    good = 0
    for seed in seeds:
        out = play(seed)
        good += out.is_good
        falls = f", falls: {'; '.join(out.falls)}" if out.falls else ""
        print(
            f"seed {seed}: {'good' if out.is_good else 'not good'}; doll carried {out.carried:.1f} "
            f"s, turned with a rider {out.turned:.1f} s, {out.cycles} cycles{falls}",
            flush=True,
        )
        if not out.is_good:
            for name, log in out.doing.items():
                print(f"    {name}: {', '.join(log)}", flush=True)
    print(f"{good} of {len(seeds)} good")


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or SEEDS)
