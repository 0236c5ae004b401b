"""Effort report: power, energy and joint torques of a scene's creatures, as table and facts."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.errors import UsageError
from pipeline.production.reports.tables import Report, table_lines
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.production.run.scene_run import working
from pipeline.production.run.take_stage import take_of
from pipeline.simulation.effort import MIN_ROWS, Effort, efforts_of
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene

HEADS = ("", "mass", "way", "mean power", "energy", "cost", "largest torque", "unbalanced")


def report_effort(order: Order, reporter: Reporter, with_csv: bool) -> Report:
    """Return the efforts of a scene's creatures.

    Args:
        order: the scene.
        reporter: of progress.
        with_csv: whether to write all torques over time into the scene's folder.

    Raises:
        PronkError: no creature stands on legs, or something cannot be made.
    """
    names = legged_of(order.scene)
    with working(order, reporter) as run:
        efforts = efforts_of(take_of(run), names)
        text = table(efforts)
        if with_csv:
            place = run.outputs.folder / f"{order.name}_torques.csv"
            file = run.write(place, torques_csv(efforts).encode("utf-8"))
            text += f"\n{file}"
    return Report(text, [facts(effort) for effort in efforts])


def legged_of(scene: Scene) -> list[str]:
    """Return the names of the creatures that stand on the terrain on legs.

    Raises:
        UsageError: there are none, or the film is too short to have accelerations.
        PronkError: the scene cannot start.
    """
    riders = {member.name for _, member in scene.creatures if member.parent is not None}
    names = dict.fromkeys(leg.performer for leg in Simulation(scene).legs())
    found = [name for name in names if name not in riders]
    if not found:
        raise UsageError(
            "nobody in this scene stands on legs, so there is no effort to tell; "
            "give it a creature with legs"
        )
    if scene.n_frames * scene.rows_per_frame < MIN_ROWS:
        raise UsageError(
            f"{scene.n_frames} frames are too few to tell accelerations; give the scene a "
            f"longer `duration`, {MIN_ROWS} frames or more"
        )
    return found


def facts(effort: Effort) -> dict[str, Any]:
    """Return the effort of one creature as plain values in SI units."""
    moment = float(np.linalg.norm(effort.unbalanced_moment, axis=-1).mean())
    return {
        "name": effort.name,
        "mass": effort.mass,
        "distance": effort.distance,
        "seconds": float(effort.times[-1] - effort.times[0]),
        "mean_power": effort.mean_power,
        "energy": effort.energy,
        "cost_of_transport": effort.cost_of_transport,
        "largest_torques": dict(zip(effort.joints, effort.max_torques.tolist(), strict=True)),
        "largest_ground_force": {
            leg: float(np.linalg.norm(effort.foot_forces[:, i], axis=-1).max())
            for i, leg in enumerate(effort.legs)
        },
        "mean_unbalanced_moment": moment,
        "mean_unbalanced_arm": moment / effort.weight,
        "mean_unborne_force": float(np.linalg.norm(effort.unsupported_force, axis=-1).mean()),
    }


def table(efforts: Sequence[Effort]) -> str:
    """Return a table with one row per creature."""
    return "\n".join(table_lines([HEADS, *(_row(effort) for effort in efforts)]))


def _row(effort: Effort) -> tuple[str, ...]:
    cost, joint = effort.cost_of_transport, int(np.argmax(effort.max_torques))
    moment = float(np.linalg.norm(effort.unbalanced_moment, axis=-1).mean())
    unit = "N" if effort.prismatic[joint] else "N m"
    return (
        effort.name,
        f"{effort.mass:.4g} kg",
        f"{effort.distance:.3g} m",
        f"{effort.mean_power:.4g} W",
        f"{effort.energy:.4g} J",
        "-" if cost is None else f"{cost:.3f}",
        f"{effort.max_torques[joint]:.4g} {unit} ({effort.joints[joint]})",
        f"{100.0 * moment / effort.weight:.1f} cm",
    )


def torques_csv(efforts: Sequence[Effort]) -> str:
    """Return the torques of all joints, one line per row of the take [N m, or N]."""
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n").writerow
    write(["seconds", *(f"{e.name}.{joint}" for e in efforts for joint in e.joints)])
    torques = np.concatenate([effort.torques for effort in efforts], axis=1)
    for time, row in zip(efforts[0].times, torques, strict=True):
        write([f"{time:.6f}", *(f"{value:.6g}" for value in row)])
    return text.getvalue()
