"""Node names: links and drawing nodes of the performers, as numbers of nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.pose_plan import PartNames
from pipeline.simulation.mechanism import NodeAlias
from pipeline.simulation.take import Node, Take
from pipeline.spec.suggestions import hint


def node_aliases(figures: Mapping[str, Figure], nodes: Sequence[Node]) -> tuple[NodeAlias, ...]:
    """Return the names of drawing nodes that are not those of the nodes that they stand for.

    Args:
        figures: by creature.
        nodes: of all performers.
    """
    numbers = {node.name: i for i, node in enumerate(nodes)}
    links: dict[int, dict[str, str]] = {}
    found = []
    for name, figure in figures.items():
        if id(figure) not in links:
            links[id(figure)] = _links_of(figure)
        for part, link in links[id(figure)].items():
            number = numbers.get(f"{name}.{link}", -1)
            if numbers.get(f"{name}.{part}", -1) != number:
                found.append(NodeAlias(f"{name}.{part}", number))
    return tuple(found)


def _links_of(figure: Figure) -> dict[str, str]:
    """Return the link that ends at each node of a drawing."""
    names, skeleton = PartNames(figure), figure.skeleton
    links = dict.fromkeys(sorted(names.body), "body")
    for part, (limb, link) in names.nodes.items():
        links[part] = skeleton.links[skeleton.limbs[limb].links[link]].name
    return links


@dataclass(frozen=True, eq=False)
class NodeNames:
    """Names of nodes and of the parts of drawings.

    Attributes:
        nodes: name -> number of a node.
        aliases: name of a drawing node -> number of its node, -1 for none.
    """

    nodes: Mapping[str, int]
    aliases: Mapping[str, int]

    @staticmethod
    def of(take: Take) -> NodeNames:
        """Return the names of a take."""
        return NodeNames.joined(take.nodes, take.aliases)

    @staticmethod
    def joined(nodes: Sequence[Node], aliases: Sequence[NodeAlias]) -> NodeNames:
        """Return the names of nodes and their aliases."""
        numbers = {node.name: i for i, node in enumerate(nodes)}
        return NodeNames(numbers, {alias.name: alias.node for alias in aliases})

    def find(self, part_name: str) -> int | str:
        """Return the number of the node of a performer or of one of its parts.

        Args:
            part_name: such as bug, or bug.head.

        Returns:
            The number, or an error message.
        """
        name, _, part = part_name.partition(".")
        if not part:
            for root in (name, f"{name}.body", f"{name}.pelvis"):
                if root in self.nodes:
                    return self.nodes[root]
            return f"'{name}' is a group; name a member, such as {name}.0"
        number = self.aliases.get(part_name, self.nodes.get(part_name, -1))
        if number >= 0:
            return number
        own = [n for n in (*self.nodes, *self.aliases) if n.startswith(f"{name}.")]
        return f"'{name}' has no part '{part}', {hint(part, [n.partition('.')[2] for n in own])}"
