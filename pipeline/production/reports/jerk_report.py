"""Jerk report: figure 3 again, with ours beside it, for people and programs.

Source: Matarić, Zordan and Mason 1998, section 7.3 and figure 3.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from audio.atomic_file import write_if_changed
from pipeline.production.reports.figure_picture import png_of
from pipeline.production.reports.jerk_plot import jerk_svg
from pipeline.production.reports.jerk_trials import (
    Agreement,
    Column,
    Trial,
    agreements,
    dancer_of,
    is_figure_three,
    trials_of,
)
from pipeline.production.run.order import Order
from pipeline.production.run.production import working
from pipeline.production.run.progress import Reporter, stage, step
from pipeline.simulation.dancers.figure_three import COLUMNS
from pipeline.simulation.dancers.jerk import CUTOFF, LEAST, RATE
from pipeline.simulation.dancers.measuring import Measured
from pipeline.simulation.dancers.same_way import Timed
from pipeline.spec import Dance

APART = 4
"""Ranks that are so far apart are told, with what is known of the movement."""

MEASURES = (
    *("T_s", "D_m", "C_m2_s5", "mean_m2_s6", "dimensionless", "least_m2_s5"),
    *("same_way_m2_s5", "energy_J", "largest_torque_Nm"),
)
"""What is told of a movement, with units."""

METHOD = (
    f"jerk: third derivative of the middle of the palm, at {RATE:g} Hz after a low-pass of "
    f"{CUTOFF:g} Hz\n"
    "C = integral of its square [m²/s⁵]; mean = C/T [m²/s⁶], figure 3's printed unit; "
    f"C T⁵/D² >= {LEAST:g}\n"
    "least = of the quintic between the same ends; same way = of the best timing of the same path\n"
    "between the same ends; ends are places, speeds and accelerations\n"
    "the weight of the arms is compensated, unless the scene says otherwise"
)


@dataclass(frozen=True, slots=True)
class Told:
    """A report.

    Attributes:
        text: tables.
        facts: the same for other programs, one mapping a trial.
    """

    text: str
    facts: list[dict[str, Any]]


def report_jerk(order: Order, reporter: Reporter) -> Told:
    """Return how smoothly the first dancer of a scene moves, by both controllers.

    Writes a table and plots of hand paths and speeds into the scene's folder.

    Raises:
        PronkError: nobody dances, or something cannot be made.
    """
    _, member, dance = dancer_of(order.scene)
    with working(order, reporter) as run:
        with stage(reporter, "dance", 1) as current:
            trials = trials_of(order.scene)
            step(reporter, current, 1)
            current.result = f"danced {2 * len(trials)} times"
        compared = {t.name: agreements(t) if is_figure_three(dance) else [] for t in trials}
        text = _text(member.name, dance, trials, compared)
        folder = run.outputs.folder
        files = [folder / f"{order.name}_jerk.{end}" for end in ("csv", "svg", "png")]
        svg = jerk_svg(f"{member.name}: {member.dance}", dance, trials[-1])
        write_if_changed(files[0], table_csv(dance, trials).encode("utf-8"))
        write_if_changed(files[1], svg.encode("utf-8"))
        write_if_changed(files[2], png_of(svg))
    told = "\n".join([text, *(str(file) for file in files)])
    return Told(told, [_facts(trial, compared[trial.name]) for trial in trials])


def table_csv(dance: Dance, trials: Sequence[Trial]) -> str:
    """Return all that was measured, a movement a line."""
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n").writerow
    write(["trial", "by", "subtask", "name", *MEASURES])
    for trial in trials:
        for column in trial.columns.values():
            for k, one in sorted(column.found.items()):
                values = [f"{v:.6g}" for v in _measures_of(one, column.best[k]).values()]
                write([trial.name, column.by, k + 1, dance.subtasks[k].name, *values])
    return text.getvalue()


def _measures_of(one: Measured, best: Timed) -> dict[str, float]:
    """Return what is told of a movement."""
    j = one.jerk
    values = (j.time, j.distance, j.integral, j.mean, j.dimensionless, one.floor)
    rest = (best.integral, one.energy, one.torque)
    return dict(zip(MEASURES, (*values, *rest), strict=True))


def _text(
    name: str, dance: Dance, trials: Sequence[Trial], compared: dict[str, list[Agreement]]
) -> str:
    lines = [f"{name}: jerk of the moving hand", METHOD]
    for trial in trials:
        lines += ["", f"at {trial.name}", *_table(dance, trial)]
        lines += _ranks(dance, trial, compared[trial.name])
    if is_figure_three(dance):
        lines += ["", "* not done: fields cannot turn a hand (subtasks 3 and 4)"]
    return "\n".join(lines)


def _table(dance: Dance, trial: Trial) -> list[str]:
    figure = is_figure_three(dance)
    heads = ["", *(f"1998 {name}" for name in COLUMNS if figure)]
    for by in trial.columns:
        heads += [f"{by} T", "C", "mean", "C T⁵/D²", "least", "same way", "J", "N m"]
    rows = [heads]
    for k, one in enumerate(dance.subtasks):
        printed = [COLUMNS[name][k] for name in COLUMNS] if figure else []
        row = [f"{k + 1:2d} {one.name}", *("*" if v is None else f"{v}" for v in printed)]
        for column in trial.columns.values():
            row += _cells(column.found.get(k), column.best.get(k))
        rows.append(row)
    widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
    return [
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]) for row in rows
    ]


def _cells(one: Measured | None, best: Timed | None) -> list[str]:
    if one is None or best is None:
        return ["*"] * 8
    j = one.jerk
    still = j.distance < 0.05
    values = [f"{j.time:.2f}", f"{j.integral:.0f}", f"{j.mean:.0f}"]
    values.append("-" if still else f"{j.dimensionless:.0f}")
    values += [f"{one.floor:.0f}", f"{best.integral:.0f}"]
    return [*values, f"{one.energy:.0f}", f"{one.torque:.0f}"]


def _ranks(dance: Dance, trial: Trial, compared: Sequence[Agreement]) -> Iterator[str]:
    for one in compared:
        yield (
            f"  order of our {one.ours} and their {one.theirs}: "
            f"{one.rank:+.2f} over {len(one.subtasks)} subtasks"
        )
        column = trial.columns[one.ours]
        for k, own, other in zip(one.subtasks, one.own, one.other, strict=True):
            if abs(own - other) >= APART:
                yield f"    {k + 1}: {own}. here and {other}. there; {_why(dance, column, k)}"


def _why(dance: Dance, column: Column, k: int) -> str:
    """Return what of a movement bears on its jerk."""
    measured, one = column.found[k], dance.subtasks[k]
    times, hand = column.danced.times, column.danced.hands[one.hand]
    move = next(m for m in column.danced.moves[one.hand] if m.subtask == k)
    way = hand[(times >= move.begin) & (times <= move.land)]
    length = float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
    told = [f"T = {measured.jerk.time:.2f} s"]
    if measured.jerk.distance > 0.05:
        told.append(f"the way is {length / measured.jerk.distance:.1f} times the straight one")
    if one.via:
        told.append(f"{len(one.via)} sub-goals on it")
    told.append("ends in a touch" if one.touch else "ends in the air")
    return ", ".join(told)


def _facts(trial: Trial, compared: Sequence[Agreement]) -> dict[str, Any]:
    return {
        "trial": trial.name,
        "columns": {
            by: {
                str(k + 1): _measures_of(one, column.best[k])
                for k, one in sorted(column.found.items())
            }
            for by, column in trial.columns.items()
        },
        "rank_correlations": {f"{one.ours}/{one.theirs}": one.rank for one in compared},
    }
