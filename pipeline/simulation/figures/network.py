"""Anatomy of a drawing: body, legs, arms, head, tail and feelers.

The largest connected group is used. Nodes with one connection are tips; each is followed inward to
a node with more than two connections, its base (the thesis says "more than one", which would end
every appendage at its second node). Nodes of no appendage are the body, one solid: so are loops,
and bridges between loops.

Feelers and horns, named by the author or guessed (`limb_guesses`), are followed and removed first:
what carries them is classified without them, so a head with antennae is a head. A single chain
without a branch has no base: its middle is the body.

The front-most base on the midline may carry a head, the rear-most a tail. Where several appendages
share that base, or it is not on the midline, their direction decides: a head points forward and a
tail backward, both along the midline.

Source: Sims 1987, 4.2: "depending on the position of their base nodes".
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.connection_graph import (
    Adjacency,
    find_bridges,
    largest_group,
    loop_core,
    loop_groups,
)
from pipeline.simulation.figures.drawing import Drawing
from pipeline.simulation.figures.limb_guesses import (
    ARM,
    FEELER,
    HEAD,
    HORN,
    LEG,
    TAIL,
    TWIGS,
    WING,
    Chain,
    LimbGuesses,
    Style,
    guess_limbs,
    midline,
)
from pipeline.spec.suggestions import hint

BODY = "body"
KIND_ORDER = (LEG, ARM, HEAD, TAIL, FEELER, HORN, WING)

CLOSE_NODES = 1e-3
"""Distance of nodes on top of one another, in the drawing's size."""

MIDLINE_TOLERANCE = 0.3
"""Greatest sideways offset of a head or tail from the midline, in its length."""


__all__ = [
    "ARM",
    "FEELER",
    "HEAD",
    "HORN",
    "LEG",
    "TAIL",
    "WING",
    "Anatomy",
    "Appendage",
    "Remark",
    "analyse",
]


def classify_appendages(
    drawing: Drawing,
    chains: Sequence[Chain],
    given_kinds: Mapping[int, str],
    has_branches: bool = True,
) -> dict[Chain, str]:
    """Return the kind of each appendage.

    Args:
        drawing: the flat network.
        chains: the appendages but feelers, from base to tip.
        given_kinds: kinds by tip, given by the author.
        has_branches: False for a single chain, whose ends are head and tail in any direction.
    """
    kinds = {chain: given_kinds.get(chain[-1], "") for chain in chains}
    guessed = [chain for chain in chains if not kinds[chain]]
    kinds |= dict.fromkeys(guessed, LEG)
    if not chains:
        return kinds
    x, y = drawing.places.T
    if not has_branches:
        ends = sorted(guessed, key=lambda c: (y[c[-1]], x[c[-1]]))
        free = [kind for kind in (HEAD, TAIL) if kind not in kinds.values()]
        # The direction of a single end decides.
        if len(ends) == 1 and len(free) == 2 and y[ends[0][-1]] > y[ends[0][0]]:
            free.reverse()
        kinds |= dict(zip(ends, free, strict=False))
        return kinds
    rows = [float(y[chain[0]]) for chain in chains]
    waist = (min(rows) + max(rows)) / 2
    middle = midline(drawing)
    lengthwise = [chain for chain in guessed if _is_lengthwise(drawing, chain, middle)]
    if HEAD not in kinds.values():
        front = [c for c in lengthwise if y[c[-1]] < waist and y[c[-1]] < y[c[0]]]
        if front:
            kinds[min(front, key=lambda c: (y[c[0]], y[c[-1]], abs(x[c[-1]] - middle)))] = HEAD
    if TAIL not in kinds.values():
        back = [
            c for c in lengthwise if y[c[-1]] > waist and y[c[-1]] > y[c[0]] and kinds[c] == LEG
        ]
        if back:
            kinds[min(back, key=lambda c: (-y[c[0]], -y[c[-1]], abs(x[c[-1]] - middle)))] = TAIL
    return kinds


def sort_appendages(drawing: Drawing, kinds: Mapping[Chain, str]) -> list[Chain]:
    """Return the appendages by kind, left before right, front to back."""

    def rank(chain: Chain) -> tuple[int, str, float, float]:
        y = drawing.places[list(chain), 1]
        return (
            KIND_ORDER.index(kinds[chain]),
            appendage_side(drawing, chain),
            float(y[0]),
            float(y.mean()),
        )

    return sorted(kinds, key=rank)


def appendage_side(drawing: Drawing, chain: Chain) -> str:
    """Return the side of an appendage: "l", "r", or "m" in the middle."""
    lateral = float(drawing.places[list(chain), 0].mean()) - midline(drawing)
    extent = float(np.ptp(drawing.places, axis=0).max())
    if abs(lateral) <= 1e-6 * extent:
        return "m"
    return "l" if lateral < 0 else "r"


def _is_lengthwise(drawing: Drawing, chain: Chain, middle: float) -> bool:
    """Return whether an appendage lies along the midline."""
    base, tip = drawing.places[chain[0]], drawing.places[chain[-1]]
    length = math.dist(base, tip)
    return bool(
        abs(tip[0] - base[0]) <= MIDLINE_TOLERANCE * length
        and abs(tip[0] - middle) <= MIDLINE_TOLERANCE * length
    )


@dataclass(frozen=True, slots=True)
class Appendage:
    """A chain of nodes from its base to its tip.

    Attributes:
        kind: leg, arm, head, tail, feeler, horn or wing.
        nodes: node numbers; the first is the base, a node of the body or of the carrying
            appendage.
        side: "l", "r" or "m", as drawn.
        reason: why it is of this kind.
    """

    kind: str
    nodes: Chain
    side: str = "m"
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Remark:
    """A hint about a drawing that its author may not have intended.

    Attributes:
        node: name of the node.
        text: of the hint.
        is_fault: whether it is likely a mistake, which the films of the figure show.
    """

    node: str
    text: str
    is_fault: bool = False

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, slots=True)
class Anatomy:
    """The parts of a drawing.

    Attributes:
        body: node numbers of the body.
        bones: connections within the body.
        appendages: legs (left and right, each front to back), arms, head, tail, feelers, horns,
            wings; one that carries others comes before them.
        ignored: nodes outside the largest connected group, and toes.
        warnings: hints to the author.
    """

    body: tuple[int, ...]
    bones: tuple[tuple[int, int], ...]
    appendages: tuple[Appendage, ...]
    ignored: tuple[int, ...]
    warnings: tuple[Remark, ...] = ()

    def of_kind(self, kind: str) -> tuple[Appendage, ...]:
        """Return the appendages of one kind, in order."""
        return tuple(a for a in self.appendages if a.kind == kind)


def analyse(
    drawing: Drawing,
    overrides: Mapping[str, str],
    style: Style = "insect",
    pitch_deg: float = 0.0,
) -> Anatomy:
    """Return the anatomy of a drawing.

    Args:
        drawing: the flat network.
        overrides: kind by name of a tip, or "body" by name of any node, given by the author.
        style: of the figure.
        pitch_deg: how far a mammal's body is raised at its front.

    Raises:
        SceneError: the drawing has no connection, or an override does not suit its node. Its paths
            are relative to the figure.
    """
    if not drawing.connections:
        nodes = " and ".join(f"'{name}'" for name in drawing.names[:2])
        message = f"the figure has no connections; join its nodes, such as {nodes}, in a chain"
        raise SceneError([Problem("chains", message)])
    group = largest_group(drawing.neighbours)
    adjacency = {n: set(drawing.neighbours[n]) for n in sorted(group)}
    _check_overrides(drawing, adjacency, overrides)
    given_kinds = {n: overrides[name] for n, name in enumerate(drawing.names) if name in overrides}
    fixed = {n for n, kind in given_kinds.items() if kind == BODY}
    full_adjacency = dict(adjacency)
    # All are followed before any is removed: two of them turn their common node into a base.
    stops = _find_stops(adjacency, fixed)
    twigs = {
        _follow_inward(adjacency, n, stops): given_kinds[n]
        for n in adjacency
        if given_kinds.get(n) in TWIGS
    }
    adjacency = _without(adjacency, twigs)
    guesses = LimbGuesses()
    if not _is_chain(adjacency):
        guesses = guess_limbs(drawing, adjacency, given_kinds, style, pitch_deg)
        twigs |= {chain: guesses.kinds[chain[-1]] for chain in guesses.twigs}
        adjacency = _without(adjacency, [*guesses.twigs, *guesses.toes])
    toes = {n for chain in guesses.toes for n in chain[1:]}
    stops = _find_stops(adjacency, fixed)
    tips = [n for n in adjacency if len(adjacency[n]) == 1 and n not in fixed]
    chains = [chain for tip in tips if len(chain := _follow_inward(adjacency, tip, stops)) > 1]
    known_kinds = guesses.kinds | given_kinds
    kinds = classify_appendages(drawing, chains, known_kinds, not _is_chain(adjacency)) | twigs
    body = set(adjacency) - {n for chain in chains for n in chain[1:]}
    appendages = [
        Appendage(
            kinds[chain],
            chain,
            appendage_side(drawing, chain),
            _reason(drawing, chain, kinds[chain], given_kinds, guesses),
        )
        for chain in sort_appendages(drawing, kinds)
    ]
    remarks = _find_remarks(drawing, full_adjacency, body, kinds, guesses.toes)
    return Anatomy(
        body=tuple(sorted(body)),
        bones=tuple((a, b) for a, b in drawing.connections if a in body and b in body),
        appendages=tuple(_carriers_first(appendages)),
        ignored=tuple(n for n in range(len(drawing.names)) if n not in group or n in toes),
        warnings=tuple(remarks),
    )


def _without(adjacency: Adjacency, chains: Iterable[Chain]) -> dict[int, set[int]]:
    """Return a network without chains, but with their bases."""
    gone = {node for chain in chains for node in chain[1:]}
    return {n: others - gone for n, others in adjacency.items() if n not in gone}


def _carriers_first(appendages: Sequence[Appendage]) -> Iterator[Appendage]:
    """Yield appendages in their order, but those that carry others before these."""
    waiting = list(appendages)
    while waiting:
        ends = {n for appendage in waiting for n in appendage.nodes[1:]}
        ready = next(appendage for appendage in waiting if appendage.nodes[0] not in ends)
        waiting.remove(ready)
        yield ready


def _reason(
    drawing: Drawing,
    chain: Chain,
    kind: str,
    given_kinds: Mapping[int, str],
    guesses: LimbGuesses,
) -> str:
    """Return why an appendage is of its kind."""
    tip = chain[-1]
    if tip in given_kinds:
        return "parts says so"
    if tip in guesses.reasons:
        return guesses.reasons[tip]
    if kind == HEAD:
        return "points ahead along the midline, from the foremost base"
    if kind == TAIL:
        return "points back along the midline, from the rearmost base"
    if appendage_side(drawing, chain) == "m":
        return "in the middle, neither head nor tail"
    return "a limb at the side that can stand beside the others"


def _find_stops(adjacency: Adjacency, fixed: set[int]) -> set[int]:
    """Return the nodes at which appendages end on their way inward."""
    fixed = fixed & set(adjacency)
    stops = fixed | {n for n, others in adjacency.items() if len(others) > 2}
    if stops or not _is_chain(adjacency):
        return stops
    # The middle node, or the middle link, is the body.
    chain = _follow_inward(
        adjacency, next(n for n, others in adjacency.items() if len(others) <= 1), set()
    )
    n = len(chain)
    return set(chain) if n == 2 else set(chain[(n - 1) // 2 : n // 2 + 1])


def _is_chain(adjacency: Adjacency) -> bool:
    """Return whether a group is one chain without a branch."""
    counts = [len(others) for others in adjacency.values()]
    return max(counts) <= 2 and min(counts) <= 1


def _follow_inward(adjacency: Adjacency, tip: int, stops: set[int]) -> Chain:
    """Return the nodes from the base, the first stop on the way inward, out to `tip`."""
    chain, before = [tip], -1
    while chain[-1] not in stops:
        onward = [n for n in sorted(adjacency[chain[-1]]) if n != before]
        if not onward:
            break
        before = chain[-1]
        chain.append(onward[0])
    return tuple(reversed(chain))


def _check_overrides(drawing: Drawing, adjacency: Adjacency, overrides: Mapping[str, str]) -> None:
    """Refuse overrides that do not suit their nodes."""
    number = {name: n for n, name in enumerate(drawing.names)}
    loops = loop_groups(adjacency)
    tips = [drawing.names[n] for n, others in adjacency.items() if len(others) == 1]
    problems = []
    for name, kind in overrides.items():
        node = number.get(name)
        loop = next((group for group in loops if node in group), None)
        if node is None:
            message = f"no node is called '{name}', {hint(name, number)}"
        elif node not in adjacency:
            message = f"'{name}' is not connected to the figure, so it is no part of it"
        elif kind == BODY or name in tips:
            continue
        elif loop is not None:
            around = list_names(drawing, loop)
            message = f"'{name}' is on a loop ({around}), which can only be body, not a {kind}"
        else:
            message = f"'{name}' is no tip of the figure; {_tips_hint(name, tips)}"
        problems.append(Problem(f"parts.{name}", message))
    if problems:
        raise SceneError(problems)


def _tips_hint(name: str, tips: list[str]) -> str:
    return f"the tips are {', '.join(sorted(tips))}" if tips else "it has none"


def list_names(drawing: Drawing, nodes: set[int], limit: int = 6) -> str:
    """Return the names of nodes in drawing order, the first few of many."""
    names = [f"'{drawing.names[n]}'" for n in sorted(nodes)]
    return ", ".join(names[:limit]) + (", ..." if len(names) > limit else "")


def _find_remarks(
    drawing: Drawing,
    adjacency: Adjacency,
    body: set[int],
    kinds: Mapping[Chain, str],
    toes: Sequence[Chain],
) -> Iterator[Remark]:
    """Yield hints to the author."""
    ignored = set(range(len(drawing.names))) - set(adjacency)
    if ignored:
        are = "are" if len(ignored) > 1 else "is"
        text = f"{list_names(drawing, ignored)} {are} not connected to the rest and ignored"
        yield Remark(drawing.names[min(ignored)], text, True)
    for toe in toes:
        text = f"'{drawing.names[toe[-1]]}' is a toe or a finger of its limb and left out; write "
        yield Remark(drawing.names[toe[-1]], f"{text}`feet: toes` for toes that are seen")
    yield from _joined_loops(drawing, adjacency)
    chain = _is_chain(adjacency)
    if LEG not in kinds.values() and not chain:
        name = drawing.names[min(body)]
        yield Remark(name, "there is no leg: the figure can stand and pose, but not walk")
    if chain:
        text = (
            f"the figure is one chain without a branch: {list_names(drawing, body)} is its body; "
            "say otherwise with parts: {node: body}. Drawn straight it walks as an inchworm"
        )
        yield Remark(drawing.names[min(body)], text)
    ends = {n for chain in (*kinds, *toes) for n in chain[1:]}
    for n in sorted(set(adjacency) - ends):
        if drawing.shapes[n] != "round":
            text = f"no link ends at '{drawing.names[n]}', so its shape is not used"
            yield Remark(drawing.names[n], text)
    yield from _side_loops(drawing, adjacency)
    yield from _close_nodes(drawing, adjacency)


def _close_nodes(drawing: Drawing, adjacency: Adjacency) -> Iterator[Remark]:
    """Yield hints about nodes on top of one another."""
    nodes = sorted(adjacency)
    places = drawing.places[nodes]
    gaps = np.linalg.norm(places[:, None] - places[None], axis=-1)
    close = np.triu(gaps <= CLOSE_NODES * float(np.ptp(drawing.places, axis=0).max()), 1)
    for i, j in np.argwhere(close).tolist():
        a, b = nodes[i], nodes[j]
        one, other = drawing.names[a], drawing.names[b]
        if b in adjacency[a]:
            text = f"'{one}' and '{other}' are joined and only {gaps[i, j]:.1g} m apart"
        else:
            where = "at the same place" if gaps[i, j] == 0.0 else f"{gaps[i, j]:.1g} m apart"
            text = f"'{one}' and '{other}' are {where} and not connected"
        yield Remark(other, f"{text}; one node is enough", True)


def _side_loops(drawing: Drawing, adjacency: Adjacency) -> Iterator[Remark]:
    """Yield hints about loops beside the midline, which make a limb a part of the body."""
    x = drawing.places[:, 0] - midline(drawing)
    beside = [
        loop
        for loop in loop_groups(adjacency)
        if all(x[n] > 0.0 for n in loop) or all(x[n] < 0.0 for n in loop)
    ]
    if beside:
        around = " and of ".join(list_names(drawing, loop, 3) for loop in beside[:2])
        loops, lie = ("the loop", "lies") if len(beside) == 1 else ("the loops", "lie")
        text = f"{loops} of {around} {lie} beside the midline: loops and the limbs that carry them "
        yield Remark(drawing.names[min(beside[0])], f"{text}are body and do not bend", True)


def _joined_loops(drawing: Drawing, adjacency: Adjacency) -> Iterator[Remark]:
    """Yield hints about loops that a bridge joins, which makes it a part of the body."""
    loops = loop_groups(adjacency)
    core = loop_core(adjacency)
    between: dict[int, set[int]] = {n: set() for n in core}
    for a, b in find_bridges(core):
        between[a].add(b)
        between[b].add(a)
    home = {n: i for i, loop in enumerate(loops) for n in loop}
    reported = set[frozenset[int]]()
    for start in sorted(between):
        if start not in home:
            continue
        for step in sorted(between[start]):
            way = [start, step]
            while way[-1] not in home:
                way.append(next(n for n in sorted(between[way[-1]]) if n != way[-2]))
            ends = frozenset((start, way[-1]))
            if ends in reported:
                continue
            reported.add(ends)
            first_loop, second_loop = loops[home[start]], loops[home[way[-1]]]
            bridge = " - ".join(f"'{drawing.names[n]}'" for n in way)
            text = (
                f"the loops of {list_names(drawing, first_loop, 3)} and of "
                f"{list_names(drawing, second_loop, 3)} are "
                f"joined by the bridge {bridge}, which is part of the body and does not bend"
            )
            yield Remark(drawing.names[start], text)
