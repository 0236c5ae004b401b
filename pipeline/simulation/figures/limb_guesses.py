"""Guesses of what limbs are, before a figure's appendages are followed.

A drawing is seen from above, so a horn, a wing and a leg look alike. What tells them apart is where
a limb hangs along the trunk, how long it is beside the others, where it points, and whether it
could stand on the ground beside them:

- Short twigs ahead of the legs, on a head, are horns of a mammal and feelers of an insect; so are
  long ones that point straight ahead, as antennae do.
- Short twigs behind the legs and short twigs in the middle are stiff ornaments.
- A foremost pair before three pairs of an insect, bent to point ahead, are arms with claws.
- A mammal's limbs ahead of its last legs are arms if they are too short for the ground, and wings
  if they are too long.
- An insect's pairs that are much longer than three others are wings.
- Short side twigs of a limb are toes. They are left out: `feet` makes toes.

The trunk is what lies on the midline, and loops. A limb is what hangs on it by one connection.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Literal

import numpy as np

from pipeline.simulation.figures.connection_graph import Adjacency, connected_groups, loop_core
from pipeline.simulation.figures.drawing import Drawing
from pipeline.simulation.spatial import Array

LEG, ARM, HEAD, TAIL = "leg", "arm", "head", "tail"
FEELER, HORN, WING = "feeler", "horn", "wing"
TWIGS = (FEELER, HORN)
"""Kinds that what carries them is classified without."""

Chain = tuple[int, ...]
Style = Literal["insect", "mammal"]

TRUNK_WIDTH = 0.01
"""Distance from the midline at which a node is on the trunk, and within which limbs hang in one
row, in the drawing's size."""

SHORT = 0.5
"""Greatest length of a twig, in that of the longest leg behind it."""

SHORT_BEHIND = 0.4
"""The same of a twig behind all legs."""

SHORT_TOE = 0.35
"""Greatest length of a toe, in that of its limb."""

SNOUT = 0.3
"""Greatest length of a head ahead of its twigs, in the distance from these to the last legs. A
longer one is a neck, and what hangs at its base is no twig on a head."""

LEGLESS = 0.15
"""Length of a figure's longest limb, in its trunk's, below which it is no leg."""

FORWARD_DEG, ANTENNA_DEG, ANTENNA = 30.0, 40.0, 0.8
"""Greatest angle between straight ahead and an antenna of any length, and one of less than this
part of the legs' length."""

CLAW_DEG, CLAW_TURN_DEG = 35.0, 25.0
"""Greatest angle between straight ahead and the last link of an arm with a claw, and least angle
by which that link points farther ahead than the first."""

BACKWARD_COSINE = math.cos(math.radians(60.0))
"""Of the direction of a twig behind all legs."""

BEHIND = "behind the legs"
"""Start of the reason of twigs at the rear, which lie as drawn."""

CLAW_LEGS, ANTENNA_LEGS = 6, 4
"""Legs that an insect has behind its claws, and any animal behind long antennae."""

SMALLEST_LEG = 0.25
"""Least length of the last legs, in the longest limb's."""

HANGING = 0.65
"""A mammal's limb is an arm if its length is less than this part of its height above ground."""

MAMMAL_WING, INSECT_WING = 1.35, 1.8
"""Least length of wings, in that of the last legs, and in the median of an insect's limbs."""


@dataclass(frozen=True, slots=True)
class Branch:
    """What hangs on the trunk by one connection.

    Attributes:
        chain: its longest way, from its base, a node of the trunk, to a tip.
        twigs: further chains, each from a node of the chains before it.
        length: of the chain [m].
        row: y of its base [m].
        is_given: whether the author says what it is.
    """

    chain: Chain
    twigs: tuple[Chain, ...]
    length: float
    row: float
    is_given: bool


@dataclass(slots=True)
class LimbGuesses:
    """What limbs are guessed to be.

    Attributes:
        twigs: horns and feelers from base to tip; those that carry others first.
        toes: chains that are left out.
        kinds: by tip, of these twigs and of limbs that are not as they would be by their places.
        reasons: by tip.
    """

    twigs: list[Chain] = field(default_factory=list)
    toes: list[Chain] = field(default_factory=list)
    kinds: dict[int, str] = field(default_factory=dict)
    reasons: dict[int, str] = field(default_factory=dict)

    def add_twig(self, branch: Branch, kind: str, reason: str) -> None:
        """Add a branch with all its twigs."""
        for chain in (branch.chain, *branch.twigs):
            self.twigs.append(chain)
            self.add(chain[-1], kind, reason)

    def add(self, tip: int, kind: str, reason: str) -> None:
        """Add the kind of one tip."""
        self.kinds[tip], self.reasons[tip] = kind, reason


def guess_limbs(
    drawing: Drawing,
    adjacency: Adjacency,
    given: Mapping[int, str],
    style: Style,
    pitch_deg: float,
) -> LimbGuesses:
    """Return what limbs are guessed to be.

    Args:
        drawing: the flat network.
        adjacency: of the figure, without the twigs that its author names.
        given: kinds of nodes that the author names.
        style: of the figure.
        pitch_deg: how far a mammal's body is raised at its front.
    """
    guesses = LimbGuesses()
    trunk = _trunk(drawing, adjacency)
    branches = list(_branches(drawing, adjacency, trunk, given))
    if not branches:
        return guesses
    for branch in _middle_twigs(drawing, adjacency, trunk, branches):
        if branch.chain[-1] not in given:
            guesses.add_twig(branch, HORN, "a short twig in the middle, neither head nor tail")
    reasons = _twig_reasons(drawing, branches, drawing.places[sorted(trunk), 1])
    for branch, reason in zip(branches, reasons, strict=True):
        if reason:
            stands = style == "mammal" and not reason.startswith(BEHIND)
            guesses.add_twig(branch, HORN if stands else FEELER, reason)
    limbs = [branch for branch, reason in zip(branches, reasons, strict=True) if not reason]
    for branch in (limb for limb in limbs if not limb.is_given):
        toes = [t for t in branch.twigs if _length(drawing, t) < SHORT_TOE * branch.length]
        guesses.toes += toes if len(toes) == len(branch.twigs) else []
    choose = _mammal_forelimbs if style == "mammal" else _insect_forelimbs
    for branch, kind, reason in choose(drawing, limbs, pitch_deg):
        if not branch.is_given:
            guesses.add(branch.chain[-1], kind, reason)
    return guesses


def midline(drawing: Drawing) -> float:
    """Return x of the midline: 0, or the middle of a drawing beside it [m]."""
    low, high = float(drawing.places[:, 0].min()), float(drawing.places[:, 0].max())
    return 0.0 if low <= 0.0 <= high else (low + high) / 2


def _width(drawing: Drawing) -> float:
    return TRUNK_WIDTH * float(np.ptp(drawing.places, axis=0).max())


def _trunk(drawing: Drawing, adjacency: Adjacency) -> set[int]:
    """Return the nodes on the midline and on loops."""
    middle, width = midline(drawing), _width(drawing)
    on_midline = {n for n in adjacency if abs(float(drawing.places[n, 0]) - middle) <= width}
    return on_midline | set(loop_core(adjacency))


def _branches(
    drawing: Drawing, adjacency: Adjacency, trunk: set[int], given: Mapping[int, str]
) -> Iterator[Branch]:
    """Yield what hangs on the trunk by one connection."""
    outside = {n: others - trunk for n, others in adjacency.items() if n not in trunk}
    for group in connected_groups(outside):
        roots = [(a, n) for n in sorted(group) for a in sorted(adjacency[n] & trunk)]
        if len(roots) == 1:
            yield _branch(drawing, outside, roots[0], given)


def _branch(
    drawing: Drawing, adjacency: Adjacency, root: tuple[int, int], given: Mapping[int, str]
) -> Branch:
    """Return the branch of a tree whose first connection is `root`."""
    chains: dict[int, Chain] = {root[1]: root}
    edge, tips = [root[1]], list[int]()
    while edge:
        node = edge.pop()
        onward = [n for n in sorted(adjacency[node]) if n not in chains and n != root[0]]
        chains |= {n: (*chains[node], n) for n in onward}
        edge += onward
        if not onward:
            tips.append(node)
    ways = sorted((chains[tip] for tip in tips), key=lambda c: (-_length(drawing, c), c[-1]))
    covered, twigs = set(ways[0]), []
    for way in ways[1:]:
        first = max(i for i, n in enumerate(way) if n in covered)
        twigs.append(way[first:])
        covered |= set(way)
    row = float(drawing.places[root[0], 1])
    is_given = any(n in given for n in covered - {root[0]})
    return Branch(ways[0], tuple(twigs), _length(drawing, ways[0]), row, is_given)


def _middle_twigs(
    drawing: Drawing, adjacency: Adjacency, trunk: set[int], branches: Sequence[Branch]
) -> list[Branch]:
    """Return short ends of the trunk beside which the midline goes on in the same direction."""
    y = drawing.places[:, 1]
    longest = max(branch.length for branch in branches)
    bases = {branch.chain[0] for branch in branches}
    ends = _trunk_ends(adjacency, trunk)
    lengths = {end[:2]: _length(drawing, end) for end in ends}
    middle, width = midline(drawing), _width(drawing)
    found = []
    for end in ends:
        (base, first), length = end[:2], lengths[end[:2]]
        if len(branches) < 2 or length >= SHORT * longest or bases & set(end[1:]):
            continue
        ahead = bool(y[first] < y[base])
        rivals = [
            n
            for n in adjacency[base] & trunk
            if n != first
            and abs(float(drawing.places[n, 0]) - middle) <= width
            and bool(y[n] < y[base]) == ahead
        ]
        # Of two ends the longer one is the head or the tail.
        if any((lengths.get((base, n), math.inf), -n) > (length, -first) for n in rivals):
            found.append(Branch(end, (), length, float(y[base]), False))
    return found


def _trunk_ends(adjacency: Adjacency, trunk: set[int]) -> list[Chain]:
    """Return the ends of the trunk, each from where the trunk forks to a tip."""
    spine = {n: adjacency[n] & trunk for n in trunk}
    ends = []
    for tip in (n for n in sorted(trunk) if len(adjacency[n]) == 1):
        way = [tip]
        while len(spine[way[-1]]) <= 2 and (onward := sorted(spine[way[-1]] - set(way))):
            way.append(onward[0])
        if len(way) > 1:
            ends.append(tuple(reversed(way)))
    return ends


def _twig_reasons(drawing: Drawing, branches: Sequence[Branch], rows: Array) -> list[str]:
    """Return why each branch is a twig; empty for one that is none.

    Args:
        drawing: the flat network.
        branches: all of the figure.
        rows: (n,) y of the trunk's nodes [m].
    """
    front, length = float(rows.min()), float(np.ptp(rows))
    legless = all(branch.length < LEGLESS * length for branch in branches)
    reasons = []
    for branch in branches:
        if branch.is_given:
            reasons.append("")
        elif legless and branch.row - front <= SNOUT * length:
            reasons.append("a short twig on the head of a figure without legs")
        else:
            ahead = _head_twig_reason(drawing, branch, branches, front)
            reasons.append(ahead or _rear_twig_reason(drawing, branch, branches))
    return reasons


def _legs_but(branch: Branch, branches: Sequence[Branch]) -> list[Branch]:
    """Return the other branches that are long enough for legs."""
    longest = max(other.length for other in branches)
    return [b for b in branches if b.length >= SHORT * longest and b is not branch]


def _head_twig_reason(
    drawing: Drawing, branch: Branch, branches: Sequence[Branch], front: float
) -> str:
    """Return why a branch is a twig on a head; empty if it is none."""
    legs = _legs_but(branch, branches)
    behind = [leg for leg in legs if leg.row > branch.row + _width(drawing)]
    if not behind:
        return ""
    to_last = max(leg.row for leg in behind) - branch.row
    if branch.row - front > SNOUT * to_last:
        return ""
    ratio = branch.length / max(leg.length for leg in behind)
    if ratio < SHORT:
        return f"ahead of the legs, on the head, {_percent(ratio)} of their length"
    limit = math.radians(ANTENNA_DEG if ratio < ANTENNA else FORWARD_DEG)
    ahead = _cosine(drawing, branch.chain[0], branch.chain[-1]) >= math.cos(limit)
    if ahead and len(behind) >= ANTENNA_LEGS:
        return "ahead of the legs, on the head, pointing straight ahead"
    return ""


def _rear_twig_reason(drawing: Drawing, branch: Branch, branches: Sequence[Branch]) -> str:
    """Return why a branch is a twig behind all legs; empty if it is none."""
    legs = _legs_but(branch, branches)
    if len(legs) < ANTENNA_LEGS or any(leg.row >= branch.row - _width(drawing) for leg in legs):
        return ""
    ratio = branch.length / max(leg.length for leg in legs)
    backward = -_cosine(drawing, branch.chain[0], branch.chain[-1]) >= BACKWARD_COSINE
    if ratio < SHORT_BEHIND and backward:
        return f"{BEHIND}, {_percent(ratio)} of their length"
    return ""


Choice = tuple[Branch, str, str]


def _mammal_forelimbs(
    drawing: Drawing, limbs: Sequence[Branch], pitch_deg: float
) -> Iterator[Choice]:
    """Yield a mammal's arms and wings, with reasons."""
    if len(limbs) < 4:
        return
    longest = max(limb.length for limb in limbs)
    last = max(
        (limb for limb in limbs if limb.length >= SMALLEST_LEG * longest),
        key=lambda limb: (round(limb.row / max(_width(drawing), 1e-12)), -limb.length),
    )
    stands = math.dist(drawing.places[last.chain[0]], drawing.places[last.chain[-1]])
    for limb in limbs:
        rise = math.sin(math.radians(pitch_deg)) * (last.row - limb.row)
        if limb.row < last.row - _width(drawing) and limb.length < HANGING * (stands + rise):
            gap = stands + rise - limb.length
            yield limb, ARM, f"hangs {gap:.2g} m above the ground while the last legs stand"
        elif limb.row <= last.row and limb.length > MAMMAL_WING * last.length and pitch_deg < 45.0:
            ratio = limb.length / last.length
            yield limb, WING, f"{ratio:.2g} times as long as the last legs, too long to walk on"


def _insect_forelimbs(
    drawing: Drawing, limbs: Sequence[Branch], pitch_deg: float
) -> Iterator[Choice]:
    """Yield an insect's arms with claws and its wings, with reasons."""
    del pitch_deg
    if not limbs:
        return
    first = min(limb.row for limb in limbs)
    usual = median(limb.length for limb in limbs)
    few = sum(limb.length <= INSECT_WING * usual for limb in limbs) < CLAW_LEGS
    for limb in limbs:
        behind = [other for other in limbs if other.row > limb.row + _width(drawing)]
        if limb.row <= first and len(behind) >= CLAW_LEGS and _bends_ahead(drawing, limb):
            yield limb, ARM, "ahead of three pairs of legs, and bent to point ahead"
        elif not few and limb.length > INSECT_WING * usual:
            ratio = limb.length / usual
            yield limb, WING, f"{ratio:.2g} times as long as most limbs, too long to walk on"


def _bends_ahead(drawing: Drawing, limb: Branch) -> bool:
    """Return whether a limb goes to the side first and then ahead, as one with a claw."""
    links = list(itertools.pairwise(limb.chain))
    first, last = (math.degrees(math.acos(_cosine(drawing, *links[i]))) for i in (0, -1))
    return last <= CLAW_DEG and first - last >= CLAW_TURN_DEG


def _length(drawing: Drawing, chain: Chain) -> float:
    """Return the length of a chain [m]."""
    return sum(
        math.dist(drawing.places[a], drawing.places[b]) for a, b in itertools.pairwise(chain)
    )


def _cosine(drawing: Drawing, start: int, end: int) -> float:
    """Return the cosine between the way from one node to another and straight ahead."""
    x, y = drawing.places[end] - drawing.places[start]
    return float(np.clip(-y / max(math.hypot(x, y), 1e-12), -1.0, 1.0))


def _percent(ratio: float) -> str:
    return f"{100 * ratio:.0f}%"
