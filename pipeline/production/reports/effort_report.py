"""Effort report: what the motions of a scene's creatures take, for people and programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from audio.atomic_file import write_if_changed
from pipeline.production.reports.effort import Effort, efforts, legged_of
from pipeline.production.run.order import Order
from pipeline.production.run.production import take_of, working
from pipeline.production.run.progress import Reporter
from pipeline.simulation.dynamics.gravity import GRAVITY

HEADS = ("", "mass", "way", "mean power", "energy", "cost", "largest torque", "unbalanced")


@dataclass(frozen=True, slots=True)
class Told:
    """A report.

    Attributes:
        text: a table.
        facts: the same and more, one mapping a creature.
    """

    text: str
    facts: list[dict[str, Any]]


def report_effort(order: Order, reporter: Reporter, with_csv: bool = False) -> Told:
    """Return what the motions of a scene's creatures take, simulating if need be.

    Args:
        order: the scene.
        reporter: where to say what is done.
        with_csv: whether to write all torques over time into the scene's folder.

    Raises:
        PronkError: nobody stands on legs, or something cannot be made.
    """
    legged = legged_of(order.scene)
    with working(order, reporter) as run:
        found = efforts(legged, take_of(run))
        text = table(found)
        if with_csv:
            file = run.outputs.folder / f"{order.name}_torques.csv"
            write_if_changed(file, torques_csv(found).encode("utf-8"))
            text += f"\n{file}"
    return Told(text, [facts(effort) for effort in found])


def facts(effort: Effort) -> dict[str, Any]:
    """Return what is told of one creature, for other programs; SI units throughout."""
    weight = effort.mass * GRAVITY
    names = effort.figure.skeleton.joint_names
    return {
        "name": effort.name,
        "mass": effort.mass,
        "distance": effort.distance,
        "seconds": float(effort.times[-1] - effort.times[0]),
        "mean_power": effort.mean_power,
        "energy": effort.energy,
        "cost_of_transport": effort.cost_of_transport,
        "largest_torques": dict(zip(names, effort.largest.tolist(), strict=True)),
        "largest_ground_force": {
            leg: float(np.linalg.norm(effort.feet[:, i], axis=-1).max())
            for i, leg in enumerate(effort.legs)
        },
        "mean_unbalanced_moment": float(np.linalg.norm(effort.unbalanced, axis=-1).mean()),
        "mean_unbalanced_arm": float(np.linalg.norm(effort.unbalanced, axis=-1).mean()) / weight,
        "mean_unborne_force": float(np.linalg.norm(effort.unborne, axis=-1).mean()),
    }


def table(found: Sequence[Effort]) -> str:
    """Return a table with one row a creature."""
    rows = [HEADS, *(_row(effort) for effort in found)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = [cell.rjust(w) for cell, w in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join([row[0].ljust(widths[0]), *cells]))
    return "\n".join(lines)


def _row(effort: Effort) -> tuple[str, ...]:
    cost, joint = effort.cost_of_transport, int(np.argmax(effort.largest))
    arm = float(np.linalg.norm(effort.unbalanced, axis=-1).mean()) / (effort.mass * GRAVITY)
    unit = "N" if effort.figure.skeleton.prismatic[joint] else "N m"
    return (
        effort.name,
        f"{effort.mass:.4g} kg",
        f"{effort.distance:.3g} m",
        f"{effort.mean_power:.4g} W",
        f"{effort.energy:.4g} J",
        "-" if cost is None else f"{cost:.3f}",
        f"{effort.largest[joint]:.4g} {unit} ({effort.figure.skeleton.joint_names[joint]})",
        f"{100.0 * arm:.1f} cm",
    )


def torques_csv(found: Sequence[Effort]) -> str:
    """Return the torques of all joints over time [N m, or N], a row of the take a line."""
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n").writerow
    names = [f"{e.name}.{joint}" for e in found for joint in e.figure.skeleton.joint_names]
    write(["seconds", *names])
    torques = np.concatenate([effort.torques for effort in found], axis=1)
    for time, row in zip(found[0].times, torques, strict=True):
        write([f"{time:.6f}", *(f"{value:.6g}" for value in row)])
    return text.getvalue()
