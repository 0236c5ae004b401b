"""Crossing: two groups of people that walk through one another, and what becomes of them.

Everybody is to arrive, nobody to be hurt, nobody to be dazed. Kinds of crossings:

- head-on: the groups come from opposite sides;
- corner: they come at a right angle;
- speeds: head-on, each person at its own speed, from a stroll to a run;
- standing: head-on, through people who stand about;
- gate: head-on, through a gap of `GATE` metres between two walls.

    python benchmarks/crossing.py [KIND...] [SIZE...] [seed=N...] [spacing=METRES]
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.person_record import HEAD
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene

KINDS = ("head-on", "corner", "speeds", "standing", "gate")
SIZES, SEEDS = (25, 50), (1, 2, 3)
DURATION = 30.0  # [s]

# Of the rows and files of a group [m]: 0.44 people/m², and twice that where groups meet, which is
# level of service C, where people choose their speed (Fruin 1971). At 1.1 m they shuffle (level E).
SPACING = 1.5
JITTER = 0.12  # spread of places [m]
APART = 3.5  # from the middle of the square to the first row, at least [m]
LATE = 0.5  # spread of the times at which people set out [s]
SLOWEST, FASTEST = 0.7, 2.2  # of people who walk at their own speeds [m/s]
STANDERS = 6
GATE, WALL = 5.0, 12.0  # width of the gate, and length of each wall beside it [m]

DAZED = 0.25  # slackness of muscles from which a person counts as dazed
LOW_HEAD = 0.5  # of a person that has fallen, in heights above its floor


@dataclass
class Outcome:
    """What became of one crossing.

    Attributes:
        people: number of those who cross.
        arrived: number of those who have arrived.
        time: at which the last one did [s].
        reasons: why others gave up.
        hurt: names and times [s] of pains.
        cries: number of cries.
        dazed: names and times [s] at which somebody began to be dazed.
        fallen: names and times [s] of falls.
        touches: number of touches of two people.
        slackest: greatest slackness of muscles, 0 to 1.
        nearest: least distance of the middles of two people [heights].
    """

    people: int
    arrived: int = 0
    time: float = 0.0
    reasons: list[str] = field(default_factory=list)
    hurt: list[str] = field(default_factory=list)
    cries: int = 0
    dazed: list[str] = field(default_factory=list)
    fallen: list[str] = field(default_factory=list)
    touches: int = 0
    slackest: float = 0.0
    nearest: float = math.inf

    @property
    def is_good(self) -> bool:
        """Whether all arrived, unharmed."""
        return self.arrived == self.people and not self.hurt + self.dazed + self.fallen

    def text(self) -> str:
        """Return one line about it."""
        return (
            f"{'good' if self.is_good else 'not good'}: {self.arrived} of {self.people} arrived by "
            f"{self.time:.1f} s, {len(self.hurt)} pains, {self.cries} cries, {len(self.dazed)} "
            f"dazed, {len(self.fallen)} fell, {self.touches} touches, slackest "
            f"{self.slackest:.2f}, nearest {self.nearest:.2f} heights"
        )


def scene_text(kind: str, size: int, seed: int, spacing: float = SPACING) -> str:
    """Return a scene in YAML of two groups of a size that cross."""
    rng = np.random.default_rng([seed, size, KINDS.index(kind)])
    cast, script = list[str](), list[str]()
    files = math.ceil(math.sqrt(size))
    # At a corner neither the starts nor the goals of the groups overlap.
    apart = max(APART, 0.5 * spacing * files) if kind == "corner" else APART
    for side in range(2):
        turn = math.pi * (1.0 if kind != "corner" else 0.5) * side
        for k in range(size):
            row, file = divmod(k, files)
            back = apart + spacing * row
            across = spacing * (file - 0.5 * (files - 1))
            start = np.array([-back, across]) + rng.uniform(-JITTER, JITTER, 2)
            goal = np.array([apart + spacing * (size // files - row), across])
            goal += rng.uniform(-JITTER, JITTER, 2)
            name, character = f"{'ab'[side]}{k}", "child" if rng.random() < 0.2 else "adult"
            cast.append(_person(name, character, _turned(start, turn), turn, rng))
            if kind == "speeds":
                speed = rng.uniform(SLOWEST, FASTEST)
                script.append(f"- {{at: 0, who: {name}, do: {{speed: {speed:.2f}}}}}")
            x, z = _turned(goal, turn)
            at = rng.uniform(0.0, LATE)
            order = f"{{go_to: [{x:.2f}, {z:.2f}]}}"
            script.append(f"- {{at: {at:.2f}, who: {name}, do: {order}}}")
    if kind == "standing":
        for k in range(STANDERS):
            aside = spacing * (k - 2.5) + rng.uniform(-0.3, 0.3)
            place = np.array([rng.uniform(-2.5, 2.5), aside])
            cast.append(_person(f"s{k}", "adult", place, rng.uniform(-3.0, 3.0), rng))
    if kind == "gate":
        for end in (-1.0, 1.0):
            z = end * (0.5 * GATE + 0.5 * WALL)
            form = f"{{shape: box, size: [0.3, 2.2, {WALL}]}}"
            cast.append(f"- {{name: wall{int(end > 0)}, prop: {form}, at: [0, 0, {z}]}}")
    head = (
        f"pronk: 1\nduration: {DURATION:g}\nseed: {seed}\nterrain: {{kind: flat, size: [60, 60]}}"
    )
    return "\n".join([head, "cast:", *cast, "script:", *script])


def _turned(place: Array, turn: float) -> Array:
    c, s = math.cos(turn), math.sin(turn)
    return np.array([c * place[0] + s * place[1], c * place[1] - s * place[0]])


def _person(name: str, character: str, at: Array, turn: float, rng: np.random.Generator) -> str:
    heading, scale = math.degrees(turn), rng.uniform(0.94, 1.06)
    return (
        f"- {{name: {name}, character: {character}, at: [{at[0]:.2f}, {at[1]:.2f}], "
        f"heading_deg: {heading:.0f}, scale: {scale:.2f}}}"
    )


class Watch:
    """Watches one crossing."""

    def __init__(self, simulation: Simulation, people: int) -> None:
        self.simulation, self.outcome = simulation, Outcome(people)
        self.troupe = next(t for t in simulation.troupes if isinstance(t, Characters))
        self.dt = simulation.world.clock.dt
        self.names = [one.name for one in self.troupe.dispatcher.controllers]
        self.was_dazed = np.zeros(len(self.names), dtype=bool)
        self.was_down = np.zeros(len(self.names), dtype=bool)

    def step(self) -> None:
        """Take a step and note what happens."""
        self.simulation.step()
        now, out, persons = (
            self.simulation.step_number * self.dt,
            self.outcome,
            self.troupe.persons,
        )
        facts = self.troupe.facts()
        out.arrived += len(facts.arrived)
        out.time = now if facts.arrived else out.time
        out.reasons += [f"{one.who} at {now:.1f} s: {one.reason}" for one in facts.outcomes]
        for signal in facts.signals:
            if signal.kind == "pain":
                out.hurt.append(f"{signal.who} by {signal.other or '?'} at {now:.1f} s")
            out.cries += signal.kind == "cry"
        out.touches += sum({"wall0", "wall1"}.isdisjoint(pair) for pair in facts.touched)
        out.slackest = max(out.slackest, float(persons["stun"].max()))
        is_dazed = persons["stun"] > DAZED
        heads = self.troupe.arrays.p[persons["node"] + HEAD, 1] - persons["floor"]
        is_down = heads < LOW_HEAD * persons["height"]
        for k in np.flatnonzero(is_dazed & ~self.was_dazed):
            out.dazed.append(f"{self.names[k]} at {now:.1f} s")
        for k in np.flatnonzero(is_down & ~self.was_down):
            out.fallen.append(f"{self.names[k]} at {now:.1f} s")
        self.was_dazed, self.was_down = is_dazed, is_down
        if self.simulation.step_number % 8 == 0:
            offset = persons["at"][:, None] - persons["at"][None]
            height = 0.5 * (persons["height"][:, None] + persons["height"][None])
            distance = np.sqrt((offset * offset).sum(axis=-1)) / height
            np.fill_diagonal(distance, np.inf)
            out.nearest = min(out.nearest, float(distance.min()))


def cross(kind: str, size: int, seed: int, spacing: float = SPACING) -> Outcome:
    """Let two groups cross."""
    watch = Watch(Simulation(read_scene(scene_text(kind, size, seed, spacing))), 2 * size)
    while not watch.simulation.finished:
        watch.step()
    return watch.outcome


def main(
    kinds: Sequence[str] = KINDS,
    sizes: Sequence[int] = SIZES,
    seeds: Sequence[int] = SEEDS,
    spacing: float = SPACING,
) -> None:
    """Print the table."""
    good = count = 0
    for kind in kinds:
        for size in sizes:
            for seed in seeds:
                out = cross(kind, size, seed, spacing)
                good, count = good + out.is_good, count + 1
                print(f"{kind}, 2 x {size}, seed {seed}: {out.text()}", flush=True)
                for what in (out.reasons, out.hurt, out.dazed, out.fallen):
                    if what:
                        print(f"    {'; '.join(what[:6])}", flush=True)
    print(f"{good} of {count} good")


if __name__ == "__main__":
    words = sys.argv[1:]
    main(
        [word for word in words if word in KINDS] or KINDS,
        [int(word) for word in words if word.isdigit()] or SIZES,
        [int(word[5:]) for word in words if word.startswith("seed=")] or SEEDS,
        *[float(word[8:]) for word in words if word.startswith("spacing=")][:1],
    )
