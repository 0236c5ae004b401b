"""Figure report: what the analysis made of a drawing, in lines of text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass


def headline(figure: Figure) -> str:
    """Return what a figure is, in one line."""
    width, length = np.ptp(figure.drawing.places, axis=0) * figure.scale
    kinds = Counter(limb.kind for limb in figure.skeleton.limbs)
    limbs = [counted(n, kind) for kind, n in kinds.items()]
    joints = counted(len(figure.skeleton.joint_names), "joint")
    size = f"drawn {width:.3g} x {length:.3g} m"
    return ", ".join([figure.style, *(limbs or ["no limbs"]), joints, size])


def report(figure: Figure, inertia: FigureMass) -> str:
    """Return all that the analysis found, one part a line, and what the parts weigh."""
    drawing, anatomy = figure.drawing, figure.anatomy
    nodes = counted(len(drawing.names), "node")
    connections = counted(len(drawing.connections), "connection")
    lines = [f"{figure.name}: {headline(figure)}; {nodes}, {connections}"]
    lines += _wrapped("body", f"{_names(figure, anatomy.body)}")
    lines += _wrapped("mass", _weight(inertia))
    for appendage, limb in zip(anatomy.appendages, figure.skeleton.limbs, strict=True):
        links, joints = counted(len(limb.links), "link"), counted(len(limb.joints), "joint")
        weight = _weights([inertia.links[i].mass for i in limb.links])
        chain = " - ".join(drawing.names[n] for n in appendage.nodes)
        text = f"{limb.kind}, {links}, {joints}, {limb.length:.3g} m: {chain}; {weight}"
        lines += _wrapped(limb.name, text)
    if anatomy.ignored:
        lines += _wrapped("ignored", _names(figure, anatomy.ignored))
    lines += [line for remark in anatomy.warnings for line in _wrapped("warning", str(remark))]
    return "\n".join(lines)


def counted(n: int, thing: str) -> str:
    """Return a number of things: "1 joint", "2 joints"."""
    return f"{n} {thing}" if n == 1 else f"{n} {thing}s"


def _weight(inertia: FigureMass) -> str:
    """Return what the whole figure weighs, and where its centre of mass is."""
    whole, body = inertia.at_rest, inertia.links[0].mass
    # No minus before a number that is shown as zero.
    x, y, z = (float(value) + 0.0 for value in whole.centre.round(3))
    weight = f"{whole.mass:.4g} kg, body {body:.3g} kg"
    return f"{weight}; centre of mass at rest ({x:.3f}, {y:.3f}, {z:.3f}) m from the body's origin"


def _weights(masses: Sequence[float]) -> str:
    """Return what a limb weighs, and each of its links from base to tip."""
    one_by_one = " + ".join(f"{mass:.3g}" for mass in masses)
    return f"{sum(masses):.3g} kg" + (f" ({one_by_one})" if len(masses) > 1 else "")


def _names(figure: Figure, nodes: Sequence[int]) -> str:
    return ", ".join(figure.drawing.names[n] for n in nodes)


def _wrapped(head: str, text: str, width: int = 92) -> Iterator[str]:
    """Give the lines of a part, its name before the first of them."""
    line = ""
    for word in text.split(" "):
        if line and len(line) + len(word) >= width:
            yield f"  {head:<11} {line}"
            head, line = "", ""
        line = f"{line} {word}" if line else word
    yield f"  {head:<11} {line}"
