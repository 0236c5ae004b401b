"""Network: which parts of a drawing are body, legs, head, tail and feelers.

The largest connected group is kept. Nodes with one connection are tips; each is
followed inward until a node with more than two connections, its base (the thesis
says "more than one", which would end every appendage at its second node).
Whatever belongs to no appendage is the body, so loops fall into it.

Feelers, which an author names, are followed and taken away first: what carries
them is then judged as if they were not there, so a head with antennae is a head.

Source: Sims 1987, 4.2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.drawing import Drawing

LEG, ARM, HEAD, TAIL, FEELER = "leg", "arm", "head", "tail", "feeler"


@dataclass(frozen=True, slots=True)
class Appendage:
    """A chain of nodes from its base to its tip.

    Attributes:
        kind: leg, head, tail or feeler.
        nodes: node numbers; the first is the base, a node of the body or of what carries it.
    """

    kind: str
    nodes: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Anatomy:
    """A drawing with its parts told apart.

    Attributes:
        body: node numbers of the body.
        bones: connections within the body.
        appendages: legs (left and right, each front to back), head, tail, feelers.
        ignored: nodes outside the largest connected group.
    """

    body: tuple[int, ...]
    bones: tuple[tuple[int, int], ...]
    appendages: tuple[Appendage, ...]
    ignored: tuple[int, ...]

    def of_kind(self, kind: str) -> tuple[Appendage, ...]:
        """Return the appendages of one kind, in order."""
        return tuple(a for a in self.appendages if a.kind == kind)


def analyse(drawing: Drawing, overrides: Mapping[str, str]) -> Anatomy:
    """Tell the parts of `drawing` apart.

    Args:
        drawing: the flat network.
        overrides: name of a tip -> kind, where the author knows better.

    Raises:
        SceneError: if the drawing has no connection at all, or an override names a
            node that is no tip. Its paths are relative to the figure.
    """
    if not drawing.connections:
        raise SceneError([Problem("chains", "the figure has no connections: join nodes here")])
    group = _largest_group(drawing)
    links = {n: set(drawing.neighbours[n]) for n in group}
    _check_overrides(drawing, links, overrides)
    # All are followed before any is taken away: a pair of them makes their base a base.
    feelers = tuple(
        Appendage(FEELER, _follow(links, n))
        for n in sorted(group)
        if overrides.get(drawing.names[n]) == FEELER
    )
    for feeler in feelers:
        _detach(links, feeler.nodes)
    tips = [n for n in sorted(links) if len(links[n]) == 1]
    chains = [_follow(links, tip) for tip in tips]
    # A drawing without branches is one chain; it is all body, and nothing hangs on it.
    chains = [chain for chain in chains if len(links[chain[0]]) > 2]
    limbs = _sort(drawing, chains, overrides)
    limb_nodes = {n for chain in chains for n in chain[1:]}
    body = tuple(n for n in sorted(links) if n not in limb_nodes)
    inside = set(body)
    bones = tuple((a, b) for a, b in drawing.connections if a in inside and b in inside)
    ignored = tuple(n for n in range(len(drawing.names)) if n not in group)
    return Anatomy(body, bones, limbs + feelers, ignored)


def _largest_group(drawing: Drawing) -> set[int]:
    """Return the nodes of the largest connected group; the first drawn wins a draw."""
    left, best = set(range(len(drawing.names))), set[int]()
    while left:
        group, edge = set[int](), [min(left)]
        while edge:
            node = edge.pop()
            if node not in group:
                group.add(node)
                edge.extend(drawing.neighbours[node])
        left -= group
        best = max(best, group, key=len)
    return best


def _check_overrides(
    drawing: Drawing, links: Mapping[int, set[int]], overrides: Mapping[str, str]
) -> None:
    tips = {drawing.names[n] for n, others in links.items() if len(others) == 1}
    allowed = f"is no tip of the figure; the tips are {', '.join(sorted(tips)) or 'none'}"
    problems = [Problem(f"parts.{name}", allowed) for name in overrides if name not in tips]
    if problems:
        raise SceneError(problems)


def _follow(links: Mapping[int, set[int]], tip: int) -> tuple[int, ...]:
    """Return the nodes from the base to `tip`, the base having more than two connections."""
    chain, before = [tip], -1
    while True:
        onward = [n for n in sorted(links[chain[-1]]) if n != before]
        if (len(chain) > 1 and len(links[chain[-1]]) > 2) or not onward:
            return tuple(reversed(chain))
        before = chain[-1]
        chain.append(onward[0])


def _detach(links: dict[int, set[int]], chain: tuple[int, ...]) -> None:
    """Take `chain`, all but its base, out of `links`."""
    for node in chain[1:]:
        for other in links.pop(node):
            links.get(other, set()).discard(node)


def _sort(
    drawing: Drawing, chains: list[tuple[int, ...]], overrides: Mapping[str, str]
) -> tuple[Appendage, ...]:
    """Sort chains into legs (left, then right, front to back), head and tail."""
    kinds = {chain: overrides.get(drawing.names[chain[-1]], "") for chain in chains}
    guess = [chain for chain in chains if not kinds[chain]]
    # Head and tail lie along the midline: they are longer than they are wide.
    middle = [c for c in guess if _is_lengthwise(drawing, c)]
    front = min(middle, key=lambda c: drawing.places[c[-1]][1], default=None)
    back = max(middle, key=lambda c: drawing.places[c[-1]][1], default=None)
    for chain in guess:
        kinds[chain] = LEG
    bases_y = [drawing.places[c[0]][1] for c in chains]
    middle_y = (min(bases_y) + max(bases_y)) / 2 if bases_y else 0.0
    if front is not None and drawing.places[front[-1]][1] < middle_y:
        kinds[front] = HEAD
    if back is not None and kinds[back] == LEG and drawing.places[back[-1]][1] > middle_y:
        kinds[back] = TAIL

    def order(chain: tuple[int, ...]) -> tuple[int, bool, float, float]:
        rank = (LEG, ARM, HEAD, TAIL, FEELER).index(kinds[chain])
        x, y = drawing.places[list(chain)].mean(axis=0)
        return rank, bool(x > 0), float(drawing.places[chain[0]][1]), float(y)

    return tuple(Appendage(kinds[chain], chain) for chain in sorted(chains, key=order))


def _is_lengthwise(drawing: Drawing, chain: tuple[int, ...]) -> bool:
    x, y = np.abs(drawing.places[chain[-1]] - drawing.places[chain[0]])
    off_axis = abs(float(drawing.places[chain[-1]][0]))
    return bool(x < 0.3 * y and off_axis < 0.3 * max(float(y), 1e-9))
