"""Jerk report: figure 3 of 1998 with our columns beside it, for people and programs.

Source: Matarić, Zordan and Mason 1998, section 7.3 and figure 3.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from pipeline.production.reports.jerk_plot import jerk_svg
from pipeline.production.reports.jerk_trials import (
    RESTING_DISTANCE,
    Agreement,
    Column,
    Trial,
    agreements,
    dancer_of,
    is_figure_three,
    trials_of,
)
from pipeline.production.reports.plot_files import write_plot
from pipeline.production.reports.tables import Report, table_lines
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter, stage
from pipeline.production.run.scene_run import working
from pipeline.simulation.dance_trials import (
    CUTOFF_FREQUENCY,
    MINIMUM_DIMENSIONLESS_JERK,
    PAPER_JERK,
    SAMPLE_RATE,
    MeasuredMove,
    RetimedPath,
)
from pipeline.spec import Dance

MIN_RANK_DIFFERENCE = 4
"""Difference of ranks from which on a movement is listed with its circumstances."""

MEASURES = (
    *("T_s", "D_m", "C_m2_s5", "mean_m2_s6", "dimensionless", "least_m2_s5"),
    *("same_way_m2_s5", "energy_J", "largest_torque_Nm"),
)
"""Quantities of a movement, with units."""

METHOD = (
    f"jerk: third derivative of the middle of the palm, at {SAMPLE_RATE:g} Hz after a low-pass of "
    f"{CUTOFF_FREQUENCY:g} Hz\n"
    "C = integral of its square [m²/s⁵]; mean = C/T [m²/s⁶], figure 3's printed unit; "
    f"C T⁵/D² >= {MINIMUM_DIMENSIONLESS_JERK:g}\n"
    "least = of the quintic between the same ends; same way = of the best timing of the same path\n"
    "between the same ends; ends are places, speeds and accelerations\n"
    "the weight of the arms is compensated, unless the scene says otherwise"
)


def report_jerk(order: Order, reporter: Reporter) -> Report:
    """Return how smoothly the first dancer of a scene moves, by both controllers.

    Writes a table and plots of hand paths and speeds into the scene's folder.

    Raises:
        PronkError: the scene has no dancer, or something cannot be made.
    """
    _, member, dance = dancer_of(order.scene)
    with working(order, reporter) as run:
        with stage(reporter, "dance", 1) as current:
            trials = trials_of(order.scene)
            current.advance(1)
            current.result = f"danced {2 * len(trials)} times"
        compared = {t.name: agreements(t) if is_figure_three(dance) else [] for t in trials}
        text = _text(member.name, dance, trials, compared)
        place = run.outputs.folder / f"{order.name}_jerk.csv"
        table = run.write(place, table_csv(dance, trials).encode("utf-8"))
        svg = jerk_svg(f"{member.name}: {member.dance}", dance, trials[-1])
        files = (table, *write_plot(run, "jerk", svg))
    facts = [_facts(trial, compared[trial.name]) for trial in trials]
    return Report("\n".join([text, *map(str, files)]), facts)


def table_csv(dance: Dance, trials: Sequence[Trial]) -> str:
    """Return all measures, one movement per line."""
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n").writerow
    write(["trial", "by", "subtask", "name", *MEASURES])
    for trial in trials:
        for column in trial.columns.values():
            for k, values in _measures(column).items():
                row = [f"{value:.6g}" for value in values.values()]
                write([trial.name, column.name, k + 1, dance.subtasks[k].name, *row])
    return text.getvalue()


def _measures(column: Column) -> dict[int, dict[str, float]]:
    """Return the quantities of each movement of a column, by the number of the subtask."""
    found = {}
    for k, movement in sorted(column.movements.items()):
        j = movement.jerk
        values = (j.time, j.distance, j.integral, j.mean, j.dimensionless, movement.floor)
        rest = (column.smoothest[k].integral, movement.energy, movement.torque)
        found[k] = dict(zip(MEASURES, (*values, *rest), strict=True))
    return found


def _text(
    name: str, dance: Dance, trials: Sequence[Trial], compared: dict[str, list[Agreement]]
) -> str:
    lines = [f"{name}: jerk of the moving hand", METHOD]
    for trial in trials:
        lines += ["", f"at {trial.name}", *_table(dance, trial)]
        lines += _rank_lines(dance, trial, compared[trial.name])
    if is_figure_three(dance):
        lines += ["", "* not done: fields cannot turn a hand (subtasks 3 and 4)"]
    return "\n".join(lines)


def _table(dance: Dance, trial: Trial) -> list[str]:
    has_printed = is_figure_three(dance)
    heads = ["", *(f"1998 {name}" for name in PAPER_JERK if has_printed)]
    for name in trial.columns:
        heads += [f"{name} T", "C", "mean", "C T⁵/D²", "least", "same way", "J", "N m"]
    rows = [heads]
    for k, subtask in enumerate(dance.subtasks):
        printed = [PAPER_JERK[name][k] for name in PAPER_JERK] if has_printed else []
        row = [f"{k + 1:2d} {subtask.name}", *("*" if v is None else f"{v}" for v in printed)]
        for column in trial.columns.values():
            row += _cells(column.movements.get(k), column.smoothest.get(k))
        rows.append(row)
    return table_lines(rows)


def _cells(movement: MeasuredMove | None, smoothest: RetimedPath | None) -> list[str]:
    if movement is None or smoothest is None:
        return ["*"] * 8
    j = movement.jerk
    values = [f"{j.time:.2f}", f"{j.integral:.0f}", f"{j.mean:.0f}"]
    values.append("-" if j.distance < RESTING_DISTANCE else f"{j.dimensionless:.0f}")
    values += [f"{movement.floor:.0f}", f"{smoothest.integral:.0f}"]
    return [*values, f"{movement.energy:.0f}", f"{movement.torque:.0f}"]


def _rank_lines(dance: Dance, trial: Trial, compared: Sequence[Agreement]) -> Iterator[str]:
    for agreement in compared:
        yield (
            f"  order of our {agreement.ours} and their {agreement.theirs}: "
            f"{agreement.rank:+.2f} over {len(agreement.subtasks)} subtasks"
        )
        ranks = zip(agreement.subtasks, agreement.own, agreement.other, strict=True)
        for k, own, other in ranks:
            if abs(own - other) >= MIN_RANK_DIFFERENCE:
                why = _circumstances(dance, trial.columns[agreement.ours], k)
                yield f"    {k + 1}: {own}. here and {other}. there; {why}"


def _circumstances(dance: Dance, column: Column, k: int) -> str:
    """Return properties of a movement that bear on its jerk."""
    jerk, subtask = column.movements[k].jerk, dance.subtasks[k]
    times, hand = column.danced.times, column.danced.hands[subtask.hand]
    move = next(m for m in column.danced.moves[subtask.hand] if m.subtask == k)
    path = hand[(times >= move.begin) & (times <= move.land)]
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    found = [f"T = {jerk.time:.2f} s"]
    if jerk.distance > RESTING_DISTANCE:
        found.append(f"the way is {length / jerk.distance:.1f} times the straight one")
    if subtask.via:
        found.append(f"{len(subtask.via)} sub-goals on it")
    found.append("ends in a touch" if subtask.touch else "ends in the air")
    return ", ".join(found)


def _facts(trial: Trial, compared: Sequence[Agreement]) -> dict[str, Any]:
    return {
        "trial": trial.name,
        "columns": {
            name: {str(k + 1): values for k, values in _measures(column).items()}
            for name, column in trial.columns.items()
        },
        "rank_correlations": {f"{a.ours}/{a.theirs}": a.rank for a in compared},
    }
