"""Figure report: the analysis of a drawing as lines of text and as plain values.

Units are SI, and degrees where a key ends in `_deg`. Places and axes are those of the creation
frame, in which the figure lies as it was drawn: X forward, Y up, Z right.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from pipeline.errors import Problem
from pipeline.production.reports.figure_size import FigureSize
from pipeline.simulation.figure_analysis import (
    BODY,
    DenavitRow,
    Figure,
    FigureMass,
    MassProperties,
    denavit_table,
    to_denavit,
)

DENAVIT_HEAD = "  {:<16} {:<18} {:<9} {:>10} {:>10} {:>10} {:>10}"
DENAVIT_ROW = "  {:<16} {:<18} {:<9} {:>10.4f} {:>10.6f} {:>10.6f} {:>10.4f}"

LINE_LENGTH = 92
"""Of a part's text [characters]."""


def headline(figure: Figure) -> str:
    """Return a figure in one line: style, limbs, joints, size."""
    width, length = np.ptp(figure.drawing.places, axis=0) * figure.scale
    kinds = Counter(limb.kind for limb in figure.skeleton.limbs)
    limbs = [counted(n, kind) for kind, n in kinds.items()]
    joints = counted(len(figure.skeleton.joint_names), "joint")
    size = f"drawn {width:.3g} x {length:.3g} m"
    return ", ".join([figure.style, *(limbs or ["no limbs"]), joints, size])


def report(figure: Figure, inertia: FigureMass, remarks: Sequence[Problem] = ()) -> str:
    """Return all that the analysis found: parts, masses, what limbs were taken for, remarks."""
    drawing, anatomy = figure.drawing, figure.anatomy
    nodes = counted(len(drawing.names), "node")
    connections = counted(len(drawing.connections), "connection")
    lines = [f"{figure.name}: {headline(figure)}; {nodes}, {connections}"]
    lines += _wrapped("body", f"{_names(figure, anatomy.body)}")
    lines += _wrapped("stands", f"{FigureSize.of(figure).text}, at scale {figure.scale:g}")
    lines += _wrapped("mass", _mass_text(inertia))
    for appendage, limb in zip(anatomy.appendages, figure.skeleton.limbs, strict=True):
        links, joints = counted(len(limb.links), "link"), counted(len(limb.joints), "joint")
        weight = _limb_mass_text([inertia.links[i].mass for i in limb.links])
        chain = " - ".join(drawing.names[n] for n in appendage.nodes)
        text = f"{limb.kind}, {links}, {joints}, {limb.length:.3g} m: {chain}; {weight}"
        lines += _wrapped(limb.name, text)
    if anatomy.ignored:
        lines += _wrapped("ignored", _names(figure, anatomy.ignored))
    lines += _limb_table(figure)
    lines += [line for remark in remarks for line in _wrapped("warning", _placed(remark))]
    return "\n".join(lines)


def _limb_table(figure: Figure) -> Iterator[str]:
    """Yield a table of what limbs were taken for and why, twins of both sides in one row."""
    rows: dict[tuple[str, ...], list[str]] = {}
    for limb, appendage in zip(figure.skeleton.limbs, figure.anatomy.appendages, strict=True):
        tip = figure.drawing.names[appendage.nodes[-1]]
        length = f"{limb.length:.3g} m"
        twins = rows.setdefault((limb.kind, length, appendage.reason), [])
        twins.append(f"{limb.name} ({tip})")
    if rows:
        yield f"  {'taken for':<11} {'because':<58} limbs (tips)"
    for (kind, _, reason), twins in rows.items():
        yield f"  {kind:<11} {reason:<58} {', '.join(twins)}"


def _placed(remark: Problem) -> str:
    """Return a remark after the file and line that it is about."""
    place = f"{remark.file}:{remark.line}: " if remark.line else ""
    return f"{place}{remark.message}"


def counted(n: int, thing: str) -> str:
    """Return a number of things: "1 joint", "2 joints"."""
    return f"{n} {thing}" if n == 1 else f"{n} {thing}s"


def _mass_text(inertia: FigureMass) -> str:
    whole, body = inertia.at_rest, inertia.links[0].mass
    # Adding zero turns -0.0 into 0.0.
    x, y, z = (float(value) + 0.0 for value in whole.centre.round(3))
    weight = f"{whole.mass:.4g} kg, body {body:.3g} kg"
    return f"{weight}; centre of mass at rest ({x:.3f}, {y:.3f}, {z:.3f}) m from the body's origin"


def _limb_mass_text(masses: Sequence[float]) -> str:
    one_by_one = " + ".join(f"{mass:.3g}" for mass in masses)
    return f"{sum(masses):.3g} kg" + (f" ({one_by_one})" if len(masses) > 1 else "")


def _names(figure: Figure, nodes: Sequence[int]) -> str:
    return ", ".join(figure.drawing.names[n] for n in nodes)


def _wrapped(head: str, text: str) -> Iterator[str]:
    """Yield the lines of a part, its name before the first of them."""
    line = ""
    for word in text.split(" "):
        if line and len(line) + len(word) >= LINE_LENGTH:
            yield f"  {head:<11} {line}"
            head, line = "", ""
        line = f"{line} {word}" if line else word
    yield f"  {head:<11} {line}"


def denavit_text(figure: Figure) -> str:
    """Return the Denavit-Hartenberg parameters of all limbs as a table."""
    rows = denavit_table(figure.skeleton)
    heads = ("joint", "after", "kind", "theta", "r", "a", "alpha")
    lines = [
        "  Denavit-Hartenberg parameters [degrees, m, m, degrees]",
        DENAVIT_HEAD.format(*heads),
    ]
    for limb in figure.skeleton.limbs:
        lines.append(f"  {limb.name}")
        lines += _denavit_lines(limb.name, [rows[j] for j in limb.joints])
    return "\n".join(line.rstrip() for line in lines)


def _denavit_lines(limb: str, rows: list[DenavitRow]) -> Iterator[str]:
    """Yield the lines of a limb, its own joints without its name."""
    for row in rows:
        joint, after = (f"  {name.removeprefix(f'{limb}.')}" for name in (row.joint, row.parent))
        # Adding zero turns -0.0 into 0.0.
        numbers = (
            round(value, places) + 0.0
            for value, places in ((row.theta_deg, 4), (row.r, 6), (row.a, 6), (row.alpha_deg, 4))
        )
        yield DENAVIT_ROW.format(joint, after.strip(), row.kind, *numbers)


def facts(figure: Figure, inertia: FigureMass, remarks: Sequence[Problem] = ()) -> dict[str, Any]:
    """Return limbs, remarks, masses, centres of mass and inertias of a figure and its links.

    Those of the whole figure are in its rest pose, in the body's frame.
    """
    skeleton = figure.skeleton
    links = [
        {
            "name": link.name,
            "kind": link.kind,
            "joint": None if link.joint == BODY else skeleton.joint_names[link.joint],
            **_mass_facts(mass),
        }
        for link, mass in zip(skeleton.links, inertia.links, strict=True)
    ]
    whole = _mass_facts(inertia.at_rest)
    limbs = [
        {
            "name": limb.name,
            "kind": limb.kind,
            "nodes": [figure.drawing.names[n] for n in appendage.nodes],
            "length": limb.length,
            "reason": appendage.reason,
        }
        for limb, appendage in zip(skeleton.limbs, figure.anatomy.appendages, strict=True)
    ]
    return {
        "name": figure.name,
        "density": figure.density,
        "size": FigureSize.of(figure).facts,
        "rest": whole,
        "links": links,
        "limbs": limbs,
        "warnings": [asdict(remark) for remark in remarks],
    }


def denavit_facts(figure: Figure) -> list[dict[str, Any]]:
    """Return the Denavit-Hartenberg parameters of all joints.

    `tool` is the frame of the link relative to the Denavit-Hartenberg frame: parallel to the
    creation frame at joint values zero, at the joint's place, as four rows of four numbers.
    """
    rows, tools = denavit_table(figure.skeleton), to_denavit(figure.skeleton).tools
    return [{**asdict(row), "tool": tool.tolist()} for row, tool in zip(rows, tools, strict=True)]


def _mass_facts(mass: MassProperties) -> dict[str, Any]:
    return {
        "mass": mass.mass,
        "centre": mass.centre.tolist(),
        "inertia": mass.inertia.tolist(),
    }
