"""Connected groups, loops and bridges of a network of nodes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

Adjacency = Mapping[int, set[int]]
"""Connected nodes of each node."""


def largest_group(neighbours: Sequence[Iterable[int]]) -> set[int]:
    """Return the nodes of the largest connected group; among equals the first drawn."""
    adjacency = {node: set(others) for node, others in enumerate(neighbours)}
    return max(connected_groups(adjacency), key=len, default=set[int]())


def connected_groups(adjacency: Adjacency) -> list[set[int]]:
    """Return the connected groups, ordered by their lowest nodes."""
    found, seen = [], set[int]()
    for start in sorted(adjacency):
        if start in seen:
            continue
        group, edge = set[int](), [start]
        while edge:
            node = edge.pop()
            if node not in group:
                group.add(node)
                edge.extend(adjacency[node])
        seen |= group
        found.append(group)
    return found


def loop_core(adjacency: Adjacency) -> dict[int, set[int]]:
    """Return the loops and what joins them: the network without its trees."""
    core = {node: set(others) for node, others in adjacency.items()}
    tips = [node for node in core if len(core[node]) <= 1]
    while tips:
        tip = tips.pop()
        for other in core.pop(tip, set()):
            core[other].discard(tip)
            if len(core[other]) == 1:
                tips.append(other)
    return core


def find_bridges(adjacency: Adjacency) -> set[tuple[int, int]]:
    """Return the connections, lower node first, whose removal disconnects a group.

    Source: Tarjan 1974, "A note on finding the bridges of a graph", without recursion.
    """
    entered: dict[int, int] = {}
    reach: dict[int, int] = {}
    found = set()
    for root in sorted(adjacency):
        if root in entered:
            continue
        entered[root] = reach[root] = len(entered)
        path = [(root, -1, iter(sorted(adjacency[root])))]
        while path:
            node, before, others = path[-1]
            for other in others:
                if other == before:
                    continue
                if other in entered:
                    reach[node] = min(reach[node], entered[other])
                    continue
                entered[other] = reach[other] = len(entered)
                path.append((other, node, iter(sorted(adjacency[other]))))
                break
            else:
                path.pop()
                if before >= 0:
                    reach[before] = min(reach[before], reach[node])
                    if reach[node] > entered[before]:
                        found.add((min(before, node), max(before, node)))
    return found


def loop_groups(adjacency: Adjacency) -> list[set[int]]:
    """Return the nodes of each group of loops that no bridge separates."""
    core = loop_core(adjacency)
    for a, b in find_bridges(core):
        core[a].discard(b)
        core[b].discard(a)
    return [group for group in connected_groups(core) if len(group) > 1]
