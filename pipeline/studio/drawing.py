"""Drawing: what the figure editor of the page changes of a figure, as plain values.

All else of a figure file, such as its skin and its comments, stays as it was read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pipeline.errors import UsageError
from pipeline.spec import Figure

MIRRORED: tuple[Mapping[str, str], ...] = ({"mirror": "x"},)
"""The operations of a figure whose left half alone is drawn."""

SETTINGS = ("style", "feet")
"""Keys of a figure whose values are names, that the page offers to change."""

MAPPINGS = ("parts", "joints", "masses")
"""Keys of a figure whose values are mappings, that the page offers to change."""

JOINT_KEYS = ("rest_deg", "limits_deg", "rest", "slide")
"""Of the settings of a joint."""

Joint = dict[str, float | list[float]]
"""Settings of a joint by `JOINT_KEYS`."""


@dataclass(frozen=True, slots=True)
class DrawnNode:
    """A node as it is written in the file.

    Attributes:
        at: x to the right, y towards the tail [m].
        radius: of the links here [m]; None for the figure's.
    """

    at: tuple[float, float]
    radius: float | None = None


@dataclass(frozen=True, slots=True)
class DrawnFigure:
    """What the editor changes.

    Attributes:
        nodes: by name, before any operation, in the order of the file.
        chains: lists of connected nodes.
        is_mirrored: whether `then: [mirror: x]` follows; None where other operations follow,
            which the editor leaves alone.
        parts: kinds by the node that ends them.
        settings: values of `SETTINGS` that are given.
        joints: by limb and joint, those that are not as their style makes them.
        masses: by limb, those that are not by volume [kg].
    """

    nodes: dict[str, DrawnNode] = field(default_factory=dict)
    chains: tuple[tuple[str, ...], ...] = ()
    is_mirrored: bool | None = False
    parts: dict[str, str] = field(default_factory=dict)
    settings: dict[str, str] = field(default_factory=dict)
    joints: dict[str, dict[str, Joint]] = field(default_factory=dict)
    masses: dict[str, float] = field(default_factory=dict)

    @staticmethod
    def of(figure: Figure) -> DrawnFigure:
        """Return the drawing of a figure."""
        then = [operation.model_dump(exclude_unset=True) for operation in figure.then]
        mirrored = True if then == list(MIRRORED) else None
        given = figure.model_fields_set
        return DrawnFigure(
            {name: DrawnNode(node.at, node.radius) for name, node in figure.nodes.items()},
            figure.chains,
            mirrored if then else False,
            dict(figure.parts),
            {key: str(getattr(figure, key)) for key in SETTINGS if key in given},
            {
                limb: {
                    name: joint.model_dump(mode="json", exclude_unset=True)
                    for name, joint in joints.items()
                }
                for limb, joints in figure.joints.items()
            },
            dict(figure.masses),
        )

    @staticmethod
    def from_json(plain: Any) -> DrawnFigure:
        """Return the drawing of a message of the page.

        Raises:
            UsageError: the message holds no drawing.
        """
        try:
            nodes = {
                str(name): DrawnNode(
                    (float(node["at"][0]), float(node["at"][1])),
                    None if node.get("radius") is None else float(node["radius"]),
                )
                for name, node in plain["nodes"].items()
            }
            mirrored = plain.get("is_mirrored")
            return DrawnFigure(
                nodes,
                tuple(tuple(str(name) for name in chain) for chain in plain["chains"]),
                None if mirrored is None else bool(mirrored),
                {str(tip): str(kind) for tip, kind in plain.get("parts", {}).items()},
                {key: str(plain["settings"][key]) for key in SETTINGS if key in plain["settings"]},
                {
                    str(limb): {str(name): _joint(joint) for name, joint in joints.items()}
                    for limb, joints in plain.get("joints", {}).items()
                },
                {str(limb): float(mass) for limb, mass in plain.get("masses", {}).items()},
            )
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            raise UsageError(f"the message holds no drawing ({error!r})") from None

    def as_json(self) -> dict[str, Any]:
        """Return the drawing as a message."""
        return {
            "nodes": {
                name: {"at": list(node.at), "radius": node.radius}
                for name, node in self.nodes.items()
            },
            "chains": [list(chain) for chain in self.chains],
            "is_mirrored": self.is_mirrored,
            "parts": self.parts,
            "settings": self.settings,
            "joints": self.joints,
            "masses": self.masses,
        }


def _joint(plain: Any) -> Joint:
    """Return the settings of a joint of a message."""
    return {
        key: [float(v) for v in plain[key]] if isinstance(plain[key], list) else float(plain[key])
        for key in JOINT_KEYS
        if plain.get(key) is not None
    }
