"""Joint facts: links, joints and masses of a figure as the page poses and changes them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pipeline.simulation.figure_analysis import BODY, Figure, FigureMass, Limb

MIRRORED_WITHIN = 1e-6
"""Distance of tips, in the figure's size, within which two limbs are mirror images."""

MIRROR = np.diag([1.0, 1.0, -1.0])
"""Left to right, in the creation frame."""


def posed_facts(figure: Figure) -> dict[str, Any]:
    """Return masses of limbs and the body, and the links with their joints, as plain values.

    Returns:
        `masses` [kg] by limb; `links` without the body, each after its parent, with its place and
        direction in the creation frame [m], and with its joints from the parent outward: axis in
        the creation frame, limits and rest [degrees, or m for one that slides], and the joint of
        the twin limb with the sign of its value.
    """
    skeleton, inertia = figure.skeleton, FigureMass(figure)
    owner = {link.joint: link.name for link in skeleton.links}
    twins = _twins(figure)
    number = {name: j for j, name in enumerate(skeleton.joint_names)}
    links = []
    for link in skeleton.links[1:]:
        chain, above = [link.joint], int(skeleton.parents[link.joint])
        while above not in owner:
            chain.append(above)
            above = int(skeleton.parents[above])
        twin = twins.get(link.limb)
        joints = []
        for j in reversed(chain):
            name = skeleton.joint_names[j].rpartition(".")[2]
            slides = bool(skeleton.prismatic[j])
            unit = 1.0 if slides else math.degrees(1.0)
            facts: dict[str, Any] = {
                "name": name,
                "slides": slides,
                "axis": skeleton.axes[j].tolist(),
                "twin_sign": None,
            }
            for key in ("lower", "upper", "preferred"):
                facts[key] = round(float(getattr(skeleton, key)[j]) * unit, 4) + 0.0
            other = number.get(f"{twin}.{name}")
            if other is not None:
                # A turn about an axis is, mirrored, the opposite turn about the mirrored axis.
                same = float(MIRROR @ skeleton.axes[j] @ skeleton.axes[other])
                facts["twin_sign"] = 1 if slides or same < 0.0 else -1
            joints.append(facts)
        links.append(
            {
                "name": link.name,
                "limb": link.limb,
                "kind": link.kind,
                "twin": twin,
                "parent": owner[above] if above != BODY else "body",
                "place": link.ends[0].tolist(),
                "along": (link.ends[1] - link.ends[0]).tolist(),
                "joints": joints,
            }
        )
    masses = {limb.name: inertia.mass_of(limb.links) for limb in skeleton.limbs}
    return {"masses": {"body": inertia.of_link(0).mass, **masses}, "links": links}


def _twins(figure: Figure) -> dict[str, str]:
    """Return the mirror image of each limb that has one."""
    within = MIRRORED_WITHIN * float(np.ptp(figure.points, axis=0).max())
    found = {}
    for limb in figure.skeleton.limbs:
        for other in figure.skeleton.limbs:
            is_other_side = {limb.side, other.side} == {"l", "r"} and limb.kind == other.kind
            same = is_other_side and len(limb.joints) == len(other.joints)
            if same and _is_mirrored(limb, other, within):
                found[limb.name] = other.name
    return found


def _is_mirrored(limb: Limb, other: Limb, within: float) -> bool:
    return bool(np.abs(MIRROR @ limb.tip - other.tip).max() <= within)
