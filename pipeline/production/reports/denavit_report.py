"""Figure table: the Denavit-Hartenberg parameters of all limbs, for people to read."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.simulation.figures.denavit_hartenberg import DenavitRow, denavit_table
from pipeline.simulation.figures.figure import Figure

HEAD = "  {:<16} {:<18} {:<9} {:>10} {:>10} {:>10} {:>10}"
ROW = "  {:<16} {:<18} {:<9} {:>10.4f} {:>10.6f} {:>10.6f} {:>10.4f}"


def denavit_text(figure: Figure) -> str:
    """Return a table of four numbers a joint, limb by limb."""
    rows = denavit_table(figure.skeleton)
    words = ("joint", "after", "kind", "theta", "r", "a", "alpha")
    lines = ["  Denavit-Hartenberg parameters [degrees, m, m, degrees]", HEAD.format(*words)]
    for limb in figure.skeleton.limbs:
        lines.append(f"  {limb.name}")
        lines += _lines(limb.name, [rows[j] for j in limb.joints])
    return "\n".join(line.rstrip() for line in lines)


def _lines(limb: str, rows: list[DenavitRow]) -> Iterator[str]:
    """Give the lines of a limb; its own joints without its name."""
    for row in rows:
        joint, after = (f"  {name.removeprefix(f'{limb}.')}" for name in (row.joint, row.parent))
        # No minus before a number that is shown as zero.
        numbers = (
            round(value, places) + 0.0
            for value, places in ((row.theta_deg, 4), (row.r, 6), (row.a, 6), (row.alpha_deg, 4))
        )
        yield ROW.format(joint, after.strip(), row.kind, *numbers)
