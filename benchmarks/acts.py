"""Acts: how people's acts with things and with one another end, over random draws of each kind.

Sizes, places, headings and things are drawn; all acts of a kind go on in one scene, far apart. An
act is done, or given up with its note within `GIVE_UP_TIME`; anything else is missed. At the end no
empty hand may be held out, and nobody may have cried. Hugging people are told to let go, after
which all arms hang within 2 s.

    python benchmarks/acts.py [COUNT [KIND...]]
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene

COUNT = 15
APART, COLUMNS = 14.0, 5
"""Distance between neighbouring acts [m], and their number in a row."""

START, GIVE_UP_TIME = 0.3, 10.0
"""Time of the first orders, and the longest time from an order to its note [s]."""

LONG_ARM = 0.45
"""Distance of a hand from its shoulder over the ground from which it is held out, in arms."""

SIDE, TALL, DEEP = 3.0, 1.2, 0.5
"""Length, height and depth of a fence [m]."""

AT_GOAL, TABLE = 0.4, 0.8
"""Distance from its goal at which a thing is there, and the width of a table [m]."""

HUG_SCALES = 0.5, 1.4
"""Least and greatest scale of people that hug."""

People = Mapping[str, PersonController]


@dataclass
class Act:
    """One act and what became of it.

    Attributes:
        number: of its draw.
        origin: (2,) the middle of its ground [m].
        rng: of its draws.
        cast: in YAML.
        script: in YAML.
        holds: tells whether the act is what it should be, from the people by name.
        outcome: done, failed or missed.
        notes: of what was given up or cut off.
        arms: hands that are empty and held out at the end.
        hurt: people that cried.
    """

    number: int
    origin: tuple[float, float]
    rng: np.random.Generator
    cast: list[str] = field(default_factory=list)
    script: list[str] = field(default_factory=list)
    holds: Callable[[People], bool] | None = None
    outcome: str = "done"
    notes: list[str] = field(default_factory=list)
    arms: list[str] = field(default_factory=list)
    hurt: list[str] = field(default_factory=list)

    def name(self, own: str) -> str:
        """Return the name of a member in the scene of all."""
        return f"{own}{self.number}"

    def place(self, x: float, z: float, y: float | None = None) -> str:
        """Return a place on its ground, in YAML [m]."""
        x, z = x + self.origin[0], z + self.origin[1]
        return f"[{x:.3f}, {z:.3f}]" if y is None else f"[{x:.3f}, {y:.4f}, {z:.3f}]"

    def somewhere(self, near: float, far: float) -> tuple[float, float]:
        """Return a random place at a distance from the middle [m]."""
        turn, distance = self.rng.uniform(0.0, 2.0 * math.pi), self.rng.uniform(near, far)
        return distance * math.cos(turn), distance * math.sin(turn)

    def add_person(
        self,
        own: str,
        at: tuple[float, float],
        kind: str = "",
        scales: tuple[float, float] = (0.85, 1.15),
    ) -> None:
        """Add a person of a random size and heading."""
        kind = kind or str(self.rng.choice(["adult", "child"]))
        turn, scale = self.rng.uniform(-180.0, 180.0), self.rng.uniform(*scales)
        more = f"heading_deg: {turn:.0f}, scale: {scale:.2f}"
        self.cast.append(
            f"name: {self.name(own)}, character: {kind}, at: {self.place(*at)}, {more}"
        )

    def add(self, own: str, text: str, low: float = 0.0, at: Sequence[float] = (0.0, 0.0)) -> None:
        """Add a body, a prop or a thing whose middle is so high above the ground [m]."""
        is_character = text.startswith("character")
        place = self.place(at[0], at[1], None if is_character else low)
        self.cast.append(f"name: {self.name(own)}, {text}, at: {place}")

    def order(self, own: str, do: str, at: float = START, after: str = "") -> None:
        """Add an order: at a time [s], or when another has arrived."""
        when = f"when: {{arrived: {self.name(after)}}}" if after else f"at: {at:.2f}"
        self.script.append(f"{when}, who: {self.name(own)}, do: {{{do}}}")

    def add_small_thing(self) -> None:
        """Add a thing on the ground that a child's hand can hold."""
        size, draw = self.rng.uniform(0.05, 0.11), self.rng.integers(5)
        if draw == 0:
            self.add(
                "t", f"body: {{shape: cube, size: {size:.3f}, density: 300}}", 0.5 * size + 0.002
            )
        elif draw == 1:
            radius = 0.5 * size
            body = f"body: {{shape: sphere, radius: {radius:.3f}, density: 300}}"
            self.add("t", body, radius + 0.002)
        elif draw == 2:
            self.add("t", f"prop: {{shape: box, size: [{size:.3f}, 0.08, 0.1]}}", 0.04)
        elif draw == 3:
            self.add("t", f"character: ball, scale: {self.rng.uniform(0.35, 0.6):.2f}")
        else:
            self.add("t", f"character: ragdoll, heading_deg: {self.rng.uniform(0.0, 360.0):.0f}")

    def add_wide_thing(self) -> None:
        """Add a thing on the ground that both hands of a child can hold."""
        size, draw = self.rng.uniform(0.2, 0.27), self.rng.integers(4)
        turn = self.rng.uniform(0.0, 90.0)
        if draw == 0:
            self.add(
                "t", f"body: {{shape: cube, size: {size:.3f}, density: 120}}", 0.5 * size + 0.002
            )
        elif draw == 1:
            body = f"body: {{shape: sphere, radius: {0.5 * size:.3f}, density: 80}}"
            self.add("t", body, 0.5 * size + 0.002)
        elif draw == 2:
            self.add("t", f"character: ball, scale: {size / 0.24:.2f}")
        else:
            self.add("t", f"character: box, scale: {2.0 * size:.2f}, heading_deg: {turn:.0f}")

    def expect_at(self, own: str, at: Sequence[float], reach: float) -> None:
        """Expect a thing to lie no farther from a place of its ground [m]."""
        name, thing = self.name("a"), self.name(own)
        place = at[0] + self.origin[0], at[1] + self.origin[1]

        def is_there(people: People) -> bool:
            view = people[name].view
            owner = view.owner(thing)
            if owner >= 0:
                return math.dist(view.middle(owner)[[0, 2]], place) < reach
            state = view.members.get(thing)
            return state is not None and math.dist(state.centre[[0, 2]], place) < reach

        self.holds = is_there

    def expect_holding(self, own: str, hands: int = 1) -> None:
        """Expect a person to hold the thing with so many hands at least."""
        name, thing = self.name(own), self.name("t")
        self.holds = lambda people: len(people[name].hands_holding(thing)) >= hands


def take(act: Act) -> None:
    """Take a small thing from the ground."""
    act.add_person("a", act.somewhere(0.3, 3.0))
    act.add_small_thing()
    act.order("a", f"grab: {act.name('t')}")
    act.expect_holding("a")


def take_doll(act: Act) -> None:
    """Take a doll from the ground."""
    act.add_person("a", act.somewhere(0.3, 3.0))
    act.add("t", f"character: ragdoll, heading_deg: {act.rng.uniform(0.0, 360.0):.0f}")
    act.order("a", f"grab: {act.name('t')}")
    act.expect_holding("a")


def take_wide(act: Act) -> None:
    """Take a wide thing with both hands."""
    act.add_person("a", act.somewhere(0.5, 3.0))
    act.add_wide_thing()
    act.order("a", f"grab: {act.name('t')}, hand: both")
    act.expect_holding("a", 2)


def _add_thing(act: Act, small_share: float) -> str:
    """Add a small or a wide thing, and return the words of an order for its hands."""
    if act.rng.random() < small_share:
        act.add_small_thing()
        return ""
    act.add_wide_thing()
    return ", hand: both"


def carry(act: Act) -> None:
    """Carry a thing to a place or onto a table."""
    act.add_person("a", act.somewhere(0.5, 3.0))
    hand = _add_thing(act, 0.5)
    at = act.somewhere(1.2, 3.0)
    to, reach = act.place(*at), AT_GOAL
    if act.rng.random() < 0.4:
        act.add("table", f"prop: {{shape: box, size: [{TABLE}, 0.45, {TABLE}]}}", 0.225, at)
        to, reach = act.name("table"), math.hypot(0.5 * TABLE, 0.5 * TABLE)
    act.order("a", f"carry: {act.name('t')}, to: {to}{hand}")
    act.expect_at("t", at, reach)


def hand_over(act: Act) -> None:
    """Take from another's hand what the other has taken from the ground."""
    act.add_person("a", act.somewhere(0.5, 1.0))
    act.add_person("b", act.somewhere(1.5, 3.5))
    hand = _add_thing(act, 0.6)
    act.order("a", f"grab: {act.name('t')}{hand}")
    act.order("b", f"grab: {act.name('t')}{hand}", after="a")
    name, other, thing = act.name("b"), act.name("a"), act.name("t")
    act.holds = lambda people: (
        bool(people[name].hands_holding(thing)) and not people[other].hands_holding(thing)
    )


def carry_by_two(act: Act) -> None:
    """Carry a crate together."""
    act.add_person("a", act.somewhere(1.0, 3.0), "adult")
    act.add_person("b", act.somewhere(1.0, 3.0), "adult")
    turn = act.rng.uniform(0.0, 180.0)
    if act.rng.random() < 0.5:
        body = f"body: {{shape: box, size: [0.9, 0.4, 0.4], density: 280}}, heading_deg: {turn:.0f}"
        act.add("t", body, 0.202)
    else:
        act.add("t", f"character: box, heading_deg: {turn:.0f}")
    at = act.somewhere(2.0, 3.0)
    for own in "ab":
        act.order(own, f"carry: {act.name('t')}, to: {act.place(*at)}, hand: both")
    act.expect_at("t", at, AT_GOAL)


def sit(act: Act) -> None:
    """Sit with one or two others."""
    owns = "abc" if act.rng.random() < 0.6 else "ab"
    if len(owns) == 3:
        act.add("s", f"character: bench, heading_deg: {act.rng.uniform(0.0, 180.0):.0f}")
    else:
        act.add("s", "prop: {shape: box, size: [0.4, 0.38, 1.2]}", 0.19)
    for k, own in enumerate(owns):
        turn = 2.0 * math.pi * (k + act.rng.uniform(0.1, 0.9)) / len(owns)
        far = act.rng.uniform(1.3, 3.0)
        act.add_person(own, (far * math.cos(turn), far * math.sin(turn)))
        act.order(own, f"sit: {act.name('s')}", at=START + act.rng.uniform(0.0, 1.0))


def push(act: Act) -> None:
    """Shove a person or a doll."""
    act.add_person("a", act.somewhere(0.8, 3.0))
    if act.rng.random() < 0.4:
        act.add("b", "character: ragdoll, scale: 1.5")
    else:
        act.add_person("b", (0.0, 0.0))
    act.order("a", f"grapple: {act.name('b')}")


def _add_carousel(act: Act) -> None:
    """Add a merry-go-round that stands, or turns slowly already."""
    spin = act.rng.choice([-25.0, 0.0, 0.0, 25.0])
    turn = act.rng.uniform(0.0, 45.0)
    more = f"scale: {act.rng.uniform(0.9, 1.1):.2f}, heading_deg: {turn:.0f}"
    act.add("c", f"character: merry-go-round, {more}, spin_deg: [0, {spin:.0f}, 0]")


def ride(act: Act) -> None:
    """Step onto a merry-go-round, one or two, or onto a platform that moves."""
    owns = "ab" if act.rng.random() < 0.4 else "a"
    if act.rng.random() < 0.7:
        _add_carousel(act)
    else:
        x, z = act.somewhere(0.5, 1.5)
        size = f"[{act.rng.uniform(1.2, 2.0):.2f}, 0.2, 1.1]"
        keys = f"{{at: 6, position: {act.place(0.0, 0.0, 0.1)}}}"
        keys += f", {{at: 13, position: {act.place(x, z, 0.1)}}}"
        act.add("c", f"prop: {{shape: box, size: {size}}}, keyframes: [{keys}]", 0.1)
    for k, own in enumerate(owns):
        act.add_person(own, act.somewhere(2.2, 3.5))
        act.order(own, f"ride: {act.name('c')}", at=START + k * act.rng.uniform(0.0, 1.0))
    names = [act.name(own) for own in owns]
    act.holds = lambda people: all(float(people[n].record.deck_share) > 0.5 for n in names)


def push_round(act: Act) -> None:
    """Push a merry-go-round, one to three, with or without a rider."""
    count, has_rider = int(act.rng.integers(1, 4)), act.rng.random() < 0.4
    _add_carousel(act)
    turns = act.rng.uniform(0.3, 0.6)
    for k in range(count):
        turn = 2.0 * math.pi * (k + act.rng.uniform(0.1, 0.9)) / count
        far = act.rng.uniform(2.2, 3.2)
        own = "pqs"[k]
        act.add_person(own, (far * math.cos(turn), far * math.sin(turn)))
        at = START + act.rng.uniform(0.0, 1.0)
        act.order(own, f"push: {act.name('c')}, turns: {turns:.2f}", at=at)
    if has_rider:
        act.add_person("a", act.somewhere(3.3, 3.8))
        act.order("a", f"ride: {act.name('c')}", at=0.0)


def reach(act: Act) -> None:
    """Hold a hand out to a person near by or too far away."""
    act.add_person("a", act.somewhere(0.35, 0.8))
    act.add_person("b", (0.0, 0.0))
    act.order("a", f"reach: {act.name('b')}")
    act.script.append(f"at: 8, who: {act.name('a')}, do: {{let_go: both}}")


def hug(act: Act) -> None:
    """Hug: both are told to, or one is, while the other stands or walks."""
    _meet(act)
    for own in "ab":
        act.script.append(f"at: {LET_GO_TIME}, who: {act.name(own)}, do: {{let_go: both}}")
    names = act.name("a"), act.name("b")

    def together(people: People) -> bool:
        a, b = (people[name] for name in names)
        gap = a.ground_distance(a.view.pelvis(int(b.record.owner)))
        return gap < 0.075 * float(a.record.height + b.record.height) + 0.1

    act.holds = together


def hug_lost(act: Act) -> None:
    """Hug a person that leaves after a while."""
    _meet(act)
    act.order("b", f"go_to: {act.place(*act.somewhere(4.0, 5.0))}", at=7.0)


def _meet(act: Act) -> None:
    """Let one or both be told to hug."""
    act.add_person("a", act.somewhere(0.6, 3.5), scales=HUG_SCALES)
    act.add_person("b", (0.0, 0.0), scales=HUG_SCALES)
    draw = act.rng.random()
    if 0.5 < draw < 0.7:
        act.order("b", f"go_to: {act.place(*act.somewhere(0.5, 2.0))}", at=0.0)
    act.order("a", f"hug: {act.name('b')}")
    if draw < 0.5:
        act.order("b", f"hug: {act.name('a')}", at=START + act.rng.uniform(0.0, 0.5))


def blocked(act: Act) -> None:
    """Try what a fence all around makes impossible."""
    act.add_person("a", (act.rng.uniform(-3.0, -1.5), act.rng.uniform(-1.0, 1.0)))
    act.add_person("b", (1.2, 0.0))
    act.add("t", "prop: {shape: box, size: [0.1, 0.1, 0.1]}", 0.05, (0.9, 0.4))
    sides = ((-0.3, 0.0, 0), (2.7, 0.0, 0), (1.2, 1.5, 90), (1.2, -1.5, 90))
    for k, (x, z, turn) in enumerate(sides):
        size = f"[{DEEP}, {TALL}, {SIDE}]" if turn == 0 else f"[{SIDE}, {TALL}, {DEEP}]"
        act.add(f"fence{k}x", f"prop: {{shape: box, size: {size}}}", 0.5 * TALL, (x, z))
    verb = str(act.rng.choice(["hug", "grab", "grapple", "go_to"]))
    act.order("a", f"{verb}: {act.name('t' if verb == 'grab' else 'b')}")


LET_GO_TIME, ARMS_DOWN_TIME = 11.0, 2.0
"""When hugging people are told to let go, and the time in which their arms sink [s]."""

SECONDS, LEAVING_SECONDS = 14.0, 20.0
"""Duration of most acts, and of one in which somebody leaves afterwards, at any pace [s]."""

KINDS: dict[str, tuple[Callable[[Act], None], float]] = {
    "take": (take, SECONDS),
    "take doll": (take_doll, SECONDS),
    "take wide": (take_wide, SECONDS),
    "carry": (carry, 24.0),
    "hand over": (hand_over, 22.0),
    "carry by two": (carry_by_two, 24.0),
    "sit": (sit, 16.0),
    "push": (push, SECONDS),
    "ride": (ride, 16.0),
    "push round": (push_round, 20.0),
    "reach": (reach, SECONDS),
    "hug": (hug, LET_GO_TIME + ARMS_DOWN_TIME),
    "hug lost": (hug_lost, LEAVING_SECONDS),
    "blocked": (blocked, SECONDS),
}
"""The kinds of acts, and the durations of their scenes [s]."""


def arms_out(people: People) -> Iterator[str]:
    """Yield the hands that are empty and away from the sides of people."""
    for name, one in people.items():
        for k in range(2):
            out = math.hypot(*(one.hand(k) - one.shoulder(k))[[0, 2]])
            is_sitting = float(one.record.sit_blend) > 0.0
            if not one.is_holding(k) and not is_sitting and out > LONG_ARM * one.arm:
                yield f"{name}.hand_{'lr'[k]}"


def draw_acts(kind: str, numbers: Sequence[int]) -> list[Act]:
    """Return the acts of a kind with these numbers, drawn."""
    acts = []
    rows = math.ceil(len(numbers) / COLUMNS)
    for k, number in enumerate(numbers):
        x = APART * (k % COLUMNS - 0.5 * (COLUMNS - 1))
        z = APART * (k // COLUMNS - 0.5 * (rows - 1))
        act = Act(number, (x, z), np.random.default_rng([number, *kind.encode()]))
        KINDS[kind][0](act)
        acts.append(act)
    return acts


def scene_of(acts: Sequence[Act], seconds: float) -> str:
    """Return the scene of acts."""
    cast = "".join(f"  - {{{one}}}\n" for act in acts for one in act.cast)
    script = "".join(f"  - {{{one}}}\n" for act in acts for one in act.script)
    width, depth = APART * (COLUMNS + 1), APART * (math.ceil(len(acts) / COLUMNS) + 1)
    terrain = f"{{kind: flat, size: [{width}, {depth}]}}"
    return f"pronk: 1\nduration: {seconds}\nterrain: {terrain}\ncast:\n{cast}script:\n{script}"


def play(kind: str, numbers: Sequence[int]) -> list[Act]:
    """Play acts of a kind in one scene, and return what became of them."""
    acts, seconds = draw_acts(kind, numbers), KINDS[kind][1]
    simulation = Simulation(read_scene(scene_of(acts, seconds)))
    troupe = next(one for one in simulation.troupes if isinstance(one, Characters))
    people = {one.name: one for one in troupe.dispatcher.controllers}
    dt, last = simulation.world.clock.dt, simulation.world.clock.last_step
    check = round(LET_GO_TIME / dt) - 2 if kind == "hug" else last
    hurt, holds = dict[str, None](), dict[int, bool]()
    while not simulation.finished:
        simulation.step()
        hurt |= {signal.who: None for signal in simulation.signals if signal.kind == "cry"}
        if simulation.step_number == check:
            holds = {act.number: act.holds is None or act.holds(people) for act in acts}
    orders, arms = simulation.take().orders, list(arms_out(people))
    for act in acts:
        own = {name for name in people if name[1:] == str(act.number)}
        act.arms = [hand for hand in arms if hand.partition(".")[0] in own]
        act.hurt = [name for name in hurt if name in own]
        failed = missed = False
        for order in orders:
            if order.who not in own or order.outcome in ("done", "replaced", "begun"):
                continue
            time = (order.end - order.step) * dt
            text = f"{order.who} {order.text}: {order.outcome} {order.reason} ({time:.1f} s)"
            act.notes.append(text)
            failed |= order.outcome == "given up"
            missed |= order.outcome == "cut off" or time > GIVE_UP_TIME
        if not (holds[act.number] or failed or missed):
            act.notes.append("told as done, and is not")
            missed = True
        act.outcome = "missed" if missed else "failed" if failed else "done"
    return acts


def main(count: int = COUNT, kinds: Sequence[str] = ()) -> None:
    """Print what was not done, and the table."""
    found = {}
    for kind in kinds or KINDS:
        found[kind] = play(kind, range(count))
        for act in found[kind]:
            if act.outcome != "done" or act.arms or act.hurt:
                more = [*act.notes, *(f"{hand} is out" for hand in act.arms)]
                more += [f"{name} is hurt" for name in act.hurt]
                print(f"{kind} {act.number}: {act.outcome}; {'; '.join(more)}", flush=True)
    print(f"{'act':14s}  done  failed  missed  arms out  hurt  of")
    found["all"] = [act for acts in found.values() for act in acts]
    for kind, acts in found.items():
        outcomes = [act.outcome for act in acts]
        counts = [outcomes.count(name) for name in ("done", "failed", "missed")]
        arms, hurt = sum(bool(act.arms) for act in acts), sum(bool(act.hurt) for act in acts)
        print(
            f"{kind:14s}  {counts[0]:4d}  {counts[1]:6d}  {counts[2]:6d}"
            f"  {arms:8d}  {hurt:4d}  {len(acts):2d}"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else COUNT, sys.argv[2:])
